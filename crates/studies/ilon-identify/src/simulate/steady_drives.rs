//! Extracts the steady drives of the logs.

use nalgebra::Matrix3xX;

use super::drive_result::DriveResult;
use super::observations::Observations;
use crate::directions::of_body;
use crate::log::Log;
use crate::motion::{Window, largest_size, twist_of};
use crate::ripple::{Ripple, Stretches, ripple};
use crate::study::{Logged, Phases, Simulate, Study};

/// Wheel rates that differ by less than this share of the fastest belong to one drive.
const ALIKE: f64 = 0.06;
/// Smallest relative error of a ripple: it varies between wheels and runs.
const LEAST_RIPPLE_ERROR: f64 = 0.1;

/// Quantities in the fit besides the distances.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fits {
    pub heading: bool,
    pub currents: bool,
}

/// A drive to simulate.
#[derive(Clone, Debug)]
pub(super) struct Course {
    /// The mean rate of each wheel, in rad/s.
    pub rates_rad_s: Vec<f64>,
    /// Initial angle of each wheel, in radians relative to the robot's file, if the log contains
    /// it.
    pub begun_rad: Option<Vec<f64>>,
}

/// A drive at constant wheel rates, from several windows of one run.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    pub run: usize,
    /// Index of the simulated drive that represents it.
    pub drive: usize,
    pub along: f64,
    pub across: f64,
    pub error: f64,
    /// Rotation beyond the one commanded by the wheels, over the commanded distance, and its
    /// standard error, in rad/m.
    pub drift_rad_per_m: [f64; 2],
    /// Torque of each wheel by its motor's current and its standard error, in N m at the wheel;
    /// `None` for wheels that hardly turn, and if the log has no currents.
    pub torques_n_m: Vec<Option<[f64; 2]>>,
    /// Whether drift and torques enter the fit.
    pub fits: Fits,
    /// The ripple of the log, if compared.
    pub ripple: Option<Ripple>,
}

impl Leg {
    /// The number of compared values.
    pub fn equations(&self) -> usize {
        let torques = self.torques_n_m.iter().flatten().count();
        2 + if self.ripple.is_some() { 2 } else { 0 }
            + usize::from(self.fits.heading)
            + if self.fits.currents { torques } else { 0 }
    }

    /// Returns the residuals relative to a simulated drive, each with its error; `scale` is the
    /// common factor on its distances.
    pub fn differences(&self, made: &DriveResult, scale: f64) -> Vec<[f64; 2]> {
        let mut left = Vec::with_capacity(self.equations());
        left.push([self.along - scale * made.along, self.error]);
        left.push([self.across - scale * made.across, self.error]);
        if let Some(ripple) = &self.ripple {
            let [wheels, body] = sure(ripple);
            left.push([ripple.wheels_rad_s[0] - made.wheels_rad_s, wheels]);
            left.push([ripple.body_m[0] - made.body_m, body]);
        }
        if self.fits.heading {
            let [drift, error] = self.drift_rad_per_m;
            left.push([drift - made.drift_rad_per_m, error]);
        }
        if self.fits.currents {
            for (seen, made) in self.torques_n_m.iter().zip(&made.torques_n_m) {
                left.extend(seen.map(|[torque, error]| [torque - made, error]));
            }
        }
        left
    }
}

/// Returns the assumed errors of the ripple of wheels and body.
fn sure(ripple: &Ripple) -> [f64; 2] {
    let of = |[amplitude, error]: [f64; 2], least: f64| {
        libm::hypot(error, LEAST_RIPPLE_ERROR * amplitude).max(least)
    };
    [
        of(ripple.wheels_rad_s, f64::MIN_POSITIVE),
        of(ripple.body_m, f64::MIN_POSITIVE),
    ]
}
/// Returns the steady drives of all runs, and the drives to simulate for them: one per kind, or per
/// run if the logs contain the initial wheel angles.
pub(super) fn legs(
    study: &Study,
    section: &Simulate,
    all: &Observations<'_>,
    nominal: &Matrix3xX<f64>,
) -> (Vec<Leg>, Vec<Course>) {
    let (windows, trackers, window_s) = (all.windows, all.trackers, study.file.window_s);
    let rollers = study.robot.wheels.iter().map(|wheel| wheel.rollers.len());
    let rollers = rollers.max().unwrap_or(0);
    let fits = Fits {
        heading: section.heading.is_some_and(|heading| heading.fitted),
        currents: section.currents.is_some_and(|currents| currents.fitted),
    };
    let least_drift = section
        .heading
        .map_or(0.0, |heading| heading.least_error_rad_per_m);
    let is_begun = section.phases == Some(Phases::Logged(Logged::Log));
    let mut drives: Vec<Course> = Vec::new();
    let mut legs: Vec<Leg> = Vec::new();
    for run in 0..all.held_out.len() {
        let of_run = windows.iter().copied().filter(|window| window.run == run);
        for kind in &kinds(of_run, window_s) {
            let count = kind.len() as f64;
            let wheels = kind[0].turned_rad.len();
            let mean: Vec<f64> = (0..wheels)
                .map(|wheel| {
                    kind.iter()
                        .map(|window| rates(window, window_s)[wheel])
                        .sum::<f64>()
                        / count
                })
                .collect();
            let (mut way, mut along, mut across) = (0.0, 0.0, 0.0);
            let mut ratios = Vec::new();
            let mut drifts = Vec::new();
            for window in kind {
                let asked = window.of_wheels(nominal);
                let size = libm::hypot(asked[0], asked[1]);
                let seen = of_body(window, &trackers[window.run]);
                let here = (seen[0] * asked[0] + seen[1] * asked[1]) / size;
                way += size;
                along += here;
                across += (seen[1] * asked[0] - seen[0] * asked[1]) / size;
                ratios.push(here / size);
                drifts.push((seen[2] - asked[2]) / size);
            }
            // Rotations on the spot have no distance.
            let asked = twist_of(nominal, &mean);
            if libm::hypot(asked[0], asked[1]) < 0.02 * asked[2].abs() || way <= 0.0 {
                continue;
            }
            let (along, across) = (along / way, across / way);
            let squares: f64 = ratios.iter().map(|ratio| (ratio - along).powi(2)).sum();
            let error = (squares / (count * (count - 1.0))).sqrt();
            let begun_rad = is_begun.then(|| begun(&all.logs[run], kind[0].at_s - 0.5 * window_s));
            let alike = |known: &Course| !is_begun && !apart(&mean, &known.rates_rad_s);
            let drive = drives.iter().position(alike).unwrap_or_else(|| {
                drives.push(Course {
                    rates_rad_s: mean.clone(),
                    begun_rad,
                });
                drives.len() - 1
            });
            let seen_ripple = section.ripple.as_ref().and_then(|compared| {
                let stretches = Stretches {
                    length_s: compared.stretch_s,
                    rates_rad_s: &mean,
                    alike: ALIKE,
                };
                ripple(&all.logs[run], rollers, nominal, &stretches)
            });
            legs.push(Leg {
                run,
                drive,
                along,
                across,
                error: libm::hypot(error, section.least_error),
                drift_rad_per_m: mean_of(&drifts, least_drift),
                torques_n_m: torques(study, section, (kind, &all.logs[run]), &mean),
                fits,
                ripple: seen_ripple,
            });
        }
    }
    (legs, drives)
}

/// Returns the mean rates of the wheels in a window, in rad/s.
fn rates(window: &Window, window_s: f64) -> Vec<f64> {
    let turned = window.turned_rad.iter();
    turned.map(|turned| turned / window_s).collect()
}

/// Whether wheel rates belong to another kind of motion.
fn apart(a: &[f64], b: &[f64]) -> bool {
    let size = largest_size(b);
    a.iter().zip(b).any(|(a, b)| (a - b).abs() > ALIKE * size)
}

/// Returns the kinds of motion in a run, each with its windows, without rare ones.
fn kinds<'w>(windows: impl Iterator<Item = &'w Window>, window_s: f64) -> Vec<Vec<&'w Window>> {
    let mut kinds: Vec<Vec<&Window>> = Vec::new();
    for window in windows {
        let own = rates(window, window_s);
        let is_same = |kind: &&mut Vec<&Window>| !apart(&own, &rates(kind[0], window_s));
        match kinds.iter_mut().find(is_same) {
            Some(kind) => kind.push(window),
            None => kinds.push(vec![window]),
        }
    }
    let most = kinds.iter().map(Vec::len).max().unwrap_or(0);
    kinds.retain(|kind| kind.len() >= 3 && 4 * kind.len() >= most);
    kinds
}

/// Returns the angle of each wheel at a time of a log, in its encoders' count, in radians.
fn begun(log: &Log, at_s: f64) -> Vec<f64> {
    let row = log
        .times_s
        .partition_point(|t_s| *t_s < at_s - 0.5 * log.period_s());
    let row = row.min(log.len() - 1);
    let angles = log.angles_rad[row].iter().zip(&log.begun_rad);
    angles.map(|(angle, begun)| angle + begun).collect()
}

/// Returns the mean of values and its standard error, to which the smallest credible error is added
/// in squares.
fn mean_of(values: &[f64], least_error: f64) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let error = (squares / (count * (count - 1.0).max(1.0))).sqrt();
    [mean, libm::hypot(error, least_error)]
}

/// Wheels slower than this share of the fastest do not show the direction of their motors' torque.
const TURNS: f64 = 0.1;

/// Returns the torques of the wheels over some windows of a log, from the currents of their motors.
fn torques(
    study: &Study,
    section: &Simulate,
    (stretches, log): (&[&Window], &Log),
    rates_rad_s: &[f64],
) -> Vec<Option<[f64; 2]>> {
    let Some(motors) = &section.currents else {
        return Vec::new();
    };
    let half_s = 0.5 * study.file.window_s;
    let fastest = largest_size(rates_rad_s);
    rates_rad_s
        .iter()
        .enumerate()
        .map(|(wheel, rate)| {
            if rate.abs() < TURNS * fastest {
                return None;
            }
            let gear_ratio = study.robot.wheels[wheel].drive.gear_ratio;
            let gear_ratio = motors.gear_ratio.unwrap_or(gear_ratio);
            let means: Vec<f64> = stretches
                .iter()
                .filter_map(|stretch| {
                    let rows = |at_s: f64| log.times_s.partition_point(|t_s| *t_s < at_s);
                    let rows = rows(stretch.at_s - half_s)..rows(stretch.at_s + half_s);
                    let count = rows.len() as f64;
                    let sum: f64 = log.currents_a.get(rows)?.iter().map(|row| row[wheel]).sum();
                    (count > 0.0).then_some(sum / count)
                })
                .collect();
            if means.is_empty() {
                return None;
            }
            let way = rate.signum();
            let torque = |current_a: f64| {
                let signed_a = if motors.unsigned {
                    way * current_a.abs()
                } else {
                    current_a
                };
                gear_ratio * (motors.torque_constant_n_m_a * signed_a - way * motors.friction_n_m)
            };
            let torques: Vec<f64> = means.into_iter().map(torque).collect();
            Some(mean_of(&torques, motors.least_error_n_m))
        })
        .collect()
}
