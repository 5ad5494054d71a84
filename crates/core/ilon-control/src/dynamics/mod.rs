//! Torques of a motion (Indiveri 2009, eq. (11)), wheel loads and grip.

pub(crate) mod acceleration_limits;
pub(crate) mod capacity;
mod interval;
pub(crate) mod loads;
pub(crate) mod model;
pub(crate) mod traction;
mod tree_loads;
mod wheel_force;
