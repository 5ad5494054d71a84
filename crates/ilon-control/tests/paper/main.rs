//! Indiveri 2009, equation by equation. Each test is named after the equation it holds the crate to.

#[path = "../../src/fixtures.rs"]
mod fixtures;

mod dynamics;
mod kinematics;
mod priorities;
mod random;
mod reference;
mod saturation;
mod torques;
mod tracking;
