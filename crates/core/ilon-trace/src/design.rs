//! What a robot can do by its wheel arrangement, rate limits and grip, known without a run.

use serde::{Deserialize, Serialize};

/// Figures of a robot that need no run. Empty in the summary of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Design {
    /// The rank of M, equation (8): 3 if the wheels can produce any twist.
    pub rank: Option<f64>,
    /// Ratio of the largest to the smallest singular value of M, with its last column in units of
    /// the farthest wheel's distance; absent if the rank is below 3.
    pub condition: Option<f64>,
    /// Top speed without rotation in the slowest direction, in m/s; absent if no wheel limits it.
    pub speed_least_m_s: Option<f64>,
    /// Top speed without rotation in the fastest direction, in m/s; absent if no wheel limits it.
    pub speed_most_m_s: Option<f64>,
    /// Top yaw rate on the spot, in rad/s; absent if no wheel limits it.
    pub yaw_rate_rad_s: Option<f64>,
    /// Largest acceleration from rest without slip in the weakest direction, in m/s^2.
    pub acceleration_least_m_s2: Option<f64>,
    /// Largest acceleration from rest without slip in the strongest direction, in m/s^2.
    pub acceleration_most_m_s2: Option<f64>,
}

impl Design {
    /// Whether nothing is known.
    pub fn is_unknown(&self) -> bool {
        *self == Self::default()
    }
}
