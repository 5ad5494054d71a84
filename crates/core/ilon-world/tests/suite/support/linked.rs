//! Robots with wheels on rockers, springs and arms.

use ilon_robot::{Body, BodyJoint, JointKind, JointRole, JointSpring, MassProperties, Robot};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use super::mecanum4;

/// The mass of a wheel's carrier, in kg.
pub const CARRIER_KG: f64 = 0.1;
/// The stiffness under a wheel, in N/m.
pub const STIFFNESS_N_M: f64 = 4000.0;
/// Half of the wheelbase and of the track, in metres.
pub const X_M: f64 = 0.15;
pub const Y_M: f64 = 0.16;

/// A body of a mass in kg with its centre at a point in the body frame, on a joint at a point with
/// a given axis.
pub fn joint(
    name: &str,
    (kind, role): (JointKind, JointRole),
    (place_m, axis): (Vector3<f64>, Vector3<f64>),
    (mass_kg, center_m): (f64, Vector3<f64>),
) -> BodyJoint {
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &axis).expect("not opposite");
    let body_from_joint = Isometry3::from_parts(place_m.into(), turn);
    let mass = MassProperties {
        mass_kg,
        center_of_mass_m: center_m,
        inertia_kg_m2: Matrix3::identity() * mass_kg * 0.02 * 0.02,
    };
    BodyJoint {
        name: name.into(),
        parent: None,
        kind,
        body_from_joint,
        body: Body {
            name: name.into(),
            mass: mass.moved(&body_from_joint.inverse()),
            collisions: Vec::new(),
        },
        role,
        limits: [f64::NEG_INFINITY, f64::INFINITY],
        damping: 0.0,
        friction: 0.0,
    }
}

/// A spring at rest at zero.
pub fn sprung(stiffness: f64) -> JointRole {
    JointRole::Sprung(JointSpring {
        stiffness,
        rest: 0.0,
        preload: 0.0,
    })
}

/// Each wheel is on a vertical slide with a spring.
pub fn on_springs(damping: f64) -> Robot {
    let mut robot = mecanum4();
    for (index, wheel) in robot.wheels.iter_mut().enumerate() {
        let at_m = wheel.position_m();
        let law = (JointKind::Slides, sprung(STIFFNESS_N_M));
        let mut of = joint("slide", law, (at_m, Vector3::z()), (CARRIER_KG, at_m));
        of.damping = damping;
        robot.joints.push(of);
        wheel.carrier = Some(index);
    }
    robot
}

/// Each wheel is on an arm of 0.1 m behind its pivot.
pub fn on_arms(damping: f64) -> Robot {
    let mut robot = mecanum4();
    for (index, wheel) in robot.wheels.iter_mut().enumerate() {
        let hub_m = wheel.position_m();
        let pivot_m = hub_m + 0.1 * Vector3::x();
        let law = (JointKind::Turns, sprung(STIFFNESS_N_M * 0.1 * 0.1));
        let middle_m = hub_m + 0.05 * Vector3::x();
        let mut of = joint("arm", law, (pivot_m, Vector3::y()), (CARRIER_KG, middle_m));
        of.damping = damping;
        robot.joints.push(of);
        wheel.carrier = Some(index);
    }
    robot
}

/// The rear wheels are on a rocker about the robot's long axis.
pub fn on_a_rocker() -> Robot {
    let mut robot = mecanum4();
    let middle_m = Vector3::new(-X_M, 0.0, 0.05);
    let law = (JointKind::Turns, JointRole::Free);
    let rocker = joint("rocker", law, (middle_m, Vector3::x()), (0.2, middle_m));
    robot.joints.push(rocker);
    for wheel in &mut robot.wheels[2..] {
        wheel.carrier = Some(0);
    }
    robot
}
