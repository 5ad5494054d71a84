//! A robot as planners and learners need it: a base that moves in the plane, fitted to sweeps of ilon itself.
//!
//! The body's twist v follows the asked twist u through the law of the wheel loops, within what grip and motors give:
//!
//! ```text
//! e = S u - v                                        S: how much of what is asked comes, shortfall by direction
//! a = k_p e + k_i z + c(v),  z' = e                  the wheel loops' lag; c(v) = (-omega v_y, omega v_x, 0)
//! a is shortened until |a_x/A|^p + |a_y/B|^p + |a_turn/C|^p <= 1, and z stands meanwhile
//! v' = a - c(v)
//! ```
//!
//! Each part comes of a sweep of its own: S of steady drives in all directions, A, B, C and p of steps that ask for more than there is, k_p
//! and k_i of steps that do not, and what the model then misses on drives of chance is the drift. Other drives, which no fit has seen, say how
//! far it is off.
//!
//! | module | answers |
//! |---|---|
//! | `drives` | what ilon's robot does under commands of the body's twist |
//! | `model` | the law above |
//! | [`fit()`] | the law's numbers |
//! | [`files()`] | JSON, and a model for numpy |

mod drives;
mod files;
mod fit;
mod model;

use serde::Serialize;

pub use drives::PlanarDrive;
pub use files::files;
pub use fit::fit;

/// A planar base, and how well it is one. Vectors are ahead, to the left, and turning counter-clockwise, about the origin of the body frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Planar {
    /// The robot's name.
    pub robot: String,
    /// Coulomb's coefficient of friction of the floor on which it was driven.
    pub friction: f64,
    /// The rate up to which wheels were driven, in rad/s: the fit holds as far.
    pub wheel_rate_rad_s: f64,
    /// The speeds that this allows along each axis, in m/s and rad/s.
    pub top: [f64; 3],
    /// The longest step in which the law may be integrated, in seconds.
    pub step_s: f64,
    /// How much of what is asked comes.
    pub shortfall: Shortfall,
    /// What grip and motors give.
    pub grip: Grip,
    /// How the wheel loops follow.
    pub lag: Lag,
    /// What the model misses on drives of chance: covariance of the pose in the body frame (m, m, rad) that grows in a second of driving.
    pub drift_covariance_per_s: [[f64; 3]; 3],
    /// How far off it is on drives that the fit has not seen.
    pub held_out: HeldOut,
}

/// How much of what is asked comes, when nothing changes any more.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Shortfall {
    /// S: the twist that comes is S times the twist that is asked.
    pub matrix: [[f64; 3]; 3],
    /// By direction, from where the robot looks, counter-clockwise: what was measured.
    pub by_direction: Vec<DirectionShortfall>,
    /// The largest difference between S and a measured twist, over the top speeds.
    pub fit_error: f64,
}

/// What is missing in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DirectionShortfall {
    /// The direction, in degrees.
    pub direction_deg: f64,
    /// The share of the asked speed that is missing along it.
    pub missing: f64,
    /// By how much the robot drifts off to the left of it, over the asked speed.
    pub aside: f64,
}

/// What grip and motors give to a start from rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Grip {
    /// A, B and C: the largest accelerations along the axes, in m/s^2 and rad/s^2.
    pub most: [f64; 3],
    /// p: 1 where the axes share one budget, 2 of an ellipse, more where they hardly know of each other.
    pub exponent: f64,
    /// The root mean square of what is measured over what this gives, less 1.
    pub fit_error: f64,
    /// The axes of the ellipse that fits best, for planners that know no other shape, in m/s^2 and rad/s^2.
    pub ellipse: [f64; 3],
    /// The same error of the ellipse.
    pub ellipse_fit_error: f64,
}

/// How the body follows what is asked, while there is grip: the law's gains along each axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Lag {
    /// k_p, in 1/s.
    pub proportional_per_s: [f64; 3],
    /// k_i, in 1/s^2.
    pub integral_per_s2: [f64; 3],
    /// The root mean square of what the law misses on the steps that it was fitted to, over their size.
    pub fit_error: [f64; 3],
}

/// The errors on drives that no fit has seen.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HeldOut {
    /// How many drives there are, and how long each is in seconds.
    pub drives: usize,
    /// See above.
    pub duration_s: f64,
    /// Of the law, as in the model for numpy.
    pub model: DriveError,
    /// Of ideal kinematics: the robot does what is asked, at once.
    pub ideal: DriveError,
}

/// How far a model is off from ilon, over some drives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DriveError {
    /// Root mean square of the twist's error, in m/s, m/s and rad/s.
    pub twist_rms: [f64; 3],
    /// Distance of the positions at the end over the length of the path: the mean over the drives.
    pub position_over_path: f64,
    /// Error of the heading at the end, in rad: root mean square over the drives.
    pub heading_rms_rad: f64,
}
