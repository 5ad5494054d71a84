//! One simulated drive.

use std::f64::consts::TAU;

use ilon_robot::Robot;
use ilon_sim::scenario::{Scenario, Setting};
use ilon_sim::simulate::Driver;
use ilon_sim::{Error, Plant, WheelCommand, load_robot, resolve_for};
use nalgebra::Matrix3xX;
use toml::Value as Toml;

use super::free::Free;
use crate::log::Log;
use crate::motion::window;
use crate::ripple::{Stretches, ripple};
use crate::study::{Simulate, Study, flat};

/// How long the simulated wheels turn before what they do counts, in seconds.
const SETTLE_S: f64 = 0.7;

/// What a simulated drive made.
#[derive(Clone, Debug)]
pub(super) struct Made {
    /// The way along the direction that the wheels ask for, over the way that they ask for by the study's robot.
    pub along: f64,
    /// The same across it, to the left.
    pub across: f64,
    /// By how much it turned beyond what the wheels ask for, over the way that they ask for, in rad/m.
    pub drift_rad_per_m: f64,
    /// The mean torque of each wheel's motor, in N m at the wheel.
    pub torques_n_m: Vec<f64>,
    /// The ripple of the wheels' rates in rad/s and of the body's way in metres, root mean square; 0 where none is compared.
    pub wheels_rad_s: f64,
    pub body_m: f64,
}

impl Made {
    /// What drives from several wheel angles made together: the mean of ways and of the squares of ripples.
    pub fn together(all: &[Option<Self>]) -> Option<Self> {
        let all: Vec<Self> = all.iter().cloned().collect::<Option<_>>()?;
        let mean = |of: &dyn Fn(&Self) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        Some(Self {
            along: mean(&|made| made.along),
            across: mean(&|made| made.across),
            drift_rad_per_m: mean(&|made| made.drift_rad_per_m),
            torques_n_m: (0..all.first()?.torques_n_m.len())
                .map(|wheel| mean(&|made| made.torques_n_m[wheel]))
                .collect(),
            wheels_rad_s: mean(&|made| made.wheels_rad_s.powi(2)).sqrt(),
            body_m: mean(&|made| made.body_m.powi(2)).sqrt(),
        })
    }
}

/// The keys of a simulation: those of the study, with free ones at some values, and with others in their place.
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

/// The robot at some values of the keys, and the period of its control, in seconds.
///
/// # Errors
/// Where there is no such robot or scenario.
pub(super) fn built(study: &Study, keys: &[(String, Toml)]) -> Result<(Robot, Plant, f64), Error> {
    let settings: Vec<Setting> = keys
        .iter()
        .map(|(key, value)| Setting::new(key, value))
        .collect();
    let text = crate::study::scenario_text(&study.file.robot);
    let scenario = Scenario::from_text(&text, &study.path, &settings, &study.files)?;
    let robot = load_robot(&scenario)?;
    let resolved = resolve_for(&scenario, &robot, Driver::Own)?;
    let plant = Plant::new(&resolved, &robot)?;
    Ok((robot, plant, scenario.run.control_dt_s))
}

/// Drives the simulated robot at wheel rates, from the wheel angles of a phase; `None` where it leaves all numbers.
pub(super) fn made(
    study: &Study,
    section: &Simulate,
    keys: &[(String, Toml)],
    rates: &[f64],
    phase: u32,
    nominal: &Matrix3xX<f64>,
) -> Result<Option<Made>, Error> {
    let (robot, mut plant, period_s) = built(study, keys)?;
    let rows = (section.drive_s / period_s).ceil().max(2.0) as usize;
    let settle = (SETTLE_S / period_s).ceil() as usize;
    // Wheels come to their phases while they settle.
    let settling: Vec<f64> = rates
        .iter()
        .zip(phases(section, &robot, phase))
        .map(|(rate, offset_rad)| rate + offset_rad / (settle as f64 * period_s))
        .collect();
    let mut log = Log::default();
    let mut torques_n_m = vec![0.0; robot.wheels.len()];
    for row in 0..settle + rows {
        let rates = if row < settle { &settling[..] } else { rates };
        let outcome = match plant.advance(WheelCommand::Rates(rates), period_s) {
            Ok(outcome) => outcome,
            Err(Error::Diverged { .. }) => return Ok(None),
            Err(error) => return Err(error),
        };
        if row >= settle {
            for (sum, torque) in torques_n_m.iter_mut().zip(&outcome.torques_n_m) {
                *sum += torque / rows as f64;
            }
            let pose = plant.truth().pose;
            log.times_s.push((row - settle) as f64 * period_s);
            log.angles_rad
                .push(plant.observe().wheel_angles_rad.clone());
            log.poses.push([pose.x_m, pose.y_m, pose.heading_rad]);
            log.unseen.push(false);
        }
    }
    for row in 1..log.poses.len() {
        let last = log.poses[row - 1][2];
        log.poses[row][2] = last + ilon_robot::wrap_angle(log.poses[row][2] - last);
    }
    let whole = window(&log, 0, 0, log.len() - 1);
    let asked = whole.of_wheels(nominal);
    let size = libm::hypot(asked[0], asked[1]);
    if size <= 0.0 {
        return Ok(None);
    }
    let seen = whole.seen;
    let (mut wheels_rad_s, mut body_m) = (0.0, 0.0);
    if let Some(compared) = &section.ripple {
        // The loops of the simulated wheels let them turn slower than they are told to.
        let own: Vec<f64> = whole
            .turned_rad
            .iter()
            .map(|turned| turned / log.duration_s())
            .collect();
        let stretches = Stretches {
            length_s: compared.stretch_s,
            rates_rad_s: &own,
            alike: f64::INFINITY,
        };
        let rollers = robot.wheels.iter().map(|wheel| wheel.rollers.len()).max();
        if let Some(found) = ripple(&log, rollers.unwrap_or(0), nominal, &stretches, true) {
            (wheels_rad_s, body_m) = (found.wheels_rad_s[0], found.body_m[0]);
        }
    }
    Ok(Some(Made {
        along: (seen[0] * asked[0] + seen[1] * asked[1]) / (size * size),
        across: (seen[1] * asked[0] - seen[0] * asked[1]) / (size * size),
        drift_rad_per_m: (seen[2] - asked[2]) / size,
        torques_n_m,
        wheels_rad_s,
        body_m,
    }))
}

/// By how much each wheel is turned on before a drive counts, in radians, up to half a roller: nothing where there is one phase, else
/// angles that fill all combinations evenly. Wheels that are in phase by the study turn on together.
fn phases(section: &Simulate, robot: &Robot, phase: u32) -> Vec<f64> {
    let together = section.ripple.iter().flat_map(|ripple| &ripple.together);
    let groups: Vec<&Vec<String>> = together.collect();
    let group_of = |wheel: usize| {
        let name = &robot.wheels[wheel].name;
        let group = groups.iter().position(|names| names.contains(name));
        group.unwrap_or(groups.len() + wheel)
    };
    (0..robot.wheels.len())
        .map(|wheel| {
            if section.phases < 2 {
                return 0.0;
            }
            // Steps by roots of primes fill the phases of all wheels evenly.
            const PRIMES: [f64; 12] = [
                2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0,
            ];
            let root = PRIMES[group_of(wheel) % PRIMES.len()].sqrt();
            let share = (f64::from(phase) * root).fract();
            let pitch_rad = TAU / robot.wheels[wheel].rollers.len().max(1) as f64;
            (share - if share < 0.5 { 0.0 } else { 1.0 }) * pitch_rad
        })
        .collect()
}
