//! A run as ROS 2 topics, in frames of REP-105.
//!
//! | topic | type | says |
//! |---|---|---|
//! | `/clock` | `rosgraph_msgs/Clock` | the simulated time |
//! | `/robot_description` | `std_msgs/String` | the robot's URDF ([`RobotDescription`](ilon_robot::RobotDescription)), latched |
//! | `/tf_static` | `tf2_msgs/TFMessage` | `map -> odom`, and all links that do not move, latched |
//! | `/tf` | `tf2_msgs/TFMessage` | `odom -> base_link` as reckoned, `map -> ground_truth/base_link` as it is, wheels, rollers |
//! | `/joint_states` | `sensor_msgs/JointState` | angle, rate and torque of each wheel |
//! | `/robot_joint_commands` | `sensor_msgs/JointState` | the rates commanded |
//! | `/cmd_vel` | `geometry_msgs/TwistStamped` | the twist asked for, before any saturation |
//! | `/odom` | `nav_msgs/Odometry` | the robot's own dead reckoning by Indiveri 2009, eq. (7), as its controllers do it |
//! | `/ground_truth/odom` | `nav_msgs/Odometry` | where the robot is and how it moves |
//! | `/pose` | `geometry_msgs/PoseStamped` | the pose that the robot's sensors show it |
//! | `/reference` | `geometry_msgs/PoseStamped` | the pose wanted of the point that follows the reference, where there is one |
//! | `/imu` | `sensor_msgs/Imu` | rates, specific force and, by the robot's filter, roll and pitch, where there is an IMU |
//! | `/wheels/NAME/slip` | `geometry_msgs/Vector3Stamped` | sliding velocity at the wheel's contact, along the body's axes, m/s |
//! | `/wheels/NAME/force` | `geometry_msgs/WrenchStamped` | force of the ground on the wheel, along the body's axes, N |
//! | `/contacts` | `visualization_msgs/MarkerArray` | contact forces, friction cones and sliding, at [`MARKER_RATE_HZ`] |
//! | `/diagnostics` | `diagnostic_msgs/DiagnosticArray` | the error budget, guidance and wheels of each second |
//!
//! `base_link` stands for the robot's root link, whatever its name. `map` is the frame of the simulated world; dead reckoning
//! starts at the true pose, so that `odom` rests on it. The estimate has no height of its own: it is that of the robot at rest.
//!
//! A stamp is the time since the start. That of the first row would be zero, which tf2 takes for "the latest": it is 1 ns.
//!
//! Rollers turn on `/tf` in rows that have their angles (`run.roller_angles_hz` of a scenario); in a run without, they rest on
//! `/tf_static`, for a viewer places no link without a transform.

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
