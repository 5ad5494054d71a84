//! The messages, by the ROS package that defines them.

use crate::description::Description;

pub mod builtin_interfaces;
pub mod diagnostic_msgs;
pub mod geometry_msgs;
pub mod nav_msgs;
pub mod rosgraph_msgs;
pub mod sensor_msgs;
pub mod std_msgs;
pub mod tf2_msgs;
pub mod trajectory_msgs;
pub mod visualization_msgs;

/// The messages of all packages.
const ALL: &[&[&Description]] = &[
    builtin_interfaces::ALL,
    diagnostic_msgs::ALL,
    geometry_msgs::ALL,
    nav_msgs::ALL,
    rosgraph_msgs::ALL,
    sensor_msgs::ALL,
    std_msgs::ALL,
    tf2_msgs::ALL,
    trajectory_msgs::ALL,
    visualization_msgs::ALL,
];

/// All messages of this crate.
pub fn messages() -> impl Iterator<Item = &'static Description> {
    ALL.iter().copied().flatten().copied()
}
