//! A planned motion on the rollers that touch, under the wheel loops: what statics about the wheels' middles cannot say.

use ilon_control::{ContactDynamics, ControlError, Kinematics, LimitSettings, Motor, WheelGains};
use ilon_robot::{Robot, Twist};

use super::super::pilot::Pilot;
use crate::scenario::{self, Scenario, WheelLaw};

/// A robot with its payloads and motors, and the ground that it rolls on.
#[derive(Clone, Copy)]
pub(super) struct RobotOnGround<'a> {
    pub robot: &'a Robot,
    pub motors: &'a [Motor],
    pub settings: LimitSettings,
}

/// A robot that rolls on its touching rollers as its loops let it, period by period of the control.
struct Rolling<'a> {
    dynamics: ContactDynamics,
    motors: &'a [Motor],
    periods: Periods,
}

/// The periods of the control in which targets are held, and the steps in one.
#[derive(Clone, Copy)]
struct Periods {
    period_s: f64,
    steps: u64,
}

impl Periods {
    fn of(scenario: &Scenario) -> Self {
        /// Steps are at most so long, in seconds, and at least four to a period.
        const STEP_S: f64 = 1e-3;
        /// Targets that are held for less than this, in seconds, are as good as continuous.
        const LEAST_PERIOD_S: f64 = 2.5e-4;
        let period_s = scenario.run.control_dt_s.max(LEAST_PERIOD_S);
        Self {
            period_s,
            steps: (period_s / STEP_S).ceil().max(4.0) as u64,
        }
    }

    fn step_s(&self) -> f64 {
        self.period_s / self.steps as f64
    }
}

impl<'a> Rolling<'a> {
    /// Under the loops of a scenario, on ground that falls in a direction of the body frame in radians; `None` of joints between bodies and of laws that
    /// it does not know.
    fn new(scenario: &Scenario, on_ground: RobotOnGround<'a>, downhill_rad: f64) -> Option<Self> {
        let section = &scenario.wheel_loop;
        if !on_ground.robot.joints.is_empty() || section.law != WheelLaw::Pid {
            return None;
        }
        let gains = WheelGains {
            proportional_n_m_s: section.proportional_n_m_s?,
            integral_n_m: section.integral_n_m?,
            derivative_n_m_s2: section.derivative_n_m_s2,
        };
        let settings = LimitSettings {
            downhill_rad,
            ..on_ground.settings
        };
        Some(Self {
            dynamics: ContactDynamics::new(on_ground.robot, &settings, gains).ok()?,
            motors: on_ground.motors,
            periods: Periods::of(scenario),
        })
    }

    /// Takes a step with a target twist, which changes at a rate in the mean.
    fn step(&mut self, (twist, twist_rate): (Twist, Twist)) -> Result<(), ControlError> {
        let step_s = self.periods.step_s();
        self.dynamics.step(twist, twist_rate, self.motors, step_s)
    }
}

/// When a planned motion first keeps a wheel at its grip, and which share of its grip each wheel uses then, about the time that statics say; `None` where no
/// wheel is kept there, or the loops are not those that are known. What comes before a time is not counted.
pub(super) fn slides_first(
    scenario: &Scenario,
    on_ground: RobotOnGround<'_>,
    pilot: &Pilot,
    (counts_from_s, statics_s): (f64, f64),
) -> Option<(f64, Vec<f64>)> {
    /// How far from the time that statics say wheels are looked for, in seconds: what is looked at stays some thousand steps.
    const BEFORE_S: f64 = 1.0;
    const AFTER_S: f64 = 2.0;
    /// In which the loops take hold, in seconds.
    const TAKES_HOLD_S: f64 = 0.5;
    /// Longer than a roller that comes down keeps its wheel at its grip, in seconds.
    const LASTS_S: f64 = 0.02;
    if scenario.guidance.kinematics != scenario::Kinematics::Ideal {
        return None;
    }
    let Periods { period_s, steps } = Periods::of(scenario);
    let counts_from_s = counts_from_s.max(statics_s - BEFORE_S);
    let begins_at = ((counts_from_s - TAKES_HOLD_S).max(0.0) / period_s).floor() as u64;
    let ends_at = ((statics_s + AFTER_S).min(scenario.run.duration_s) / period_s) as u64;

    // Up to there wheels turn as they are told.
    let kinematics = Kinematics::new(on_ground.robot).ok()?;
    let n = on_ground.robot.wheels.len();
    let (mut rates, mut angles) = (vec![0.0; n], vec![0.0; n]);
    let mut heading_rad = scenario.robot.start().heading_rad;
    for period in 0..begins_at {
        let (twist, _) = pilot.planned(period_s * (period as f64 + 0.5))?;
        kinematics.wheel_rates(twist, &mut rates);
        for (angle, rate) in angles.iter_mut().zip(&rates) {
            *angle += period_s * rate;
        }
        heading_rad += period_s * twist.omega_rad_s;
    }
    let begins_s = period_s * begins_at as f64;
    let heading_rad = pilot.desired_heading_rad(begins_s).unwrap_or(heading_rad);
    let mut rolling = Rolling::new(scenario, on_ground, -heading_rad)?;
    let begins = pilot.planned(begins_s)?.0;
    rolling.dynamics.set_moving(begins, &angles);
    for period in begins_at..ends_at {
        let t_s = period_s * period as f64;
        let planned = pilot.planned(t_s)?;
        for step in 1..=steps {
            rolling.step(planned).ok()?;
            if let Some(found) = rolling.dynamics.at_grip(LASTS_S) {
                let began_s = t_s + rolling.periods.step_s() * step as f64 - found.for_s;
                if began_s >= counts_from_s {
                    return Some((began_s, found.used.to_vec()));
                }
            }
        }
    }
    None
}

/// The share of the motors' work that a motion from rest loses to sliding along rollers up to a time in seconds; `None` where the loops are not those that
/// are known. `motion` says twist and its rate at a time.
pub(super) fn lost_to_sliding(
    scenario: &Scenario,
    on_ground: RobotOnGround<'_>,
    (heading_rad, until_s): (f64, f64),
    motion: impl Fn(f64) -> (Twist, Twist),
) -> Option<f64> {
    /// More are not looked at: half a minute, of steps of a millisecond.
    const MOST_STEPS: u64 = 30_000;
    /// Of what motors give, what counts as work at least.
    const MOVES: f64 = 0.05;
    let mut rolling = Rolling::new(scenario, on_ground, -heading_rad)?;
    let Periods { period_s, steps } = rolling.periods;
    let periods = (until_s / period_s).ceil() as u64;
    for period in 0..periods.min(MOST_STEPS / steps) {
        let planned = motion(period_s * period as f64);
        for _ in 0..steps {
            rolling.step(planned).ok()?;
        }
    }
    // Of a robot that hardly loses anything work is what it was moved with.
    let (given_j, taken_j) = (
        rolling.dynamics.given_energy_j(),
        rolling.dynamics.taken_energy_j(),
    );
    let work_j = (given_j - taken_j).max(MOVES * given_j);
    (work_j > 0.0).then(|| rolling.dynamics.slid_energy_j() / work_j)
}
