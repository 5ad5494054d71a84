//! On a slope as on the level.

use std::path::Path;

use ilon::scenario::Scenario;

/// Downhill the robot loses height in the world and none above the floor: its hubs ripple by what they do on the level,
/// under 0.02 mm, while it comes 0.1 m down over 0.7 m of way.
#[test]
fn hubs_are_measured_from_the_floor_they_roll_on() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\n[twist]\nvx_m_s = 0.3\n[run]\nduration_s = 3\n\
                [world.floor]\nslope_deg = 8";
    let scenario = Scenario::from_toml(text, "slope", folder).expect("a scenario");
    let run = ilon::run(&scenario).expect("it runs");
    let ripple_m = run.summary.hub_ripple_m.expect("the hubs are recorded");
    assert!(ripple_m < 2e-5, "{ripple_m} m");
}

/// Truth and dead reckoning count in the same plane: what wheels roll along a slope is what the robot has moved, and not its
/// horizontal projection, which is cos 8 degrees = 0.990 of it.
#[test]
fn dead_reckoning_drifts_on_a_slope_as_little_as_on_the_level() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let drift = |slope_deg: f64, heading_deg: f64| {
        let text = format!(
            "[robot]\nfile = 'mecanum4.urdf'\nheading_deg = {heading_deg}\n[twist]\nvx_m_s = 0.3\n[run]\nduration_s = 3\n\
             [world.floor]\nslope_deg = {slope_deg}"
        );
        let scenario = Scenario::from_toml(&text, "slope", folder.clone()).expect("a scenario");
        let run = ilon::run(&scenario).expect("it runs");
        run.summary.odometry_contact.m_per_m.expect("it moves")
    };
    for heading_deg in [0.0, 60.0] {
        let (level, slope) = (drift(0.0, heading_deg), drift(8.0, heading_deg));
        // What is left are the first steps, in which the robot settles: micrometres.
        assert!(slope < level + 1e-5, "{slope} m/m against {level}");
    }
}
