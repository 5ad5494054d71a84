//! Reads omnidirectional robots from files, writes them as URDF, and reports faults of the files
//! with remedies.
//!
//! [`Robot::load`](LoadRobot::load) reads a robot from URDF, xacro, SDF or MJCF, by structure and
//! geometry; names only count if a file models no rollers, and its wheels' names imply some.
//! [`Robot::load_with`](LoadRobot::load_with) takes [`LoadOptions`]. A robot with rollers too many
//! to write by hand is described by a [`Spec`] and written by [`generate`]:
//!
//! ```
//! use ilon_formats::{LoadRobot, Spec, generate};
//! use ilon_robot::Robot;
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
//! # Ok::<(), ilon_formats::RobotError>(())
//! ```

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod build;
mod convert;
mod described_wheel;
mod diagnosis;
mod error;
mod generate;
mod load;
mod loaded;
mod options;
mod packages;
mod prepare;
mod solid;
mod spec;
mod urdf;
mod wheels;

use ilon_files as files;
use ilon_robot as model;
use xacro_expand::xml;

pub use build::{build, described};
pub use diagnosis::{Diagnosis, Question};
pub use error::{
    CandidateJoint, Clue, ClueKind, Clues, Fault, MissingFile, Proposed, Remedy, RobotError,
    TextPlace,
};
pub use generate::{describe, generate, generate_on_tyres, with_ros2_control};
pub use load::LoadRobot;
pub use loaded::Loaded;
pub use options::{
    Handedness, JointOptions, LoadOptions, RoleOption, RollerForms, TyreOptions, WheelOptions,
};
pub use packages::Package;
pub use prepare::urdf_text;
pub use spec::{
    Arrangement, CasterSpec, ChassisShape, ChassisSpec, PlacedWheel, RollerBearings, RollerSpec,
    Spec, SpecOnTyres, SteeringSpec, SuspensionLaw, SuspensionSpec, TreadSpec, TyreSpec,
    TyredWheel, WheelOverride, WheelSpec,
};
pub use urdf::{WheelOutline, link_tree, mesh_triangles};
pub use wheels::{
    FittedRobot, Format, Ground, RollerShape, STEP_S, contact_stiffness_n_m, fit, write_fitted,
};
