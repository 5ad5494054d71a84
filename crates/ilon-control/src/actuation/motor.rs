//! What a wheel's motor can give: URDF effort and velocity limits, and the torque-speed line of a DC motor.

use ilon_robot::MotorLimits;

use crate::ControlError;
use crate::error::positive;

/// A torque that a motor can give at one moment, in N m: min <= 0 <= max.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueRange {
    /// Most negative torque.
    pub min_n_m: f64,
    /// Most positive torque.
    pub max_n_m: f64,
}

impl TorqueRange {
    /// Any torque.
    pub const UNLIMITED: Self = Self {
        min_n_m: f64::NEG_INFINITY,
        max_n_m: f64::INFINITY,
    };

    /// The torque in the range nearest to `torque_n_m`. NaN stays NaN: it shall not pass for the largest torque.
    pub fn clamp(&self, torque_n_m: f64) -> f64 {
        if torque_n_m.is_nan() {
            return torque_n_m;
        }
        torque_n_m.min(self.max_n_m).max(self.min_n_m)
    }
}

/// How a motor's torque depends on its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum MotorCurve {
    /// It does not, up to the velocity limit.
    #[default]
    Flat,
    /// A DC motor on a fixed supply: the torque it can drive with falls in a line from the stall torque at rest to
    /// nothing at the no-load rate. See [`MotorCurve::dc_line`].
    DcLine {
        /// Torque at rest, at the wheel, in N m.
        stall_torque_n_m: f64,
        /// Rate at which it drives no more, at the wheel, in rad/s.
        no_load_rate_rad_s: f64,
    },
}

impl MotorCurve {
    /// The torque-speed line of a DC motor of torque constant K, winding resistance R and supply U behind a gear:
    /// stall torque K U / R and no-load rate U / K, both at the wheel (after the gear, its losses left out).
    ///
    /// # Errors
    /// [`ControlError::NotPositive`].
    pub fn dc_line(stall_torque_n_m: f64, no_load_rate_rad_s: f64) -> Result<Self, ControlError> {
        Ok(Self::DcLine {
            stall_torque_n_m: positive("the motor's stall torque in N m", stall_torque_n_m)?,
            no_load_rate_rad_s: positive("the motor's no-load rate in rad/s", no_load_rate_rad_s)?,
        })
    }
}

/// A wheel's motor, all figures at the wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    effort_n_m: f64,
    velocity_rad_s: f64,
    curve: MotorCurve,
}

impl Motor {
    /// A motor with limits as URDF gives them (infinite where there is none) and a torque-speed curve.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`] where a limit is NaN, zero or negative.
    pub fn new(limits: &MotorLimits, curve: MotorCurve) -> Result<Self, ControlError> {
        let limit = |what: &str, value: f64| match value {
            f64::INFINITY => Ok(value),
            _ => positive(what, value),
        };
        Ok(Self {
            effort_n_m: limit("the motor's effort limit in N m", limits.effort_n_m)?,
            velocity_rad_s: limit("the motor's velocity limit in rad/s", limits.velocity_rad_s)?,
            curve,
        })
    }

    /// The torques it can give at a wheel rate.
    ///
    /// Driving (torque along the rate): up to the effort limit and the DC line, and nothing at or beyond the velocity
    /// limit. Braking (torque against the rate): up to the effort limit and the stall torque, at any rate. With the
    /// supply reversed a DC motor's back-EMF would add to the supply and drive more than the stall current; the
    /// drive's current limit, taken to be the stall current, is what holds it there. Beyond the no-load rate the
    /// motor is let coast: its range never leaves zero out, so that no torque is forced upon the wheel.
    pub fn range(&self, rate_rad_s: f64) -> TorqueRange {
        self.range_on(rate_rad_s, 1.0)
    }

    /// The torques it can give at a wheel rate while a share of the supply's voltage is left, 0 to 1.
    ///
    /// Of the DC line stall torque and no-load rate are both proportional to the supply (K U / R and U / K), so that it
    /// shifts in parallel. Of a motor without a curve the limits of torque and rate shrink by the share.
    pub fn range_on(&self, rate_rad_s: f64, supply_share: f64) -> TorqueRange {
        let range = self.torque_range_on(rate_rad_s, supply_share);
        if rate_rad_s.abs() < self.velocity_limit_on(supply_share) {
            range
        } else if rate_rad_s >= 0.0 {
            TorqueRange {
                max_n_m: 0.0,
                ..range
            }
        } else {
            TorqueRange {
                min_n_m: 0.0,
                ..range
            }
        }
    }

    /// Its velocity limit while a share of the supply's voltage is left, in rad/s; it shrinks with the share where there is no
    /// curve.
    pub fn velocity_limit_on(&self, supply_share: f64) -> f64 {
        match self.curve {
            MotorCurve::Flat => share_of(self.velocity_rad_s, supply_share),
            MotorCurve::DcLine { .. } => self.velocity_rad_s,
        }
    }

    /// The rate at and beyond which it drives no more while a share of the supply's voltage is left, in rad/s: its velocity
    /// limit, or the no-load rate, if that is lower.
    pub fn rate_limit_on(&self, supply_share: f64) -> f64 {
        let velocity_rad_s = self.velocity_limit_on(supply_share);
        match self.curve {
            MotorCurve::Flat => velocity_rad_s,
            MotorCurve::DcLine {
                no_load_rate_rad_s, ..
            } => velocity_rad_s.min(share_of(no_load_rate_rad_s, supply_share)),
        }
    }

    /// By how much a torque in N m that it gives at a wheel rate falls per rate gained, in N m s/rad: the slope of the DC line
    /// where it drives with all that the line allows, else 0.
    pub fn droop_on(&self, torque_n_m: f64, rate_rad_s: f64, supply_share: f64) -> f64 {
        let MotorCurve::DcLine {
            stall_torque_n_m,
            no_load_rate_rad_s,
        } = self.curve
        else {
            return 0.0;
        };
        let line_n_m = stall_torque_n_m * (supply_share - rate_rad_s.abs() / no_load_rate_rad_s);
        let drives = torque_n_m * rate_rad_s >= 0.0;
        if drives && line_n_m > 0.0 && torque_n_m.abs() >= line_n_m {
            stall_torque_n_m / no_load_rate_rad_s
        } else {
            0.0
        }
    }

    /// As [`Self::range_on`], but for the velocity limit: for who holds that apart, within a step of time and not from one
    /// to the next, where a wheel at its limit would be driven in one step and free in the other.
    pub fn torque_range_on(&self, rate_rad_s: f64, supply_share: f64) -> TorqueRange {
        let (brake_n_m, drive_n_m) = match self.curve {
            MotorCurve::Flat => {
                let effort_n_m = share_of(self.effort_n_m, supply_share);
                (effort_n_m, effort_n_m)
            }
            MotorCurve::DcLine {
                stall_torque_n_m,
                no_load_rate_rad_s,
            } => {
                let brake_n_m = (self.effort_n_m).min(share_of(stall_torque_n_m, supply_share));
                let slowed = supply_share - rate_rad_s.abs() / no_load_rate_rad_s;
                let drive_n_m = (stall_torque_n_m * slowed).clamp(0.0, brake_n_m);
                (brake_n_m, drive_n_m)
            }
        };
        if rate_rad_s >= 0.0 {
            TorqueRange {
                min_n_m: -brake_n_m,
                max_n_m: drive_n_m,
            }
        } else {
            TorqueRange {
                min_n_m: -drive_n_m,
                max_n_m: brake_n_m,
            }
        }
    }
}

/// A share of a limit; a share of nothing is nothing, also of a limit that is infinite.
fn share_of(limit: f64, share: f64) -> f64 {
    if share == 0.0 { 0.0 } else { share * limit }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dc() -> Motor {
        let limits = MotorLimits {
            effort_n_m: 3.0,
            velocity_rad_s: 18.0,
        };
        Motor::new(&limits, MotorCurve::dc_line(4.0, 20.0).unwrap()).unwrap()
    }

    /// What a motor gives of a torque in N m at a wheel rate in rad/s.
    fn given(motor: &Motor, torque_n_m: f64, rate_rad_s: f64) -> f64 {
        motor.range(rate_rad_s).clamp(torque_n_m)
    }

    #[test]
    fn what_is_no_torque_does_not_become_the_largest() {
        let range = TorqueRange {
            min_n_m: -1.0,
            max_n_m: 2.0,
        };
        assert_eq!([-3.0, 0.5, 3.0].map(|t| range.clamp(t)), [-1.0, 0.5, 2.0]);
        assert!(range.clamp(f64::NAN).is_nan());
    }

    #[test]
    fn driving_follows_the_lower_of_effort_and_dc_line() {
        // The line crosses the effort limit where 4 (1 - w/20) = 3, at 5 rad/s.
        assert_eq!(given(&dc(), 9.0, 0.0), 3.0);
        assert_eq!(given(&dc(), 9.0, 4.0), 3.0);
        assert!((given(&dc(), 9.0, 10.0) - 2.0).abs() < 1e-15);
        assert!((given(&dc(), -9.0, -10.0) + 2.0).abs() < 1e-15);
    }

    #[test]
    fn nothing_drives_at_or_beyond_the_velocity_limit_but_braking_stays() {
        for rate_rad_s in [18.0, 25.0] {
            assert_eq!(given(&dc(), 1.0, rate_rad_s), 0.0);
            assert_eq!(given(&dc(), -9.0, rate_rad_s), -3.0);
            assert_eq!(given(&dc(), -1.0, -rate_rad_s), 0.0);
            assert_eq!(given(&dc(), 9.0, -rate_rad_s), 3.0);
        }
    }

    #[test]
    fn braking_never_exceeds_the_stall_torque() {
        let limits = MotorLimits {
            effort_n_m: 10.0,
            velocity_rad_s: f64::INFINITY,
        };
        let motor = Motor::new(&limits, MotorCurve::dc_line(4.0, 20.0).unwrap()).unwrap();
        assert_eq!(given(&motor, -9.0, 15.0), -4.0);
        assert_eq!(given(&motor, 9.0, -30.0), 4.0);
    }

    #[test]
    fn on_half_of_its_supply_a_dc_motor_has_half_its_stall_torque_and_no_load_rate() {
        let limits = MotorLimits::default();
        let motor = Motor::new(&limits, MotorCurve::dc_line(4.0, 20.0).unwrap()).unwrap();
        let drives_n_m = |rate_rad_s| motor.range_on(rate_rad_s, 0.5).max_n_m;
        // 4 (0.5 - w/20): 2 at rest, 1 at 5 rad/s, nothing from 10 rad/s on; it brakes with 2.
        assert_eq!([0.0, 5.0, 10.0, 15.0].map(drives_n_m), [2.0, 1.0, 0.0, 0.0]);
        assert_eq!(motor.range_on(5.0, 0.5).min_n_m, -2.0);
        assert_eq!(motor.range_on(7.0, 1.0), motor.range(7.0));
    }

    #[test]
    fn what_drives_along_the_dc_line_falls_with_it_and_ends_at_the_no_load_rate() {
        // The line of 4 N m and 20 rad/s falls by 0.2 N m per rad/s; below 5 rad/s the effort limit of 3 N m is what bounds.
        let droop = |rate_rad_s: f64| {
            let given_n_m = given(&dc(), 9.0, rate_rad_s);
            dc().droop_on(given_n_m, rate_rad_s, 1.0)
        };
        assert_eq!([0.0, 4.0, 10.0, 17.0].map(droop), [0.0, 0.0, 0.2, 0.2]);
        // Less than the line allows, and braking, do not fall.
        assert_eq!(dc().droop_on(1.9, 10.0, 1.0), 0.0);
        assert_eq!(dc().droop_on(-3.0, 10.0, 1.0), 0.0);
        assert_eq!(dc().droop_on(-2.0, -10.0, 1.0), 0.2);
        // 18 rad/s are its velocity limit; on 0.8 of its supply it has no load at 16.
        assert_eq!(
            [1.0, 0.8].map(|share| dc().rate_limit_on(share)),
            [18.0, 16.0]
        );
        assert_eq!(dc().velocity_limit_on(0.8), 18.0);
    }

    #[test]
    fn on_half_of_its_supply_a_motor_without_a_curve_has_half_its_limits() {
        let limits = MotorLimits {
            effort_n_m: 3.0,
            velocity_rad_s: 18.0,
        };
        let motor = Motor::new(&limits, MotorCurve::Flat).unwrap();
        let drives_n_m = |rate_rad_s| motor.range_on(rate_rad_s, 0.5).max_n_m;
        assert_eq!([0.0, 8.9, 9.0].map(drives_n_m), [1.5, 1.5, 0.0]);
        let dead = Motor::new(&MotorLimits::default(), MotorCurve::Flat).unwrap();
        assert_eq!(dead.range_on(1.0, 0.0), motor.range_on(1.0, 0.0));
        assert_eq!(dead.range_on(1.0, 0.0).max_n_m, 0.0);
    }

    #[test]
    fn a_motor_without_limits_gives_what_is_asked() {
        let motor = Motor::new(&MotorLimits::default(), MotorCurve::Flat).unwrap();
        assert_eq!(given(&motor, 1e9, 1e9), 1e9);
    }

    #[test]
    fn limits_that_are_not_positive_are_refused() {
        let bad = |effort_n_m, velocity_rad_s| {
            let limits = MotorLimits {
                effort_n_m,
                velocity_rad_s,
            };
            Motor::new(&limits, MotorCurve::Flat)
                .unwrap_err()
                .to_string()
        };
        assert_eq!(
            bad(0.0, 1.0),
            "the motor's effort limit in N m is 0; it must be finite and above zero"
        );
        assert_eq!(
            bad(1.0, f64::NAN),
            "the motor's velocity limit in rad/s is NaN; it must be finite and above zero"
        );
        assert!(MotorCurve::dc_line(1.0, 0.0).is_err());
    }
}
