//! Torque laws (from wheel rates to torques) and motor models (which torques a motor can give).

pub(crate) mod computed_torque;
mod derivative;
pub(crate) mod motor;
pub(crate) mod passive;
pub(crate) mod pid;
pub(crate) mod prioritised_torque;
mod torque_law;

pub use torque_law::{BodySense, Demand, FallingTorque, PassiveEffort, TorqueLaw, TorqueShares};
