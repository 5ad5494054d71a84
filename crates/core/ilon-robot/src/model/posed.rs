//! Robots with joints at positions other than zero.

use nalgebra::{Isometry3, Vector3};

use super::{BodyJoint, JointKind, JointRole, Robot, Wheel};

impl Robot {
    /// Returns the same robot with its joints' zero at the given positions, in rad or m: wheels,
    /// bodies and collision shapes are moved there; limits, springs, targets and couplings keep
    /// their place in space.
    ///
    /// So all computations for a robot with joints at zero, such as kinematics, masses, loads and
    /// drawings, work in any pose. A missing position is zero.
    pub fn posed(&self, positions: &[f64]) -> Self {
        let mut robot = self.clone();
        let at = |joint: usize| positions.get(joint).copied().unwrap_or(0.0);
        let moved = self.moved(positions);
        for (index, (to, of)) in robot.joints.iter_mut().zip(&moved).enumerate() {
            to.body_from_joint = of.body_from_joint;
            for collision in &mut to.body.collisions {
                collision.body_from_shape = of.from_zero * collision.body_from_shape;
            }
            to.count_from(at(index));
        }
        for wheel in &mut robot.wheels {
            wheel.body_from_hub = carried_by(&moved, wheel.carrier) * wheel.body_from_hub;
        }
        for coupling in &mut robot.couplings {
            coupling.offset += coupling.factor * at(coupling.follows) - at(coupling.joint);
        }
        robot
    }

    /// Returns the pose of each hub in the body frame, at wheel angle zero, with the joints at
    /// these positions, in rad or m: those of [`Self::posed`].
    pub fn body_from_hubs(&self, positions: &[f64]) -> Vec<Isometry3<f64>> {
        let moved = self.moved(positions);
        let hub = |wheel: &Wheel| carried_by(&moved, wheel.carrier) * wheel.body_from_hub;
        self.wheels.iter().map(hub).collect()
    }

    /// Each joint and its body with the joints at these positions, in rad or m.
    fn moved(&self, positions: &[f64]) -> Vec<Moved> {
        // Parents come before their children.
        let mut moved = Vec::with_capacity(self.joints.len());
        for (index, joint) in self.joints.iter().enumerate() {
            let carried = carried_by(&moved, joint.parent);
            let at = positions.get(index).copied().unwrap_or(0.0);
            let body_from_joint = carried * joint.body_from_joint * joint.moved_by(at);
            moved.push(Moved {
                body_from_joint,
                from_zero: body_from_joint * joint.body_from_joint.inverse(),
            });
        }
        moved
    }

    /// Returns the joint positions at the start of a run, in rad or m, before anything sags: a
    /// driven joint where its servo starts, others at zero or the stop nearest to it, followers as
    /// their couplings require.
    pub fn start_positions(&self) -> Vec<f64> {
        let nearest = |joint: &BodyJoint| {
            let target = joint.servo().map_or(0.0, |servo| servo.target);
            target.max(joint.limits[0]).min(joint.limits[1])
        };
        let mut positions: Vec<f64> = self.joints.iter().map(nearest).collect();
        self.couple(&mut positions);
        positions
    }

    /// Sets the positions of joints that follow others, in rad or m, by their couplings.
    pub fn couple(&self, positions: &mut [f64]) {
        // Each pass sets the followers of joints that are already set.
        for _ in &self.couplings {
            for coupling in &self.couplings {
                positions[coupling.joint] =
                    coupling.factor * positions[coupling.follows] + coupling.offset;
            }
        }
    }
}

/// The pose of a joint, and the motion of its body from joint positions of zero, in the body frame.
struct Moved {
    body_from_joint: Isometry3<f64>,
    from_zero: Isometry3<f64>,
}

fn carried_by(moved: &[Moved], carrier: Option<usize>) -> Isometry3<f64> {
    let carrier = carrier.and_then(|joint| moved.get(joint));
    carrier.map_or_else(Isometry3::identity, |joint| joint.from_zero)
}

impl BodyJoint {
    /// Returns the motion of the joint's frame from zero to a position, in that frame.
    fn moved_by(&self, position: f64) -> Isometry3<f64> {
        match self.kind {
            JointKind::Turns => Isometry3::rotation(position * Vector3::z()),
            JointKind::Slides => Isometry3::translation(0.0, 0.0, position),
        }
    }

    /// Moves the zero of its positions.
    fn count_from(&mut self, position: f64) {
        self.limits.iter_mut().for_each(|limit| *limit -= position);
        match &mut self.role {
            JointRole::Free => {}
            JointRole::Sprung(spring) => spring.rest -= position,
            JointRole::Driven(servo) => servo.target -= position,
        }
    }
}

#[cfg(test)]
pub(super) mod tests;
