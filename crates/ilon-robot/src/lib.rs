//! What an omnidirectional robot **is**: a chassis and N >= 3 driven wheels, each carrying passive rollers.
//!
//! Frames, used by every crate of the project:
//!
//! - *body*: the frame of the chassis link, x forward, y left, z up (REP-103).
//! - *hub*: one per wheel, its origin at the wheel's centre, its z axis along the hub axis **n** (positive wheel
//!   rates turn about it by the right-hand rule), its x axis straight down at wheel angle zero. It turns with the
//!   wheel.
//! - *roller*: one per roller, its origin at the roller's centre, its z axis along the roller's axis.
//!
//! A positive wheel rate drives the hub along **u** = **n** x **k** (Indiveri 2009, section II).
//!
//! A robot is read by [`Robot::load`] from URDF, xacro, SDF or MJCF, by structure and geometry and not by names (which count only
//! where a file models no rollers, and says of its wheels by their names that they have some), or with [`LoadOptions`] by
//! [`Robot::load_with`]. A robot whose rollers nobody wants to write by hand is described by a [`Spec`]
//! and written by [`generate`]:
//!
//! ```
//! use ilon_robot::{Robot, Spec, generate};
//!
//! let spec = Spec::from_toml_str(
//!     r#"
//!     name = "trike"
//!     [chassis]
//!     shape.cylinder = { radius_m = 0.2, height_m = 0.1 }
//!     mass_kg = 6.0
//!     center_m = [0.0, 0.0, 0.06]
//!     [wheel]
//!     radius_m = 0.05
//!     hub_mass_kg = 0.25
//!     hub_radius_m = 0.03
//!     hub_width_m = 0.04
//!     motor_effort_n_m = 1.0
//!     motor_velocity_rad_s = 20.0
//!     [rollers]
//!     per_row = 8
//!     radius_m = 0.012
//!     mass_kg = 0.01
//!     [wheels.ring]
//!     count = 3
//!     distance_m = 0.2
//!     gamma_deg = 0.0
//!     "#,
//!     "trike.toml",
//! )?;
//! let robot = Robot::from_urdf_str(&generate(&spec)?, "trike.urdf")?;
//! assert_eq!(robot.wheels.len(), 3);
//! assert!((robot.wheels[0].radius_m - 0.05).abs() < 1e-12);
//! # Ok::<(), ilon_robot::RobotError>(())
//! ```

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod angles;
mod convert;
mod error;
pub mod files;
mod generate;
mod load;
mod model;
mod options;
mod packages;
mod prepare;
mod spec;
mod urdf;
mod xacro;
mod xml;

pub use angles::roll_pitch_yaw;
pub use error::{Clue, ClueKind, Clues, Fault, Looked, MissingFile, Place, Remedy, RobotError};
pub use files::{FileAccess, ReadError};
pub use generate::generate;
pub use load::{Diagnosis, Loaded};
pub use model::{
    Barrel, Chassis, Collision, CollisionShape, DriveTrain, Joint, MassProperties, ModelledRoller,
    MotorLimits, NotMade, NotTurned, Pose, Profile, ProfilePart, Remark, Robot, Roller, RollerForm,
    RollerSurface, RollersAsMade, Scale, StandingPose, Tread, Turned, Twist, Wheel, mean_of_gain,
    wrap_angle,
};
pub use model::{barrel, made, profile, tread, turned};
pub use options::{Handedness, LoadOptions, RollerForms, WheelOptions};
pub use packages::Package;
pub use prepare::urdf_text;
pub use spec::{
    Arrangement, ChassisShape, ChassisSpec, PlacedWheel, RollerSpec, Spec, TreadSpec,
    WheelOverride, WheelSpec,
};
pub use urdf::{Looks, Mesh, WheelOutline};
