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
//! a <= 1/2 there, a quarter of the limit, which leaves room for a step of delay.

use crate::ControlError;
use crate::error::{not_negative, positive};
use crate::motor::TorqueRange;

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
    /// J_air / (2 dt), for the stability of a wheel in the air; k_i = k_p w / 4 with w = k_p / J_ground the bandwidth
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
        let k_p = (j_ground * w_b).min(0.5 * j_air / dt_s);
        Ok(Self {
            proportional_n_m_s: k_p,
            integral_n_m: 0.25 * k_p * k_p / j_ground,
            derivative_n_m_s2: 0.0,
        })
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
