//! Bodies that move against the chassis, and the joints on which they do: rockers, swing arms, sprung wheels.

use nalgebra::{Isometry3, Vector3};

use super::{Collision, MassProperties};

/// A body beside the chassis, on the joint that it moves on.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyJoint {
    /// The joint's name in the robot's file.
    pub name: String,
    /// What carries it: the body of another joint, by its place among [`Robot::joints`](super::Robot::joints), where it stands before this one; `None` where that
    /// is the chassis.
    pub parent: Option<usize>,
    /// What it lets its body do.
    pub kind: JointKind,
    /// Pose of the joint's frame in the body frame while all joints stand at zero; it turns about its z axis, or slides along it.
    pub body_from_joint: Isometry3<f64>,
    /// The body.
    pub body: Body,
    /// What acts in it beside its damping and friction.
    pub role: JointRole,
    /// The least and the largest position, in rad or m; infinite where there is no stop.
    pub limits: [f64; 2],
    /// Viscous damping, >= 0, in N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, >= 0, in N m or N.
    pub friction: f64,
}

/// A rigid body that a joint moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The name of its link.
    pub name: String,
    /// Mass properties in the joint's frame.
    pub mass: MassProperties,
    /// Its collision geometry, in the body frame while all joints stand at zero. It is drawn; of a robot only chassis and rollers touch the
    /// world.
    pub collisions: Vec<Collision>,
}

/// What a joint lets its body do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turn about its axis; positions are in rad.
    Turns,
    /// Slide along it; positions are in m.
    Slides,
}

/// What acts in a joint beside damping and friction. A joint that is held is none: its body is a part of what carries it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum JointRole {
    /// Nothing.
    Free,
    /// A spring.
    Sprung(JointSpring),
}

/// A linear spring in a joint: on the body it acts with `preload - stiffness * (position - rest)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSpring {
    /// > 0, in N m/rad or N/m.
    pub stiffness: f64,
    /// The position at which it acts with its preload alone, in rad or m.
    pub rest: f64,
    /// What it acts with there, in N m or N.
    pub preload: f64,
}

/// A linear gear between two joints, as a mimic joint or a differential bar is: the position of one is factor times that of the other, and an
/// offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// The joint that follows, by its place among [`Robot::joints`](super::Robot::joints).
    pub joint: usize,
    /// The joint that it follows, by its place there.
    pub follows: usize,
    /// Its movement per movement of that.
    pub factor: f64,
    /// Where it stands while that stands at zero, in rad or m.
    pub offset: f64,
}

impl JointSpring {
    /// What it acts with on the body at a position, in N m or N.
    pub fn force_at(&self, position: f64) -> f64 {
        self.preload - self.stiffness * (position - self.rest)
    }
}

impl BodyJoint {
    /// The spring in it, if it is sprung.
    pub fn spring(&self) -> Option<&JointSpring> {
        match &self.role {
            JointRole::Sprung(spring) => Some(spring),
            JointRole::Free => None,
        }
    }

    /// Energy in its spring at a position, in J, above that at its rest.
    pub fn stored_j(&self, position: f64) -> f64 {
        self.spring().map_or(0.0, |spring| {
            let by = position - spring.rest;
            (0.5 * spring.stiffness * by - spring.preload) * by
        })
    }

    /// The centre of mass of its body in the body frame while all joints stand at zero, in metres.
    pub fn center_of_mass_m(&self) -> Vector3<f64> {
        let in_joint_m = nalgebra::Point3::from(self.body.mass.center_of_mass_m);
        (self.body_from_joint * in_joint_m).coords
    }
}
