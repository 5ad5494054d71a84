//! On a slope as on the level.

use std::path::Path;

use ilon::scenario::Scenario;

/// Downhill the robot loses height in the world and none above the floor: its hubs ripple as on the
/// level, under 0.02 mm, while it descends by 0.1 m over 0.7 m of path.
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

/// Truth and dead reckoning use the same plane: the path is measured along the slope, not by its
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
        // Only the first steps remain, in which the robot settles: micrometres.
        assert!(slope < level + 1e-5, "{slope} m/m against {level}");
    }
}
