//! The free motion of an articulated body, in f64: a floating root and revolute or prismatic joints
//! in any tree.
//!
//! q'' follows from M q'' + c = tau with M the mass matrix, c the forces of rotating frames, and
//! tau the forces of motors, gravity and others. M is built from composite rigid bodies and
//! factorised along the branches of the tree, so that zeros stay zeros ([`Mechanics`]); c comes
//! exactly from the recursive Newton-Euler equations at the given rates (Featherstone, Rigid Body
//! Dynamics Algorithms 2008, chapters 5, 6 and 8).
//!
//! **Coordinates.** The rates are the velocity of the root's centre of mass and its angular
//! velocity, both in the floor's frame, and then the rate of each joint. All vectors are along the
//! floor's axes and relative to the root's current centre of mass, so that a twist of the root is
//! its rates, and a joint's screw is its link's twist per unit rate.

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
