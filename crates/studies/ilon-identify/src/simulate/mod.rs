//! Fits keys of the scenario by simulation: for each direction of steady drive in a log, the
//! simulated robot drives at the same wheel rates, and the distances are compared.

mod check;
mod config;
mod drive;
mod drive_result;
mod fitting;
mod observations;
mod parameters;
mod phases;
mod profile_likelihood;
mod residuals;
mod steady_drives;

use std::sync::atomic::{AtomicU32, Ordering};

use ilon_sim::Error;
use nalgebra::{DMatrix, Matrix3xX};

pub(crate) use self::check::check;
pub use self::config::{
    BesideFile, CurrentsFile, HeadingFile, Logged, Phases, RippleFile, Simulate,
};
use self::drive::Ready;
use self::fitting::{Fitted, Problem, Rig, shown};
pub(crate) use self::observations::Observations;
use self::parameters::{Free, free_of, start_of};
use self::phases::Starts;
use self::residuals::{Scales, SimulatedLegs};
use self::steady_drives::{Leg, legs};
use crate::least_squares::{Minimum, Search};
use crate::outcome::{Beside, Elsewhere, Simulation, Value};
use crate::study::Study;
use ilon_files::toml::flat;

/// Results of the fit by simulation.
pub(crate) struct SimulationFit {
    pub parameters: Vec<(String, Value)>,
    pub simulation: Simulation,
}

/// Number of sets of initial wheel angles if the log does not contain them.
const SETS: u32 = 8;

/// Fits the free keys of a study to the distances of its runs, and to their ripple if the study
/// asks for it.
pub(crate) fn simulate(
    study: &Study,
    section: &Simulate,
    seen: &Observations<'_>,
    nominal: &Matrix3xX<f64>,
    count: &(dyn Fn(u32) + Sync),
) -> Result<SimulationFit, Error> {
    let free = free_of(section)?;
    let held_out = seen.held_out;
    let (legs, drives) = legs(study, section, seen, nominal);
    let fitted: Vec<&Leg> = legs.iter().filter(|leg| !held_out[leg.run]).collect();
    let scales = Scales::new(section, study, &fitted);
    refuse_what_nothing_determines(section, &free, &fitted, &scales)?;
    refuse_what_cannot_be(study, &free)?;
    let mut wanted: Vec<usize> = fitted.iter().map(|leg| leg.drive).collect();
    wanted.sort_unstable();
    wanted.dedup();

    let rig = Rig {
        study,
        section,
        courses: &drives,
        nominal,
        count,
        simulated: AtomicU32::new(0),
    };
    let (start, search) = search_of(section, &free, &scales.means(&fitted));
    let problem = |starts: Starts| Problem::new(&rig, &free, &scales, (&fitted, &wanted), starts);
    let FromStarts {
        starts,
        fit,
        do_matter,
    } = fit_from_starts(section.phases, problem, &start, &search)?;
    let found = &fit.found;
    let values = shown(&free, &found.values[..free.len()]);
    let at_bounds = at_bounds(&free, found, &search);
    let Ranges {
        parameters,
        open,
        cut_off,
    } = ranges(&free, &values, &fit, &search, &at_bounds);

    let every: Vec<usize> = (0..drives.len()).collect();
    let ready = Ready::new(study, &drive::keys(study, &free, &values, &[]))?;
    let compare = |ready: &Ready| -> Result<SimulatedLegs<'_>, Error> {
        let made = rig.drives(ready, &every, starts)?;
        let of_series = &found.values[free.len()..];
        Ok(SimulatedLegs::new(study, &legs, &made, &scales, of_series))
    };
    let compared = compare(&ready)?;
    let mut beside = Vec::new();
    for other in &section.beside {
        let keys = drive::keys(study, &free, &values, &flat(&other.set));
        let compared = compare(&Ready::new(study, &keys)?)?;
        beside.push(Beside {
            name: other.name.clone(),
            fit: compared.misses(false),
            held_out: compared.misses(true),
            drives: compared.others(),
        });
    }
    let insensitive = insensitive(&free, found, &search);
    let of_one_run = free.iter().zip(&fit.intervals);
    let of_one_run = of_one_run
        .filter(|(free, interval)| interval.low.is_nan() && !insensitive.contains(&free.key))
        .map(|(free, _)| free.key.clone())
        .collect();
    let elsewhere = free.iter().zip(&fit.elsewhere).filter_map(|(free, value)| {
        Some(Elsewhere {
            key: free.key.clone(),
            value: shown(std::slice::from_ref(free), &[(*value)?])[0],
        })
    });
    let elsewhere = elsewhere.collect();
    Ok(SimulationFit {
        parameters,
        simulation: Simulation {
            fit: compared.misses(false),
            held_out: compared.misses(true),
            scale: compared.first_scale,
            has_converged: found.has_converged,
            drives_simulated: rig.simulated.load(Ordering::Relaxed),
            phases: starts.count(),
            phases_matter: do_matter,
            alike: alike(&found.jacobian, &free),
            insensitive,
            open,
            cut_off,
            of_one_run,
            at_bounds,
            elsewhere,
            series: compared.series(study, &drives, nominal),
            drives: compared.drives(study, &drives, nominal),
            beside,
        },
    })
}

/// Rejects fewer directions of motion than keys, and a missing ripple.
fn refuse_what_nothing_determines(
    section: &Simulate,
    free: &[Free],
    fitted: &[&Leg],
    scales: &Scales,
) -> Result<(), Error> {
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
    if let Some(ripple) = &section.ripple
        && fitted.iter().all(|leg| leg.ripple.is_none())
    {
        return Err(Error::invalid(
            format!(
                "no drive that is fitted has a steady stretch of {} s whose ripple could be compared",
                ripple.stretch_s
            ),
            "let `simulate.ripple.stretch_s` be shorter than the drives and as long as 16 rows of the log or more, or leave the section out",
        ));
    }
    Ok(())
}

/// A fit, the initial wheel angles of its drives, and whether they matter, if tested.
struct FromStarts {
    starts: Starts,
    fit: Fitted,
    do_matter: Option<bool>,
}

/// Fits with the initial wheel angles that a study states; by default with those of the robot's
/// file, unless angles matter.
fn fit_from_starts<'a>(
    phases: Option<Phases>,
    problem: impl Fn(Starts) -> Problem<'a>,
    start: &[f64],
    search: &Search,
) -> Result<FromStarts, Error> {
    let fit = |starts: Starts, do_matter: Option<bool>| {
        Ok(FromStarts {
            starts,
            fit: problem(starts).fit(start, search)?,
            do_matter,
        })
    };
    match phases {
        Some(Phases::Logged(Logged::Log)) => fit(Starts::Log, None),
        Some(Phases::Count(1)) => fit(Starts::File, None),
        Some(Phases::Count(count)) => fit(Starts::Sets(count), Some(true)),
        None => match problem(Starts::File).fit_unless_angles_matter(start, search)? {
            Some(known) => Ok(FromStarts {
                starts: Starts::File,
                fit: known,
                do_matter: Some(false),
            }),
            None => fit(Starts::Sets(SETS), Some(true)),
        },
    }
}

/// The fitted keys with their intervals, and those whose interval reaches one or both ends of the
/// searched range.
struct Ranges {
    parameters: Vec<(String, Value)>,
    open: Vec<String>,
    cut_off: Vec<String>,
}

fn ranges(
    free: &[Free],
    values: &[f64],
    fit: &Fitted,
    search: &Search,
    at_bounds: &[String],
) -> Ranges {
    let mut ranges = Ranges {
        parameters: Vec::new(),
        open: Vec::new(),
        cut_off: Vec::new(),
    };
    for (axis, free) in free.iter().enumerate() {
        let mut interval = fit.intervals[axis];
        let (low, high) = search.bounds[axis];
        let rounded = 1e-9 * (high - low);
        let reaches = [
            interval.low <= low + rounded,
            interval.high >= high - rounded,
        ];
        match reaches {
            [true, true] => ranges.open.push(free.key.clone()),
            // For a value at the end of its range this was reported already.
            [true, false] | [false, true] if !at_bounds.contains(&free.key) => {
                ranges.cut_off.push(free.key.clone());
            }
            _ => {}
        }
        // Nothing was tried beyond the ends, where a robot may be impossible; NaN stays NaN.
        interval.low = interval.low.clamp(low, high);
        interval.high = interval.high.clamp(low, high);
        if free.is_log {
            interval.low = libm::exp(interval.low);
            interval.high = libm::exp(interval.high);
        }
        let value = Value::new(values[axis], interval, "", start_of(free));
        ranges.parameters.push((free.key.clone(), value));
    }
    ranges
}

/// Returns the keys whose effect over their whole range is below the noise.
fn insensitive(free: &[Free], found: &Minimum, search: &Search) -> Vec<String> {
    let is_insensitive = |axis: usize| {
        let (low, high) = search.bounds[axis];
        found.jacobian.column(axis).norm() * (high - low) < 1.0
    };
    keys_where(free, is_insensitive)
}

/// Returns the keys whose value is at an end of their range.
fn at_bounds(free: &[Free], found: &Minimum, search: &Search) -> Vec<String> {
    let is_at_bounds = |axis: usize| {
        let (low, high) = search.bounds[axis];
        let margin = 0.005 * (high - low);
        found.values[axis] < low + margin || found.values[axis] > high - margin
    };
    keys_where(free, is_at_bounds)
}

fn keys_where(free: &[Free], of: impl Fn(usize) -> bool) -> Vec<String> {
    let keys = free.iter().enumerate().filter(|(axis, _)| of(*axis));
    keys.map(|(_, free)| free.key.clone()).collect()
}

/// Returns the start and the settings of the search: values of the keys, followed by the scale of
/// each series.
fn search_of(section: &Simulate, free: &[Free], means: &[f64]) -> (Vec<f64>, Search) {
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
    for mean in means {
        start.push(*mean);
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
    (start, search)
}

/// Rejects ranges whose ends give an impossible robot or scenario, before any simulation.
fn refuse_what_cannot_be(study: &Study, free: &[Free]) -> Result<(), Error> {
    let start: Vec<f64> = free.iter().map(start_of).collect();
    for (axis, key) in free.iter().enumerate() {
        for end in [key.low, key.high] {
            let mut values = start.clone();
            values[axis] = end;
            if let Err(error) = Ready::new(study, &drive::keys(study, free, &values, &[])) {
                return Err(Error::invalid(
                    format!(
                        "`simulate.free.{}` reaches {end}, where the simulation fails: {error}",
                        key.key
                    ),
                    "choose `from` and `to` within what a scenario accepts",
                ));
            }
        }
    }
    Ready::new(study, &drive::keys(study, free, &start, &[])).map(|_| ())
}

/// Returns pairs of keys whose effects have a correlation of at least 0.9: the log hardly
/// distinguishes them.
fn alike(jacobian: &DMatrix<f64>, free: &[Free]) -> Vec<[String; 2]> {
    let mut pairs = Vec::new();
    let dot = |a: usize, b: usize| jacobian.row_iter().map(|row| row[a] * row[b]).sum::<f64>();
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
