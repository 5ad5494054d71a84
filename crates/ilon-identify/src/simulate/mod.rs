//! Keys of the scenario that are fitted by simulating: each direction in which a log drives steadily is driven by the simulated robot
//! at the same wheel rates, and the ways made are compared.

mod compared;
mod drive;
mod free;
mod legs;

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use ilon_sim::Error;
use nalgebra::{Matrix3xX, RowDVector};
use rayon::prelude::*;
use toml::Value as Toml;

use self::compared::{Compared, Scales};
use self::drive::{Made, made};
use self::free::{Free, free_of, start_of};
use self::legs::{Leg, legs};
use crate::least_squares::{Search, least_squares};
use crate::log::Log;
use crate::motion::{Tracker, Window};
use crate::outcome::{Beside, Simulation, Value};
use crate::resample::{Cluster, Draws};
use crate::study::{Simulate, Study, flat};

/// What simulating found.
pub(crate) struct Found {
    pub parameters: Vec<(String, Value)>,
    pub simulation: Simulation,
}

/// What the drives made at some values of the keys.
type Simulated = (Vec<f64>, Vec<Option<Made>>);

/// What was seen of all runs.
pub(crate) struct Seen<'a> {
    pub windows: &'a [&'a Window],
    /// Of each run, whether it is kept back.
    pub held_out: &'a [bool],
    pub trackers: &'a [Tracker],
    pub logs: &'a [Log],
}

/// Fits the keys that a study leaves free to the ways that its runs made, and to their ripple where the study says so.
pub(crate) fn simulate(
    study: &Study,
    section: &Simulate,
    seen: &Seen<'_>,
    nominal: &Matrix3xX<f64>,
    count: &(dyn Fn(u32) + Sync),
) -> Result<Found, Error> {
    let free = free_of(section)?;
    let held_out = seen.held_out;
    let (legs, drives) = legs(study, section, seen, nominal);
    let fitted: Vec<&Leg> = legs.iter().filter(|leg| !held_out[leg.run]).collect();
    let scales = Scales::new(section, study, &fitted);
    let equations: usize = fitted.iter().map(|leg| leg.equations()).sum();
    if equations < free.len() + scales.series.len() {
        return Err(Error::invalid(
            format!(
                "{} directions of motion cannot determine {} keys",
                fitted.len(),
                free.len()
            ),
            "leave fewer keys free below `[simulate.free]`, or drive in more directions",
        ));
    }
    refuse_what_cannot_be(study, &free)?;
    let mut wanted: Vec<usize> = fitted.iter().map(|leg| leg.drive).collect();
    wanted.sort_unstable();
    wanted.dedup();

    let simulated = AtomicU32::new(0);
    let run_with = |keys: &[(String, Toml)], which: &[usize]| -> Result<Vec<Option<Made>>, Error> {
        let each: Vec<(usize, u32)> = which
            .iter()
            .flat_map(|drive| (0..section.phases).map(|phase| (*drive, phase)))
            .collect();
        let all: Result<Vec<Option<Made>>, Error> = each
            .par_iter()
            .map(|(drive, phase)| {
                let made = made(study, section, keys, &drives[*drive], *phase, nominal);
                count(simulated.fetch_add(1, Ordering::Relaxed) + 1);
                made
            })
            .collect();
        let all = all?;
        Ok(all
            .chunks(section.phases as usize)
            .map(Made::together)
            .collect())
    };
    let run_drives =
        |values: &[f64], which: &[usize]| run_with(&drive::keys(study, &free, values, &[]), which);
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
    // What was simulated is kept: where only a scale changes, nothing moves otherwise.
    let kept: Mutex<Vec<Simulated>> = Mutex::new(Vec::new());
    // Values as the search sees them, with the scale of each series last.
    let residuals = |seen: &[f64]| -> Result<Option<Vec<f64>>, Error> {
        let known = |kept: &Mutex<Vec<Simulated>>| {
            let kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
            let mut kept = kept.iter();
            kept.find(|(values, _)| *values == seen[..keys])
                .map(|(_, made)| made.clone())
        };
        let made = match known(&kept) {
            Some(made) => made,
            None => {
                let values = shown(seen);
                // Each key by itself can have what its range holds; together they may ask for a robot that cannot be.
                if drive::built(study, &drive::keys(study, &free, &values, &[])).is_err() {
                    return Ok(None);
                }
                let made = run_drives(&values, &wanted)?;
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                kept.push((seen[..keys].to_vec(), made.clone()));
                made
            }
        };
        let mut left = Vec::with_capacity(equations);
        for leg in &fitted {
            let place = wanted.binary_search(&leg.drive).ok();
            let Some(made) = place.and_then(|place| made[place].as_ref()) else {
                return Ok(None);
            };
            leg.compare(made, scales.of(leg, &seen[keys..]), &mut left);
        }
        Ok(Some(left))
    };
    let end = |value: f64, is_log: bool| if is_log { libm::log(value) } else { value };
    let mut bounds: Vec<(f64, f64)> = free
        .iter()
        .map(|free| (end(free.low, free.is_log), end(free.high, free.is_log)))
        .collect();
    let mut start: Vec<f64> = free
        .iter()
        .map(|free| end(start_of(free), free.is_log))
        .collect();
    let mut differences: Vec<f64> = bounds
        .iter()
        .map(|(low, high)| 0.04 * (high - low))
        .collect();
    for mean in scales.means(&fitted) {
        start.push(mean);
        bounds.push((0.2 * mean, 5.0 * mean));
        differences.push(0.01);
    }
    let search = Search {
        differences,
        bounds,
        steps: section.steps,
        tolerance: 0.1,
        damping: 1e-2,
        tries: 5,
    };
    let found = least_squares(&residuals, &start, &search)?;

    let mut clusters = vec![Cluster::empty(found.values.len()); held_out.len()];
    let mut row = 0;
    for leg in &fitted {
        clusters[leg.run].add(
            found.jacobian.rows(row, leg.equations()).clone_owned(),
            found.residuals.rows(row, leg.equations()).clone_owned(),
        );
        row += leg.equations();
    }
    clusters.retain(|cluster| cluster.rows > 0);
    let draws = Draws::new(&clusters, study.file.resamples, study.file.seed);
    let values = shown(&found.values);
    let mut parameters = Vec::new();
    let mut open = Vec::new();
    for (axis, free) in free.iter().enumerate() {
        let mut interval = draws.interval(found.values[axis], |step| step[axis]);
        if free.is_log {
            interval.low = libm::exp(interval.low);
            interval.high = libm::exp(interval.high);
        }
        if !(interval.low > free.low || interval.high < free.high) {
            open.push(free.key.clone());
        }
        let value = Value::new(values[axis], interval, "", start_of(free));
        parameters.push((free.key.clone(), value));
    }

    let every: Vec<usize> = (0..drives.len()).collect();
    let made = run_drives(&values, &every)?;
    let compared = Compared::new(study, &legs, &made, &scales, &found.values[keys..]);
    let mut beside = Vec::new();
    for other in &section.beside {
        let keys = drive::keys(study, &free, &values, &flat(&other.set));
        let made = run_with(&keys, &every)?;
        let compared = Compared::new(study, &legs, &made, &scales, &found.values[free.len()..]);
        beside.push(Beside {
            name: other.name.clone(),
            fit: compared.misses(false),
            held_out: compared.misses(true),
            drives: compared.others(),
        });
    }
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
            fit: compared.misses(false),
            held_out: compared.misses(true),
            scale: compared.scale(),
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
            open,
            at_bounds,
            series: compared.series(study, &drives, nominal),
            drives: compared.drives(study, &drives, nominal),
            beside,
        },
    })
}

/// Refuses ranges at whose ends there is no robot or scenario that could be simulated, before anything is simulated.
fn refuse_what_cannot_be(study: &Study, free: &[Free]) -> Result<(), Error> {
    let start: Vec<f64> = free.iter().map(start_of).collect();
    for (axis, key) in free.iter().enumerate() {
        for end in [key.low, key.high] {
            let mut values = start.clone();
            values[axis] = end;
            if let Err(error) = drive::built(study, &drive::keys(study, free, &values, &[])) {
                return Err(Error::invalid(
                    format!(
                        "`simulate.free.{}` goes to {end}, where nothing can be simulated: {error}",
                        key.key
                    ),
                    "let `from` and `to` hold values that a scenario can have",
                ));
            }
        }
    }
    drive::built(study, &drive::keys(study, free, &start, &[])).map(|_| ())
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
