//! An episode of one robot on a path, from a start until it fails or time is up.

use std::sync::{Mutex, PoisonError};

use ilon::Error;
use ilon::control::{Kinematics, Reference};
use ilon::robot::{Pose, Roller, Wheel};
use ilon::simulate::{Followed, Pilot, Plant, WheelCommand};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use toml::Value;

use super::task::{Action, Off, Spent, Task};
use crate::scenario::Settings;

/// An episode of one robot on a path.
pub struct Episode {
    plant: Plant,
    reference: Reference,
    kinematics: Kinematics,
    /// Turns steered wheels to a twist. In a lock, which is never waited for, because Python may
    /// pass an episode between threads.
    pilot: Option<Mutex<Pilot>>,
    /// Draws the random differences between episodes.
    rng: ChaCha8Rng,
    /// The time on the path at which the episode began, in seconds.
    phase_s: f64,
    step: u64,
    action: Vec<f32>,
    wheels: Vec<f64>,
    /// Energies so far, in J: work of the motors, and losses by sliding.
    energies_j: (f64, f64),
    /// Whether the episode has ended, or has not begun.
    is_over: bool,
}

/// The result of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stepped {
    /// The reward: zero if the robot failed.
    pub reward: f64,
    /// Whether the robot has failed.
    pub failed: bool,
    /// Whether time is up.
    pub time_is_up: bool,
    /// The robot's deviation from its path.
    pub off: Off,
}

/// A robot and its path from above, in the world frame.
pub struct Above {
    /// The true pose: x and y in m, heading in rad.
    pub pose: [f64; 3],
    /// The desired pose, likewise.
    pub desired: [f64; 3],
    /// Points of the path, in m.
    pub path: Vec<[f64; 2]>,
    /// Each wheel in the body frame: x and y in m, the direction of its axis in rad, its radius and
    /// half its width in m.
    pub wheels: Vec<[f64; 5]>,
}

impl Episode {
    /// An episode that has not begun.
    ///
    /// # Errors
    /// As [`Task::plant`].
    pub fn new(task: &Task, plant: &Plant, seed: u64) -> Result<Self, Error> {
        let reference = plant.resolved().reference().cloned();
        let Some(reference) = reference else {
            return Err(Error::invalid(
                "the scenario has no `[reference]`",
                "add one",
            ));
        };
        Ok(Self {
            kinematics: plant.kinematics().clone(),
            pilot: steering(task, plant)?,
            wheels: vec![0.0; plant.robot().wheels.len()],
            plant: plant.clone(),
            reference,
            rng: ChaCha8Rng::seed_from_u64(seed),
            phase_s: 0.0,
            step: 0,
            action: vec![0.0; task.actions()],
            energies_j: (0.0, 0.0),
            is_over: true,
        })
    }

    /// Whether the episode has ended, or has not begun.
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// Sets the seed of the next draws.
    pub fn seed(&mut self, seed: u64) {
        self.rng = ChaCha8Rng::seed_from_u64(seed);
    }

    /// Begins a new episode and draws its random differences.
    ///
    /// # Errors
    /// If the scenario is invalid with the drawn values.
    pub fn begin(&mut self, task: &Task, observation: &mut [f32]) -> Result<Off, Error> {
        // Drawn in this order, so that a seed gives the same start whatever else varies.
        let sensors = self.rng.next_u64();
        let phase = self.between(0.0, 1.0);
        let off = [
            self.between(-1.0, 1.0),
            self.between(-1.0, 1.0),
            self.between(-1.0, 1.0),
        ];
        let draws = task.drawn.iter();
        let settings: Settings = draws
            .map(|(key, low, high)| (key.clone(), Value::Float(self.between(*low, *high))))
            .collect();
        if !settings.is_empty() {
            self.plant = task.plant(&settings)?;
            self.kinematics = self.plant.kinematics().clone();
            if let Some(reference) = self.plant.resolved().reference() {
                self.reference = reference.clone();
            }
        }
        let duration_s = self.plant.resolved().scenario().run.duration_s;
        self.phase_s = if task.any_phase {
            phase * duration_s
        } else {
            0.0
        };
        let start = self.reference.at(self.phase_s).pose;
        let (off_m, off_rad) = task.start_off;
        let start = Pose {
            x_m: start.x_m + off_m * off[0],
            y_m: start.y_m + off_m * off[1],
            heading_rad: start.heading_rad + off_rad * off[2],
        };
        self.plant.reset(sensors, start)?;
        self.pilot = steering(task, &self.plant)?;
        self.step = 0;
        self.action.fill(0.0);
        self.energies_j = (0.0, 0.0);
        self.is_over = false;
        let t_s = self.time_s();
        task.see(
            self.plant.observe(),
            &self.reference,
            t_s,
            &self.action,
            observation,
        );
        Ok(task.off(&self.plant, &self.reference, t_s))
    }

    /// Applies an action for a control period. Its numbers lie in [-1, 1].
    ///
    /// # Errors
    /// If the plant refuses.
    pub fn step(
        &mut self,
        task: &Task,
        action: &[f32],
        observation: &mut [f32],
    ) -> Result<Stepped, Error> {
        let command = match (&mut self.pilot, task.action) {
            (Some(pilot), _) => {
                let pilot = pilot.get_mut().unwrap_or_else(PoisonError::into_inner);
                pilot.follow(Followed::Twist(task.twist(action)))?;
                pilot.decide(self.plant.time_s(), self.plant.observe());
                self.plant.steer(pilot.steering());
                pilot.command()
            }
            (None, kind) => {
                task.act(&self.kinematics, action, &mut self.wheels);
                match kind {
                    Action::WheelTorques => WheelCommand::Torques(&self.wheels),
                    _ => WheelCommand::Rates(&self.wheels),
                }
            }
        };
        let period_s = self.plant.resolved().control_dt_s();
        let diverged = match self.plant.advance(command, period_s) {
            Ok(_) => false,
            Err(Error::Diverged { .. }) => true,
            Err(error) => return Err(error),
        };
        self.step += 1;
        let changes = action.iter().zip(&self.action);
        let change: f32 = changes.map(|(new, old)| (new - old).powi(2)).sum();
        let change = f64::from(change) / action.len() as f64;
        self.action.copy_from_slice(action);
        if diverged {
            // The last observation is kept, as a motion that is not finite has no other.
            self.is_over = true;
            return Ok(Stepped {
                failed: true,
                off: Off {
                    position_m: task.fail_at_m,
                    heading_rad: std::f64::consts::PI,
                },
                ..Stepped::default()
            });
        }
        let t_s = self.time_s();
        let off = task.off(&self.plant, &self.reference, t_s);
        let failed = task.has_failed(&self.plant, &off);
        let world = self.plant.world();
        let energies_j = (world.motor_energy_j(), world.slip_energy_j());
        let spent = Spent {
            period_s,
            off,
            change,
            motors_j: energies_j.0 - self.energies_j.0,
            slip_j: energies_j.1 - self.energies_j.1,
        };
        let reward = if failed {
            0.0
        } else {
            task.weights.earned(&spent, task.fail_at_m)
        };
        self.energies_j = energies_j;
        let time_is_up = !failed && self.step >= task.steps;
        self.is_over = failed || time_is_up;
        task.see(
            self.plant.observe(),
            &self.reference,
            t_s,
            &self.action,
            observation,
        );
        Ok(Stepped {
            reward,
            failed,
            time_is_up,
            off,
        })
    }

    /// The robot and its path from above, for a picture.
    pub fn above(&self) -> Above {
        /// Points of the path; chosen for a smooth line.
        const POINTS: u32 = 400;
        let numbers = |pose: Pose| [pose.x_m, pose.y_m, pose.heading_rad];
        let duration_s = self.plant.resolved().scenario().run.duration_s;
        let on_path = |index: u32| {
            let t_s = f64::from(index) / f64::from(POINTS) * duration_s;
            let pose = self.reference.at(t_s).pose;
            [pose.x_m, pose.y_m]
        };
        let of_wheel = |wheel: &Wheel| {
            let (place, axis) = (wheel.position_m(), wheel.axis());
            let reach_m = |roller: &Roller| {
                roller.row_offset_m().abs() + 0.5 * roller.length_m * roller.axis_in_hub.z.abs()
            };
            let half_width_m = wheel.rollers.iter().map(reach_m).fold(0.0, f64::max);
            let axis_rad = axis.y.atan2(axis.x);
            [place.x, place.y, axis_rad, wheel.radius_m, half_width_m]
        };
        Above {
            pose: numbers(self.plant.truth().pose),
            desired: numbers(self.reference.at(self.time_s()).pose),
            path: (0..=POINTS).map(on_path).collect(),
            wheels: self.plant.robot().wheels.iter().map(of_wheel).collect(),
        }
    }

    /// The current time on the path, in seconds.
    fn time_s(&self) -> f64 {
        self.phase_s + self.plant.time_s()
    }

    /// A uniformly distributed number between two.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        // 53 bits, the precision of a number.
        let unit = (self.rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        low + unit * (high - low)
    }
}

/// The pilot of a robot with steered wheels under twists; `None` of any other, which needs none.
fn steering(task: &Task, plant: &Plant) -> Result<Option<Mutex<Pilot>>, Error> {
    if task.action != Action::Twist {
        return Ok(None);
    }
    let pilot = Pilot::of(plant.resolved(), plant.robot(), None)?;
    Ok(Some(pilot).filter(Pilot::steers).map(Mutex::new))
}
