//! The low-level control of section III-A, decentralised: one PID on each wheel's rate, giving torque.
//!
//! **Gains from the plant.** A wheel under torque tau turns by J q'' = tau - d q', with J the inertia that the wheel
//! feels. With tau = k_p e + k_i integral(e) and d left out, the error obeys J e'' + k_p e' + k_i e = 0. Asking for the
//! loop bandwidth w_b sets k_p = J w_b, and k_i = k_p w_b / 4 puts both poles on w_b / 2: critically damped.
//!
//! J differs from moment to moment. On the ground a wheel feels its share of the robot, in the air only itself
//! (J_air < J_ground). The damping ratio is sqrt(k_p^2 / (4 k_i J)): with gains set for the largest J it is 1 there and
//! above 1 for every smaller one. But the loop is sampled. With the torque held over dt, the rate moves by
//! dt/J (k_p e + k_i I) a step. With a = k_p dt / J and b = k_i dt^2 / J, and the integral updated before its use, the
//! error's characteristic polynomial is z^2 - (2 - a - b) z + (1 - a), whose roots lie in the unit circle exactly when
//! a > 0, b > 0 and 2 a + b < 4 (Jury). The smallest J decides: the wheel in the air. [`WheelGains::propose`] keeps
//! a <= 1 there, half of the limit: a wheel in the air then reaches its target in one step and does not swing about it.

use crate::error::{not_negative, positive};
use crate::motor::TorqueRange;
use crate::{ControlError, DynamicModel};

/// Gains of one wheel's PID.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelGains {
    /// k_p: torque per rate error, in N m s/rad.
    pub proportional_n_m_s: f64,
    /// k_i: torque per angle error, in N m/rad.
    pub integral_n_m: f64,
    /// k_d: torque per acceleration, in N m s^2/rad. Acts on the measured rate only, so that a step of the target
    /// gives no kick.
    pub derivative_n_m_s2: f64,
}

impl WheelGains {
    /// Gains for a loop bandwidth in rad/s, from the largest inertia that a wheel feels (on the ground) and the
    /// smallest (in the air), in kg m^2, and the loop's period in seconds: k_p = J_ground w_b, but at most
    /// J_air / dt, for the stability of a wheel in the air; k_i = k_p w / 4 with w = k_p / J_ground the bandwidth
    /// that this leaves; no derivative.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`].
    pub fn propose(
        ground_inertia_kg_m2: f64,
        air_inertia_kg_m2: f64,
        dt_s: f64,
        bandwidth_rad_s: f64,
    ) -> Result<Self, ControlError> {
        let j_ground = positive(
            "the wheel's inertia on the ground in kg m^2",
            ground_inertia_kg_m2,
        )?;
        let j_air = positive(
            "the wheel's inertia in the air in kg m^2",
            air_inertia_kg_m2,
        )?;
        let dt_s = positive("the wheel loop's period in s", dt_s)?;
        let w_b = positive("the wheel loop's bandwidth in rad/s", bandwidth_rad_s)?;
        let k_p = (j_ground * w_b).min(j_air / dt_s);
        Ok(Self {
            proportional_n_m_s: k_p,
            integral_n_m: 0.25 * k_p * k_p / j_ground,
            derivative_n_m_s2: 0.0,
        })
    }

    /// Gains for a robot's wheels, from its [`DynamicModel`], as [`Self::propose`].
    ///
    /// # Errors
    /// As [`Self::propose`].
    pub fn for_robot(
        model: &DynamicModel,
        dt_s: f64,
        bandwidth_rad_s: f64,
    ) -> Result<Self, ControlError> {
        Self::propose(
            model.ground_inertia_kg_m2(),
            model.air_inertia_kg_m2(),
            dt_s,
            bandwidth_rad_s,
        )
    }

    /// The loop bandwidth that these gains give a wheel of this inertia, in rad/s: k_p / J. Less than what was asked
    /// of [`Self::propose`] where the wheel in the air held it down: a shorter period then gives more.
    pub fn bandwidth_rad_s(&self, inertia_kg_m2: f64) -> f64 {
        self.proportional_n_m_s / inertia_kg_m2
    }

    /// Whether a wheel of this inertia under these gains (without derivative) and this period is stable: a > 0, b >= 0
    /// and 2 a + b < 4 of the module's derivation.
    pub fn is_stable(&self, inertia_kg_m2: f64, dt_s: f64) -> bool {
        let a = self.proportional_n_m_s * dt_s / inertia_kg_m2;
        let b = self.integral_n_m * dt_s * dt_s / inertia_kg_m2;
        a > 0.0 && b >= 0.0 && 2.0 * a + b < 4.0
    }
}

/// Settings of the wheel loops, the same for every wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelLoopSettings {
    /// Gains of the PID.
    pub gains: WheelGains,
    /// Time constant of the low-pass on the derivative, in seconds; 0 for none.
    pub derivative_filter_s: f64,
    /// Viscous damping of the wheel's joint made up for at the target rate, in N m s/rad; 0 for none.
    pub feedforward_damping_n_m_s: f64,
    /// Dry friction of the wheel's joint made up for in the target's direction, in N m; 0 for none.
    pub feedforward_friction_n_m: f64,
}

impl WheelLoopSettings {
    /// A PID with these gains, without derivative filter and feedforward.
    pub fn new(gains: WheelGains) -> Self {
        Self {
            gains,
            derivative_filter_s: 0.0,
            feedforward_damping_n_m_s: 0.0,
            feedforward_friction_n_m: 0.0,
        }
    }
}

/// One PID a wheel, from wheel rates to torques.
///
/// The integral stands still while the torque is at the motor's limit and the error would drive it further beyond
/// (conditional integration), so that it never winds up on what the motor cannot give.
#[derive(Clone, Debug)]
pub struct WheelLoop {
    settings: WheelLoopSettings,
    wheels: Vec<WheelState>,
    torques_n_m: Vec<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
struct WheelState {
    /// Integral part of the torque, in N m.
    integral_n_m: f64,
    /// Filtered acceleration, in rad/s^2.
    acceleration_rad_s2: f64,
    /// The rate one step ago.
    previous_rate_rad_s: Option<f64>,
}

impl WheelLoop {
    /// Loops for `wheel_count` wheels.
    ///
    /// # Errors
    /// [`ControlError::Negative`] where a gain or a setting is negative or not finite.
    pub fn new(wheel_count: usize, settings: WheelLoopSettings) -> Result<Self, ControlError> {
        let gains = &settings.gains;
        for (what, value) in [
            (
                "the proportional gain in N m s/rad",
                gains.proportional_n_m_s,
            ),
            ("the integral gain in N m/rad", gains.integral_n_m),
            (
                "the derivative gain in N m s^2/rad",
                gains.derivative_n_m_s2,
            ),
            (
                "the derivative filter's time constant in s",
                settings.derivative_filter_s,
            ),
            (
                "the damping feedforward in N m s/rad",
                settings.feedforward_damping_n_m_s,
            ),
            (
                "the friction feedforward in N m",
                settings.feedforward_friction_n_m,
            ),
        ] {
            not_negative(what, value)?;
        }
        Ok(Self {
            settings,
            wheels: vec![WheelState::default(); wheel_count],
            torques_n_m: vec![0.0; wheel_count],
        })
    }

    /// The settings.
    pub fn settings(&self) -> &WheelLoopSettings {
        &self.settings
    }

    /// Torques in N m, one a wheel and within `limits`, from target and measured rates in rad/s. The loop's period
    /// `dt_s` may change from call to call; without a positive one the torques stay as they were.
    pub fn update(
        &mut self,
        targets_rad_s: &[f64],
        rates_rad_s: &[f64],
        limits: &[TorqueRange],
        dt_s: f64,
    ) -> &[f64] {
        if dt_s > 0.0 {
            let inputs = targets_rad_s.iter().zip(rates_rad_s).zip(limits);
            let wheels = self.wheels.iter_mut().zip(&mut self.torques_n_m);
            for ((wheel, torque_n_m), ((target, rate), limit)) in wheels.zip(inputs) {
                *torque_n_m = wheel.update(&self.settings, *target, *rate, limit, dt_s);
            }
        }
        &self.torques_n_m
    }

    /// Forgets integrals and past rates.
    pub fn reset(&mut self) {
        self.wheels.fill(WheelState::default());
        self.torques_n_m.fill(0.0);
    }
}

impl WheelState {
    fn update(
        &mut self,
        settings: &WheelLoopSettings,
        target_rad_s: f64,
        rate_rad_s: f64,
        limit: &TorqueRange,
        dt_s: f64,
    ) -> f64 {
        let gains = &settings.gains;
        let e = target_rad_s - rate_rad_s;

        // First-order low-pass, implicit Euler: stable for any time constant.
        let previous = self
            .previous_rate_rad_s
            .replace(rate_rad_s)
            .unwrap_or(rate_rad_s);
        let raw = (rate_rad_s - previous) / dt_s;
        let share = dt_s / (settings.derivative_filter_s + dt_s);
        self.acceleration_rad_s2 += share * (raw - self.acceleration_rad_s2);

        // No friction is made up for at a target of zero: its sign is unknown there.
        let friction_sign = if target_rad_s == 0.0 {
            0.0
        } else {
            target_rad_s.signum()
        };
        let direct = gains.proportional_n_m_s * e
            - gains.derivative_n_m_s2 * self.acceleration_rad_s2
            + settings.feedforward_damping_n_m_s * target_rad_s
            + settings.feedforward_friction_n_m * friction_sign;

        let integral = self.integral_n_m + gains.integral_n_m * e * dt_s;
        let wanted = direct + integral;
        let winds_up = (wanted > limit.max_n_m && e > 0.0) || (wanted < limit.min_n_m && e < 0.0);
        if !winds_up {
            self.integral_n_m = integral;
        }
        limit.clamp(wanted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: TorqueRange = TorqueRange {
        min_n_m: -1.0,
        max_n_m: 1.0,
    };

    /// A wheel of inertia `j` under its loop, the torque held over each step: rates after each.
    fn run(gains: WheelGains, j: f64, damping: f64, dt_s: f64, steps: usize) -> Vec<f64> {
        let mut wheel_loop = WheelLoop::new(1, WheelLoopSettings::new(gains)).unwrap();
        let mut rate = 0.0;
        (0..steps)
            .map(|_| {
                let torque = wheel_loop.update(&[5.0], &[rate], &[TorqueRange::UNLIMITED], dt_s)[0];
                rate += dt_s / j * (torque - damping * rate);
                rate
            })
            .collect()
    }

    #[test]
    fn proposed_gains_reach_the_target_in_about_one_over_the_bandwidth() {
        let gains = WheelGains::propose(7e-3, 2.4e-4, 1e-3, 30.0).unwrap();
        assert!((gains.bandwidth_rad_s(7e-3) - 30.0).abs() < 1e-12);
        let rates = run(gains, 7e-3, 1e-3, 1e-3, 1000);
        // Critically damped with both poles at 15 rad/s and a zero at 7.5: e(t) = (1 - 15 t) exp(-15 t) plus the
        // response of the zero; within 15 % after 4/15 s, within 0.1 % after 1 s, damping included.
        assert!((rates[266] / 5.0 - 1.0).abs() < 0.15, "{}", rates[266]);
        assert!((rates[999] / 5.0 - 1.0).abs() < 1e-3, "{}", rates[999]);
    }

    #[test]
    fn proposed_gains_hold_a_wheel_in_the_air_without_swinging() {
        for dt_s in [1.0 / 1000.0, 1.0 / 240.0, 1.0 / 60.0] {
            let gains = WheelGains::propose(7e-3, 2.4e-4, dt_s, 50.0).unwrap();
            assert!(gains.is_stable(2.4e-4, dt_s) && gains.is_stable(7e-3, dt_s));
            let rates = run(gains, 2.4e-4, 0.0, dt_s, 2000);
            // The integral overshoots by a few per cent; beyond that a swing from step to step would show.
            assert!(rates.iter().all(|r| *r > 0.0 && *r < 5.0 * 1.2));
            assert!((rates[1999] / 5.0 - 1.0).abs() < 0.02);
        }
    }

    #[test]
    fn the_stability_limit_is_where_the_simulated_loop_starts_to_grow() {
        let (j, dt_s) = (2e-4, 1e-3);
        for (integral, share) in [(0.0, 0.99), (0.0, 1.01), (20.0, 0.99), (20.0, 1.01)] {
            // 2 a + b = 4 share.
            let b = integral * dt_s * dt_s / j;
            let a = (4.0 * share - b) / 2.0;
            let gains = WheelGains {
                proportional_n_m_s: a * j / dt_s,
                integral_n_m: integral,
                derivative_n_m_s2: 0.0,
            };
            let rates = run(gains, j, 0.0, dt_s, 4000);
            let off = (rates[3999] - 5.0).abs();
            assert_eq!(gains.is_stable(j, dt_s), share < 1.0);
            assert_eq!(off < 5.0, share < 1.0, "{integral} {share}: {off}");
        }
    }

    #[test]
    fn the_integral_does_not_wind_up_while_the_motor_is_at_its_limit() {
        let gains = WheelGains {
            proportional_n_m_s: 0.1,
            integral_n_m: 1.0,
            derivative_n_m_s2: 0.0,
        };
        let mut wheel_loop = WheelLoop::new(1, WheelLoopSettings::new(gains)).unwrap();
        // Stalled for 100 s at an error of 50 rad/s: an integral that went on would hold 5000 N m.
        for _ in 0..10_000 {
            let torque = wheel_loop.update(&[50.0], &[0.0], &[LIMIT], 0.01)[0];
            assert_eq!(torque, 1.0);
        }
        // Let go and a little beyond the target: the torque comes off the limit at once.
        let torque = wheel_loop.update(&[50.0], &[50.1], &[LIMIT], 0.01)[0];
        assert!(torque < 1.0, "{torque}");
    }

    #[test]
    fn the_derivative_acts_on_the_rate_and_is_filtered() {
        let gains = WheelGains {
            proportional_n_m_s: 0.0,
            integral_n_m: 0.0,
            derivative_n_m_s2: 0.5,
        };
        let mut settings = WheelLoopSettings::new(gains);
        settings.derivative_filter_s = 0.03;
        let mut wheel_loop = WheelLoop::new(1, settings).unwrap();
        let open = [TorqueRange::UNLIMITED];
        assert_eq!(wheel_loop.update(&[0.0], &[0.0], &open, 0.01)[0], 0.0);
        // A step of the target alone gives no torque.
        assert_eq!(wheel_loop.update(&[9.0], &[0.0], &open, 0.01)[0], 0.0);
        // The rate rises by 10 rad/s^2: a quarter of it passes the filter in the first step, dt / (T + dt).
        let first = wheel_loop.update(&[9.0], &[0.1], &open, 0.01)[0];
        assert!((first + 0.5 * 10.0 * 0.25).abs() < 1e-12, "{first}");
    }

    #[test]
    fn feedforward_makes_up_for_damping_and_dry_friction() {
        let gains = WheelGains {
            proportional_n_m_s: 0.0,
            integral_n_m: 0.0,
            derivative_n_m_s2: 0.0,
        };
        let settings = WheelLoopSettings {
            feedforward_damping_n_m_s: 0.02,
            feedforward_friction_n_m: 0.3,
            ..WheelLoopSettings::new(gains)
        };
        let mut wheel_loop = WheelLoop::new(3, settings).unwrap();
        let torques = wheel_loop.update(&[5.0, -5.0, 0.0], &[0.0; 3], &[LIMIT; 3], 0.01);
        for (torque, expected) in torques.iter().zip([0.4, -0.4, 0.0]) {
            assert!((torque - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn settings_that_are_negative_or_not_numbers_are_refused() {
        let mut settings =
            WheelLoopSettings::new(WheelGains::propose(1e-2, 1e-3, 1e-3, 10.0).unwrap());
        settings.derivative_filter_s = -1.0;
        assert_eq!(
            WheelLoop::new(3, settings).unwrap_err().to_string(),
            "the derivative filter's time constant in s is -1; it must be finite and not below zero"
        );
        assert!(WheelGains::propose(1e-2, 1e-3, f64::NAN, 10.0).is_err());
    }
}
