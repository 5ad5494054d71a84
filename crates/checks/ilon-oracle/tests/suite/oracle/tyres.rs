//! Robots on tyres in both engines: on springs of the same stiffness at the same places.

use ilon_formats::{LoadOptions, LoadRobot, TyreOptions};
use ilon_robot::{JointRole, JointSpring, Robot, Twist};
use nalgebra::Vector2;

use crate::oracle::case::{Case, Wheels};
use crate::oracle::engines::Springs;
use crate::oracle::tread::agree_on;

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");

/// Those of each place; several of them on one light wheel take a shorter step than one.
const SPRINGS: Springs = Springs {
    stiffness_n_m: 2e6,
    step_s: 1.2e-5,
};

/// The shipped differential robot, with tyres on its casters too.
fn on_casters() -> Robot {
    let mut tyres = TyreOptions::default();
    tyres.joints = ["left", "right"].map(str::to_owned).to_vec();
    tyres.free = ["front", "rear"]
        .map(|end| format!("{end}_caster_roll"))
        .to_vec();
    let mut options = LoadOptions::default();
    options.tyres = Some(tyres);
    let file = format!("{ROBOTS}/differential.urdf");
    let mut robot = Robot::load_with(file, &options).expect("shipped").robot;
    for joint in &mut robot.joints {
        joint.role = JointRole::Free;
    }
    robot
}

/// An arc, a stop, and straight back: casters trail askew, and then turn over.
#[test]
fn a_differential_robot_drives_alike_in_both_engines() {
    let robot = on_casters();
    assert_eq!(robot.wheels.len(), 4);
    let wheels = robot.wheels.clone();
    let case = Case::new("differential", robot, 0.6, 1.6, move |t_s| {
        let share = (t_s / 0.3).min(1.0) - ((t_s - 0.7) / 0.4).clamp(0.0, 2.0);
        let omega_rad_s = if t_s < 0.9 { 0.8 * share } else { 0.0 };
        let rate = |wheel: &ilon_robot::Wheel| {
            (0.3 * share - omega_rad_s * wheel.position_m().y) / wheel.radius_m
        };
        Wheels::At(wheels.iter().map(rate).collect())
    });
    agree_on(&case, SPRINGS);
}

/// Modules on stiff springs swing to where their wheels roll a motion ahead, to the left and round,
/// and then the wheels drive it.
#[test]
fn a_swerve_robot_drives_alike_in_both_engines() {
    let mut robot = Robot::load(format!("{ROBOTS}/swerve4.urdf")).expect("shipped");
    let twist = Twist::new(0.3, 0.3, 0.5);
    let mut rates_rad_s = Vec::new();
    for wheel in &robot.wheels {
        let at_m = wheel.position_m();
        let v = twist.linear_m_s() + twist.omega_rad_s * Vector2::new(-at_m.y, at_m.x);
        rates_rad_s.push(v.norm() / wheel.radius_m);
        let joint = &mut robot.joints[wheel.carrier.expect("steered")];
        joint.role = JointRole::Sprung(JointSpring {
            stiffness: 60.0,
            rest: v.y.atan2(v.x),
            preload: 0.0,
        });
        joint.damping = 1.0;
    }
    let case = Case::new("swerve", robot, 0.6, 1.2, move |t_s| {
        let share = ((t_s - 0.3) / 0.4).clamp(0.0, 1.0);
        Wheels::At(rates_rad_s.iter().map(|rate| share * rate).collect())
    });
    agree_on(&case, SPRINGS);
}
