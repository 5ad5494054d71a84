//! A good robot, small, from which the tests make others.

#![allow(dead_code)] // Each test binary uses a part.

use ilon_robot::{Spec, generate};

/// Three omni wheels on a ring.
pub const SPEC: &str = r#"
name = "small"
[chassis]
shape.box = { size_m = [0.3, 0.3, 0.1] }
mass_kg = 5.0
center_m = [0.0, 0.0, 0.06]
[wheel]
radius_m = 0.05
hub_mass_kg = 0.2
hub_radius_m = 0.03
hub_width_m = 0.04
motor_effort_n_m = 1.0
motor_velocity_rad_s = 20.0
[rollers]
per_row = 8
radius_m = 0.012
mass_kg = 0.01
[wheels.ring]
count = 3
distance_m = 0.2
gamma_deg = 0.0
"#;

/// Its URDF.
pub fn small() -> String {
    let spec = Spec::from_toml_str(SPEC, "small.toml").expect("a good description");
    generate(&spec).expect("a good description")
}

/// The line of the first place where `needle` stands.
pub fn line_of(text: &str, needle: &str) -> usize {
    let at = text.find(needle).unwrap_or_else(|| panic!("no {needle}"));
    text[..at].matches('\n').count() + 1
}
