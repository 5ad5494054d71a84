//! A ROS 2 node over DDS, without a ROS installation.
//!
//! The node `/ilon`, in a namespace if one is given, publishes the topics of a bag
//! ([`ilon_messages::topics`]) with the same quality of service, and accepts commands:
//!
//! | topic | type | effect |
//! |---|---|---|
//! | `/cmd_vel` | `geometry_msgs/TwistStamped`, or `Twist` ([`Options::unstamped`]) | drives the body |
//! | `/robot_joint_commands` | `sensor_msgs/JointState` | drives the wheels, like `joint_state_topic_hardware_interface` |
//! | `/wheel_commands` | `std_msgs/Float64MultiArray` | drives the wheels, in the robot's order, rad/s |
//!
//! The last command counts, whatever its topic. The resulting limited commands are on
//! `/ilon/cmd_vel` and `/ilon/wheel_commands`; the wheels' states are also on
//! `/robot_joint_states`. Services of `simulation_interfaces` pause, step and reset: while time
//! stands, a step is a control period, and is answered after all of its messages were sent.
//!
//! Parameters, such as the floor's friction, can be changed while the robot drives (`ros2 param set
//! /ilon friction 0.3`).
//!
//! DDS runs in its own thread; the simulation never waits. [`Network`] determines the networks.

mod network;
mod node;
mod others;
mod outlet;
mod parameters;
mod services;

pub use network::{BadVariable, Network};
pub use node::Ros2;

/// Options of a node.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// Namespace of the node and of all its topics and services, such as `/robot1`; empty for none.
    pub namespace: String,
    /// Whether `/cmd_vel` has the type `geometry_msgs/Twist` instead of `TwistStamped`.
    pub unstamped: bool,
    /// Whether controllers of ros2_control drive the wheels: they publish `/joint_states`, `/odom`
    /// and the frame `odom -> base_link`, so the node publishes none of them.
    pub controllers: bool,
}

/// Reasons why the node cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Ros2Error {
    /// An environment variable is invalid.
    #[error(transparent)]
    Variable(#[from] BadVariable),
    /// The participant cannot join the domain.
    #[error("cannot join the ROS 2 domain {domain}: {reason}")]
    Join {
        /// The domain.
        domain: u16,
        /// The middleware's error.
        reason: String,
    },
    /// A topic or a service cannot be created.
    #[error("cannot have {name} in ROS 2: {reason}")]
    Topic {
        /// Its name.
        name: String,
        /// The middleware's error.
        reason: String,
    },
}

impl Ros2Error {
    fn topic(name: &str, reason: impl std::fmt::Display) -> Self {
        Self::Topic {
            name: name.to_owned(),
            reason: reason.to_string(),
        }
    }
}
