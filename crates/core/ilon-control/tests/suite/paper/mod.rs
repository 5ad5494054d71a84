//! Indiveri 2009, equation by equation. Each test is named after the equation it holds the crate
//! to.

use crate::fixtures;

mod dynamics;
mod kinematics;
mod priorities;
mod random;
mod reference;
mod saturation;
mod tasks;
mod torques;
mod tracking;
