//! The tests of `ilon-control` from outside, one module for each subject, in one program.

mod another_point;
#[path = "../../src/tests/robots.rs"]
mod fixtures;
mod paper;
mod passive_by_hand;
mod peers_kinematics;
mod tyres;
