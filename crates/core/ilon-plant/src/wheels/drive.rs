//! Converts commanded wheel rates to torques: the wheel loops and the motors' limits.

use std::collections::VecDeque;

use ilon_control::{
    BodySense, ComputedTorque, ComputedTorqueSettings, Demand, Motor, PassiveEffort, PassiveTorque,
    PassiveTorqueSettings, PrioritisedTorque, PrioritisedTorqueSettings, TorqueLaw, TorqueRange,
    TorqueShares,
};
use ilon_robot::{JointRole, Robot};
use ilon_world::MotorTorque;

use crate::wheels::motors::motors;
use ilon_scenario::choices::wheel_loop::{dynamic_model, passive_settings, pid};
use ilon_scenario::course::command::WheelCommand;
use ilon_scenario::scenario::{AntiWindup, WheelLaw, WheelLoop};
use ilon_scenario::{Error, Resolved};

/// The wheel loops of a robot and its motors.
#[derive(Clone)]
pub(crate) struct Drive {
    law: Box<dyn TorqueLaw>,
    /// The law's period in physics steps, and the number of steps until its next decision.
    every: u32,
    until_due: u32,
    /// The last torques of the law, in N m.
    held_n_m: Vec<f64>,
    /// Its earlier torques, delayed on the way to the motors.
    on_the_way: Option<OnTheWay>,
    /// The robot of a law that uses its masses, if joints between bodies move them; its servos have
    /// their current targets.
    moving: Option<Box<Robot>>,
    motors: Vec<Motor>,
    limits: Vec<TorqueRange>,
    /// Smaller torques are suppressed, in N m.
    dead_band_n_m: f64,
    /// Whether targets beyond the motors' rate limits reach the law: a PID without anti-windup counts
    /// what it cannot reach.
    winds_up: bool,
    /// Targets within the motors' limits unless the law winds up, in rad/s.
    targets_rad_s: Vec<f64>,
    torques: Vec<MotorTorque>,
}

impl Drive {
    /// The drive of a resolved scenario.
    pub fn new(resolved: &Resolved, robot: &Robot) -> Result<Self, Error> {
        let (scenario, physics_dt_s) = (resolved.scenario(), resolved.physics_dt_s());
        let loop_period_s = scenario.wheel_loop.period_s.unwrap_or(physics_dt_s);
        // A PID is tuned for the real robot; the other laws use the controller's model.
        let known = match scenario.wheel_loop.law {
            WheelLaw::Pid => robot,
            _ => resolved.believed(robot),
        };
        let standing = &resolved.choices().joint_targets.standing(known);
        let model = dynamic_model(standing)?;
        let law: Box<dyn TorqueLaw> = match scenario.wheel_loop.law {
            WheelLaw::Pid => Box::new(pid(&scenario.wheel_loop, &model, loop_period_s)?),
            WheelLaw::ComputedTorque => {
                let settings = ComputedTorqueSettings {
                    bandwidth_rad_s: scenario.wheel_loop.bandwidth_rad_s,
                    // The targets change once a control period; their derivative is smoothed over
                    // the same time.
                    target_filter_s: scenario.run.control_dt_s,
                    dt_s: loop_period_s,
                };
                Box::new(ComputedTorque::new(model, &settings)?)
            }
            WheelLaw::PrioritisedTorque => {
                let settings = PrioritisedTorqueSettings {
                    bandwidth_rad_s: scenario.wheel_loop.bandwidth_rad_s,
                    target_filter_s: scenario.run.control_dt_s,
                    dt_s: loop_period_s,
                    priority: scenario.guidance.priority.unwrap_or_default(),
                    reference_point_m: resolved.reference_point_m(),
                    friction: scenario.wheel_loop.friction.unwrap_or(f64::INFINITY),
                    gravity_m_s2: scenario.world.gravity_m_s2,
                };
                Box::new(PrioritisedTorque::new(standing, &settings)?)
            }
            WheelLaw::Passive => {
                let settings = passive_settings(scenario, standing, loop_period_s)?;
                let reference_point_m = resolved.reference_point_m();
                Box::new(PassiveTorque::new(
                    standing,
                    &PassiveTorqueSettings {
                        reference_point_m,
                        ..settings
                    },
                )?)
            }
        };
        let motors = motors(scenario, robot)?;
        let moves = !robot.joints.is_empty() && scenario.wheel_loop.law != WheelLaw::Pid;
        Ok(Self {
            law,
            // A period is a whole number of steps.
            every: (loop_period_s / physics_dt_s).round().max(1.0) as u32,
            until_due: 0,
            held_n_m: vec![0.0; motors.len()],
            on_the_way: OnTheWay::of(&scenario.wheel_loop, physics_dt_s, motors.len()),
            moving: moves.then(|| Box::new(known.clone())),
            winds_up: scenario.wheel_loop.law == WheelLaw::Pid
                && scenario.wheel_loop.anti_windup == AntiWindup::None,
            targets_rad_s: vec![0.0; motors.len()],
            torques: vec![MotorTorque::constant(0.0); motors.len()],
            limits: vec![TorqueRange::UNLIMITED; motors.len()],
            dead_band_n_m: scenario.motors.dead_band_n_m.unwrap_or(0.0),
            motors,
        })
    }

    /// Updates the positions of the joints between bodies, in rad or m, and the targets of their
    /// servos.
    pub fn stand(&mut self, positions: &[f64], targets: impl Iterator<Item = f64>) {
        let Some(robot) = &mut self.moving else {
            return;
        };
        for (joint, target) in robot.joints.iter_mut().zip(targets) {
            if let JointRole::Driven(servo) = &mut joint.role {
                servo.target = target;
            }
        }
        self.law.stand(&robot.posed(positions));
    }

    /// The last action of a passive law; `None` for other laws.
    pub fn passive_effort(&self) -> Option<PassiveEffort<'_>> {
        self.law.passive_effort()
    }

    /// The share of each task that the last torques gave; `None` for a law that weighs no tasks.
    pub fn shares(&self) -> Option<TorqueShares> {
        self.law.shares()
    }

    /// The torques of the next physics step, of `dt_s` seconds, while a share of the supply is
    /// left, each with what its motor can give about the rate of its wheel. The wheel loops go by
    /// the rates that are seen.
    pub fn torques(
        &mut self,
        command: WheelCommand<'_>,
        (rates, known): (WheelRates<'_>, &BodySense<'_>),
        supply_share: f64,
        dt_s: f64,
    ) -> &[MotorTorque] {
        let is_due = self.until_due == 0;
        self.until_due = if is_due { self.every } else { self.until_due } - 1;
        if is_due {
            self.law.sense(known);
        }
        let motors = self.motors.iter().zip(rates.real_rad_s);
        let outputs = self.limits.iter_mut().zip(&mut self.torques);
        for ((limit, torque), (motor, rate_rad_s)) in outputs.zip(motors) {
            let bounds = motor.bounds_on(*rate_rad_s, supply_share);
            *limit = TorqueRange::of(&bounds);
            *torque = MotorTorque {
                rate_limit_rad_s: motor.velocity_limit_on(supply_share),
                bounds,
                ..MotorTorque::constant(0.0)
            };
        }
        let targets = match command {
            WheelCommand::Rates(targets) => targets,
            WheelCommand::Torques(asked) => {
                let given = self.torques.iter_mut().zip(&self.limits);
                for ((given, limit), asked) in given.zip(asked) {
                    given.torque_n_m = limit.clamp(*asked);
                }
                // Nothing that a loop decided before is held, or on the way, when rates are
                // commanded again.
                self.held_n_m.fill(0.0);
                self.law.pause();
                if let Some(on_the_way) = &mut self.on_the_way {
                    on_the_way.forget();
                }
                return &self.torques;
            }
        };
        let held = self.targets_rad_s.iter_mut().zip(targets);
        for ((target, asked), motor) in held.zip(&self.motors) {
            let limit_rad_s = motor.velocity_limit_on(supply_share);
            *target = match self.winds_up {
                true => *asked,
                false => asked.clamp(-limit_rad_s, limit_rad_s),
            };
        }
        if is_due {
            let (targets, limits) = (&self.targets_rad_s, &self.limits);
            let period_s = f64::from(self.every) * dt_s;
            let decided_n_m =
                self.law
                    .update(&Demand::new(targets, rates.seen_rad_s, limits, period_s));
            self.held_n_m.copy_from_slice(decided_n_m);
        }
        for (torque, held_n_m) in self.torques.iter_mut().zip(&self.held_n_m) {
            torque.torque_n_m = *held_n_m;
        }
        for (torque, falling) in self.torques.iter_mut().zip(self.law.falling()) {
            torque.torque_n_m = falling.torque_n_m;
            torque.droop_n_m_s = falling.droop_n_m_s;
            torque.per_acceleration_n_m_s2 = falling.per_acceleration_n_m_s2;
        }
        if let Some(on_the_way) = &mut self.on_the_way {
            on_the_way.pass(&mut self.torques, rates.real_rad_s, dt_s);
        }
        let dead_band_n_m = self.dead_band_n_m;
        let is_swallowed = |torque: &&mut MotorTorque| torque.torque_n_m.abs() < dead_band_n_m;
        for torque in self.torques.iter_mut().filter(is_swallowed) {
            (torque.torque_n_m, torque.droop_n_m_s) = (0.0, 0.0);
            torque.per_acceleration_n_m_s2 = 0.0;
        }
        &self.torques
    }

    /// The torque of a wheel's motor at a rate in rad/s while its winding is shorted; zero if its
    /// winding is unknown.
    pub fn shorted(&self, wheel: usize, rate_rad_s: f64) -> MotorTorque {
        let motor = &self.motors[wheel];
        let per_rate_n_m_s = motor.shorted_n_m_s().unwrap_or(0.0);
        MotorTorque::with_droop(-per_rate_n_m_s * rate_rad_s, per_rate_n_m_s)
    }
}

/// Torques of wheel loops with a latency, from their decision to the motors.
#[derive(Clone)]
struct OnTheWay {
    /// The fraction of a step of the delay beyond whole steps.
    part: f64,
    wheel_count: usize,
    /// The torques of the last steps, the oldest first, one per wheel each.
    decided: VecDeque<DecidedTorque>,
}

/// A torque that a wheel loop decided for a step.
#[derive(Clone, Copy, Default)]
struct DecidedTorque {
    /// At the step's beginning, in N m.
    torque_n_m: f64,
    /// By how much it falls per rate gained, in N m s/rad; 0 if it is held.
    droop_n_m_s: f64,
    /// The wheel's rate at the step's beginning, in rad/s.
    rate_rad_s: f64,
    /// By how much it fell over the step, in N m: known once the step is over.
    fell_n_m: f64,
}

impl OnTheWay {
    fn of(section: &WheelLoop, physics_dt_s: f64, wheel_count: usize) -> Option<Self> {
        let steps = section.latency_s() / physics_dt_s;
        // Whole steps, with a slack for rounding.
        let whole = (steps + 1e-9).floor();
        (steps > 0.0).then(|| Self {
            part: (steps - whole).max(0.0),
            wheel_count,
            decided: vec![DecidedTorque::default(); (whole as usize + 1) * wheel_count].into(),
        })
    }

    /// Forgets all torques.
    fn forget(&mut self) {
        self.decided
            .make_contiguous()
            .fill(DecidedTorque::default());
    }

    /// Stores the torques decided for a step at the wheels' rates in rad/s, and replaces them by
    /// those that arrive in it: in its first part the end of those decided one step before the
    /// rest; the motors get the mean. A torque falls evenly over its step.
    fn pass(&mut self, torques: &mut [MotorTorque], rates_rad_s: &[f64], dt_s: f64) {
        let p = self.part;
        for torque in &mut *torques {
            let per_acceleration_n_m_s2 = std::mem::take(&mut torque.per_acceleration_n_m_s2);
            torque.droop_n_m_s += 2.0 * per_acceleration_n_m_s2 / dt_s;
        }
        let newest = self.decided.len() - self.wheel_count;
        for (decided, rate_rad_s) in self.decided.range_mut(newest..).zip(rates_rad_s) {
            decided.fell_n_m = decided.droop_n_m_s * (rate_rad_s - decided.rate_rad_s);
        }
        let decided = torques.iter().zip(rates_rad_s);
        self.decided
            .extend(decided.map(|(torque, rate_rad_s)| DecidedTorque {
                torque_n_m: torque.torque_n_m,
                droop_n_m_s: torque.droop_n_m_s,
                rate_rad_s: *rate_rad_s,
                fell_n_m: 0.0,
            }));
        // What arrives in the step that it was decided for falls in it.
        let falls = match newest {
            0 => (1.0 - p) * (1.0 - p),
            _ => 0.0,
        };
        for (wheel, torque) in torques.iter_mut().enumerate() {
            let [before, after] =
                [wheel, self.wheel_count + wheel].map(|place| self.decided[place]);
            let ended_n_m = before.torque_n_m - (1.0 - 0.5 * p) * before.fell_n_m;
            let begun_n_m = after.torque_n_m - 0.5 * (1.0 - p) * after.fell_n_m;
            torque.torque_n_m = p * ended_n_m + (1.0 - p) * begun_n_m;
            torque.droop_n_m_s *= falls;
        }
        self.decided.drain(..self.wheel_count);
    }
}

/// The rates of a robot's wheels, in rad/s, one a wheel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelRates<'a> {
    /// The real rates, which determine a motor's back-EMF.
    pub real_rad_s: &'a [f64],
    /// The measured rates.
    pub seen_rad_s: &'a [f64],
}
