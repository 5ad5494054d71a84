//! What a motor puts on its wheel during a step.

use ilon_robot::mean_of_gain;

/// The torque of a motor on its wheel during a step; the chassis takes the opposite.
///
/// It falls as the wheel gains rate, stays within bounds at every moment, and does not drive the wheel beyond a limit. All of it is
/// solved within the step: the fall is stable for any droop, and a limit holds a wheel that would otherwise swing about it, driven in
/// one step and free in the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorTorque {
    /// At the rate with which the step begins, in N m.
    pub torque_n_m: f64,
    /// By how much it falls per rate gained, in N m s/rad, not below 0, at every moment of the step. A motor with back-EMF is
    /// of that kind, and a wheel loop that runs faster than the step.
    pub droop_n_m_s: f64,
    /// The magnitude of the rate beyond which the motor does not drive, in rad/s, > 0; infinite if
    /// it drives at any. It brakes at any rate.
    pub rate_limit_rad_s: f64,
    /// What bounds the torque within the step, also where `torque_n_m` is beyond.
    pub bounds: TorqueBounds,
}

/// What bounds the torque of a motor within a step: the two lines of a DC motor's back-EMF, which fall with its rate, and a limit
/// that does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueBounds {
    /// The least torque of the lines at the rate with which the step begins, in N m: a DC motor's on full reverse.
    pub least_n_m: f64,
    /// The most, in N m: on full forward.
    pub most_n_m: f64,
    /// By how much both fall per rate gained, in N m s/rad, >= 0.
    pub fall_n_m_s: f64,
    /// The largest torque of either sign, in N m, >= 0; it holds where the lines ask for more, too.
    pub limit_n_m: f64,
    /// Whether the lines force a torque upon a wheel that is beyond their zero; where they do not, the motor is free there.
    pub regenerates: bool,
}

/// What a wheel sets against its motor, about its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WheelInertia {
    /// Where it rolls: with its share of the robot's mass at its rim, in kg m^2.
    pub on_ground_kg_m2: f64,
    /// Where it spins free, in kg m^2.
    pub spinning_kg_m2: f64,
}

impl TorqueBounds {
    /// No bounds.
    pub const NONE: Self = Self {
        least_n_m: f64::NEG_INFINITY,
        most_n_m: f64::INFINITY,
        fall_n_m_s: 0.0,
        limit_n_m: f64::INFINITY,
        regenerates: true,
    };

    /// The least and the most torque when the wheel has gained a rate, in rad/s.
    fn at_gain(&self, gained_rad_s: f64) -> [f64; 2] {
        let lost_n_m = self.fall_n_m_s * gained_rad_s;
        let (mut least_n_m, mut most_n_m) = (self.least_n_m - lost_n_m, self.most_n_m - lost_n_m);
        if !self.regenerates {
            (least_n_m, most_n_m) = (least_n_m.min(0.0), most_n_m.max(0.0));
        }
        [least_n_m, most_n_m].map(|bound| bound.max(-self.limit_n_m).min(self.limit_n_m))
    }

    /// By how much a bound that holds when the step begins falls per rate gained: a line does, a limit does not.
    fn fall_of(&self, bound_n_m: f64) -> f64 {
        if bound_n_m == self.least_n_m || bound_n_m == self.most_n_m {
            self.fall_n_m_s
        } else {
            0.0
        }
    }

    /// As a motor sees them that turns the other way.
    fn mirrored(&self) -> Self {
        Self {
            least_n_m: -self.most_n_m,
            most_n_m: -self.least_n_m,
            ..*self
        }
    }
}

impl MotorTorque {
    /// A torque in N m that stays as it is over the step, at any rate.
    pub fn constant(torque_n_m: f64) -> Self {
        Self {
            torque_n_m,
            droop_n_m_s: 0.0,
            rate_limit_rad_s: f64::INFINITY,
            bounds: TorqueBounds::NONE,
        }
    }

    /// A torque in N m that falls by a droop in N m s/rad per rate gained, at any rate.
    pub fn with_droop(torque_n_m: f64, droop_n_m_s: f64) -> Self {
        Self {
            droop_n_m_s,
            ..Self::constant(torque_n_m)
        }
    }

    /// Whether a wheel with this rate, in rad/s, is so near to the rate limit that it may reach it within a step.
    pub(crate) fn is_near_limit(&self, rate_rad_s: f64) -> bool {
        /// Below this share of its limit a wheel does not reach it by what it gains on the ground in a step.
        const NEAR: f64 = 0.9;
        rate_rad_s.abs() >= NEAR * self.rate_limit_rad_s
    }

    /// The torque when the wheel has gained a rate, in rad/s, but for the rate limit.
    pub(crate) fn at_gain(&self, gained_rad_s: f64) -> f64 {
        let [least_n_m, most_n_m] = self.bounds.at_gain(gained_rad_s);
        let torque_n_m = self.torque_n_m - self.droop_n_m_s * gained_rad_s;
        torque_n_m.max(least_n_m).min(most_n_m)
    }

    /// The same motor when the wheel has gained a rate, in rad/s.
    pub(crate) fn after_gaining(&self, gained_rad_s: f64) -> Self {
        let lost_n_m = self.bounds.fall_n_m_s * gained_rad_s;
        Self {
            torque_n_m: self.torque_n_m - self.droop_n_m_s * gained_rad_s,
            bounds: TorqueBounds {
                least_n_m: self.bounds.least_n_m - lost_n_m,
                most_n_m: self.bounds.most_n_m - lost_n_m,
                ..self.bounds
            },
            ..*self
        }
    }

    /// The same motor without bounds, as it falls where the step begins: with its own droop, or along the bound that holds it. That is
    /// the straight line on which most steps also end.
    pub(crate) fn straight(&self) -> Self {
        let [least_n_m, most_n_m] = self.bounds.at_gain(0.0);
        let is_beyond = |bound_n_m: f64, over_n_m: f64| {
            over_n_m > 0.0 || (over_n_m == 0.0 && self.droop_n_m_s < self.bounds.fall_of(bound_n_m))
        };
        let bound_n_m = if is_beyond(most_n_m, self.torque_n_m - most_n_m) {
            most_n_m
        } else if is_beyond(least_n_m, least_n_m - self.torque_n_m) {
            least_n_m
        } else {
            return *self;
        };
        Self {
            torque_n_m: bound_n_m,
            droop_n_m_s: self.bounds.fall_of(bound_n_m),
            ..*self
        }
    }

    /// The same motor as it is seen by one whose wheel turns the other way.
    pub(crate) fn mirrored(&self) -> Self {
        Self {
            torque_n_m: -self.torque_n_m,
            bounds: self.bounds.mirrored(),
            ..*self
        }
    }

    /// The same motor with the droop that its mean torque over a time has per rate gained over it, for a wheel that feels an
    /// inertia.
    ///
    /// Of the rate that is gained over the time the torque feels the mean. A wheel of inertia J that a droop D brings to its
    /// rate nears it as exp(-z), z = D t / J, and the mean of what it gains is theta = 1 / (1 - exp(-z)) - 1 / z of the whole:
    /// half in a short time, nearly all in a long one. That is of second order in the time, and stable for any.
    ///
    /// The bounds fall as they do for a wheel that spins free: no other nears their zero as fast, and none goes beyond it.
    pub(crate) fn over(&self, time_s: f64, inertia: WheelInertia) -> Self {
        let mean = |fall_n_m_s: f64, inertia_kg_m2: f64| {
            mean_of_gain(fall_n_m_s * time_s / inertia_kg_m2) * fall_n_m_s
        };
        Self {
            droop_n_m_s: mean(self.droop_n_m_s, inertia.on_ground_kg_m2),
            bounds: TorqueBounds {
                fall_n_m_s: mean(self.bounds.fall_n_m_s, inertia.spinning_kg_m2),
                ..self.bounds
            },
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
            let felt = WheelInertia {
                on_ground_kg_m2: inertia,
                spinning_kg_m2: inertia,
            };
            let step = MotorTorque::with_droop(-droop * from_rad_s, droop).over(time_s, felt);
            let gained = time_s * step.torque_n_m / (inertia + time_s * step.droop_n_m_s);
            let exact = from_rad_s * ((-droop * time_s / inertia).exp() - 1.0);
            // The series leaves z^3/720 of a part in the shortest: 1e-9.
            assert!(
                (gained / exact - 1.0).abs() < 1e-7,
                "{time_s}: {gained} {exact}"
            );
        }
    }

    /// Asked for more than it can give it is held by its line, which falls with the rate, or by a limit, which does not.
    #[test]
    fn what_holds_a_motor_that_is_asked_for_too_much_falls_as_that_does() {
        let straight = |torque_n_m: f64, limit_n_m: f64| {
            let motor = MotorTorque {
                bounds: TorqueBounds {
                    least_n_m: -0.5,
                    most_n_m: 0.3,
                    fall_n_m_s: 0.015,
                    limit_n_m,
                    regenerates: true,
                },
                ..MotorTorque::with_droop(torque_n_m, 0.2)
            };
            let straight = motor.straight();
            (straight.torque_n_m, straight.droop_n_m_s)
        };
        assert_eq!(straight(1.0, 0.4), (0.3, 0.015));
        assert_eq!(straight(1.0, 0.2), (0.2, 0.0));
        assert_eq!(straight(-1.0, 0.6), (-0.5, 0.015));
        assert_eq!(straight(-1.0, 0.4), (-0.4, 0.0));
        assert_eq!(straight(0.1, 0.4), (0.1, 0.2));
    }
}
