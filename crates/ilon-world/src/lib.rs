//! What **happens**: a rapier world in which every roller of an omnidirectional robot touches the ground by itself.
//!
//! - [`RollerShape`] is the exact barrel as a parry shape, [`RollerDispatcher`] its contacts with any ground.
//! - [`World`] holds one robot on one floor: torques in, truth out.
//!
//! Only this crate of the project names rapier or parry.

mod contact;
mod convert;
mod error;
mod groups;
mod roller_contact;
mod roller_shape;
mod settings;
mod wheel_body;
mod world;

pub use contact::WheelContact;
pub use error::WorldError;
pub use roller_contact::RollerDispatcher;
pub use roller_shape::RollerShape;
pub use settings::{Floor, RollerBodies, Settings};
pub use world::{BodyState, World};
