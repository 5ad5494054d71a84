//! Robots with locked joints: the bodies of these joints are merged into what carries them.

use super::{Chassis, Collision, Coupling, MassProperties, Robot};

impl Robot {
    /// Returns the robot with some joints locked at positions in rad or m: the body of each is
    /// merged into its carrier, which then carries its children. `held` has the position of each of
    /// [`Robot::joints`] to lock, and `None` for each that moves; missing entries move. Couplings
    /// of a locked joint are removed: lock all coupled joints, or none.
    pub fn with_joints_held(&self, held: &[Option<f64>]) -> Self {
        let of = |joint: usize| held.get(joint).copied().flatten();
        let positions: Vec<f64> = (0..self.joints.len())
            .map(|joint| of(joint).unwrap_or(0.0))
            .collect();
        let mut robot = self.posed(&positions);
        // The nearest joint above that still moves, by its new index.
        let mut kept: Vec<Option<usize>> = Vec::with_capacity(robot.joints.len());
        let mut joints: Vec<super::BodyJoint> = Vec::new();
        for (index, mut joint) in std::mem::take(&mut robot.joints).into_iter().enumerate() {
            let carrier = joint.parent.and_then(|parent| kept[parent]);
            if of(index).is_none() {
                joint.parent = carrier;
                joints.push(joint);
                kept.push(Some(joints.len() - 1));
                continue;
            }
            let in_body = joint.body.mass.moved(&joint.body_from_joint);
            let collisions = joint.body.collisions;
            match carrier {
                None => robot.chassis.join(&in_body, collisions),
                Some(carrier) => {
                    let carrier = &mut joints[carrier];
                    let there = in_body.moved(&carrier.body_from_joint.inverse());
                    carrier.body.mass = carrier.body.mass.joined(&there);
                    carrier.body.collisions.extend(collisions);
                }
            }
            kept.push(carrier);
        }
        robot.joints = joints;
        for wheel in &mut robot.wheels {
            wheel.carrier = wheel.carrier.and_then(|joint| kept[joint]);
        }
        let moves = |joint: usize| of(joint).is_none().then(|| kept[joint]).flatten();
        let couplings = std::mem::take(&mut robot.couplings).into_iter();
        robot.couplings = couplings
            .filter_map(|coupling| {
                Some(Coupling {
                    joint: moves(coupling.joint)?,
                    follows: moves(coupling.follows)?,
                    ..coupling
                })
            })
            .collect();
        robot
    }
}

impl Chassis {
    fn join(&mut self, part: &MassProperties, collisions: Vec<Collision>) {
        self.mass = self.mass.joined(part);
        self.collisions.extend(collisions);
    }
}

impl MassProperties {
    /// Merges another body, given in the same frame, into this one; unchanged if both have zero
    /// mass.
    fn joined(&self, part: &Self) -> Self {
        Self::merged(&[self.clone(), part.clone()]).unwrap_or_else(|| self.clone())
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::posed::tests::{joint, robot};
    use crate::JointKind;

    /// A lift carries a turntable, which carries an arm. Whichever of them are locked, mass, centre
    /// and the inertia on the arm stay the same; the moving joints keep their names and places.
    #[test]
    fn what_is_held_is_part_of_what_carries_it() {
        let joints = vec![
            joint(None, JointKind::Slides, Vector3::new(0.0, 0.0, 0.5)),
            joint(Some(0), JointKind::Turns, Vector3::new(0.2, 0.1, 0.7)),
            joint(Some(1), JointKind::Turns, Vector3::new(0.3, 0.1, 0.9)),
        ];
        let whole = robot(joints);
        let at = [0.2, 0.7, 0.0];
        let posed = whole.posed(&at);
        for held in [
            [true, true, false],
            [false, true, false],
            [true, false, false],
        ] {
            let asked: Vec<Option<f64>> =
                held.iter().zip(at).map(|(h, q)| h.then_some(q)).collect();
            let less = whole.with_joints_held(&asked);
            let moves = held.iter().filter(|held| !**held).count();
            assert_eq!(less.joints.len(), moves);
            // The other joints are moved to the same pose.
            let rest: Vec<f64> = (0..3).filter(|i| !held[*i]).map(|i| at[i]).collect();
            let less = less.posed(&rest);
            assert!((less.mass_kg() - 7.0).abs() < 1e-14);
            let off = (less.center_of_mass_m() - posed.center_of_mass_m()).norm();
            assert!(off < 1e-14, "{held:?}: {off}");
            let [arm, of_whole] = [&less, &posed].map(|of| of.joints.last().unwrap());
            let off =
                (arm.body_from_joint.to_matrix() - of_whole.body_from_joint.to_matrix()).norm();
            assert!(off < 1e-14, "{held:?}: {off}");
            // Turntable and lift still carry the same mass.
            if !held[0] {
                let [less, posed] = [&less, &posed].map(|of| of.inertia_on_joint(0));
                assert!((less - posed).abs() < 1e-14);
            }
            if !held[1] {
                let [less, posed] = [less.inertia_on_joint(moves - 2), posed.inertia_on_joint(1)];
                assert!((less - posed).abs() < 1e-13, "{less} {posed}");
            }
        }
    }
}
