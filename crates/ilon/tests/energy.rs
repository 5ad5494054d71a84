//! Where the energy goes: the balance of every shipped scenario, and what sliding takes in a turn.

use std::path::Path;

use ilon::Scenario;
use ilon::scenario::{RollerBodies, Step};

#[test]
fn every_shipped_scenario_expects_its_energy_to_close_within_a_hundredth() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenarios");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the shipped scenarios") {
        let path = entry.expect("a file").path();
        if path.extension().is_none_or(|end| end != "toml") {
            continue;
        }
        let scenario = Scenario::load(&path).expect("a shipped scenario");
        let bound = |quantity: &str| scenario.expect.bounds.get(quantity).copied();
        let within = |quantity: &str, most: f64| {
            bound(quantity).is_some_and(|bound| {
                bound.min.is_some_and(|min| min >= -most)
                    && bound.max.is_some_and(|max| max <= most)
            })
        };
        // A robot that rests turns nothing over that a share could be of: it is held to a tenth of a millijoule.
        assert!(
            within("energy.unexplained_share", 0.01) || within("energy.unexplained_j", 1e-4),
            "{}: write `energy.unexplained_share = {{ min = -0.01, max = 0.01 }}` under [expect]",
            path.display()
        );
        count += 1;
    }
    assert!(count > 30, "{count} scenarios");
}

/// A fast turn starts and stops with a slide, and holds in between: the heat of sliding at the automatic step is within a tenth
/// of its limit, which steps of 0.1 ms have to a hundredth (from there to 0.05 ms it changes by half a per cent). A turn whose contacts
/// lost m v^2 omega^2 dt / 2 while they hold would have 0.5 J of it.
#[test]
fn the_heat_of_sliding_in_a_fast_turn_is_near_its_limit_at_the_automatic_step() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots");
    let text = "[robot]\nfile = 'mecanum4.urdf'\n[twist]\nvx_m_s = 1.0\nomega_rad_s = 3.0\n[run]\nduration_s = 5.5";
    let mut scenario = Scenario::from_toml(text, "turn", folder).expect("a scenario");
    scenario.robot.roller_bodies = RollerBodies::Near;
    let mut heat_j = |step: Option<f64>| {
        if let Some(dt_s) = step {
            scenario.run.physics_dt_s = Step::Seconds(dt_s);
        }
        let run = ilon::run(&scenario).expect("it runs");
        run.summary.slip_energy_j.expect("the energy is counted")
    };
    let (automatic_j, limit_j) = (heat_j(None), heat_j(Some(1e-4)));
    assert!(
        (automatic_j - limit_j).abs() < 0.1 * limit_j,
        "{automatic_j} J for {limit_j} J"
    );
}
