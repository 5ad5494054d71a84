//! What wheels and joints are told, and what of it is recorded.

use ilon_robot::{Pose, Twist};

/// What the wheels shall do until the next command, one number a wheel in the robot's order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WheelCommand<'a> {
    /// Wheel rates in rad/s, for the wheel loops to reach.
    Rates(&'a [f64]),
    /// Torques in N m; the motors' limits still stand.
    Torques(&'a [f64]),
}

impl WheelCommand<'_> {
    /// The numbers, whatever they are of.
    pub fn numbers(&self) -> &[f64] {
        match self {
            Self::Rates(numbers) | Self::Torques(numbers) => numbers,
        }
    }
}

/// What the numbers are that a controller has written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Commanded {
    /// Wheel rates in rad/s, for the wheel loops to reach.
    #[default]
    Rates,
    /// Torques in N m, held for the control period; the motors' limits still stand.
    Torques,
}

/// What was decided at the start of a control period, as it is recorded. Twists are the body origin's.
#[derive(Clone, Copy, Debug, Default)]
pub struct Decided<'a> {
    /// What the reference wants; `None` of what follows none.
    pub desired: Option<ilon_control::Desired>,
    /// Where a log says that the real robot was; `None` without one.
    pub measured: Option<Pose>,
    /// The twist asked for in the body frame, before any saturation.
    pub command_twist_in_body: Twist,
    /// What is left of it after saturation.
    pub granted_twist_in_body: Twist,
    /// The guidance's tasks, highest priority first; none of what has no guidance.
    pub tasks: &'a [ilon_control::TaskShare],
    /// Whether a limit on wheel rates took anything of what was asked.
    pub is_limited: bool,
    /// The rate commanded of each wheel, in rad/s; zero where torques are.
    pub wheel_rates_rad_s: &'a [f64],
    /// Whether rates are commanded, or torques.
    pub commanded: Commanded,
}

/// What the servo of a joint between bodies is told, in rad and N m where it turns, in m and N where it slides.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum JointCommand {
    /// A target, and how fast it moves on from there, in rad/s or m/s: 0 of one that stands.
    Position {
        /// Where it is.
        position: f64,
        /// How fast it moves on.
        rate: f64,
    },
    /// How fast the target moves on from where the joint is.
    Rate(f64),
    /// The torque or force that acts, within the servo's effort, in place of holding the joint anywhere.
    Effort(f64),
}

impl JointCommand {
    /// Whether all of its numbers are.
    pub fn is_finite(self) -> bool {
        match self {
            Self::Position { position, rate } => position.is_finite() && rate.is_finite(),
            Self::Rate(number) | Self::Effort(number) => number.is_finite(),
        }
    }
}
