//! A run as ROS 2 topics, in frames of REP-105.
//!
//! | topic | type | content |
//! |---|---|---|
//! | `/clock` | `rosgraph_msgs/Clock` | the simulated time |
//! | `/robot_description` | `std_msgs/String` | the robot's URDF ([`RobotDescription`](ilon_robot::RobotDescription)), latched |
//! | `/tf_static` | `tf2_msgs/TFMessage` | `map -> odom`, and all fixed links, latched |
//! | `/tf` | `tf2_msgs/TFMessage` | `odom -> base_link` by dead reckoning, `map -> ground_truth/base_link`, wheels, rollers |
//! | `/joint_states` | `sensor_msgs/JointState` | angle, rate and torque of each wheel |
//! | `/robot_joint_commands` | `sensor_msgs/JointState` | the commanded rates |
//! | `/cmd_vel` | `geometry_msgs/TwistStamped` | the commanded twist, before any saturation |
//! | `/odom` | `nav_msgs/Odometry` | the robot's own dead reckoning by Indiveri 2009, eq. (7), as its controllers compute it |
//! | `/ground_truth/odom` | `nav_msgs/Odometry` | the actual pose and twist |
//! | `/pose` | `geometry_msgs/PoseStamped` | the pose measured by the robot's sensors |
//! | `/reference` | `geometry_msgs/PoseStamped` | the desired pose of the point that follows the reference, if there is one |
//! | `/imu` | `sensor_msgs/Imu` | rates, specific force and, by the robot's filter, roll and pitch, if there is an IMU |
//! | `/wheels/NAME/slip` | `geometry_msgs/Vector3Stamped` | sliding velocity at the wheel's contact, along the body's axes, m/s |
//! | `/wheels/NAME/force` | `geometry_msgs/WrenchStamped` | force of the ground on the wheel, along the body's axes, N |
//! | `/contacts` | `visualization_msgs/MarkerArray` | contact forces, friction cones and sliding, at [`MARKER_RATE_HZ`] |
//! | `/diagnostics` | `diagnostic_msgs/DiagnosticArray` | the error budget, guidance and wheels of each second |
//!
//! `base_link` stands for the robot's root link, whatever its name. `map` is the frame of the
//! simulated world; dead reckoning starts at the true pose, so `odom` coincides with it. The
//! estimate has no height of its own: it is that of the robot at rest.
//!
//! A stamp is the time since the start. That of the first row would be zero, which tf2 interprets
//! as "the latest": it is 1 ns.
//!
//! Rollers turn on `/tf` in rows that have their angles (`run.roller_angles_hz` of a scenario);
//! without any angles they are fixed on `/tf_static`, because viewers need a transform to place a
//! link.

mod bag_sink;
mod contacts;
mod convert;
mod diagnostics;
mod frames;
mod outlet;
mod run;

pub use bag_sink::BagSink;
pub use contacts::MARKER_RATE_HZ;
pub use frames::{Fixed, Frames, Turning};
pub use outlet::Outlet;
pub use run::RunTopics;
