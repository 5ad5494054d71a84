//! A robot's own units.

use ilon_formats::LoadRobot;
use ilon_robot::{Robot, Scale};

#[test]
fn a_robot_of_s_times_the_size_has_units_that_grow_as_froude_has_it() {
    let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
    let robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
    let mut large = robot.clone();
    let s: f64 = 8.0;
    large.chassis.mass.mass_kg *= s.powi(3);
    for wheel in &mut large.wheels {
        wheel.radius_m *= s;
        wheel.hub.mass_kg *= s.powi(3);
        for roller in &mut wheel.rollers {
            roller.mass_kg *= s.powi(3);
        }
    }
    let (one, other) = (Scale::of(&robot, 9.81), Scale::of(&large, 9.81));
    // 11.36 kg on four wheels of 50 mm: 27.86 N over 1e-6 of the radius.
    assert!((one.stiffness_n_m(1e-6) / (2.84 * 9.81 / 5e-8) - 1.0).abs() < 1e-12);
    assert!((other.time_s() / one.time_s() / s.sqrt() - 1.0).abs() < 1e-12);
    assert!((other.speed_m_s() / one.speed_m_s() / s.sqrt() - 1.0).abs() < 1e-12);
    let stiffer = other.stiffness_n_m(1e-6) / one.stiffness_n_m(1e-6);
    assert!((stiffer / s.powi(2) - 1.0).abs() < 1e-12);
    // Without gravity there would be no contact force, and no time scale.
    assert_eq!(Scale::of(&robot, 0.0), Scale::of(&robot, 0.981));
}
