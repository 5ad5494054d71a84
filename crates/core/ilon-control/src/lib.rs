//! The **control** of an omnidirectional robot: kinematics, references, guidance, wheel loops and
//! motors of robots with N >= 3 Swedish wheels, after G. Indiveri, "Swedish Wheeled Omnidirectional
//! Mobile Robots: Kinematics Analysis and Control", IEEE Transactions on Robotics 25(1), 2009,
//! cited in this crate as "Indiveri 2009".
//!
//! The crate has no I/O, no clock and no physics engine: time, poses and wheel rates are arguments,
//! wheel rates and torques are results. After construction nothing in the update paths allocates.
//! So the crate runs unchanged on a real robot.
//!
//! From the outside in, one control step is:
//!
//! 0. [`PoseFilter`] estimates the pose from wheel odometry and late, noisy poses (section IV).
//! 1. [`Reference::at`] returns the desired pose and velocity: eqs. (13)-(17).
//! 2. [`Guidance::update`] converts the error to wheel rates within the wheels' limit: eqs.
//!    (26)-(50).
//! 3. A [`TorqueLaw`] converts wheel rates to torques (section III-A): [`WheelLoop`] by one PID per
//!    wheel, [`ComputedTorque`] for all wheels together, eqs. (11), (12), [`PrioritisedTorque`] by
//!    priority under torque limits and limited grip; [`PassiveTorque`] makes the robot a spring and
//!    a damper about its reference, with an IMU's tilt from [`TiltFilter`].
//! 4. [`Motor::range`] returns the range of torques that the motor can give.
//!
//! All use [`Kinematics`], the paper's eqs. (2)-(10) with one constant roller angle per wheel, and
//! [`ContactKinematics`], the same constraint at the roller that really touches.
//!
//! ```
//! use ilon_control::*;
//! use ilon_formats::LoadRobot;
//! use ilon_robot::{Pose, Robot};
//! use nalgebra::Vector2;
//!
//! let robot = Robot::load("../../../assets/robots/volksbot.urdf")?;
//! let kinematics = Kinematics::new(&robot)?;
//! let settings = GuidanceSettings {
//!     position_gain: Gain::Scalar(1.0),
//!     heading_gain: 1.0,
//!     wheel_rate_limit_rad_s: 8.7,
//!     saturation: Saturation::Prioritised(Priority::Position),
//! };
//! let mut guidance = Guidance::new(kinematics, &settings)?;
//! let still = Heading::Constant { heading_rad: 0.0 };
//! let reference = Reference::circle(Vector2::zeros(), 1.0, 0.2, 0.0, still)?;
//!
//! // Every control period, from the time and the pose that the robot knows:
//! let seen = Pose { x_m: 2.5, y_m: 0.0, heading_rad: 2.1 };
//! let command = guidance.update(&seen, &reference.at(0.0));
//! assert!(command.wheel_rates_rad_s.iter().all(|rate| rate.abs() <= 8.7));
//! // 1.5 m off: the position takes what the wheels have, the heading waits.
//! assert!(command.tasks[3].is_saturated());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Symbols
//!
//! | paper | here | meaning |
//! |---|---|---|
//! | n, u | `n`, `u` | hub axis; u = n x k, where a positive wheel rate drives the hub |
//! | n_gamma, u_gamma | `n_g`, `u_g` | roller axis; its rolling direction, u_gamma = n_gamma x k |
//! | b | `b` | the wheel's centre in the body frame, from the reference point |
//! | rho, gamma | `rho`, `gamma` | wheel radius; angle from hub axis to rolling direction |
//! | M, M_l, M_a | `m` | eq. (8), its first two columns, its last |
//! | v_c, omega | [`Twist`](ilon_robot::Twist) | velocity of the reference point in the body frame; yaw rate |
//! | q' | `rates` | wheel rates in rad/s |
//! | e_r, e_phi | `e_r`, `e_phi` | position and heading error, eqs. (16), (17) |
//! | sigma, c | `sigma`, `c` | weight and capacity of a task, eqs. (30), (34) |

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod actuation;
mod dynamics;
mod error;
mod estimation;
mod guidance;
mod kinematics;
#[cfg(test)]
mod tests;

pub use actuation::computed_torque::{ComputedTorque, ComputedTorqueSettings};
pub use actuation::motor::{DcMotor, Motor, MotorCurve, TorqueRange};
pub use actuation::passive::{PassiveTorque, PassiveTorqueSettings, TiltLoop};
pub use actuation::pid::{LoopTiming, WheelGains, WheelLoop, WheelLoopSettings};
pub use actuation::prioritised_torque::{PrioritisedTorque, PrioritisedTorqueSettings};
pub use actuation::{BodySense, Demand, FallingTorque, PassiveEffort, TorqueLaw, TorqueShares};
pub use dynamics::acceleration_limits::{
    AccelerationLimit, AccelerationLimits, AccelerationPolytope, AccelerationRange,
    AccelerationUse, LimitCause, LimitSettings, LimitedBy, PushSharing,
};
pub use dynamics::loads::WheelLoads;
pub use dynamics::model::DynamicModel;
pub use error::ControlError;
pub use estimation::odometry::Odometry;
pub use estimation::odometry_covariance::{OdometryCovariance, WayErrors};
pub use estimation::pose_filter::{PoseEstimate, PoseFilter, PoseFilterSettings};
pub use estimation::tilt::{InertialErrors, TiltFilter};
pub use guidance::fastest::Fastest;
pub use guidance::law::{
    Command, Feasibility, Gain, Guidance, GuidanceSettings, GuidanceTask, Saturation,
    WheelRateAsked,
};
pub use guidance::priority::{Priority, Task, TaskShare, share_capacity, sigma};
pub use guidance::reference::{Desired, Heading, Reference};
pub use guidance::tracking::{PathPoint, PathTracking};
pub use kinematics::analysis::Arrangement;
pub use kinematics::contact::{ContactKinematics, RollerContact};
pub use kinematics::handedness::{WrongHands, handed, other_hands};
pub use kinematics::ideal::Kinematics;
pub use kinematics::singularity::{Singularity, SingularityKind};
pub use kinematics::speeds::SpeedLimits;
pub use kinematics::turning::{Turn, sharpest_turn};
pub use kinematics::tyres::HeldRow;
