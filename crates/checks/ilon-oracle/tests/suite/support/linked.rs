//! Robots whose wheels are on springs, arms and rockers, all made from mecanum4.

use ilon_robot::{Body, BodyJoint, JointKind, JointRole, JointSpring, MassProperties, Robot};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use super::robot;

/// The mass of a wheel's carrier, in kg.
pub const CARRIER_KG: f64 = 0.1;
/// The stiffness of the suspension at a wheel, in N/m.
pub const STIFFNESS_N_M: f64 = 4000.0;
/// Length of a swing arm, in metres.
pub const ARM_M: f64 = 0.1;

/// A body of a mass in kg with its centre at a place in the body frame, on a joint at a place with
/// an axis.
pub fn joint(
    (kind, role): (JointKind, JointRole),
    (place_m, axis): (Vector3<f64>, Vector3<f64>),
    (mass_kg, center_m): (f64, Vector3<f64>),
) -> BodyJoint {
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &axis).expect("not opposite");
    let body_from_joint = Isometry3::from_parts(place_m.into(), turn);
    let mass = MassProperties {
        mass_kg,
        center_of_mass_m: center_m,
        inertia_kg_m2: Matrix3::from_diagonal(&Vector3::new(1.0, 1.5, 2.0)) * mass_kg * 4e-4,
    };
    BodyJoint {
        name: "joint".into(),
        parent: None,
        kind,
        body_from_joint,
        body: Body {
            name: "carrier".into(),
            mass: mass.moved(&body_from_joint.inverse()),
            collisions: Vec::new(),
        },
        role,
        limits: [f64::NEG_INFINITY, f64::INFINITY],
        damping: 0.0,
        friction: 0.0,
    }
}

/// A spring whose rest position is zero.
pub fn sprung(stiffness: f64) -> JointRole {
    JointRole::Sprung(JointSpring {
        stiffness,
        rest: 0.0,
        preload: 0.0,
    })
}

/// Each wheel slides up and down on a spring with a damper, in N s/m.
pub fn on_slides(damping: f64) -> Robot {
    each_wheel(|at_m| {
        let law = (JointKind::Slides, sprung(STIFFNESS_N_M));
        let mut of = joint(law, (at_m, Vector3::z()), (CARRIER_KG, at_m));
        of.damping = damping;
        of
    })
}

/// Each wheel is on an arm behind its pivot, with a spring and a damper as stiff as those of
/// [`on_slides`] at the wheel.
pub fn on_arms(damping: f64) -> Robot {
    each_wheel(|hub_m| {
        let pivot_m = hub_m + ARM_M * Vector3::x();
        let law = (JointKind::Turns, sprung(STIFFNESS_N_M * ARM_M * ARM_M));
        let middle_m = hub_m + 0.5 * ARM_M * Vector3::x();
        let mut of = joint(law, (pivot_m, Vector3::y()), (CARRIER_KG, middle_m));
        of.damping = damping * ARM_M * ARM_M;
        of
    })
}

fn each_wheel(joint_at: impl Fn(Vector3<f64>) -> BodyJoint) -> Robot {
    let mut robot = robot("mecanum4");
    for index in 0..robot.wheels.len() {
        let at_m = robot.wheels[index].position_m();
        robot.joints.push(joint_at(at_m));
        robot.wheels[index].carrier = Some(index);
    }
    robot
}

/// The rear wheels are on a rocker about the robot's long axis, with a damper in N m s/rad.
pub fn on_a_rocker(damping: f64) -> Robot {
    let mut robot = robot("mecanum4");
    let rear_m = robot.wheels[2].position_m().x;
    let middle_m = Vector3::new(rear_m, 0.0, 0.05);
    let law = (JointKind::Turns, JointRole::Free);
    let mut rocker = joint(law, (middle_m, Vector3::x()), (0.2, middle_m));
    rocker.damping = damping;
    robot.joints.push(rocker);
    for wheel in &mut robot.wheels[2..] {
        wheel.carrier = Some(0);
    }
    robot
}
