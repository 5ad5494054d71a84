//! Energy: the balance of every shipped scenario, and the heat of sliding in a turn.

use std::path::Path;

use ilon::Scenario;
use ilon::scenario::{RollerBodies, Step};

#[test]
fn every_shipped_scenario_expects_its_energy_to_close_within_a_hundredth() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/scenarios");
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
        // A robot at rest has no turnover for a relative bound: its limit is a tenth of a
        // millijoule.
        assert!(
            within("energy.unexplained_share", 0.01) || within("energy.unexplained_j", 1e-4),
            "{}: write `energy.unexplained_share = {{ min = -0.01, max = 0.01 }}` under [expect]",
            path.display()
        );
        count += 1;
    }
    assert!(count > 30, "{count} scenarios");
}

/// A gear of efficiency 0.7 takes 0.3 of the motor's power while driving, and 0.75 while braking,
/// from 1 / (2 - 1 / 0.7) - 1, at any stiffness of the wheel loop: the torque that the loop
/// requests at the start of a step is not the one that acts. Rows of one step each hold the mean
/// torque and the angle turned.
#[test]
fn a_gear_takes_its_share_of_the_torque_that_acts_at_any_stiffness_of_the_loop() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    for bandwidth_rad_s in [60, 300, 2000] {
        let run = |efficiency: f64| {
            let text = format!(
                "[robot]\nfile = 'mecanum4.urdf'\n[motors]\ngear_efficiency = {efficiency}\n\
                 [wheel_loop]\nbandwidth_rad_s = {bandwidth_rad_s}\n[twist]\nvx_m_s = 0.3\n\
                 [run]\nduration_s = 4\ncontrol_dt_s = 0.0025\nphysics_dt_s = 0.0025"
            );
            let scenario = Scenario::from_toml(&text, "gear", folder.clone()).expect("a scenario");
            ilon::run(&scenario).expect("it runs")
        };
        let (geared, bare) = (run(0.7), run(1.0));
        let lost_j = |run: &ilon::Run| run.summary.energy.bearing_j.expect("it is counted");
        let booked_j = lost_j(&geared) - lost_j(&bare);
        let mut share_j = 0.0;
        for row in 1..geared.trace.records().len() {
            let (before, now) = (geared.trace.wheels_at(row - 1), geared.trace.wheels_at(row));
            for (before, now) in before.iter().zip(now) {
                let work_j = now.torque_n_m * (now.angle_rad - before.angle_rad);
                share_j += if work_j > 0.0 {
                    0.3 * work_j
                } else {
                    -0.75 * work_j
                };
            }
        }
        // Steps in which the torque changes its sign are counted by the sign of their mean.
        assert!(
            (booked_j - share_j).abs() < 0.01 * share_j,
            "{bandwidth_rad_s} rad/s: {booked_j} J for {share_j} J"
        );
    }
}

/// A fast turn starts and stops with a slide, and grips in between: the heat of sliding at the
/// automatic step is within a tenth of its limit, which steps of 0.1 ms reach within a hundredth
/// (from there to 0.05 ms it changes by half a per cent). If its contacts lost m v^2 omega^2 dt / 2
/// while gripping, that would be 0.5 J.
#[test]
fn the_heat_of_sliding_in_a_fast_turn_is_near_its_limit_at_the_automatic_step() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
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
