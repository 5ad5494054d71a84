//! A node of ROS 2 over DDS, without a ROS installation.
//!
//! The node `/ilon` publishes the topics of a bag ([`ilon_messages::topics`]) with the quality of service that they have there, and takes
//! commands:
//!
//! | topic | type | does |
//! |---|---|---|
//! | `/cmd_vel` | `geometry_msgs/TwistStamped`, or `Twist` ([`Options::unstamped`]) | drives the body |
//! | `/robot_joint_commands` | `sensor_msgs/JointState` | drives the wheels, as `joint_state_topic_hardware_interface` does |
//! | `/wheel_commands` | `std_msgs/Float64MultiArray` | drives the wheels, in the robot's order, rad/s |
//!
//! The last command counts, whichever topic it came over. What the robot makes of it, limits kept, is on `/ilon/cmd_vel` and
//! `/ilon/wheel_commands`; the wheels' states are on `/robot_joint_states` too. Services of `simulation_interfaces` pause, step and
//! reset: in time that stands, a step is a control period, and is answered after all of its messages have been handed out.
//!
//! Parameters, such as the floor's friction, change while the robot drives (`ros2 param set /ilon friction 0.3`).
//!
//! A thread of its own speaks with DDS; the simulation waits for nobody. Which networks are used is in [`Network`].

mod network;
mod node;
mod others;
mod outlet;
mod parameters;
mod services;

pub use network::{BadVariable, Network};
pub use node::Ros2;

/// What a node does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// `/cmd_vel` has the type `geometry_msgs/Twist` in place of `TwistStamped`.
    pub unstamped: bool,
    /// Controllers of ros2_control drive the wheels: `/joint_states`, `/odom` and the frame `odom -> base_link` are theirs, so that the
    /// node publishes none of them.
    pub controllers: bool,
}

impl Options {
    /// These options.
    pub fn new(unstamped: bool, controllers: bool) -> Self {
        Self {
            unstamped,
            controllers,
        }
    }
}

/// Why there can be no node.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Ros2Error {
    /// A variable of the environment.
    #[error(transparent)]
    Variable(#[from] BadVariable),
    /// The participant in the domain.
    #[error("cannot join the ROS 2 domain {domain}: {reason}")]
    Join {
        /// The domain.
        domain: u16,
        /// Why, in the middleware's words.
        reason: String,
    },
    /// A topic or a service.
    #[error("cannot have {name} in ROS 2: {reason}")]
    Topic {
        /// Its name.
        name: String,
        /// Why, in the middleware's words.
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
