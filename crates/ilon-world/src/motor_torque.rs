//! What a motor puts on its wheel during a step.

use ilon_robot::mean_of_gain;

/// The torque of a motor on its wheel during a step; the chassis takes the opposite.
///
/// It falls as the wheel gains rate, and does not drive the wheel beyond a limit. Both are solved within the step: the first
/// is stable for any droop, and the second holds a wheel at its limit that would otherwise swing about it, driven in one step
/// and free in the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorTorque {
    /// At the rate with which the step begins, in N m.
    pub torque_n_m: f64,
    /// By how much it falls per rate gained, in N m s/rad, not below 0, at every moment of the step. A motor with back-EMF is
    /// of that kind, and a wheel loop that runs faster than the step.
    pub droop_n_m_s: f64,
    /// The magnitude of the rate beyond which the motor does not drive, in rad/s, > 0; infinite where it drives at any. It
    /// brakes at any rate.
    pub rate_limit_rad_s: f64,
}

impl MotorTorque {
    /// A torque in N m that stays as it is over the step, at any rate.
    pub fn constant(torque_n_m: f64) -> Self {
        Self {
            torque_n_m,
            droop_n_m_s: 0.0,
            rate_limit_rad_s: f64::INFINITY,
        }
    }

    /// A torque in N m that falls by a droop in N m s/rad per rate gained, at any rate.
    pub fn with_droop(torque_n_m: f64, droop_n_m_s: f64) -> Self {
        Self {
            droop_n_m_s,
            ..Self::constant(torque_n_m)
        }
    }

    /// Whether the torque is the same all through a step that begins at this rate, in rad/s, but for one that reaches the rate
    /// limit.
    pub(crate) fn is_constant_from(&self, rate_rad_s: f64) -> bool {
        self.droop_n_m_s == 0.0 && !self.is_near_limit(rate_rad_s)
    }

    /// Whether a wheel with this rate, in rad/s, is so near to the rate limit that it may reach it within a step.
    pub(crate) fn is_near_limit(&self, rate_rad_s: f64) -> bool {
        /// Below this share of its limit a wheel does not reach it by what it gains on the ground in a step.
        const NEAR: f64 = 0.9;
        rate_rad_s.abs() >= NEAR * self.rate_limit_rad_s
    }

    /// The same motor when the wheel has gained a rate, in rad/s.
    pub(crate) fn after_gaining(&self, gained_rad_s: f64) -> Self {
        Self {
            torque_n_m: self.torque_n_m - self.droop_n_m_s * gained_rad_s,
            ..*self
        }
    }

    /// The same motor with the droop that its mean torque over a time has per rate gained over it, for a wheel that feels an
    /// inertia.
    ///
    /// Of the rate that is gained over the time the torque feels the mean. A wheel of inertia J that a droop D brings to its
    /// rate nears it as exp(-z), z = D t / J, and the mean of what it gains is theta = 1 / (1 - exp(-z)) - 1 / z of the whole:
    /// half in a short time, nearly all in a long one. That is of second order in the time, and stable for any.
    pub(crate) fn over(&self, time_s: f64, inertia_kg_m2: f64) -> Self {
        Self {
            droop_n_m_s: mean_of_gain(self.droop_n_m_s * time_s / inertia_kg_m2) * self.droop_n_m_s,
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wheel under its droop alone ends a step where the differential equation does, at any length of it.
    #[test]
    fn the_mean_torque_takes_a_wheel_where_the_droop_takes_it() {
        let (inertia, droop, from_rad_s) = (0.02, 0.5, 3.0);
        for time_s in [1e-4, 1e-3, 0.03, 0.5, 3.0] {
            let step = MotorTorque::with_droop(-droop * from_rad_s, droop).over(time_s, inertia);
            let gained = time_s * step.torque_n_m / (inertia + time_s * step.droop_n_m_s);
            let exact = from_rad_s * ((-droop * time_s / inertia).exp() - 1.0);
            // The series leaves z^3/720 of a part in the shortest: 1e-9.
            assert!(
                (gained / exact - 1.0).abs() < 1e-7,
                "{time_s}: {gained} {exact}"
            );
        }
    }
}
