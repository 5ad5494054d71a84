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

pub mod barrel;
mod error;
mod generate;
mod load;
mod model;
mod planar;
mod spec;

pub use barrel::Barrel;
pub use error::{Fault, Place, RobotError};
pub use generate::generate;
pub use load::{Handedness, LoadOptions, Loaded, Package, WheelOptions, WheelOutline};
pub use model::{
    Chassis, Collision, CollisionShape, Joint, MassProperties, MotorLimits, Remark, Robot, Roller,
    Wheel,
};
pub use planar::{Pose, Twist, wrap_angle};
pub use spec::{Arrangement, ChassisShape, ChassisSpec, PlacedWheel, RollerSpec, Spec, WheelSpec};
