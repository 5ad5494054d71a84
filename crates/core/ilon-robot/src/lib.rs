//! The **model** of an omnidirectional robot: a chassis and N >= 3 driven wheels, each carrying
//! passive rollers.
//!
//! Frames, used by every crate of the project:
//!
//! - *body*: the frame of the chassis link, x forward, y left, z up (REP-103).
//! - *hub*: one per wheel, its origin at the wheel's centre, its z axis along the hub axis **n**
//!   (positive wheel rates turn about it by the right-hand rule), its x axis straight down at wheel
//!   angle zero. It turns with the wheel.
//! - *roller*: one per roller, its origin at the roller's centre, its z axis along the roller's
//!   axis.
//!
//! A positive wheel rate drives the hub along **u** = **n** x **k** (Indiveri 2009, section II).
//!
//! The crate contains no file format: `ilon-formats` reads the model from URDF, xacro, SDF, MJCF or
//! a description in TOML.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod angles;
mod bisection;
mod model;

pub use angles::roll_pitch_yaw;
pub use bisection::bisected;
pub use model::{
    Barrel, Body, BodyJoint, Chassis, Collision, CollisionShape, Coupling, DriveTrain, FreeShape,
    HubHeights, Joint, JointKind, JointRole, JointServo, JointSpring, Link, LinkJoint, LinkTree,
    MassProperties, Mesh, ModelledRoller, MotorLimits, NotMade, Pose, Profile, ProfileError,
    ProfilePart, Remark, Robot, RobotDescription, Roller, RollerForm, RollerSurface, RollersAsMade,
    Scale, SolidOfRevolution, StandingPose, TorqueBounds, Tread, Twist, Visual, VisualMeshes,
    VisualShape, Wheel, mean_of_gain, time_and_gain_until, wrap_angle,
};
pub use model::{
    barrel_profile, mass, modelled_profile, rollers_as_made, solid_of_revolution, tread,
};
