//! A robot as a planar base for planners and learners, fitted to simulated drives.
//!
//! The body's twist v follows the commanded twist u through the law of the wheel loops, within the
//! limits of grip and motors:
//!
//! ```text
//! e = S u - v                                        S: the reached twist over the commanded one
//! a = k_p e + k_i z + c(v),  z' = e                  the wheel loops' lag; c(v) = (-omega v_y, omega v_x, 0)
//! a is shortened until |a_x/A|^p + |a_y/B|^p + |a_turn/C|^p <= 1, and z is constant meanwhile
//! v' = a - c(v)
//! ```
//!
//! Each part is fitted to its own drives: S to steady drives in all directions; A, B, C and p to
//! starts beyond the acceleration limits; k_p and k_i to starts within them. What the model then
//! misses on pseudo-random drives is the drift. Further drives, which no fit has used, give the
//! model's error.
//!
//! | module | answers |
//! |---|---|
//! | `drives` | drives of the simulated robot under commanded body twists |
//! | `model` | the law above |
//! | [`fit()`] | the law's parameters |
//! | [`files()`] | JSON, and a model for numpy |

mod drives;
mod files;
mod fit;
mod model;

use serde::Serialize;

pub use drives::PlanarDrive;
pub use files::files;
pub use fit::fit;

/// A planar base with its errors. Vectors are (ahead, left, counter-clockwise turn) about the
/// origin of the body frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Planar {
    /// The robot's name.
    pub robot: String,
    /// Coulomb friction coefficient of the floor in the drives.
    pub friction: f64,
    /// The largest commanded wheel rate, in rad/s: the fit holds up to it.
    pub wheel_rate_rad_s: f64,
    /// The resulting top speeds along each axis, in m/s and rad/s.
    pub top: [f64; 3],
    /// The longest step for integrating the law, in seconds.
    pub step_s: f64,
    /// The reached share of a commanded twist.
    pub shortfall: Shortfall,
    /// The acceleration limits of grip and motors.
    pub grip: Grip,
    /// How the wheel loops follow.
    pub lag: Lag,
    /// Covariance of the pose error in the body frame (m, m, rad) that grows per second of
    /// pseudo-random drives.
    pub drift_covariance_per_s: [[f64; 3]; 3],
    /// The error on drives that no fit has used.
    pub held_out: HeldOut,
}

/// The reached share of a commanded twist in the steady state.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Shortfall {
    /// S: the reached twist is S times the commanded twist.
    pub matrix: [[f64; 3]; 3],
    /// The measured values by direction in the body frame, counter-clockwise from ahead.
    pub by_direction: Vec<DirectionShortfall>,
    /// The largest difference between S and a measured twist, over the top speeds.
    pub fit_error: f64,
}

/// The missing speed in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DirectionShortfall {
    /// The direction in the body frame, in degrees.
    pub direction_deg: f64,
    /// The missing share of the commanded speed along the direction.
    pub missing: f64,
    /// The drift to the left of the direction, over the commanded speed.
    pub aside: f64,
}

/// The acceleration limits from rest, by grip and motors.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Grip {
    /// A, B and C: the largest accelerations along the axes, in m/s^2 and rad/s^2.
    pub most: [f64; 3],
    /// p: 1 if the axes share one budget, 2 for an ellipse, larger if they are nearly independent.
    pub exponent: f64,
    /// Root mean square of the measured over the modelled acceleration, less 1.
    pub fit_error: f64,
    /// The axes of the best ellipse, for planners without other shapes, in m/s^2 and rad/s^2.
    pub ellipse: [f64; 3],
    /// The same error for the ellipse.
    pub ellipse_fit_error: f64,
}

/// How the body follows its command within the acceleration limits: the law's gains along each
/// axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Lag {
    /// k_p, in 1/s.
    pub proportional_per_s: [f64; 3],
    /// k_i, in 1/s^2.
    pub integral_per_s2: [f64; 3],
    /// Root mean square of the law's error on the fitted starts, over their size.
    pub fit_error: [f64; 3],
}

/// The errors on drives that no fit has used.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HeldOut {
    /// The number of drives.
    pub drives: usize,
    /// The length of each drive, in seconds.
    pub duration_s: f64,
    /// Errors of the law, as in the model for numpy.
    pub model: DriveError,
    /// Errors of ideal kinematics, in which the robot reaches its command at once.
    pub ideal: DriveError,
}

/// The error of a model against ilon, over several drives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DriveError {
    /// Root mean square of the twist error, in m/s, m/s and rad/s.
    pub twist_rms: [f64; 3],
    /// Distance between the end positions over the length of the path; the mean over the drives.
    pub position_over_path: f64,
    /// Error of the heading at the end, in rad; root mean square over the drives.
    pub heading_rms_rad: f64,
}
