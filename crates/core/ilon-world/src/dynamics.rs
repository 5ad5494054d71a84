//! How an articulated body moves where nothing touches it, in f64: a floating root and joints that turn or slide, of any shape of
//! tree.
//!
//! q'' follows from M q'' + c = tau with M the mass matrix, c what turning frames ask for, and tau the forces of motors, gravity and
//! whatever else acts. M is set up by composite rigid bodies and factorised along the branches of the tree, so that zeros stay zeros
//! ([`Mechanics`]); c comes exactly from the recursive Newton-Euler equations at the rates that are given (Featherstone,
//! Rigid Body Dynamics Algorithms 2008, chapters 5, 6 and 8).
//!
//! **Coordinates.** The rates are the velocity of the root's centre of mass and its angular velocity, both in the floor's frame,
//! and then one of each joint. Everything is counted along the floor's axes from the root's centre of mass, where it is at that moment,
//! so that a twist of the root is its rates, and a joint's screw what its unit rate makes of its link's twist.

mod attached;
mod factors;
mod mechanics;
#[cfg(test)]
mod tests;
mod tree;

pub(crate) use attached::Attached;
pub(crate) use factors::Factors;
pub(crate) use mechanics::{Loads, Mechanics};
pub(crate) use tree::{DEEPEST, Joint, LinkPose, Motion, Path, ROOT_DOFS, Tree};
