//! Keys of the scenario that are fitted by simulating: each direction in which a log drives steadily is driven by the simulated robot
//! at the same wheel rates, and the ways made are compared.

use std::sync::atomic::{AtomicU32, Ordering};

use ilon_sim::scenario::{Scenario, Setting};
use ilon_sim::simulate::Driver;
use ilon_sim::{Error, Plant, WheelCommand, load_robot, resolve_for};
use nalgebra::{Matrix3xX, RowDVector};
use rayon::prelude::*;
use toml::Value as Toml;

use crate::directions::of_body;
use crate::least_squares::{Search, least_squares};
use crate::log::Log;
use crate::motion::{Tracker, Window, window};
use crate::outcome::{Drive, Simulation, Value};
use crate::resample::{Cluster, Draws};
use crate::study::{Simulate, Study, flat};

/// Wheel rates that differ by less than this share of the fastest are one drive.
const ALIKE: f64 = 0.06;
/// How long the simulated wheels turn before what they do counts, in seconds.
const SETTLE_S: f64 = 0.7;
/// Ways are believed to no better than this, over the way asked for: what changes from run to run.
const LEAST_ERROR: f64 = 3e-3;

/// A drive at constant wheel rates, as several stretches of one run made it.
#[derive(Clone, Debug)]
struct Leg {
    run: usize,
    /// Which simulated drive stands for it.
    drive: usize,
    along: f64,
    across: f64,
    error: f64,
}

/// What is varied, from where to where.
struct Free {
    key: String,
    low: f64,
    high: f64,
    is_log: bool,
}

/// What simulating found.
pub(crate) struct Found {
    pub parameters: Vec<(String, Value)>,
    pub simulation: Simulation,
}

/// Fits the keys that a study leaves free to the ways that its runs made.
pub(crate) fn simulate(
    study: &Study,
    section: &Simulate,
    windows: &[&Window],
    held_out: &[bool],
    nominal: &Matrix3xX<f64>,
    trackers: &[Tracker],
    count: &(dyn Fn(u32) + Sync),
) -> Result<Found, Error> {
    let free = free_of(section)?;
    let (legs, drives) = legs(
        windows,
        held_out.len(),
        nominal,
        trackers,
        study.file.window_s,
    );
    let fitted: Vec<&Leg> = legs.iter().filter(|leg| !held_out[leg.run]).collect();
    if fitted.len() * 2 < free.len() + usize::from(section.free_scale) {
        return Err(Error::invalid(
            format!(
                "{} directions of motion cannot determine {} keys",
                fitted.len(),
                free.len()
            ),
            "leave fewer keys free below `[simulate.free]`, or drive in more directions",
        ));
    }
    let mut wanted: Vec<usize> = fitted.iter().map(|leg| leg.drive).collect();
    wanted.sort_unstable();
    wanted.dedup();

    let simulated = AtomicU32::new(0);
    let run_drives = |values: &[f64], which: &[usize]| -> Result<Vec<Option<[f64; 2]>>, Error> {
        let all: Result<Vec<Option<[f64; 2]>>, Error> = which
            .par_iter()
            .map(|drive| {
                let made = ways(study, section, &free, values, &drives[*drive], nominal);
                count(simulated.fetch_add(1, Ordering::Relaxed) + 1);
                made
            })
            .collect();
        all
    };
    // Values as the search sees them, with the common scale last.
    let keys = free.len();
    let shown = |seen: &[f64]| -> Vec<f64> {
        free.iter()
            .zip(seen)
            .map(|(free, value)| {
                if free.is_log {
                    libm::exp(*value)
                } else {
                    *value
                }
            })
            .collect()
    };
    let residuals = |seen: &[f64]| -> Result<Option<Vec<f64>>, Error> {
        let made = run_drives(&shown(seen), &wanted)?;
        let scale = if section.free_scale { seen[keys] } else { 1.0 };
        let mut left = Vec::with_capacity(2 * fitted.len());
        for leg in &fitted {
            let Some([along, across]) = wanted
                .binary_search(&leg.drive)
                .ok()
                .and_then(|place| made[place])
            else {
                return Ok(None);
            };
            left.push((leg.along - scale * along) / leg.error);
            left.push((leg.across - scale * across) / leg.error);
        }
        Ok(Some(left))
    };
    let end = |value: f64, is_log: bool| if is_log { libm::log(value) } else { value };
    let mut bounds: Vec<(f64, f64)> = free
        .iter()
        .map(|free| (end(free.low, free.is_log), end(free.high, free.is_log)))
        .collect();
    let mut start: Vec<f64> = bounds
        .iter()
        .map(|(low, high)| low + 0.4 * (high - low))
        .collect();
    let mut differences: Vec<f64> = bounds
        .iter()
        .map(|(low, high)| 0.04 * (high - low))
        .collect();
    if section.free_scale {
        let mean = fitted.iter().map(|leg| leg.along).sum::<f64>() / fitted.len() as f64;
        start.push(mean);
        bounds.push((0.2 * mean, 5.0 * mean));
        differences.push(0.01);
    }
    let search = Search {
        differences,
        bounds,
        steps: section.steps,
        tolerance: 0.05,
    };
    let found = least_squares(&residuals, &start, &search)?;

    let mut clusters = vec![Cluster::empty(found.values.len()); held_out.len()];
    for (index, leg) in fitted.iter().enumerate() {
        clusters[leg.run].add(
            found.jacobian.rows(2 * index, 2).clone_owned(),
            found.residuals.rows(2 * index, 2).clone_owned(),
        );
    }
    clusters.retain(|cluster| cluster.rows > 0);
    let draws = Draws::new(&clusters, study.file.resamples, study.file.seed);
    let values = shown(&found.values);
    let mut parameters = Vec::new();
    for (axis, free) in free.iter().enumerate() {
        let mut interval = draws.interval(found.values[axis], |step| step[axis]);
        if free.is_log {
            interval.low = libm::exp(interval.low);
            interval.high = libm::exp(interval.high);
        }
        let value = Value::new(values[axis], interval, "", start_of(free));
        parameters.push((free.key.clone(), value));
    }

    let every: Vec<usize> = (0..drives.len()).collect();
    let made = run_drives(&values, &every)?;
    let scale = if section.free_scale {
        found.values[keys]
    } else {
        1.0
    };
    let mut shown_drives = Vec::new();
    let (mut fit, mut not_fit) = ((0.0, 0_usize), (0.0, 0_usize));
    for leg in &legs {
        let Some([along, across]) = made[leg.drive] else {
            continue;
        };
        let missed = (leg.along - scale * along).powi(2);
        let sum = if held_out[leg.run] {
            &mut not_fit
        } else {
            &mut fit
        };
        sum.0 += missed;
        sum.1 += 1;
        let asked = asked(nominal, &drives[leg.drive]);
        shown_drives.push(Drive {
            file: study.file.runs[leg.run].file.display().to_string(),
            held_out: held_out[leg.run],
            direction_deg: libm::atan2(asked[1], asked[0])
                .to_degrees()
                .rem_euclid(360.0),
            measured: leg.along / scale,
            measured_error: leg.error / scale,
            simulated: along,
            measured_across: leg.across / scale,
            simulated_across: across,
        });
    }
    let rms = |(sum, count): (f64, usize)| (count > 0).then(|| (sum / count as f64).sqrt() / scale);
    let insensitive: Vec<String> = free
        .iter()
        .enumerate()
        .filter(|(axis, _)| {
            let changes = found.jacobian.column(*axis).norm()
                * (search.bounds[*axis].1 - search.bounds[*axis].0);
            changes < 1.0
        })
        .map(|(_, free)| free.key.clone())
        .collect();
    let at_bounds: Vec<String> = free
        .iter()
        .enumerate()
        .filter(|(axis, _)| {
            let (low, high) = search.bounds[*axis];
            let margin = 0.005 * (high - low);
            found.values[*axis] < low + margin || found.values[*axis] > high - margin
        })
        .map(|(_, free)| free.key.clone())
        .collect();
    Ok(Found {
        parameters,
        simulation: Simulation {
            ratio_rms_fit: rms(fit),
            ratio_rms_held_out: rms(not_fit),
            scale,
            has_converged: found.has_converged,
            drives_simulated: simulated.load(Ordering::Relaxed),
            alike: alike(
                &found
                    .jacobian
                    .row_iter()
                    .map(|row| row.clone_owned())
                    .collect::<Vec<_>>(),
                &free,
            ),
            insensitive,
            at_bounds,
            drives: shown_drives,
        },
    })
}

/// Pairs of keys whose changes look the same to nine parts in ten or more: the log hardly tells them apart.
fn alike(rows: &[RowDVector<f64>], free: &[Free]) -> Vec<[String; 2]> {
    let mut pairs = Vec::new();
    let dot = |a: usize, b: usize| rows.iter().map(|row| row[a] * row[b]).sum::<f64>();
    for a in 0..free.len() {
        for b in a + 1..free.len() {
            let sizes = (dot(a, a) * dot(b, b)).sqrt();
            if sizes > 0.0 && (dot(a, b) / sizes).abs() > 0.97 {
                pairs.push([free[a].key.clone(), free[b].key.clone()]);
            }
        }
    }
    pairs
}

fn start_of(free: &Free) -> f64 {
    match free.is_log {
        true => libm::exp(libm::log(free.low) + 0.4 * (libm::log(free.high) - libm::log(free.low))),
        false => free.low + 0.4 * (free.high - free.low),
    }
}

/// The keys that are free, each `{ from = ..., to = ..., scale = "log" }`.
fn free_of(section: &Simulate) -> Result<Vec<Free>, Error> {
    let mut found: Vec<Free> = Vec::new();
    for (key, value) in flat(&section.free) {
        let Some((name, end)) = key.rsplit_once('.') else {
            return Err(unclear(&key));
        };
        let place = match found.iter().position(|free| free.key == name) {
            Some(place) => place,
            None => {
                found.push(Free {
                    key: name.to_owned(),
                    low: f64::NAN,
                    high: f64::NAN,
                    is_log: false,
                });
                found.len() - 1
            }
        };
        let number = match &value {
            Toml::Float(number) => Some(*number),
            Toml::Integer(number) => Some(*number as f64),
            _ => None,
        };
        match (end, number, value.as_str()) {
            ("from", Some(number), _) => found[place].low = number,
            ("to", Some(number), _) => found[place].high = number,
            ("scale", _, Some("log")) => found[place].is_log = true,
            ("scale", _, Some("linear")) => found[place].is_log = false,
            _ => return Err(unclear(&key)),
        }
    }
    for free in &found {
        let is_range = free.low < free.high && free.low.is_finite() && free.high.is_finite();
        if !is_range || (free.is_log && free.low <= 0.0) {
            return Err(unclear(&free.key));
        }
    }
    if found.is_empty() {
        return Err(unclear("free"));
    }
    Ok(found)
}

fn unclear(key: &str) -> Error {
    Error::invalid(
        format!("`simulate.free.{key}` does not say from where to where the key is free"),
        "write `world.floor.creep = { from = 0.1, to = 3.0 }` below `[simulate.free]`; `scale = \"log\"` needs a range above 0",
    )
}

/// The steady drives of all runs, and the mean wheel rates of each kind of drive.
fn legs(
    windows: &[&Window],
    runs: usize,
    nominal: &Matrix3xX<f64>,
    trackers: &[Tracker],
    window_s: f64,
) -> (Vec<Leg>, Vec<Vec<f64>>) {
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
    for run in 0..runs {
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
            legs.push(Leg {
                run,
                drive,
                along,
                across,
                error: libm::hypot(error, LEAST_ERROR),
            });
        }
    }
    (legs, drives.into_iter().map(|(rates, _)| rates).collect())
}

/// The twist that wheel rates ask for.
fn asked(nominal: &Matrix3xX<f64>, rates: &[f64]) -> [f64; 3] {
    let mut twist = [0.0; 3];
    for (column, rate) in nominal.column_iter().zip(rates) {
        (0..3).for_each(|axis| twist[axis] += column[axis] * rate);
    }
    twist
}

/// The way that the simulated robot makes along and across the direction that its wheels ask for, over the way that they ask for by the
/// study's robot; `None` where these values cannot be simulated.
fn ways(
    study: &Study,
    section: &Simulate,
    free: &[Free],
    values: &[f64],
    rates: &[f64],
    nominal: &Matrix3xX<f64>,
) -> Result<Option<[f64; 2]>, Error> {
    let mut settings: Vec<Setting> = flat(&study.file.set)
        .iter()
        .map(|(key, value)| Setting::new(key, value))
        .collect();
    for (free, value) in free.iter().zip(values) {
        settings.push(Setting::new(&free.key, &Toml::Float(*value)));
    }
    let text = crate::study::scenario_text(&study.file.robot);
    let scenario = Scenario::from_text(&text, &study.path, &settings, &study.files)?;
    let robot = load_robot(&scenario)?;
    let resolved = resolve_for(&scenario, &robot, Driver::Own)?;
    let mut plant = Plant::new(&resolved, &robot)?;
    let period_s = scenario.run.control_dt_s;
    let rows = (section.drive_s / period_s).ceil().max(2.0) as usize;
    let settle = (SETTLE_S / period_s).ceil() as usize;
    let mut log = Log::default();
    for row in 0..settle + rows {
        match plant.advance(WheelCommand::Rates(rates), period_s) {
            Ok(_) => {}
            Err(Error::Diverged { .. }) => return Ok(None),
            Err(error) => return Err(error),
        }
        if row >= settle {
            let pose = plant.truth().pose;
            log.times_s.push((row - settle) as f64 * period_s);
            log.angles_rad
                .push(plant.observe().wheel_angles_rad.clone());
            log.poses.push([pose.x_m, pose.y_m, pose.heading_rad]);
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
    Ok(Some([
        (seen[0] * asked[0] + seen[1] * asked[1]) / (size * size),
        (seen[1] * asked[0] - seen[0] * asked[1]) / (size * size),
    ]))
}
