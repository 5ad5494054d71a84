//! The torque of a motor on its wheel during a step.

use ilon_robot::{TorqueBounds, mean_of_gain};

/// The torque of a motor on its wheel during a step; the chassis takes the opposite.
///
/// It falls as the wheel gains rate, stays within its limits at every moment, and does not drive
/// the wheel beyond a rate limit. All of this is solved within the step: the fall is stable for any
/// droop, and a rate limit holds a wheel that would otherwise oscillate about it, driven in one
/// step and free in the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorTorque {
    /// At the rate at the beginning of the step, in N m.
    pub torque_n_m: f64,
    /// Decrease of the torque per rate gained, in N m s/rad, >= 0, throughout the step: a motor
    /// with back-EMF, or a wheel loop that is faster than the step.
    pub droop_n_m_s: f64,
    /// Decrease of the torque per acceleration, in N m s^2/rad, >= 0, at every moment: the wheel is
    /// heavier by it, as under the derivative part of a loop.
    pub per_acceleration_n_m_s2: f64,
    /// The rate beyond which the motor does not drive, in rad/s, > 0; infinite without one. It
    /// brakes at any rate.
    pub rate_limit_rad_s: f64,
    /// The limits of the torque within the step, which apply even if `torque_n_m` is beyond them.
    pub bounds: TorqueBounds,
}

/// The inertia that a motor feels at its wheel, about the wheel's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WheelInertia {
    /// While it rolls: with its share of the robot's mass at its rim, in kg m^2.
    pub on_ground_kg_m2: f64,
    /// While it spins freely, in kg m^2.
    pub spinning_kg_m2: f64,
}

impl MotorTorque {
    /// A constant torque in N m over the step, at any rate.
    pub fn constant(torque_n_m: f64) -> Self {
        Self {
            torque_n_m,
            droop_n_m_s: 0.0,
            per_acceleration_n_m_s2: 0.0,
            rate_limit_rad_s: f64::INFINITY,
            bounds: TorqueBounds::NONE,
        }
    }

    /// A torque in N m with a droop in N m s/rad, at any rate.
    pub fn with_droop(torque_n_m: f64, droop_n_m_s: f64) -> Self {
        Self {
            droop_n_m_s,
            ..Self::constant(torque_n_m)
        }
    }

    /// Whether a wheel with this rate, in rad/s, is so near to the rate limit that it may reach it
    /// within a step.
    pub(crate) fn is_near_limit(&self, rate_rad_s: f64) -> bool {
        /// Below this share of the limit a wheel does not reach it within a step on the ground.
        /// Chosen.
        const NEAR: f64 = 0.9;
        rate_rad_s.abs() >= NEAR * self.rate_limit_rad_s
    }

    /// The torque after the wheel has gained a rate, in rad/s, without the rate limit.
    pub(crate) fn at_gain(&self, gained_rad_s: f64) -> f64 {
        let [least_n_m, most_n_m] = self.bounds.at_gain(gained_rad_s);
        let torque_n_m = self.torque_n_m - self.droop_n_m_s * gained_rad_s;
        torque_n_m.max(least_n_m).min(most_n_m)
    }

    /// The same motor after the wheel has gained a rate, in rad/s.
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

    /// The same motor without limits, linearised at the beginning of the step: with its own droop,
    /// or along the limit that applies. Most steps end on that line.
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

    /// The same motor for a wheel that turns the other way.
    pub(crate) fn mirrored(&self) -> Self {
        Self {
            torque_n_m: -self.torque_n_m,
            bounds: self.bounds.mirrored(),
            ..*self
        }
    }

    /// The same motor with the droop of its mean torque over a time, for a wheel with a given
    /// inertia.
    ///
    /// The torque depends on the mean of the rate gained over the time. A wheel of inertia J under
    /// a droop D approaches its final rate as exp(-z), z = D t / J, and the mean gain is theta = 1
    /// / (1 - exp(-z)) - 1 / z of the whole: half in a short time, nearly all in a long one. That
    /// is of second order in the time, and stable for any.
    ///
    /// What it loses per acceleration has the mean of the gain over the time, however that comes.
    ///
    /// The limits fall as for a freely spinning wheel: no other approaches their zero as fast, and
    /// none goes beyond it.
    pub(crate) fn over(&self, time_s: f64, inertia: WheelInertia) -> Self {
        let mean = |fall_n_m_s: f64, inertia_kg_m2: f64| {
            mean_of_gain(fall_n_m_s * time_s / inertia_kg_m2) * fall_n_m_s
        };
        Self {
            droop_n_m_s: mean(
                self.droop_n_m_s,
                inertia.on_ground_kg_m2 + self.per_acceleration_n_m_s2,
            ) + self.per_acceleration_n_m_s2 / time_s,
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

    /// A wheel under its droop alone ends a step where the differential equation does, for any
    /// length of the step.
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
            // The series has a relative error of z^3/720 in the shortest: 1e-9.
            assert!(
                (gained / exact - 1.0).abs() < 1e-7,
                "{time_s}: {gained} {exact}"
            );
        }
    }

    /// What a torque loses per acceleration makes its wheel heavier, in a step or in its parts, and
    /// for a jump of the rate too.
    #[test]
    fn a_torque_that_falls_with_the_acceleration_is_an_inertia() {
        let (inertia, added, torque_n_m, time_s) = (0.02, 0.01, 0.3, 5e-3);
        let motor = MotorTorque {
            per_acceleration_n_m_s2: added,
            ..MotorTorque::constant(torque_n_m)
        };
        let felt = WheelInertia {
            on_ground_kg_m2: inertia,
            spinning_kg_m2: inertia,
        };
        for parts in [1, 7] {
            let part_s = time_s / f64::from(parts);
            let gained_rad_s = (0..parts).fold(0.0, |gained_rad_s, part| {
                let step = motor.after_gaining(gained_rad_s).over(part_s, felt);
                // A blow of 0.01 N m s in the first part.
                let blow_n_m_s = if part == 0 { 0.01 } else { 0.0 };
                let impulse_n_m_s = part_s * step.torque_n_m + blow_n_m_s;
                gained_rad_s + impulse_n_m_s / (inertia + part_s * step.droop_n_m_s)
            });
            let exact = (torque_n_m * time_s + 0.01) / (inertia + added);
            assert!(
                (gained_rad_s / exact - 1.0).abs() < 1e-12,
                "{parts}: {gained_rad_s}"
            );
        }
    }

    /// A demand beyond its limits follows its line, which falls with the rate, or a constant limit,
    /// which does not.
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
