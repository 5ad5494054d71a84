//! The steady drives of the logs.

use nalgebra::Matrix3xX;

use super::Seen;
use super::drive::Made;
use crate::directions::of_body;
use crate::motion::Window;
use crate::ripple::{Ripple, Stretches, ripple};
use crate::study::{Simulate, Study};

/// Wheel rates that differ by less than this share of the fastest are one drive.
const ALIKE: f64 = 0.06;
/// Ripple is believed to no better than this share of it: it is not the same of all wheels, nor of all runs.
const LEAST_RIPPLE_ERROR: f64 = 0.1;

/// A drive at constant wheel rates, as several stretches of one run made it.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    pub run: usize,
    /// Which simulated drive stands for it.
    pub drive: usize,
    pub along: f64,
    pub across: f64,
    pub error: f64,
    /// The ripple of the log, where it is compared.
    pub ripple: Option<Ripple>,
}

impl Leg {
    /// How many numbers of it are compared.
    pub fn equations(&self) -> usize {
        2 + if self.ripple.is_some() { 2 } else { 0 }
    }

    /// What is left of it beside what a simulated drive made, over how well it is known; `scale` is the common factor on its ways.
    pub fn compare(&self, made: &Made, scale: f64, left: &mut Vec<f64>) {
        left.push((self.along - scale * made.along) / self.error);
        left.push((self.across - scale * made.across) / self.error);
        if let Some(ripple) = &self.ripple {
            let [wheels, body] = sure(ripple);
            left.push((ripple.wheels_rad_s[0] - made.wheels_rad_s) / wheels);
            left.push((ripple.body_m[0] - made.body_m) / body);
        }
    }
}

/// How well the ripple of wheels and body is believed to be known.
fn sure(ripple: &Ripple) -> [f64; 2] {
    let of = |[amplitude, error]: [f64; 2], least: f64| {
        libm::hypot(error, LEAST_RIPPLE_ERROR * amplitude).max(least)
    };
    [
        of(ripple.wheels_rad_s, f64::MIN_POSITIVE),
        of(ripple.body_m, f64::MIN_POSITIVE),
    ]
}
/// The steady drives of all runs, and the mean wheel rates of each kind of drive.
pub(super) fn legs(
    study: &Study,
    section: &Simulate,
    all: &Seen<'_>,
    nominal: &Matrix3xX<f64>,
) -> (Vec<Leg>, Vec<Vec<f64>>) {
    let (windows, trackers, window_s) = (all.windows, all.trackers, study.file.window_s);
    let rollers = study.robot.wheels.iter().map(|wheel| wheel.rollers.len());
    let rollers = rollers.max().unwrap_or(0);
    let mut drives: Vec<(Vec<f64>, usize)> = Vec::new();
    let mut legs: Vec<Leg> = Vec::new();
    let rates = |window: &Window| -> Vec<f64> {
        window
            .turned_rad
            .iter()
            .map(|turned| turned / window_s)
            .collect()
    };
    let apart = |a: &[f64], b: &[f64]| -> bool {
        let size = b.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
        a.iter().zip(b).any(|(a, b)| (a - b).abs() > ALIKE * size)
    };
    for run in 0..all.held_out.len() {
        // Kinds of motion in this run, each with its members.
        let mut kinds: Vec<Vec<&Window>> = Vec::new();
        for window in windows.iter().copied().filter(|window| window.run == run) {
            let own = rates(window);
            match kinds.iter_mut().find(|kind| !apart(&own, &rates(kind[0]))) {
                Some(kind) => kind.push(window),
                None => kinds.push(vec![window]),
            }
        }
        let most = kinds.iter().map(Vec::len).max().unwrap_or(0);
        for kind in kinds
            .iter()
            .filter(|kind| kind.len() >= 3 && 4 * kind.len() >= most)
        {
            let count = kind.len() as f64;
            let wheels = kind[0].turned_rad.len();
            let mean: Vec<f64> = (0..wheels)
                .map(|wheel| kind.iter().map(|window| rates(window)[wheel]).sum::<f64>() / count)
                .collect();
            let (mut way, mut along, mut across) = (0.0, 0.0, 0.0);
            let mut ratios = Vec::new();
            for window in kind {
                let asked = window.of_wheels(nominal);
                let size = libm::hypot(asked[0], asked[1]);
                let seen = of_body(window, &trackers[window.run]);
                let here = (seen[0] * asked[0] + seen[1] * asked[1]) / size;
                way += size;
                along += here;
                across += (seen[1] * asked[0] - seen[0] * asked[1]) / size;
                ratios.push(here / size);
            }
            // Turns in place make no way.
            let reach = libm::hypot(asked(nominal, &mean)[0], asked(nominal, &mean)[1]);
            let turning = asked(nominal, &mean)[2].abs();
            if reach < 0.02 * turning || way <= 0.0 {
                continue;
            }
            let (along, across) = (along / way, across / way);
            let squares: f64 = ratios.iter().map(|ratio| (ratio - along).powi(2)).sum();
            let error = (squares / (count * (count - 1.0))).sqrt();
            let known = drives.iter().position(|(known, _)| !apart(&mean, known));
            let drive = match known {
                Some(drive) => drive,
                None => {
                    drives.push((mean.clone(), 0));
                    drives.len() - 1
                }
            };
            drives[drive].1 += 1;
            let seen_ripple = section.ripple.as_ref().and_then(|compared| {
                let stretches = Stretches {
                    length_s: compared.stretch_s,
                    rates_rad_s: &mean,
                    alike: ALIKE,
                };
                ripple(&all.logs[run], rollers, nominal, &stretches, false)
            });
            legs.push(Leg {
                run,
                drive,
                along,
                across,
                error: libm::hypot(error, section.least_error),
                ripple: seen_ripple,
            });
        }
    }
    (legs, drives.into_iter().map(|(rates, _)| rates).collect())
}

/// The twist that wheel rates ask for.
pub(super) fn asked(nominal: &Matrix3xX<f64>, rates: &[f64]) -> [f64; 3] {
    let mut twist = [0.0; 3];
    for (column, rate) in nominal.column_iter().zip(rates) {
        (0..3).for_each(|axis| twist[axis] += column[axis] * rate);
    }
    twist
}
