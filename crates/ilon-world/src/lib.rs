//! What **happens**: a rapier world in which every roller of an omnidirectional robot touches the ground by itself.
//!
//! [`World`] holds robots on a floor, most of the time one: torques in, truth out. Each is an articulated body with an identity, a rapier world and
//! an f32 anchor of its own; contacts are between pairs of them and the ground.
//!
//! Only this crate of the project names rapier or parry.

mod contact;
mod dynamics;
mod engine;
mod error;
mod ground;
mod motor_torque;
mod reference;
mod robot;
mod settings;
mod world;

pub use contact::support::Support;
pub use contact::wheel_contact::WheelContact;
pub use error::WorldError;
pub use ground::{Floor, FloorSurface, Footing, GroundBox, Nap, Patch, Relief, Stribeck};
pub use motor_torque::{MotorTorque, TorqueBounds};
pub use robot::energy::Energy;
pub use robot::shared::SharedRobot;
pub use settings::{
    ContactSolver, RollerBodies, Settings, contact_relaxation_s, contact_stiffness_n_m,
};
pub use world::{Body, BodyId, BodyMut, BodyState, Payload, Push, World};
