//! On a slope as on the level.

use std::path::Path;

use ilon::scenario::Scenario;

/// Downhill the robot loses height in the world and none above the floor: its hubs ripple by what they do on the level,
/// under 0.02 mm, while it comes 0.1 m down over 0.7 m of way.
#[test]
fn hubs_are_measured_from_the_floor_they_roll_on() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots");
    let text = "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\n[twist]\nvx_m_s = 0.3\n[run]\nduration_s = 3\n\
                [world.floor]\nslope_deg = 8";
    let scenario = Scenario::from_toml(text, "slope", folder).expect("a scenario");
    let run = ilon::run(&scenario).expect("it runs");
    let ripple_m = run.summary.hub_ripple_m.expect("the hubs are recorded");
    assert!(ripple_m < 2e-5, "{ripple_m} m");
}
