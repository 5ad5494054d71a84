//! Bodies that move against the chassis, and the joints on which they do: rockers, swing arms, sprung wheels.

use std::f64::consts::TAU;

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
    /// Its collision geometry, in the body frame while all joints stand at zero: with it the body touches ground and other bodies, none of its own
    /// robot's.
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
    /// A servo.
    Driven(JointServo),
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

/// A position servo in a joint, as a drive with a stiff control loop is: on the body it acts with
/// `stiffness * (target - position) + damping * (target rate - rate)`, and never with more than its effort.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointServo {
    /// > 0, in N m/rad or N/m.
    pub stiffness: f64,
    /// >= 0, in N m s/rad or N s/m.
    pub damping: f64,
    /// The most it acts with, > 0, in N m or N; infinite where there is no limit.
    pub effort: f64,
    /// How fast its target moves at most, > 0, in rad/s or m/s; infinite where there is no limit.
    pub rate_limit: f64,
    /// Its target until it is given another, in rad or m. A world begins with the joint in equilibrium about it.
    pub target: f64,
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

impl JointServo {
    /// The natural frequency that [`JointServo::for_inertia`] gives, in Hz: far above how fast arms move, far below what a control step of
    /// some milliseconds resolves.
    pub const FREQUENCY_HZ: f64 = 10.0;

    /// The stiffness that swings an inertia, in kg m^2 or kg, at [`JointServo::FREQUENCY_HZ`].
    pub fn stiffness_for(inertia: f64) -> f64 {
        inertia * (TAU * Self::FREQUENCY_HZ).powi(2)
    }

    /// The damping that is critical for an inertia on a stiffness.
    pub fn damping_for(inertia: f64, stiffness: f64) -> f64 {
        2.0 * (inertia * stiffness).sqrt()
    }

    /// A servo at zero without limits for an inertia, in kg m^2 or kg: critically damped at [`JointServo::FREQUENCY_HZ`].
    pub fn for_inertia(inertia: f64) -> Self {
        let stiffness = Self::stiffness_for(inertia);
        Self {
            stiffness,
            damping: Self::damping_for(inertia, stiffness),
            effort: f64::INFINITY,
            rate_limit: f64::INFINITY,
            target: 0.0,
        }
    }
}

impl BodyJoint {
    /// The spring in it, if it is sprung.
    pub fn spring(&self) -> Option<&JointSpring> {
        match &self.role {
            JointRole::Sprung(spring) => Some(spring),
            JointRole::Free | JointRole::Driven(_) => None,
        }
    }

    /// The servo in it, if it is driven.
    pub fn servo(&self) -> Option<&JointServo> {
        match &self.role {
            JointRole::Driven(servo) => Some(servo),
            JointRole::Free | JointRole::Sprung(_) => None,
        }
    }

    /// The spring by which it gives way at rest: its own, or a servo's stiffness about its target; `None` where it gives way freely.
    pub fn gives_by(&self) -> Option<JointSpring> {
        match &self.role {
            JointRole::Sprung(spring) => Some(*spring),
            JointRole::Driven(servo) => Some(JointSpring {
                stiffness: servo.stiffness,
                rest: servo.target,
                preload: 0.0,
            }),
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
