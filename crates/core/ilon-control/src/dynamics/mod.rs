//! Which torques a motion takes: Indiveri 2009, eq. (11), the loads of the wheels and the grip that they give.

pub(crate) mod acceleration_limits;
pub(crate) mod capacity;
mod interval;
pub(crate) mod loads;
pub(crate) mod model;
pub(crate) mod traction;
mod tree_loads;
mod wheel_force;
