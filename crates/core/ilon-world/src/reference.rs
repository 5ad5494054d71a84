//! The reference mode: rapier alone. Every roller is a body on a joint of its own, and rapier's multibody and solver move everything, as they
//! do for anybody who builds such a robot with them.
//!
//! Its places are set before every step to the middle of it, as in the other mode.

mod barrel_shape;
mod dispatcher;
mod engine;
mod multibody;
mod step;

pub(crate) use multibody::Reference;
