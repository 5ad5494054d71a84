//! The robot in the world: its rapier bodies, its state in f64, its wheels and their rollers, its
//! energy.

pub(crate) mod articulated;
pub(crate) mod axial_play;
pub(crate) mod drive;
pub(crate) mod energy;
pub(crate) mod joints;
pub(crate) mod payload;
pub(crate) mod roller;
pub(crate) mod servo;
pub(crate) mod shared_robot;
pub(crate) mod state;
pub(crate) mod wheel;
