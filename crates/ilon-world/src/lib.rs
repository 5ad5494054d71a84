//! What **happens**: a rapier world in which every roller of an omnidirectional robot touches the ground by itself.
//!
//! - [`RollerShape`] is the exact barrel as a parry shape, [`RollerDispatcher`] its contacts with any ground.
//! - [`World`] holds one robot on one floor: torques in, truth out.
//!
//! Only this crate of the project names rapier or parry.

mod assembly;
mod collision;
mod contact;
mod convert;
mod energy;
mod error;
mod ground;
mod groups;
mod impulse_problem;
mod reaction;
mod roller_contact;
mod roller_shape;
mod settings;
mod state;
mod wheel_body;
mod window;
mod world;

pub use contact::WheelContact;
pub use energy::Energy;
pub use error::WorldError;
pub use ground::{Floor, GroundBox, Patch, Relief};
pub use roller_contact::RollerDispatcher;
pub use roller_shape::RollerShape;
pub use settings::{RollerBodies, Settings};
pub use world::{BodyState, Payload, Push, World};
