//! The reference mode: rapier alone. Every roller is a body on its own joint, and rapier's
//! multibody and solver move everything, as in any robot built with rapier.
//!
//! Its poses are set to the middle of each step before the step, as in the other mode.

mod barrel_shape;
mod dispatcher;
mod engine;
mod multibody;
mod step;

pub(crate) use multibody::Reference;
