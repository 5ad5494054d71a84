//! Bodies that move relative to the chassis, and their joints: rockers, swing arms, sprung wheels.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Vector3};

use super::{Collision, MassProperties};

/// A body other than the chassis, with its joint.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyJoint {
    /// The joint's name in the robot's file.
    pub name: String,
    /// The carrier: the body of another joint, by its index in
    /// [`Robot::joints`](super::Robot::joints), before this one; `None` for the chassis.
    pub parent: Option<usize>,
    /// The motion that it allows.
    pub kind: JointKind,
    /// Pose of the joint's frame in the body frame while all joints are at zero; it turns about its
    /// z axis, or slides along it.
    pub body_from_joint: Isometry3<f64>,
    /// The body.
    pub body: Body,
    /// The force in it besides damping and friction.
    pub role: JointRole,
    /// The smallest and the largest position, in rad or m; infinite without a stop.
    pub limits: [f64; 2],
    /// Viscous damping, >= 0, in N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, >= 0, in N m or N.
    pub friction: f64,
}

/// A rigid body on a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The name of its link.
    pub name: String,
    /// Mass properties in the joint's frame.
    pub mass: MassProperties,
    /// Its collision geometry, in the body frame while all joints are at zero; it collides with
    /// ground and other bodies, not with its own robot.
    pub collisions: Vec<Collision>,
}

/// The motion of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation about its axis; positions are in rad.
    Turns,
    /// Translation along its axis; positions are in m.
    Slides,
}

/// The force in a joint besides damping and friction. A locked joint has no role: its body is
/// merged into its carrier.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum JointRole {
    /// None.
    Free,
    /// A spring.
    Sprung(JointSpring),
    /// A servo.
    Driven(JointServo),
}

/// A linear spring in a joint, with the force `preload - stiffness * (position - rest)` on the
/// body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSpring {
    /// > 0, in N m/rad or N/m.
    pub stiffness: f64,
    /// The position at which its force is the preload, in rad or m.
    pub rest: f64,
    /// Its force at `rest`, in N m or N.
    pub preload: f64,
}

/// A position servo in a joint, like a drive with a stiff control loop, with the force `stiffness *
/// (target - position) + damping * (target rate - rate)` on the body, limited to its effort.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointServo {
    /// > 0, in N m/rad or N/m.
    pub stiffness: f64,
    /// >= 0, in N m s/rad or N s/m.
    pub damping: f64,
    /// Largest force, > 0, in N m or N; infinite without a limit.
    pub effort: f64,
    /// Largest rate of its target, > 0, in rad/s or m/s; infinite without a limit.
    pub rate_limit: f64,
    /// Initial target, in rad or m. A world starts with the joint in equilibrium about it.
    pub target: f64,
}

/// A linear gear between two joints, like a mimic joint or a differential bar: the position of one
/// is the factor times that of the other, plus an offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// The follower, by its index in [`Robot::joints`](super::Robot::joints).
    pub joint: usize,
    /// The joint that it follows, by its index there.
    pub follows: usize,
    /// Its movement per movement of the other joint.
    pub factor: f64,
    /// Its position while the other joint is at zero, in rad or m.
    pub offset: f64,
}

impl JointSpring {
    /// Returns its force on the body at a position, in N m or N.
    pub fn force_at(&self, position: f64) -> f64 {
        self.preload - self.stiffness * (position - self.rest)
    }
}

impl JointServo {
    /// Natural frequency of [`JointServo::for_inertia`], in Hz (chosen): far above how fast arms
    /// move, far below what a control step of some milliseconds resolves.
    pub const FREQUENCY_HZ: f64 = 10.0;

    /// Returns the stiffness that gives an inertia, in kg m^2 or kg, the natural frequency
    /// [`JointServo::FREQUENCY_HZ`].
    pub fn stiffness_for(inertia: f64) -> f64 {
        inertia * (TAU * Self::FREQUENCY_HZ).powi(2)
    }

    /// Returns the critical damping of an inertia on a stiffness.
    pub fn damping_for(inertia: f64, stiffness: f64) -> f64 {
        2.0 * (inertia * stiffness).sqrt()
    }

    /// Returns a servo at zero, without limits, for an inertia in kg m^2 or kg: critically damped
    /// at [`JointServo::FREQUENCY_HZ`].
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
    /// Whether it turns about an upright axis, while all joints are at zero.
    pub(super) fn turns_upright(&self) -> bool {
        /// Cosine of the largest lean of an upright axis, 8 degrees (chosen).
        const UPRIGHT: f64 = 0.99;
        let axis = self.body_from_joint.rotation * Vector3::z();
        self.kind == JointKind::Turns && axis.z.abs() > UPRIGHT
    }

    /// The spring, if the joint is sprung.
    pub fn spring(&self) -> Option<&JointSpring> {
        match &self.role {
            JointRole::Sprung(spring) => Some(spring),
            JointRole::Free | JointRole::Driven(_) => None,
        }
    }

    /// The servo, if the joint is driven.
    pub fn servo(&self) -> Option<&JointServo> {
        match &self.role {
            JointRole::Driven(servo) => Some(servo),
            JointRole::Free | JointRole::Sprung(_) => None,
        }
    }

    /// The spring that determines its deflection at rest: its own, or a servo's stiffness about its
    /// target; `None` for a free joint.
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

    /// Returns the energy in its spring at a position, in J, above that at its rest.
    pub fn stored_j(&self, position: f64) -> f64 {
        self.spring().map_or(0.0, |spring| {
            let by = position - spring.rest;
            (0.5 * spring.stiffness * by - spring.preload) * by
        })
    }

    /// The centre of mass of its body in the body frame while all joints are at zero, in metres.
    pub fn center_of_mass_m(&self) -> Vector3<f64> {
        let in_joint_m = nalgebra::Point3::from(self.body.mass.center_of_mass_m);
        (self.body_from_joint * in_joint_m).coords
    }
}
