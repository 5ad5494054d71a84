//! The ground's forces on a robot as a whole: support and obstacles.

use nalgebra::{Vector2, Vector3};

use crate::contact::reactions::reaction::{Part, Partner, Reaction};

/// The ground's forces on a robot during the last step: means over it, in the world frame, in N.
///
/// The world's z axis is the floor's normal, also on a slope.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Support {
    /// Load on the wheels: the ground's force on all rollers along the floor's normal.
    pub wheels_n: f64,
    /// Load on the chassis and on bodies on joints: the same for their parts that touch the ground.
    pub chassis_n: f64,
    /// Force of walls, kerbs and bumps on the robot: the part of all normal forces in the floor's
    /// plane, x and y. Zero on a flat floor.
    pub obstacles_n: Vector2<f64>,
}

impl Support {
    /// Adds the impulse of a reaction on this robot, in N s, if it is the ground's.
    pub(crate) fn add(&mut self, reaction: &Reaction) {
        if reaction.b != Partner::Ground {
            return;
        }
        let carried = match reaction.a.part {
            Part::Chassis | Part::Link(_) => &mut self.chassis_n,
            Part::Roller(..) => &mut self.wheels_n,
            _ => return,
        };
        let normal: Vector3<f64> = reaction.impulse.x * reaction.frame[0];
        *carried += normal.z + reaction.friction_impulse_n_s().z;
        self.obstacles_n += normal.xy();
    }

    /// The mean force of these impulses over a time in seconds.
    pub(crate) fn over(self, dt_s: f64) -> Self {
        Self {
            wheels_n: self.wheels_n / dt_s,
            chassis_n: self.chassis_n / dt_s,
            obstacles_n: self.obstacles_n / dt_s,
        }
    }
}
