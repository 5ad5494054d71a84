//! Dead reckoning that knows the wheels' places under joints between bodies.

use ilon_robot::{Pose, Robot};

use crate::sensing::hubs::Hubs;

/// Dead reckoning by Indiveri 2009, eq. (5), with the wheels at their places under their joints,
/// once a control period.
#[derive(Clone)]
pub(crate) struct PosedOdometry {
    hubs: Hubs,
    /// The angle by which each wheel rolled over the ground in the last control period, in rad.
    rolled_rad: Vec<f64>,
    pose: Pose,
}

impl PosedOdometry {
    pub fn new(robot: &Robot, start: Pose) -> Self {
        Self {
            hubs: Hubs::new(robot),
            rolled_rad: vec![0.0; robot.wheels.len()],
            pose: start,
        }
    }

    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// The angle by which each wheel rolled over the ground in the last control period, in rad: its
    /// encoder's, plus that from its hub's motion.
    pub fn rolled_rad(&self) -> &[f64] {
        &self.rolled_rad
    }

    /// The wheels at the known joint positions.
    pub fn hubs(&self) -> &Hubs {
        &self.hubs
    }

    /// Advances by the wheels' rotation in a control period, in rad, with the joints at these
    /// positions, in rad or m, which are empty where none are known yet. Returns whether joints
    /// have moved since the last.
    pub fn reckon(&mut self, turned_rad: &[f64], positions: &[f64]) -> bool {
        self.rolled_rad.copy_from_slice(turned_rad);
        if positions.is_empty() {
            return false;
        }
        let moved = self.hubs.see(positions);
        if let Some(displacement) = self.hubs.displacement(&mut self.rolled_rad) {
            self.pose = self.pose.moved(displacement);
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;
    use ilon_robot::{Body, BodyJoint, JointKind, JointRole, MassProperties};
    use nalgebra::{Isometry3, Vector3};

    use super::*;

    const URDF: &str = include_str!("../../../../../assets/robots/mecanum4.urdf");

    /// The mecanum4 with all of its wheels on one carrier, on a joint at the body's origin.
    fn on_a_carrier(kind: JointKind, axis: Vector3<f64>) -> Robot {
        let mut robot = Robot::from_urdf_str(URDF, "mecanum4.urdf").expect("a robot");
        let turn = nalgebra::UnitQuaternion::rotation_between(&Vector3::z(), &axis);
        let body_from_joint =
            Isometry3::from_parts(Vector3::zeros().into(), turn.expect("not the opposite"));
        robot.joints.push(BodyJoint {
            name: "carrier".to_owned(),
            parent: None,
            kind,
            body_from_joint,
            body: Body {
                name: "carrier".to_owned(),
                mass: MassProperties::point(1.0, Vector3::zeros()),
                collisions: Vec::new(),
            },
            role: JointRole::Free,
            limits: [-1.0, 1.0],
            damping: 0.0,
            friction: 0.0,
        });
        robot
            .wheels
            .iter_mut()
            .for_each(|wheel| wheel.carrier = Some(0));
        robot
    }

    /// Wheels stand on the ground while their carrier moves under the body: the body moves back by
    /// as much, which eq. (7) alone would not see.
    #[test]
    fn hubs_that_move_move_the_body() {
        for (kind, axis, at, expected) in [
            (JointKind::Slides, Vector3::x(), 0.1, [-0.1, 0.0, 0.0]),
            (JointKind::Slides, Vector3::y(), -0.05, [0.0, 0.05, 0.0]),
            (JointKind::Turns, Vector3::z(), 0.3, [0.0, 0.0, -0.3]),
        ] {
            let robot = on_a_carrier(kind, axis);
            let mut odometry = PosedOdometry::new(&robot, Pose::default());
            let steps = 2000;
            for step in 0..=steps {
                odometry.reckon(&[0.0; 4], &[at * f64::from(step) / f64::from(steps)]);
            }
            let pose = odometry.pose();
            let found = [pose.x_m, pose.y_m, pose.heading_rad];
            for (found, expected) in found.iter().zip(expected) {
                // Each period uses the kinematics of its end: first order in the period.
                assert!((found - expected).abs() < 1e-3, "{found} {expected}");
            }
        }
    }

    /// A carrier that turns about the wheels' own axis rolls them: an encoder relative to it sees
    /// nothing.
    #[test]
    fn a_carrier_that_turns_about_an_axle_rolls_the_wheel() {
        let mut robot = on_a_carrier(JointKind::Turns, Vector3::y());
        let hub_m = robot.wheels[0].body_from_hub.translation.vector;
        robot.joints[0].body_from_joint.translation = Vector3::new(0.0, 0.0, hub_m.z).into();
        // All hubs on one axle, so that they turn in place.
        for wheel in &mut robot.wheels {
            wheel.body_from_hub.translation.vector.x *= 1e-9;
        }
        robot.wheels[0].body_from_hub.translation.vector.x = 0.0;
        let mut odometry = PosedOdometry::new(&robot, Pose::default());
        for step in 0..=100 {
            odometry.reckon(&[0.0; 4], &[0.2 * f64::from(step) / 100.0]);
        }
        let radius_m = robot.wheels[0].radius_m;
        let pose = odometry.pose();
        assert!(
            (pose.x_m - 0.2 * radius_m).abs() < 1e-3 * radius_m,
            "{pose:?}"
        );
    }
}
