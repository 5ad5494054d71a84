//! One simulated drive.

use ilon_robot::Robot;
use ilon_sim::scenario::{Scenario, Setting};
use ilon_sim::simulate::Driver;
use ilon_sim::{Error, Plant, WheelCommand, load_robot, resolve_for};
use nalgebra::Matrix3xX;
use toml::Value as Toml;

use super::config::Simulate;
use super::drive_result::DriveResult;
use super::parameters::Free;
use super::phases::{self, Starts};
use super::steady_drives::Course;
use crate::log::Log;
use crate::motion::{Window, window};
use crate::ripple::{Stretches, ripple};
use crate::study::Study;
use ilon_files::toml::flat;

/// Settling time before the motion of a simulated drive counts, in seconds.
const SETTLE_S: f64 = 0.7;

/// Returns the keys of a simulation: those of the study, the free ones at given values, and
/// replacements.
pub(super) fn keys(
    study: &Study,
    free: &[Free],
    values: &[f64],
    beside: &[(String, Toml)],
) -> Vec<(String, Toml)> {
    let mut keys = flat(&study.file.set);
    let free = free.iter().zip(values);
    keys.extend(free.map(|(free, value)| (free.key.clone(), Toml::Float(*value))));
    keys.retain(|(key, _)| beside.iter().all(|(other, _)| other != key));
    keys.extend(beside.iter().cloned());
    keys
}

/// A robot in its scenario at some values of the keys, read once for all drives, because measuring
/// its rollers takes longer than a drive.
pub(super) struct Ready {
    scenario: Scenario,
    robot: Robot,
}

impl Ready {
    /// Reads scenario and robot.
    ///
    /// # Errors
    /// If robot or scenario are invalid.
    pub fn new(study: &Study, keys: &[(String, Toml)]) -> Result<Self, Error> {
        let settings: Vec<Setting> = keys
            .iter()
            .map(|(key, value)| Setting::new(key, value))
            .collect();
        let text = crate::study::scenario_text(&study.file.robot);
        let scenario = Scenario::from_text(&text, &study.path, &settings, &study.files)?;
        let robot = load_robot(&scenario)?;
        let ready = Self { scenario, robot };
        ready.plant(&[])?;
        Ok(ready)
    }

    /// Builds the simulation, with the rollers of each wheel turned about its hub, in radians.
    fn plant(&self, turned_rad: &[f64]) -> Result<Plant, Error> {
        let robot = phases::turned(self.robot.clone(), turned_rad);
        let resolved = resolve_for(&self.scenario, &robot, Driver::Own)?;
        Plant::new(&resolved, &robot)
    }
}

/// One simulation of a drive: the index of the drive, and its set of initial wheel angles.
#[derive(Clone, Copy)]
pub(super) struct Task {
    pub drive: usize,
    /// Seed of the sets.
    pub seed: u32,
    pub starts: Starts,
    pub set: u32,
}

/// Simulates the robot at wheel rates; `None` if it diverges, or if the drive has nothing to
/// compare.
pub(super) fn made(
    section: &Simulate,
    ready: &Ready,
    course: &Course,
    task: Task,
    nominal: &Matrix3xX<f64>,
) -> Result<Option<DriveResult>, Error> {
    let (log, torques_n_m) = match drive(section, ready, course, task) {
        Err(Error::Diverged { .. }) => return Ok(None),
        driven => driven?,
    };
    let whole = window(&log, 0, 0, log.len() - 1);
    let asked = whole.of_wheels(nominal);
    let size = libm::hypot(asked[0], asked[1]);
    if size <= 0.0 {
        return Ok(None);
    }
    let seen = whole.seen;
    let Some([wheels_rad_s, body_m]) = own_ripple(section, ready, &log, &whole, nominal)? else {
        return Ok(None);
    };
    Ok(Some(DriveResult {
        along: (seen[0] * asked[0] + seen[1] * asked[1]) / (size * size),
        across: (seen[1] * asked[0] - seen[0] * asked[1]) / (size * size),
        drift_rad_per_m: (seen[2] - asked[2]) / size,
        torques_n_m,
        wheels_rad_s,
        body_m,
    }))
}

/// The log of a drive after it has settled, with continuous headings, and the mean torque of each
/// wheel, in N m.
fn drive(
    section: &Simulate,
    ready: &Ready,
    course: &Course,
    task: Task,
) -> Result<(Log, Vec<f64>), Error> {
    let (robot, period_s) = (&ready.robot, ready.scenario.run.control_dt_s);
    let rates = WheelCommand::Rates(&course.rates_rad_s);
    let rows = (section.drive_s / period_s).ceil().max(2.0) as usize;
    let settle = (SETTLE_S / period_s).ceil() as usize;
    let turned_rad = match (task.starts, &course.begun_rad) {
        (Starts::Sets(_), _) => phases::set(section, robot, task.seed, task.drive, task.set),
        (Starts::Log, Some(begun_rad)) => {
            // The wheel angles after settling from the file's angles give the start from which
            // settling leads to the log's angles.
            let mut plant = ready.plant(&[])?;
            // The first row that counts comes one period later.
            for _ in 0..=settle {
                plant.advance(rates, period_s)?;
            }
            let settled_rad = &plant.observe().wheel_angles_rad;
            let angles = begun_rad.iter().zip(settled_rad);
            angles.map(|(to, from)| to - from).collect()
        }
        (Starts::File | Starts::Log, _) => Vec::new(),
    };
    let mut plant = ready.plant(&turned_rad)?;
    let mut log = Log::default();
    let mut torques_n_m = vec![0.0; robot.wheels.len()];
    for _ in 0..settle {
        plant.advance(rates, period_s)?;
    }
    for row in 0..rows {
        let outcome = plant.advance(rates, period_s)?;
        for (sum, torque) in torques_n_m.iter_mut().zip(&outcome.torques_n_m) {
            *sum += torque / rows as f64;
        }
        let pose = plant.truth().pose;
        log.times_s.push(row as f64 * period_s);
        log.angles_rad
            .push(plant.observe().wheel_angles_rad.clone());
        log.poses.push([pose.x_m, pose.y_m, pose.heading_rad]);
        log.unseen.push(false);
    }
    for row in 1..log.poses.len() {
        let last = log.poses[row - 1][2];
        log.poses[row][2] = last + ilon_robot::wrap_angle(log.poses[row][2] - last);
    }
    Ok((log, torques_n_m))
}

/// The ripple of the wheels, in rad/s, and of the body, in m, at the roller frequency: 0 unless
/// the study compares it, `None` if the wheels do not turn steadily.
fn own_ripple(
    section: &Simulate,
    ready: &Ready,
    log: &Log,
    whole: &Window,
    nominal: &Matrix3xX<f64>,
) -> Result<Option<[f64; 2]>, Error> {
    let Some(compared) = &section.ripple else {
        return Ok(Some([0.0; 2]));
    };
    // The loops of the simulated wheels let them turn slower than commanded.
    let turned_rad = whole.turned_rad.iter();
    let rates_rad_s: Vec<f64> = turned_rad.map(|turned| turned / log.duration_s()).collect();
    let stretches = Stretches {
        length_s: compared.stretch_s,
        rates_rad_s: &rates_rad_s,
        alike: f64::INFINITY,
    };
    if !stretches.fit(log) {
        return Err(Error::invalid(
            format!(
                "a simulated drive of {} s with a row each {} s has no stretch of {} s whose ripple could be compared",
                section.drive_s, ready.scenario.run.control_dt_s, compared.stretch_s
            ),
            "let `simulate.drive_s` be longer than `simulate.ripple.stretch_s`, and `run.control_dt_s` below `[set]` a sixteenth of it or less",
        ));
    }
    let wheels = ready.robot.wheels.iter();
    let rollers = wheels.map(|wheel| wheel.rollers.len()).max();
    let found = ripple(log, rollers.unwrap_or(0), nominal, &stretches);
    Ok(found.map(|found| [found.wheels_rad_s[0], found.body_m[0]]))
}
