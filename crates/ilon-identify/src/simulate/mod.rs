//! Keys of the scenario that are fitted by simulating: each direction in which a log drives steadily is driven by the simulated robot
//! at the same wheel rates, and the ways made are compared.

mod drive;
mod free;
mod legs;

use std::sync::atomic::{AtomicU32, Ordering};

use ilon_sim::Error;
use nalgebra::{Matrix3xX, RowDVector};
use rayon::prelude::*;

use self::drive::ways;
use self::free::{Free, free_of, start_of};
use self::legs::{Leg, asked, legs};
use crate::least_squares::{Search, least_squares};
use crate::motion::{Tracker, Window};
use crate::outcome::{Drive, Simulation, Value};
use crate::resample::{Cluster, Draws};
use crate::study::{Simulate, Study};

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
