//! Joints for robots in tests.

use ilon_robot::{
    Body, BodyJoint, JointKind, JointRole, JointServo, JointSpring, MassProperties, Robot,
};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use crate::tests::robots::mecanum4;

/// A revolute joint on the chassis, about a direction at a point in metres. It carries a body with
/// a mass in kg, whose centre relative to that point is given at joint position zero, and with the
/// inertia of a ball of 0.1 m.
pub fn joint(
    at_m: Vector3<f64>,
    axis: Vector3<f64>,
    (mass_kg, middle_m): (f64, Vector3<f64>),
) -> BodyJoint {
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &axis).expect("not opposite");
    BodyJoint {
        name: "joint".to_owned(),
        parent: None,
        kind: JointKind::Turns,
        body_from_joint: Isometry3::from_parts(at_m.into(), turn),
        body: Body {
            name: "body".to_owned(),
            mass: MassProperties {
                mass_kg,
                center_of_mass_m: turn.inverse() * middle_m,
                inertia_kg_m2: Matrix3::identity() * (0.4 * mass_kg * 0.1 * 0.1),
            },
            collisions: Vec::new(),
        },
        role: JointRole::Free,
        limits: [f64::NEG_INFINITY, f64::INFINITY],
        damping: 0.0,
        friction: 0.0,
    }
}

/// The same joint, driven by a servo.
pub fn driven(joint: BodyJoint) -> BodyJoint {
    BodyJoint {
        role: JointRole::Driven(JointServo::for_inertia(1.0)),
        ..joint
    }
}

/// The mecanum robot with each wheel on a vertical slide with a spring of a stiffness in N/m.
pub fn on_springs(stiffness: f64) -> Robot {
    let mut robot = mecanum4();
    for (index, wheel) in robot.wheels.iter_mut().enumerate() {
        robot.joints.push(BodyJoint {
            kind: JointKind::Slides,
            role: JointRole::Sprung(JointSpring {
                stiffness,
                rest: 0.0,
                preload: 0.0,
            }),
            ..joint(wheel.position_m(), Vector3::z(), (0.1, Vector3::zeros()))
        });
        wheel.carrier = Some(index);
    }
    robot
}
