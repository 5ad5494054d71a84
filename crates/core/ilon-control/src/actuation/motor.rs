//! The torque range of a wheel's motor: URDF effort and velocity limits, and a DC motor with
//! back-EMF in all four quadrants.

use ilon_robot::{MotorLimits, TorqueBounds};

use crate::ControlError;
use crate::error::positive;

/// The torques that a motor can give at one moment, in N m: min <= max. Both have the same sign if
/// a load turns a DC motor beyond its no-load rate: then it brakes, whatever its controller does.
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

    /// Returns the torques within bounds, at the bounds' rate.
    pub fn of(bounds: &TorqueBounds) -> Self {
        let [min_n_m, max_n_m] = bounds.at_gain(0.0);
        Self { min_n_m, max_n_m }
    }

    /// Returns the torque in the range nearest to `torque_n_m`. NaN stays NaN, so that it does not
    /// pass for the largest torque.
    pub fn clamp(&self, torque_n_m: f64) -> f64 {
        if torque_n_m.is_nan() {
            return torque_n_m;
        }
        torque_n_m.min(self.max_n_m).max(self.min_n_m)
    }
}

/// A DC motor and its controller, all values at the wheel (after the gear, without its losses).
///
/// With the torque constant K, the winding resistance R and a voltage u U between full reverse (u =
/// -1) and full forward (u = 1), the current is (u U - K w) / R and the torque
///
/// tau = stall (u - w / no_load),  stall = K U / R,  no_load = U / K,
///
/// at every rate w. Beyond the no-load rate the motor brakes at full voltage; turned backwards it
/// pushes with more than the stall torque. Short-circuited it brakes with -stall w / no_load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DcMotor {
    /// Torque at rest at full voltage, in N m, > 0.
    pub stall_torque_n_m: f64,
    /// Rate at which the torque at full voltage is zero, in rad/s, > 0.
    pub no_load_rate_rad_s: f64,
    /// Torque at the controller's current limit, driving and braking alike, in N m, > 0; infinite
    /// without a limit.
    pub current_limit_n_m: f64,
    /// Whether the supply, or a brake chopper across it, absorbs regenerated power. If not, the
    /// controller turns this power into heat in the winding, and beyond the no-load rate no current
    /// flows unless the voltage is reversed: the motor coasts.
    pub regenerates: bool,
}

/// How a motor's torque depends on its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum MotorCurve {
    /// Constant torque up to the velocity limit.
    #[default]
    Flat,
    /// A DC motor on a fixed supply.
    Dc(DcMotor),
}

impl MotorCurve {
    /// A DC motor with a stall torque in N m and a no-load rate in rad/s at the wheel, without a
    /// current limit, on a supply that absorbs regenerated power.
    #[cfg(test)]
    pub(crate) fn dc_line(
        stall_torque_n_m: f64,
        no_load_rate_rad_s: f64,
    ) -> Result<Self, ControlError> {
        Self::dc(DcMotor {
            stall_torque_n_m,
            no_load_rate_rad_s,
            current_limit_n_m: f64::INFINITY,
            regenerates: true,
        })
    }

    /// Checks a DC motor and makes a curve of it.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`] if a value is not above zero.
    pub fn dc(motor: DcMotor) -> Result<Self, ControlError> {
        positive("the motor's stall torque in N m", motor.stall_torque_n_m)?;
        positive(
            "the motor's no-load rate in rad/s",
            motor.no_load_rate_rad_s,
        )?;
        if motor.current_limit_n_m != f64::INFINITY {
            let what = "the torque of the motor's current limit in N m";
            positive(what, motor.current_limit_n_m)?;
        }
        Ok(Self::Dc(motor))
    }
}

/// A wheel's motor, all values at the wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    effort_n_m: f64,
    velocity_rad_s: f64,
    curve: MotorCurve,
    /// Shares of its torque available forwards and backwards.
    strength: [f64; 2],
}

impl Motor {
    /// A motor with the limits of its URDF (infinite if absent) and a torque-speed curve.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`] if a limit is NaN or negative, or that of the rate zero.
    pub fn new(limits: &MotorLimits, curve: MotorCurve) -> Result<Self, ControlError> {
        let limit = |what: &str, value: f64| match value {
            f64::INFINITY => Ok(value),
            _ => positive(what, value),
        };
        Ok(Self {
            // Nothing drives a wheel whose motor gives 0.
            effort_n_m: match limits.effort_n_m {
                0.0 => 0.0,
                effort_n_m => limit("the motor's effort limit in N m", effort_n_m)?,
            },
            velocity_rad_s: limit("the motor's velocity limit in rad/s", limits.velocity_rad_s)?,
            curve,
            strength: [1.0; 2],
        })
    }

    /// Returns the motor with separate shares of torque forwards and backwards. For a DC motor the
    /// share scales the voltage, hence stall torque and no-load rate; without a curve it scales the
    /// effort limit.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`].
    pub fn with_strength(self, strength: [f64; 2]) -> Result<Self, ControlError> {
        for share in strength {
            positive("the share of a motor's strength", share)?;
        }
        Ok(Self { strength, ..self })
    }

    /// Returns the torque range at a wheel rate in rad/s.
    ///
    /// A motor without a curve drives and brakes up to its effort limit. A DC motor gives the
    /// torques between full reverse and full forward, within the effort limit and the current
    /// limit. Neither drives (torque along the rate) at or beyond the velocity limit.
    pub fn range(&self, rate_rad_s: f64) -> TorqueRange {
        self.range_on(rate_rad_s, 1.0)
    }

    /// Returns the torque range at a wheel rate in rad/s while the supply has a share, 0 to 1, of
    /// its voltage.
    ///
    /// For a DC motor stall torque and no-load rate are both proportional to the supply (K U / R
    /// and U / K), so both lines shift in parallel; without supply it is short-circuited. Without a
    /// curve the torque and rate limits shrink by the share.
    pub fn range_on(&self, rate_rad_s: f64, supply_share: f64) -> TorqueRange {
        let range = TorqueRange::of(&self.bounds_on(rate_rad_s, supply_share));
        let TorqueRange { min_n_m, max_n_m } = range;
        if rate_rad_s.abs() < self.velocity_limit_on(supply_share) {
            range
        } else if rate_rad_s >= 0.0 {
            TorqueRange {
                min_n_m: min_n_m.min(0.0),
                max_n_m: max_n_m.min(0.0),
            }
        } else {
            TorqueRange {
                min_n_m: min_n_m.max(0.0),
                max_n_m: max_n_m.max(0.0),
            }
        }
    }

    /// Returns the velocity limit while the supply has a share of its voltage, in rad/s. Only
    /// without a curve does it shrink with the share.
    pub fn velocity_limit_on(&self, supply_share: f64) -> f64 {
        match self.curve {
            MotorCurve::Flat => share_of(self.velocity_rad_s, supply_share),
            MotorCurve::Dc(_) => self.velocity_rad_s,
        }
    }

    /// Returns the torque bounds near a wheel rate while the supply has a share of its voltage.
    /// They leave the velocity limit to the caller, who follows the lines within a time step
    /// instead of from one step to the next.
    pub fn bounds_on(&self, rate_rad_s: f64, supply_share: f64) -> TorqueBounds {
        let [forwards, backwards] = self.strength;
        match self.curve {
            MotorCurve::Flat if self.strength != [1.0; 2] => {
                let limit_n_m = share_of(self.effort_n_m, supply_share);
                TorqueBounds {
                    least_n_m: -backwards * limit_n_m,
                    most_n_m: forwards * limit_n_m,
                    ..TorqueBounds::NONE
                }
            }
            MotorCurve::Flat => TorqueBounds {
                limit_n_m: share_of(self.effort_n_m, supply_share),
                ..TorqueBounds::NONE
            },
            MotorCurve::Dc(motor) => {
                let fall_n_m_s = motor.stall_torque_n_m / motor.no_load_rate_rad_s;
                let at_rest_n_m = supply_share * motor.stall_torque_n_m;
                TorqueBounds {
                    least_n_m: -backwards * at_rest_n_m - fall_n_m_s * rate_rad_s,
                    most_n_m: forwards * at_rest_n_m - fall_n_m_s * rate_rad_s,
                    fall_n_m_s,
                    limit_n_m: self.effort_n_m.min(motor.current_limit_n_m),
                    regenerates: motor.regenerates,
                }
            }
        }
    }

    /// Returns the braking torque of the short-circuited winding per rate, in N m s/rad; `None`
    /// without a curve, since the winding is then unknown.
    pub fn shorted_n_m_s(&self) -> Option<f64> {
        match self.curve {
            MotorCurve::Flat => None,
            MotorCurve::Dc(motor) => Some(motor.stall_torque_n_m / motor.no_load_rate_rad_s),
        }
    }
}

/// Returns a share of a limit; a share of zero gives zero, even for an infinite limit.
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

    /// Returns the torque that a motor gives, in N m, when asked for a torque in N m at a wheel
    /// rate in rad/s.
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

    /// Full forward and full reverse of a line of 4 N m and 20 rad/s, within 3 N m: 4 (+-1 - w /
    /// 20).
    #[test]
    fn nothing_drives_at_or_beyond_the_velocity_limit_but_braking_stays() {
        for rate_rad_s in [18.0, 25.0] {
            assert!(given(&dc(), 1.0, rate_rad_s) <= 0.0);
            assert_eq!(given(&dc(), -9.0, rate_rad_s), -3.0);
            assert!(given(&dc(), -1.0, -rate_rad_s) >= 0.0);
            assert_eq!(given(&dc(), 9.0, -rate_rad_s), 3.0);
        }
    }

    fn unlimited(curve: MotorCurve) -> Motor {
        Motor::new(&MotorLimits::default(), curve).unwrap()
    }

    #[test]
    fn the_line_holds_in_all_four_quadrants() {
        let motor = unlimited(MotorCurve::dc_line(0.3, 20.0).unwrap());
        // 0.3 (1 - w/20) and 0.3 (-1 - w/20).
        for (rate_rad_s, forward_n_m, reverse_n_m) in [
            (-30.0, 0.75, 0.15),
            (-10.0, 0.45, -0.15),
            (0.0, 0.3, -0.3),
            (10.0, 0.15, -0.45),
            (20.0, 0.0, -0.6),
            (30.0, -0.15, -0.75),
        ] {
            let TorqueRange { min_n_m, max_n_m } = motor.range(rate_rad_s);
            assert!((max_n_m - forward_n_m).abs() < 1e-15, "{rate_rad_s}");
            assert!((min_n_m - reverse_n_m).abs() < 1e-15, "{rate_rad_s}");
            // Without supply both bounds are those of the short-circuited winding.
            let TorqueRange { min_n_m, max_n_m } = motor.range_on(rate_rad_s, 0.0);
            let shorted_n_m = -motor.shorted_n_m_s().unwrap() * rate_rad_s;
            assert!((max_n_m - shorted_n_m).abs() < 1e-15, "{rate_rad_s}");
            assert_eq!(min_n_m, max_n_m);
        }
    }

    #[test]
    fn a_current_limit_holds_driving_and_braking_alike() {
        let curve = MotorCurve::dc(DcMotor {
            stall_torque_n_m: 4.0,
            no_load_rate_rad_s: 20.0,
            current_limit_n_m: 1.0,
            regenerates: true,
        });
        let motor = unlimited(curve.unwrap());
        for rate_rad_s in [-15.0, 0.0, 15.0] {
            let range = motor.range(rate_rad_s);
            assert_eq!((range.min_n_m, range.max_n_m), (-1.0, 1.0), "{rate_rad_s}");
        }
        // The line crosses the current limit where 4 (1 - w/20) = 1, at 15 rad/s; at 22 rad/s full
        // forward brakes with 0.4, at 40 with no more than 1.
        assert!((motor.range(22.0).max_n_m + 0.4).abs() < 1e-15);
        assert_eq!(motor.range(40.0).max_n_m, -1.0);
    }

    #[test]
    fn where_nothing_takes_power_back_a_motor_coasts_beyond_its_no_load_rate_and_still_brakes() {
        let curve = MotorCurve::dc(DcMotor {
            stall_torque_n_m: 4.0,
            no_load_rate_rad_s: 20.0,
            current_limit_n_m: f64::INFINITY,
            regenerates: false,
        });
        let motor = unlimited(curve.unwrap());
        let range = motor.range(30.0);
        assert_eq!((range.min_n_m, range.max_n_m), (-10.0, 0.0));
        let range = motor.range(-30.0);
        assert_eq!((range.min_n_m, range.max_n_m), (0.0, 10.0));
        // Below its no-load rate nothing changes.
        let range = motor.range(10.0);
        assert_eq!((range.min_n_m, range.max_n_m), (-6.0, 2.0));
    }

    #[test]
    fn on_half_of_its_supply_a_dc_motor_has_half_its_stall_torque_and_no_load_rate() {
        let motor = unlimited(MotorCurve::dc_line(4.0, 20.0).unwrap());
        let drives_n_m = |rate_rad_s| motor.range_on(rate_rad_s, 0.5).max_n_m;
        // Full forward 4 (0.5 - w/20): 2 at rest, 1 at 5 rad/s, 0 at 10 and -1 at 15; full reverse
        // 4 (-0.5 - w/20).
        assert_eq!(
            [0.0, 5.0, 10.0, 15.0].map(drives_n_m),
            [2.0, 1.0, 0.0, -1.0]
        );
        assert_eq!(motor.range_on(5.0, 0.5).min_n_m, -3.0);
        assert_eq!(motor.range_on(7.0, 1.0), motor.range(7.0));
        // The velocity limit belongs to the wheel and stays.
        assert_eq!(dc().velocity_limit_on(0.8), 18.0);
    }

    /// Full forward 4 (0.9 - w/20), full reverse 4 (-0.5 - w/20): no torque at 18 and -10 rad/s.
    /// Without a curve 0.9 and 0.5 of 3 N m.
    #[test]
    fn a_motor_that_is_weaker_one_way_has_less_of_its_line_or_its_limit_there() {
        let strength = [0.9, 0.5];
        let dc = unlimited(MotorCurve::dc_line(4.0, 20.0).unwrap());
        let dc = dc.with_strength(strength).unwrap();
        assert!((dc.range(0.0).max_n_m - 3.6).abs() < 1e-15);
        assert!(dc.range(18.0).max_n_m.abs() < 1e-15 && dc.range(-10.0).min_n_m.abs() < 1e-15);
        let limits = MotorLimits {
            effort_n_m: 3.0,
            velocity_rad_s: 18.0,
        };
        let flat = Motor::new(&limits, MotorCurve::Flat).unwrap();
        let TorqueRange { min_n_m, max_n_m } = flat.with_strength(strength).unwrap().range(5.0);
        assert!((max_n_m - 2.7).abs() < 1e-15 && (min_n_m + 1.5).abs() < 1e-15);
        assert!(flat.with_strength([0.0, 1.0]).is_err());
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
            bad(-1.0, 1.0),
            "the motor's effort limit in N m is -1; it must be finite and above zero"
        );
        assert_eq!(
            bad(1.0, f64::NAN),
            "the motor's velocity limit in rad/s is NaN; it must be finite and above zero"
        );
        assert!(MotorCurve::dc_line(1.0, 0.0).is_err());
    }
}
