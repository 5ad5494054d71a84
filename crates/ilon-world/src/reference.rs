//! The reference mode: rapier alone. Every roller is a body on a joint of its own, and rapier's multibody and solver move everything, as they
//! do for anybody who builds such a robot with them.
//!
//! rapier counts in f32; here too positions are summed in f64 and handed to it rounded before every step.

mod barrel_shape;
mod dispatcher;
mod engine;
mod multibody;
mod step;

pub(crate) use multibody::Reference;
