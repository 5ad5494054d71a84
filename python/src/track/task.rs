//! The path-following task: observations, actions and reward.

use ilon::control::{Kinematics, Reference, SpeedLimits};
use ilon::robot::{Pose, Robot, Twist, wrap_angle};
use ilon::simulate::{Driver, Measurements, Plant, Resolved, load_robot, resolve_for};
use ilon::{Error, Scenario};

use crate::scenario::{Settings, as_settings};

/// Number of times at which a reference is sampled for its peaks; chosen.
const SAMPLES: usize = 2000;

/// Bounds of observations over what the reference and the motors allow; chosen.
const MARGIN: f64 = 1.5;

/// Roll or pitch at which the robot counts as fallen, in radians; chosen.
const FALLEN_RAD: f64 = 0.5;

/// The meaning of an action's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// A twist of the body, converted to wheel rates.
    Twist,
    /// Wheel rates.
    WheelRates,
    /// Wheel torques.
    WheelTorques,
}

/// Reward and costs per second of an episode.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// Reward per second in which the robot has not failed. `None` stands for
    /// [`Weights::worst_per_s`] with non-negative rewards.
    pub alive: Option<f64>,
    /// Cost per metre of true position error, per second.
    pub position: f64,
    /// Cost per radian of true heading error, per second.
    pub heading: f64,
    /// Cost per mean square of the action's change since the last step, per second.
    pub action_change: f64,
    /// Cost per joule of the motors.
    pub energy: f64,
    /// Cost per joule lost to sliding contacts.
    pub slip: f64,
}

impl Weights {
    /// The largest cost per second before failing, without the energies in joules, which are
    /// unbounded.
    pub fn worst_per_s(&self, fail_at_m: f64) -> f64 {
        // An action's numbers lie in [-1, 1], so each changes by at most 2.
        let change = 2.0_f64.powi(2);
        self.position.max(0.0) * fail_at_m
            + self.heading.max(0.0) * std::f64::consts::PI
            + self.action_change.max(0.0) * change
    }

    /// The reward per second without any cost.
    pub fn alive_per_s(&self, fail_at_m: f64) -> f64 {
        self.alive.unwrap_or_else(|| self.worst_per_s(fail_at_m))
    }

    /// The reward of a step in which the robot has not failed.
    ///
    /// If `alive` is `None`, no step's reward is negative. An episode that ends earns nothing from
    /// then on, so in every state continuing is worth at least as much as ending, whatever the
    /// weights, the robot's motion and the motors' work.
    pub fn earned(&self, spent: &Spent, fail_at_m: f64) -> f64 {
        let per_s = self.alive_per_s(fail_at_m)
            - self.position * spent.off.position_m
            - self.heading * spent.off.heading_rad
            - self.action_change * spent.change;
        let earned =
            spent.period_s * per_s - self.energy * spent.motors_j - self.slip * spent.slip_j;
        if self.alive.is_none() {
            earned.max(0.0)
        } else {
            earned
        }
    }
}

/// What a step costs.
#[derive(Clone, Copy, Debug)]
pub struct Spent {
    /// Its duration, in seconds.
    pub period_s: f64,
    /// The robot's deviation from its path at the end of the step.
    pub off: Off,
    /// The mean square of the action's change.
    pub change: f64,
    /// The work of the motors, in J.
    pub motors_j: f64,
    /// Energy lost to sliding contacts, in J.
    pub slip_j: f64,
}

/// Data shared by all episodes.
pub struct Task {
    /// The scenario as text, with all defaults.
    pub text: String,
    /// The scenario, with its name and the folder for its relative paths.
    pub scenario: Scenario,
    /// The robot, if no key of `[robot]` varies.
    pub robot: Robot,
    /// The meaning of an action's numbers.
    pub action: Action,
    /// The value of an action of 1, in m/s and rad/s, rad/s or N m; empty before [`Task::completed`]
    /// if it is not chosen.
    pub action_scale: Vec<f64>,
    /// Preview times of the path, in seconds.
    pub preview_s: Vec<f64>,
    /// Control periods per episode.
    pub steps: u64,
    /// The reward.
    pub weights: Weights,
    /// The position error at which an episode fails, in metres.
    pub fail_at_m: f64,
    /// The largest start deviation from the path, in metres along x and y, and in radians.
    pub start_off: (f64, f64),
    /// Whether an episode may start anywhere on the path.
    pub any_phase: bool,
    /// Keys of the scenario that are drawn anew for each episode, each with its range.
    pub drawn: Vec<(String, f64, f64)>,
    /// Bounds of each observation: it lies between minus and plus this.
    pub bounds: Vec<f32>,
    /// The wheel rate limits, in rad/s.
    pub rate_limits_rad_s: Vec<f64>,
}

/// A robot's deviation from its path.
#[derive(Clone, Copy, Debug, Default)]
pub struct Off {
    /// The position error, in metres.
    pub position_m: f64,
    /// The heading error, in radians.
    pub heading_rad: f64,
}

impl Task {
    /// Completes a task with its bounds and rate limits, and with `action_scale` if it is empty.
    ///
    /// # Errors
    /// If the scenario has no reference, or the value of an action of 1 is undefined.
    pub fn completed(mut self, resolved: &Resolved) -> Result<Self, Error> {
        let Some(reference) = resolved.reference() else {
            return Err(Error::invalid(
                "the scenario has no `[reference]`, and a robot needs a path to follow",
                "add a section such as `[reference.circle]`",
            ));
        };
        let kinematics = Kinematics::new(&self.robot)?;
        let limit_rad_s = resolved.wheel_rate_limit_rad_s();
        let motors = self.robot.wheels.iter().map(|wheel| &wheel.motor);
        self.rate_limits_rad_s = motors
            .clone()
            .map(|motor| motor.velocity_rad_s.min(limit_rad_s))
            .collect();
        let is_chosen = self.action_scale.is_empty();
        if is_chosen {
            self.action_scale = match self.action {
                Action::Twist => {
                    let limits = SpeedLimits::new(&kinematics, &self.rate_limits_rad_s);
                    let sideways_rad = std::f64::consts::FRAC_PI_2;
                    vec![
                        limits.top_speed_m_s(0.0),
                        limits.top_speed_m_s(sideways_rad),
                        limits.top_yaw_rate_rad_s(),
                    ]
                }
                Action::WheelRates => self.rate_limits_rad_s.clone(),
                Action::WheelTorques => motors.map(|motor| motor.effort_n_m).collect(),
            };
        }
        if self.action_scale.len() != self.actions() {
            return Err(Error::invalid(
                format!(
                    "`action_scale` has {} numbers for actions of {}",
                    self.action_scale.len(),
                    self.actions()
                ),
                "give one for each number of an action",
            ));
        }
        // 0 where tyres exclude a motion.
        let is_scale =
            |scale: &f64| scale.is_finite() && (*scale > 0.0 || is_chosen && *scale == 0.0);
        if !self.action_scale.iter().all(is_scale) {
            let fault = match is_chosen {
                true => "nothing says what an action of 1 is: the motors have no limits".to_owned(),
                false => format!("`action_scale` is {:?}", self.action_scale),
            };
            return Err(Error::invalid(
                fault,
                "give `action_scale`, one number above 0 for each number of an action",
            ));
        }
        self.bounds = self.bounds_for(reference, resolved);
        Ok(self)
    }

    fn bounds_for(&self, reference: &Reference, resolved: &Resolved) -> Vec<f32> {
        let duration_s = resolved.scenario().run.duration_s;
        let (speed_m_s, turn_rad_s) = reference.peaks(duration_s, SAMPLES);
        // Never zero: the bound of a constant quantity is still a bound.
        let wide = |number: f64| (MARGIN * number).max(1e-3);
        let off_m = MARGIN * self.fail_at_m;
        let mut bounds = vec![off_m, off_m, std::f64::consts::PI];
        bounds.extend([wide(speed_m_s), wide(speed_m_s), wide(turn_rad_s)]);
        for ahead_s in &self.preview_s {
            let reach_m = wide(speed_m_s * ahead_s);
            bounds.extend([reach_m, reach_m, std::f64::consts::PI]);
        }
        let rates = self.rate_limits_rad_s.iter();
        bounds.extend(rates.map(|limit| if limit.is_finite() { wide(*limit) } else { 1e3 }));
        bounds.extend(vec![1.0; self.actions()]);
        bounds.into_iter().map(|bound| bound as f32).collect()
    }

    /// Names of the observations, with their units.
    pub fn observation_names(&self) -> Vec<String> {
        let mut names: Vec<String> = [
            "error_x_m",
            "error_y_m",
            "error_heading_rad",
            "desired_vx_m_s",
            "desired_vy_m_s",
            "desired_omega_rad_s",
        ]
        .map(str::to_owned)
        .into();
        for ahead_s in &self.preview_s {
            for what in ["x_m", "y_m", "heading_rad"] {
                names.push(format!("ahead_{ahead_s}s_{what}"));
            }
        }
        let wheels = &self.robot.wheels;
        names.extend(
            wheels
                .iter()
                .map(|wheel| format!("{}_rate_rad_s", wheel.name)),
        );
        let actions = self.action_names();
        names.extend(actions.into_iter().map(|name| format!("last_{name}")));
        names
    }

    /// Names of the numbers of an action.
    pub fn action_names(&self) -> Vec<String> {
        let each = |what: &str| {
            let wheels = self.robot.wheels.iter();
            wheels
                .map(|wheel| format!("{}_{what}", wheel.name))
                .collect()
        };
        match self.action {
            Action::Twist => ["vx", "vy", "omega"].map(str::to_owned).into(),
            Action::WheelRates => each("rate"),
            Action::WheelTorques => each("torque"),
        }
    }

    /// The number of values in an action.
    pub fn actions(&self) -> usize {
        match self.action {
            Action::Twist => 3,
            _ => self.robot.wheels.len(),
        }
    }

    /// The number of values in an observation.
    pub fn observations(&self) -> usize {
        self.bounds.len()
    }

    /// A plant of the scenario with changed keys.
    ///
    /// # Errors
    /// If the scenario is invalid with them.
    pub fn plant(&self, settings: &Settings) -> Result<Plant, Error> {
        if settings.is_empty() {
            let resolved = resolve_for(&self.scenario, &self.robot, Driver::Own)?;
            return Plant::new(&resolved, &self.robot);
        }
        let Scenario {
            name,
            folder,
            files,
            ..
        } = &self.scenario;
        let changed = as_settings(settings);
        let scenario = Scenario::from_toml_with(&self.text, name, folder, &changed, files)?;
        let reads_anew = settings.iter().any(|(key, _)| {
            ["robot.", "motors."]
                .iter()
                .any(|section| key.starts_with(section))
        });
        let read;
        let robot = if reads_anew {
            read = load_robot(&scenario)?;
            &read
        } else {
            &self.robot
        };
        let resolved = resolve_for(&scenario, robot, Driver::Own)?;
        Plant::new(&resolved, robot)
    }

    /// Converts an action, each number in [-1, 1], to wheel commands.
    pub fn act(&self, kinematics: &Kinematics, action: &[f32], wheels: &mut [f64]) {
        if self.action != Action::Twist {
            for (wheel, number) in wheels.iter_mut().zip(self.scaled(action)) {
                *wheel = number;
            }
            return;
        }
        kinematics.wheel_rates(self.twist(action), wheels);
        // All by one factor, so that the direction is kept.
        let limits = wheels.iter().zip(&self.rate_limits_rad_s);
        let over = limits.fold(1.0, |over: f64, (rate, limit)| over.max(rate.abs() / limit));
        for rate in wheels {
            *rate /= over;
        }
    }

    /// The twist of an action, in m/s and rad/s.
    pub fn twist(&self, action: &[f32]) -> Twist {
        let mut scaled = self.scaled(action);
        let mut next = || scaled.next().unwrap_or_default();
        Twist::new(next(), next(), next())
    }

    fn scaled(&self, action: &[f32]) -> impl Iterator<Item = f64> {
        let shares = action.iter().zip(&self.action_scale);
        shares.map(|(share, scale)| f64::from(*share) * scale)
    }

    /// Writes the observation of the robot and its path.
    pub fn see(
        &self,
        seen: &Measurements,
        reference: &Reference,
        t_s: f64,
        action: &[f32],
        observation: &mut [f32],
    ) {
        let desired = reference.at(t_s);
        let error = in_body(&seen.pose, &seen.pose, &desired.pose);
        let velocity = desired.velocity_in_world;
        let (vx, vy) = turned(seen.pose.heading_rad, velocity.vx_m_s, velocity.vy_m_s);
        let ahead = self.preview_s.iter().flat_map(|ahead_s| {
            let later = reference.at(t_s + ahead_s).pose;
            in_body(&seen.pose, &desired.pose, &later)
        });
        let numbers = error
            .into_iter()
            .chain([vx, vy, velocity.omega_rad_s])
            .chain(ahead)
            .chain(seen.wheel_rates_rad_s.iter().copied())
            .map(|number| number as f32)
            .chain(action.iter().copied());
        for ((slot, number), bound) in observation.iter_mut().zip(numbers).zip(&self.bounds) {
            *slot = number.clamp(-bound, *bound);
        }
    }

    /// The true deviation of a plant from its path.
    pub fn off(&self, plant: &Plant, reference: &Reference, t_s: f64) -> Off {
        let pose = plant.truth().pose;
        let [x_m, y_m, heading_rad] = in_body(&pose, &pose, &reference.at(t_s).pose);
        Off {
            position_m: x_m.hypot(y_m),
            heading_rad: heading_rad.abs(),
        }
    }

    /// Whether an episode has failed: too far from its path, or fallen over.
    pub fn has_failed(&self, plant: &Plant, off: &Off) -> bool {
        let truth = plant.truth();
        let leans_rad = truth.roll_rad.abs().max(truth.pitch_rad.abs());
        off.position_m > self.fail_at_m || leans_rad > FALLEN_RAD
    }
}

/// The difference from one pose to another, in a body's frame.
fn in_body(body: &Pose, from: &Pose, to: &Pose) -> [f64; 3] {
    let (x_m, y_m) = turned(body.heading_rad, to.x_m - from.x_m, to.y_m - from.y_m);
    [x_m, y_m, wrap_angle(to.heading_rad - from.heading_rad)]
}

/// A world vector in the frame of a body with a heading.
fn turned(heading_rad: f64, x: f64, y: f64) -> (f64, f64) {
    let (sin, cos) = heading_rad.sin_cos();
    (cos * x + sin * y, cos * y - sin * x)
}
