//! Robots and joints that the tests of all modules share.

pub mod joints;
pub mod robots;
pub mod tyres;
