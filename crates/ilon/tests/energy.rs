//! The energy balance of every shipped scenario is held to a hundredth by the scenario itself.

use std::path::Path;

use ilon::Scenario;

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
