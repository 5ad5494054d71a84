//! What a robot can do by the arrangement of its wheels, their limits and its grip: known without a run.

use serde::{Deserialize, Serialize};

/// What is known of a robot without a run; of a run, which says what it does, nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Design {
    /// The rank of M, equation (8): 3 where the wheels can give any twist.
    pub rank: Option<f64>,
    /// The ratio of the largest to the smallest singular value of M, its last column in units of the furthest wheel's distance; absent where
    /// the rank is below 3.
    pub condition: Option<f64>,
    /// Top speed without turning in the slowest direction, in m/s; absent where no wheel limits it.
    pub speed_least_m_s: Option<f64>,
    /// Top speed without turning in the fastest direction, in m/s; absent where no wheel limits it.
    pub speed_most_m_s: Option<f64>,
    /// Top yaw rate on the spot, in rad/s; absent where no wheel limits it.
    pub yaw_rate_rad_s: Option<f64>,
    /// The largest acceleration from rest without slip, in the direction in which that is least, in m/s^2.
    pub acceleration_least_m_s2: Option<f64>,
    /// The same in the direction in which it is most.
    pub acceleration_most_m_s2: Option<f64>,
}

impl Design {
    /// Whether nothing is known.
    pub fn is_unknown(&self) -> bool {
        *self == Self::default()
    }
}
