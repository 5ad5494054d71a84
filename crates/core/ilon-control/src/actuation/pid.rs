//! One PID per wheel, from wheel rate to torque: the decentralised low-level control of section
//! III-A.
//!
//! **Gains from the plant.** A wheel under torque tau turns by J q'' = tau - d q', with J the
//! inertia that the wheel feels. With tau = k_p e + k_i integral(e) and d neglected, the error
//! obeys J e'' + k_p e' + k_i e = 0. A loop bandwidth w_b sets k_p = J w_b, and k_i = k_p w_b / 4
//! puts both poles at -w_b / 2: critically damped.
//!
//! J varies. On the ground a wheel feels its share of the robot, in the air only itself (J_air <
//! J_ground). The damping ratio is sqrt(k_p^2 / (4 k_i J)): with gains set for the largest J it is
//! 1 there and above 1 for every smaller one. But the loop is sampled. With the torque held over
//! dt, the rate moves by dt/J (k_p e + k_i I) a step. With a = k_p dt / J and b = k_i dt^2 / J, and
//! the integral updated before its use, the error's characteristic polynomial is z^2 - (2 - a - b)
//! z + (1 - a), whose roots lie in the unit circle exactly when a > 0, b > 0 and 2 a + b < 4
//! (Jury). The smallest J decides: the wheel in the air. [`WheelGains::propose`] keeps a <= 1
//! there, half of the limit: a wheel in the air then reaches its target in one step without
//! oscillating. With torques n periods late the limit of a alone is 2 sin(pi / (4 n + 2)) (Levin
//! and May 1976), and half of that is kept.
//!
//! **A loop that is faster than the simulation's steps** ([`LoopTiming::Continuous`]) has no such
//! limit. Within a step its torque falls as the wheel gains rate, by a droop D per rate, and the
//! plant feels the mean over the step. If the wheel gains x over the step, the mean gain is theta
//! x: half of x if the step is short against the loop's time constant, nearly all of x if it is
//! long. A wheel of inertia J under k_p approaches its target as exp(-z), z = k_p dt / J, which
//! gives theta = 1 / (1 - exp(-z)) - 1 / z. The mean torque is then tau(q') - theta D x, with theta
//! D = theta k_p + (5 theta - 2) / 3 k_i dt + k_d / (T + dt), T the derivative's time constant
//! (its part, k_d dt / (T + dt), adds to the wheel's inertia): in
//! a short step the integral counts half of the initial error and a sixth of the rate gained; in a
//! long one all of both. A plant that solves its step with that mean is stable for any gains and
//! any dt (theta is at least one half), exact for one pole, and of second order in dt. Where the
//! rate jumps within a step, as when rollers hand over, the wheel's angle tells its mean: the
//! integral is corrected by it.

use ilon_robot::{mean_of_gain, time_and_gain_until};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::derivative::{FilteredDerivative, weight};
use super::motor::TorqueRange;
use super::{BodySense, Demand, FallingTorque, TorqueLaw};
use crate::error::{not_negative, positive};
use crate::{ControlError, DynamicModel};

/// Gains of one wheel's PID.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelGains {
    /// k_p: torque per rate error, in N m s/rad.
    pub proportional_n_m_s: f64,
    /// k_i: torque per angle error, in N m/rad.
    pub integral_n_m: f64,
    /// k_d: torque per acceleration, in N m s^2/rad. It acts on the measured rate only, so that a
    /// step of the target causes no kick.
    pub derivative_n_m_s2: f64,
}

impl WheelGains {
    /// Returns gains for a loop bandwidth in rad/s, from the largest inertia that a wheel feels (on
    /// the ground) and the smallest (in the air), in kg m^2, and the loop's period and the latency
    /// of its torques in seconds: k_p = J_ground w_b, but at most J_air / dt sin(pi / (4 n + 2))
    /// with torques n periods late, so that a wheel in the air is stable; k_i = k_p w / 4 with the
    /// resulting bandwidth w = k_p / J_ground; no derivative.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`].
    pub fn propose(
        ground_inertia_kg_m2: f64,
        air_inertia_kg_m2: f64,
        (dt_s, latency_s): (f64, f64),
        bandwidth_rad_s: f64,
    ) -> Result<Self, ControlError> {
        let j_ground = ground_inertia_kg_m2;
        let continuous = Self::propose_continuous(j_ground, bandwidth_rad_s)?;
        let j_air = positive(
            "the wheel's inertia in the air in kg m^2",
            air_inertia_kg_m2,
        )?;
        let dt_s = positive("the wheel loop's period in s", dt_s)?;
        let waits = (latency_s / dt_s - 1e-9).ceil().max(0.0);
        let kept = libm::sin(std::f64::consts::PI / (4.0 * waits + 2.0));
        let k_p = continuous.proportional_n_m_s.min(j_air / dt_s * kept);
        Ok(Self {
            proportional_n_m_s: k_p,
            integral_n_m: 0.25 * k_p * k_p / j_ground,
            derivative_n_m_s2: 0.0,
        })
    }

    /// Returns gains of a loop that is faster than the steps, for a bandwidth in rad/s and the
    /// largest inertia that a wheel feels in kg m^2: k_p = J_ground w_b, k_i = k_p w_b / 4, no
    /// derivative.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`].
    pub fn propose_continuous(
        ground_inertia_kg_m2: f64,
        bandwidth_rad_s: f64,
    ) -> Result<Self, ControlError> {
        let j_ground = positive(
            "the wheel's inertia on the ground in kg m^2",
            ground_inertia_kg_m2,
        )?;
        let w_b = positive("the wheel loop's bandwidth in rad/s", bandwidth_rad_s)?;
        Ok(Self {
            proportional_n_m_s: j_ground * w_b,
            integral_n_m: 0.25 * j_ground * w_b * w_b,
            derivative_n_m_s2: 0.0,
        })
    }

    /// Returns gains for a robot's wheels from its [`DynamicModel`], by [`Self::propose`] with the
    /// loop's period and latency in seconds, or by [`Self::propose_continuous`].
    ///
    /// # Errors
    /// Those of these two functions.
    pub fn for_robot(
        model: &DynamicModel,
        timing: LoopTiming,
        held_s: (f64, f64),
        bandwidth_rad_s: f64,
    ) -> Result<Self, ControlError> {
        let j_ground = model.ground_inertia_kg_m2();
        match timing {
            LoopTiming::Sampled => {
                Self::propose(j_ground, model.air_inertia_kg_m2(), held_s, bandwidth_rad_s)
            }
            LoopTiming::Continuous => Self::propose_continuous(j_ground, bandwidth_rad_s),
        }
    }
}

/// How a wheel loop's torque goes with the physics steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LoopTiming {
    /// Computed once a physics step and held over it: a digital loop whose period is the step, with
    /// its limits of stability.
    Sampled,
    /// Falling within the step as the wheel gains rate: a loop much faster than the step, stable at
    /// any.
    #[default]
    Continuous,
}

/// Settings of the wheel loops, the same for every wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelLoopSettings {
    /// Gains of the PID.
    pub gains: WheelGains,
    /// When the torque is computed.
    pub timing: LoopTiming,
    /// The inertia that a wheel feels on the ground, in kg m^2; a continuous loop compares its time
    /// constant with the step by it. 0 if unknown: every step then counts as long.
    pub inertia_kg_m2: f64,
    /// Time constant of the low-pass on the derivative, in seconds; 0 for none.
    pub derivative_filter_s: f64,
    /// Viscous damping of the wheel's joint, compensated at the target rate, in N m s/rad; 0 for
    /// none.
    pub feedforward_damping_n_m_s: f64,
    /// Dry friction of the wheel's joint, compensated in the target's direction, in N m; 0 for
    /// none.
    pub feedforward_friction_n_m: f64,
    /// Limit of the integral's torque, in N m; infinite for none.
    pub integral_limit_n_m: f64,
    /// Whether the integral keeps growing while the torque is at the motor's limit.
    pub winds_up: bool,
}

impl WheelLoopSettings {
    /// The nearest integral within its limit, in N m.
    fn held(&self, integral_n_m: f64) -> f64 {
        integral_n_m.clamp(-self.integral_limit_n_m, self.integral_limit_n_m)
    }

    /// A PID with these gains, held over each step, without derivative filter and feedforward.
    pub fn new(gains: WheelGains) -> Self {
        Self {
            gains,
            timing: LoopTiming::Sampled,
            inertia_kg_m2: 0.0,
            derivative_filter_s: 0.0,
            feedforward_damping_n_m_s: 0.0,
            feedforward_friction_n_m: 0.0,
            integral_limit_n_m: f64::INFINITY,
            winds_up: false,
        }
    }
}

/// One PID per wheel, from wheel rates to torques.
///
/// The integral is frozen while the torque is at the motor's limit and the error would drive it
/// further beyond (conditional integration), unless the settings allow windup, and at the
/// integral's own limit.
#[derive(Clone, Debug)]
pub struct WheelLoop {
    settings: WheelLoopSettings,
    wheels: Vec<WheelState>,
    torques_n_m: Vec<f64>,
    falling: Vec<FallingTorque>,
}

#[derive(Clone, Copy, Debug, Default)]
struct WheelState {
    /// Integral part of the torque, in N m.
    integral_n_m: f64,
    /// The acceleration, filtered, in rad/s^2.
    acceleration_rad_s2: FilteredDerivative<f64>,
    /// The wheel's angle, in rad, and by how much it grew in the last step, if that is known.
    angle_rad: Option<f64>,
    turned_rad: Option<f64>,
    /// The last step of a continuous loop, whose integral is not booked yet.
    begun: Option<Begun>,
}

/// The beginning of a step of a continuous loop.
#[derive(Clone, Copy, Debug)]
struct Begun {
    error_rad_s: f64,
    /// Without the integral over the step itself.
    asked_n_m: f64,
    limit: TorqueRange,
    dt_s: f64,
}

impl Begun {
    /// The integral after the step, in N m, from that before it, the rate that the wheel gained and
    /// by how much its mean exceeds that of a steady gain, with the motor's limit at its end. It
    /// stands for as long as the torque is beyond the limit: a step that only began or ended there
    /// counts in part.
    fn integral_n_m(
        &self,
        before_n_m: f64,
        (gained_rad_s, jumped_rad_s): (f64, f64),
        (settings, limit): (&WheelLoopSettings, &TorqueRange),
    ) -> f64 {
        let gains = &settings.gains;
        let (e, step_n_m_s) = (self.error_rad_s, gains.integral_n_m * self.dt_s);
        let z = gains.proportional_n_m_s * self.dt_s / settings.inertia_kg_m2;
        let theta = mean_of_gain(z);
        let mean_rad_s = theta * gained_rad_s + 2.0 * (1.0 - theta) * jumped_rad_s;
        let whole_n_m = before_n_m + step_n_m_s * (e - mean_rad_s);
        if settings.winds_up {
            return settings.held(whole_n_m);
        }
        let ends_n_m = self.asked_n_m - gains.proportional_n_m_s * gained_rad_s;
        let margins_n_m = [
            (
                self.asked_n_m - self.limit.max_n_m,
                ends_n_m - limit.max_n_m,
            ),
            (
                self.limit.min_n_m - self.asked_n_m,
                limit.min_n_m - ends_n_m,
            ),
        ];
        let mut stood_rad_s = 0.0;
        for (beyond_n_m, sign) in margins_n_m.into_iter().zip([1.0, -1.0]) {
            let drives = (sign * e, sign * (e - gained_rad_s));
            let [from, to] = [above_zero(beyond_n_m), above_zero(drives)]
                .into_iter()
                .fold([0.0, 1.0], |[a, b], [c, d]| {
                    [f64::max(a, c), f64::min(b, d)]
                });
            if (from, to) == (0.0, 1.0) {
                return before_n_m;
            }
            if from < to {
                let [[from_s, from_gain], [to_s, to_gain]] =
                    [from, to].map(|share| time_and_gain_until(z, share));
                stood_rad_s += e * (to_s - from_s) - gained_rad_s * (to_gain - from_gain);
            }
        }
        settings.held(whole_n_m - step_n_m_s * stood_rad_s)
    }
}

/// The part of 0 to 1 in which a line between two values is positive; empty parts end before they
/// begin.
fn above_zero((from, to): (f64, f64)) -> [f64; 2] {
    match (from > 0.0, to > 0.0) {
        (true, true) => [0.0, 1.0],
        (true, false) => [0.0, from / (from - to)],
        (false, true) => [from / (from - to), 1.0],
        (false, false) => [1.0, 0.0],
    }
}

impl WheelLoop {
    /// Builds loops for `wheel_count` wheels.
    ///
    /// # Errors
    /// [`ControlError::Negative`] if a gain or a setting is negative or not finite.
    pub fn new(wheel_count: usize, settings: WheelLoopSettings) -> Result<Self, ControlError> {
        let WheelGains {
            proportional_n_m_s,
            integral_n_m,
            derivative_n_m_s2,
        } = settings.gains;
        for (what, value) in [
            ("the proportional gain in N m s/rad", proportional_n_m_s),
            ("the integral gain in N m/rad", integral_n_m),
            ("the derivative gain in N m s^2/rad", derivative_n_m_s2),
            ("the wheel's inertia in kg m^2", settings.inertia_kg_m2),
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
        // Without a limit it is infinite.
        let limit_n_m = settings.integral_limit_n_m;
        not_negative("the integral's limit in N m", limit_n_m.min(f64::MAX))?;
        Ok(Self {
            settings,
            wheels: vec![WheelState::default(); wheel_count],
            torques_n_m: vec![0.0; wheel_count],
            falling: vec![FallingTorque::default(); wheel_count],
        })
    }
}

impl TorqueLaw for WheelLoop {
    /// For a continuous loop these are the torques at unchanged rates; [`TorqueLaw::falling`] says
    /// how they fall.
    fn step(&mut self, demand: &Demand<'_>) {
        let inputs = demand.targets_rad_s.iter().zip(demand.rates_rad_s);
        let inputs = inputs.zip(demand.limits);
        let outputs = self.torques_n_m.iter_mut().zip(&mut self.falling);
        let wheels = self.wheels.iter_mut().zip(outputs);
        for ((wheel, (torque_n_m, falling)), ((target, rate), limit)) in wheels.zip(inputs) {
            *falling = wheel.update(&self.settings, (*target, *rate), limit, demand.dt_s);
            *torque_n_m = limit.clamp(falling.torque_n_m);
        }
    }

    fn torques_n_m(&self) -> &[f64] {
        &self.torques_n_m
    }

    fn sense(&mut self, known: &BodySense<'_>) {
        for (wheel, angle_rad) in self.wheels.iter_mut().zip(known.angles_rad) {
            let before_rad = wheel.angle_rad.replace(*angle_rad);
            wheel.turned_rad = before_rad.map(|before_rad| angle_rad - before_rad);
        }
    }

    fn pause(&mut self) {
        for wheel in &mut self.wheels {
            (wheel.begun, wheel.turned_rad) = (None, None);
        }
    }

    fn falling(&self) -> &[FallingTorque] {
        match self.settings.timing {
            LoopTiming::Sampled => &[],
            LoopTiming::Continuous => &self.falling,
        }
    }

    fn boxed(&self) -> Box<dyn TorqueLaw> {
        Box::new(self.clone())
    }
}

impl WheelState {
    /// Returns the torque at the current rate, and how it falls with the rate.
    fn update(
        &mut self,
        settings: &WheelLoopSettings,
        (target_rad_s, rate_rad_s): (f64, f64),
        limit: &TorqueRange,
        dt_s: f64,
    ) -> FallingTorque {
        let gains = &settings.gains;
        let e = target_rad_s - rate_rad_s;

        let weight = weight(settings.derivative_filter_s, dt_s);
        let gained_rad_s = self.acceleration_rad_s2.update(rate_rad_s, weight, dt_s);
        let acceleration_rad_s2 = self.acceleration_rad_s2.value;

        // At a target of zero the sign of the friction is unknown, so none is compensated.
        let friction_sign = if target_rad_s == 0.0 {
            0.0
        } else {
            target_rad_s.signum()
        };
        // The torque of a continuous loop is computed for an unchanged rate. The droop holds the
        // rest: the proportional part, the integral over the step (corrected once the rate is
        // known), and the filtered acceleration.
        if let Some(begun) = self.begun.take() {
            let steady_rad_s = rate_rad_s - 0.5 * gained_rad_s;
            let turned_rad = self.turned_rad.take();
            let jumped_rad_s = turned_rad.map_or(0.0, |rad| rad / begun.dt_s - steady_rad_s);
            let rates = (gained_rad_s, jumped_rad_s);
            self.integral_n_m = begun.integral_n_m(self.integral_n_m, rates, (settings, limit));
        }
        let theta = mean_of_gain(gains.proportional_n_m_s * dt_s / settings.inertia_kg_m2);
        let grown_n_m = self.integral_n_m + gains.integral_n_m * dt_s * e;
        // Up to its limit, where the rate that the wheel gains no longer changes it.
        let (step_n_m_s, last_n_m) = match grown_n_m.abs() > settings.integral_limit_n_m {
            true => (0.0, settings.held(grown_n_m) - self.integral_n_m),
            false => (gains.integral_n_m * dt_s, 0.0),
        };
        let (held, droop, counted) = match settings.timing {
            LoopTiming::Sampled => (acceleration_rad_s2, 0.0, 1.0),
            LoopTiming::Continuous => (
                (1.0 - weight) * acceleration_rad_s2,
                gains.proportional_n_m_s + (5.0 * theta - 2.0) / (3.0 * theta) * step_n_m_s,
                theta,
            ),
        };
        let direct = gains.proportional_n_m_s * e - gains.derivative_n_m_s2 * held
            + settings.feedforward_damping_n_m_s * target_rad_s
            + settings.feedforward_friction_n_m * friction_sign;

        let wanted = direct + self.integral_n_m + counted * step_n_m_s * e + last_n_m;
        match settings.timing {
            LoopTiming::Continuous => {
                self.begun = Some(Begun {
                    error_rad_s: e,
                    asked_n_m: direct + self.integral_n_m,
                    limit: *limit,
                    dt_s,
                });
            }
            LoopTiming::Sampled => {
                let beyond =
                    (wanted > limit.max_n_m && e > 0.0) || (wanted < limit.min_n_m && e < 0.0);
                if settings.winds_up || !beyond {
                    self.integral_n_m = settings.held(grown_n_m);
                }
            }
        }
        FallingTorque {
            torque_n_m: wanted,
            droop_n_m_s: droop,
            per_acceleration_n_m_s2: weight * gains.derivative_n_m_s2,
        }
    }
}

#[cfg(test)]
mod tests;
