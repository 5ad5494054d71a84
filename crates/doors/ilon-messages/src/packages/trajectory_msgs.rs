//! Joint trajectories.

use crate::builtin_interfaces::Duration;
use crate::declare::messages;
use crate::std_msgs::Header;

messages! { trajectory_msgs;
    /// A joint trajectory.
    JointTrajectory "179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e" {
        /// Start time; zero for at once.
        header: Header,
        /// The joints' names.
        joint_names: Vec<String>,
        /// The points, in the order of their times.
        points: Vec<JointTrajectoryPoint>,
    }

    /// A point of a trajectory. Each list has one value for each joint, or is empty.
    JointTrajectoryPoint "de8907036d8bd45aac6f30cc9044a3d4a329c42cbf719aff7d95a584cfa532d7" {
        /// Positions, rad or m.
        positions: Vec<f64>,
        /// Rates, rad/s or m/s.
        velocities: Vec<f64>,
        /// Accelerations, rad/s² or m/s².
        accelerations: Vec<f64>,
        /// Torques, N·m, or forces, N.
        effort: Vec<f64>,
        /// Time after the start.
        time_from_start: Duration,
    }
}
