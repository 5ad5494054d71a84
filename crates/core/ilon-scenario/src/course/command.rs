//! Commands to wheels and joints, and their record.

use ilon_robot::{Pose, Twist};

/// The command to the wheels until the next one, one number per wheel in the robot's order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WheelCommand<'a> {
    /// Wheel rates in rad/s, tracked by the wheel loops.
    Rates(&'a [f64]),
    /// Torques in N m, within the motors' limits.
    Torques(&'a [f64]),
}

impl WheelCommand<'_> {
    /// The numbers, of either kind.
    pub fn numbers(&self) -> &[f64] {
        match self {
            Self::Rates(numbers) | Self::Torques(numbers) => numbers,
        }
    }
}

/// The kind of numbers that a controller has written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Commanded {
    /// Wheel rates in rad/s, tracked by the wheel loops.
    #[default]
    Rates,
    /// Torques in N m, held for the control period, within the motors' limits.
    Torques,
}

/// The recorded part of a decision at the start of a control period. Twists are those of the body's
/// origin.
#[derive(Clone, Copy, Debug, Default)]
pub struct Decided<'a> {
    /// The reference; `None` without one.
    pub desired: Option<ilon_control::Desired>,
    /// The real robot's pose from a log; `None` without one.
    pub measured: Option<Pose>,
    /// The commanded twist in the body frame, before saturation.
    pub command_twist_in_body: Twist,
    /// The same after saturation.
    pub granted_twist_in_body: Twist,
    /// The guidance's tasks, highest priority first; empty without guidance.
    pub tasks: &'a [ilon_control::TaskShare],
    /// Whether a limit on wheel rates took anything of what was asked.
    pub is_limited: bool,
    /// The commanded rate of each wheel, in rad/s; zero if torques are commanded.
    pub wheel_rates_rad_s: &'a [f64],
    /// Whether rates are commanded, or torques.
    pub commanded: Commanded,
}

/// A command to the servo of a joint between bodies, in rad and N m for a revolute joint, in m and
/// N for a prismatic one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum JointCommand {
    /// A target position and its rate, in rad/s or m/s; 0 for a constant target.
    Position {
        /// The position.
        position: f64,
        /// Its rate.
        rate: f64,
    },
    /// The rate at which the target moves on from the joint's position.
    Rate(f64),
    /// The torque or force that acts, within the servo's effort, instead of a position being held.
    Effort(f64),
}

impl JointCommand {
    /// Whether all of its numbers are finite.
    pub fn is_finite(self) -> bool {
        match self {
            Self::Position { position, rate } => position.is_finite() && rate.is_finite(),
            Self::Rate(number) | Self::Effort(number) => number.is_finite(),
        }
    }
}
