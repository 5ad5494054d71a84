//! Predicts the demand of a pilot on the wheels over a run.

use ilon_control::{Feasibility, Kinematics, Reference, Task, WheelRateAsked};
use ilon_robot::{Twist, wrap_angle};
use nalgebra::Vector2;

use super::contradiction::Contradiction;
use super::{Pilot, Planned};
use ilon_scenario::scenario::Scenario;

/// Number of times at which a reference is searched for peaks: a hundredth of a period of any path
/// of the run. Chosen.
const SAMPLES: usize = 2000;

impl Pilot {
    /// The fastest wheel rate that the scenario commands, in rad/s, regardless of the wheels'
    /// limits: that of the commanded twist, or of the reference and of the way to it from the
    /// start. Noise, pushes and overshoot add to it. `None` for a caller's controller.
    pub fn fastest_rate_asked_rad_s(&self, scenario: &Scenario) -> Option<f64> {
        match &self.motion {
            Planned::Reference(reference) => {
                let (speed_m_s, turn_rad_s) = reference.peaks(scenario.run.duration_s, SAMPLES);
                let start = scenario.robot.start();
                let first = reference.at(0.0).pose;
                // The point that follows is at most this far from the origin.
                let arm_m = self.reference_point_m().norm();
                let off_m = (first.position_m() - start.position_m()).norm() + arm_m;
                let off_rad = wrap_angle(first.heading_rad - start.heading_rad).abs();
                let gains = &scenario.guidance;
                // Feedforward and feedback together.
                let asked = self.guidance.feasibility(
                    speed_m_s + gains.position_gain_most_per_s() * off_m,
                    turn_rad_s + gains.heading_gain_per_s * off_rad,
                );
                Some(asked.position_rad_s + asked.heading_rad_s)
            }
            Planned::Twist(profile) => {
                let kinematics = self.guidance.kinematics();
                let rates = profile.held().map(|twist| fastest_rad_s(kinematics, twist));
                Some(rates.fold(0.0, f64::max))
            }
            Planned::Log(log) => {
                let kinematics = self.guidance.kinematics();
                let rates = |twist, out: &mut [f64]| kinematics.wheel_rates(twist, out);
                log.fastest_rate_rad_s(rates, kinematics.wheel_count())
            }
            Planned::Rates(_) | Planned::Own(..) => None,
        }
    }

    /// The twist of a schedule with the fastest wheels, and the same after saturation; `None`
    /// without a schedule.
    pub fn held_to_limits(&self) -> Option<[Twist; 2]> {
        let Planned::Twist(profile) = &self.motion else {
            return None;
        };
        let mut guidance = self.guidance.clone();
        let fastest = |twist: &Twist| fastest_rad_s(&self.kinematics, *twist);
        let twist_in_body = profile
            .held()
            .max_by(|a, b| fastest(a).total_cmp(&fastest(b)))?;
        let tasks = Task::of_twist(twist_in_body, self.priority);
        Some([
            twist_in_body,
            guidance.command(&tasks).saturated_twist_in_body,
        ])
    }

    /// The inconsistency of the wheel rates of a log over the run, by the kinematics of the real
    /// robot.
    pub fn contradiction(&self, kinematics: &Kinematics, duration_s: f64) -> Contradiction {
        let count = kinematics.wheel_count();
        let mut found = Contradiction::new(count);
        let Planned::Log(log) = &self.motion else {
            return found;
        };
        // Steering turns M in the run: there the recorder judges, by M of the time.
        let is_steered = |wheel| self.robot.steering_of(wheel).is_some();
        if self.robot.wheels.iter().any(is_steered) {
            return found;
        }
        let mut rates_rad_s = vec![0.0; count];
        let periods = (duration_s / self.period_s).round() as u64;
        for period in 0..periods {
            let t_s = period as f64 * self.period_s;
            if log.rates_alone(t_s, &mut rates_rad_s) {
                kinematics.roll_idle(&mut rates_rad_s);
                let sizes = found.of(kinematics, &rates_rad_s);
                found.add(kinematics, &rates_rad_s, sizes, [t_s, self.period_s]);
            }
        }
        found
    }

    /// The desired heading at a time in seconds, in radians, if a reference defines it.
    pub fn desired_heading_rad(&self, t_s: f64) -> Option<f64> {
        match &self.motion {
            Planned::Reference(reference) => Some(reference.at(t_s).pose.heading_rad),
            _ => None,
        }
    }

    /// The planned motion of the body's origin at a time in seconds: its twist in the body frame
    /// and the twist's rate of change, if a reference or a twist defines it.
    pub fn planned(&self, t_s: f64) -> Option<(Twist, Twist)> {
        match &self.motion {
            Planned::Reference(reference) => {
                Some(motion_of(reference, self.reference_point_m(), t_s))
            }
            Planned::Twist(profile) => {
                const OVER_S: f64 = 1e-5;
                let [now, then] = [t_s, t_s + OVER_S].map(|t_s| profile.at(t_s));
                Some((now, (then + now.scaled(-1.0)).scaled(1.0 / OVER_S)))
            }
            Planned::Rates(_) | Planned::Log(_) | Planned::Own(..) => None,
        }
    }

    /// The feasibility conditions (36)-(37) over the run; `None` in open loop.
    pub fn feasibility(&self, duration_s: f64) -> Option<FeasibilityInTime> {
        let Planned::Reference(reference) = &self.motion else {
            return None;
        };
        let mut feasibility = FeasibilityInTime::default();
        for sample in 0..=SAMPLES {
            let t_s = duration_s * sample as f64 / SAMPLES as f64;
            let desired = reference.at(t_s);
            let velocity = desired.velocity_in_world;
            let now = self
                .guidance
                .feasibility(velocity.linear_m_s().norm(), velocity.omega_rad_s);
            feasibility.take(t_s, &now, self.guidance.feedforward(&desired));
        }
        Some(feasibility)
    }
}

/// The rate of the wheel that turns fastest for a twist, in rad/s.
fn fastest_rad_s(kinematics: &Kinematics, twist: Twist) -> f64 {
    let mut rates_rad_s = vec![0.0; kinematics.wheel_count()];
    kinematics.wheel_rates(twist, &mut rates_rad_s);
    let sizes = rates_rad_s.iter().map(|rate| rate.abs());
    sizes.fold(0.0, f64::max)
}

/// The motion of the body's origin if a point of the body, in metres in its frame, follows a
/// reference, at a time in seconds: its twist in the body frame and the twist's rate of change.
pub fn motion_of(reference: &Reference, point_m: Vector2<f64>, t_s: f64) -> (Twist, Twist) {
    let desired = reference.at(t_s);
    let phi = desired.pose.heading_rad;
    let twist = desired.velocity_in_world.rotated(-phi);
    let omega = twist.omega_rad_s;
    // Derivative of components in a rotating frame.
    let rate = reference.acceleration_in_world(t_s).rotated(-phi)
        + Twist::new(omega * twist.vy_m_s, -omega * twist.vx_m_s, 0.0);
    (twist.at(-point_m), rate.at(-point_m))
}

/// The conditions (36) and (37) over a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct FeasibilityInTime {
    /// The left-hand side of (36).
    pub position: RateAsked,
    /// The left-hand side of (37).
    pub heading: RateAsked,
    /// q'_max, in rad/s: both must stay below half of it.
    pub limit_rad_s: f64,
    /// If the reference needs all of a wheel's rate or more: the first time, the time of the
    /// largest demand, both in seconds, and that demand.
    pub saturates: Option<(f64, f64, WheelRateAsked)>,
}

/// The wheel rates of one condition over a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct RateAsked {
    /// The largest, in rad/s.
    pub most_rad_s: f64,
    /// Time of that, in seconds.
    pub most_at_s: f64,
    /// Time from which on the condition is violated, in seconds; `None` if it always holds.
    pub beyond_from_s: Option<f64>,
}

impl FeasibilityInTime {
    fn take(&mut self, t_s: f64, now: &Feasibility, asked: WheelRateAsked) {
        self.limit_rad_s = now.limit_rad_s;
        let half_rad_s = 0.5 * now.limit_rad_s;
        self.position.take(t_s, now.position_rad_s, half_rad_s);
        self.heading.take(t_s, now.heading_rad_s, half_rad_s);
        if asked.share() > 1.0 + 1e-9 {
            let (_, at_s, worst) = self.saturates.get_or_insert((t_s, t_s, asked));
            if asked.share() > worst.share() * (1.0 + 1e-9) {
                (*at_s, *worst) = (t_s, asked);
            }
        }
    }
}

impl RateAsked {
    fn take(&mut self, t_s: f64, rate_rad_s: f64, half_rad_s: f64) {
        // Of values equal except for rounding, the first time counts.
        if rate_rad_s > self.most_rad_s * (1.0 + 1e-9) {
            (self.most_rad_s, self.most_at_s) = (rate_rad_s, t_s);
        }
        if rate_rad_s >= half_rad_s {
            self.beyond_from_s.get_or_insert(t_s);
        }
    }
}
