//! A study from its logs to what was found.

use std::collections::BTreeMap;

use ilon_robot::Robot;
use ilon_sim::Error;
use nalgebra::Matrix3xX;

use crate::controller;
use crate::delay;
use crate::directions::directions;
use crate::kinematic_fit::{Evidence, Fitted, Noise, fit, take_noise};
use crate::log::{Delayed, Kind, Log, anomalies, wiring};
use crate::model::{Model, Parameter};
use crate::model_choice::{choose, end, judge, judged_by, matrix_of, trackers_of};
use crate::motion::{Tracker, Window, reckoned, windows};
use crate::outcome::{
    Drive, Errors, Held, Identified, Judged, NoiseFigures, Run, RunDoubt, Series, Value,
};
use crate::read_logs::{delays, read, refuse};
use crate::scatter::Scatter;
use crate::simulate::{Observations, simulate};
use crate::study::{ModelFile, Study};

/// How far an identification is.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// Logs are read.
    Reading,
    /// A model of the kinematics is fitted.
    Fitting(String),
    /// Runs are simulated: so many so far.
    Simulating(u32),
}

/// Fits all that a study leaves free.
///
/// # Errors
/// Where a log cannot be read, is not what it is stated to be, or does not say enough.
pub fn identify(study: &Study, progress: &(dyn Fn(Progress) + Sync)) -> Result<Identified, Error> {
    progress(Progress::Reading);
    let mut logs = read(study)?;
    let mut evidence = Evidence {
        windows: Vec::new(),
        series: study
            .file
            .runs
            .iter()
            .map(|run| run.series.clone())
            .collect(),
        held_out: study.file.runs.iter().map(|run| run.held_out).collect(),
    };
    let mut odd: Vec<RunDoubt> = Vec::new();
    for (run, log) in logs.iter().enumerate() {
        for doubt in anomalies::of_rows(log, &study.robot) {
            refuse(study, run, &doubt)?;
            odd.push(RunDoubt {
                file: study.file.runs[run].file.display().to_string(),
                doubt,
            });
        }
        let found = windows(log, run, study.file.window_s);
        if found.len() < FEWEST_WINDOWS {
            return Err(crate::log::fault(
                &study.resolve(&study.file.runs[run].file),
                format!(
                    "it holds {} stretches of {} s in which wheels turn, which is too few",
                    found.len(),
                    study.file.window_s
                ),
                "drive for longer, or compare shorter stretches: `window_s`",
            ));
        }
        evidence.windows.extend(found);
    }
    // A single run may not move enough ways for that; runs of a series are wired alike.
    let all: Vec<&Window> = evidence.windows.iter().collect();
    for series in evidence.series_of(&all) {
        let of_series: Vec<&Window> = all
            .iter()
            .copied()
            .filter(|window| evidence.series[window.run] == series)
            .collect();
        if let (Some(first), Some(doubt)) = (
            of_series.first(),
            wiring::of_motion(&of_series, &study.robot),
        ) {
            let doubt = match doubt.kind {
                // Neither wheels nor the tracker's hand: one of its axes alone may be otherwise, which displacements do not show.
                Kind::Unexplained | Kind::Wiring => {
                    let runs: Vec<&Log> = logs
                        .iter()
                        .zip(&evidence.series)
                        .filter(|(_, of)| **of == series)
                        .map(|(log, _)| log)
                        .collect();
                    let axis = wiring::of_axes(&runs, &study.robot, study.file.window_s);
                    axis.unwrap_or(doubt)
                }
                _ => doubt,
            };
            refuse(study, first.run, &doubt)?;
        }
    }
    let delays = delays(study, &logs)?;
    for (series, delay) in &delays {
        let of_series = |run: &usize| evidence.series[*run] == *series;
        let runs: Vec<usize> = (0..logs.len()).filter(of_series).collect();
        match (study.file.log.delay_s, runs.first()) {
            (Some(Delayed::Fitted(_)), _) => {
                for run in runs {
                    logs[run] = delay::shifted(&logs[run], delay.value_s);
                }
            }
            (None, Some(first)) if delay.is_shown => odd.push(RunDoubt {
                file: study.file.runs[*first].file.display().to_string(),
                doubt: anomalies::anomaly(
                    Kind::Delay,
                    false,
                    format!(
                        "the poses come {} s after the wheels ({} to {} s)",
                        anomalies::shown(delay.value_s),
                        anomalies::shown(delay.interval.low),
                        anomalies::shown(delay.interval.high)
                    ),
                    "two clocks, or a tracker that takes its time: `delay_s = \"fit\"` in `[log]` takes it out",
                ),
            }),
            _ => {}
        }
    }
    if matches!(study.file.log.delay_s, Some(Delayed::Fitted(_))) {
        evidence.windows = logs
            .iter()
            .enumerate()
            .flat_map(|(run, log)| windows(log, run, study.file.window_s))
            .collect();
    }
    let (noise, left_out) = take_noise(&mut evidence);
    let fitted_windows = evidence.fitted();
    if fitted_windows.is_empty() {
        return Err(Error::invalid(
            "nothing is left to fit: all stretches were outliers",
            "look at the logs, and compare longer stretches: `window_s`",
        ));
    }

    let listed = models(study);
    let mut tried: Vec<(Fitted, Errors, Errors)> = Vec::new();
    let kept_back = evidence.kept_back();
    let judged_by = judged_by(&evidence, &kept_back);
    for model in &listed {
        progress(Progress::Fitting(model.name.clone()));
        tried.push(judge(study, model, &evidence, noise, &logs, judged_by)?);
    }
    let chosen = choose(&tried);
    let nominal = judge(study, &nominal_model(), &evidence, noise, &logs, judged_by)?;

    let (fitted, fit_errors, held_out_errors) = &tried[chosen];
    let matrix = matrix_of(fitted)?;
    let own = matrix_of(&nominal.0)?;
    let trackers = trackers_of(study, fitted, &evidence, noise)?;
    let valued = valued(fitted, &study.robot);
    let mut parameters = by_name(&valued, &study.robot, |_| true);
    if matches!(study.file.log.delay_s, Some(Delayed::Fitted(_))) {
        for (series, delay) in &delays {
            let name = match series.as_str() {
                "" => "tracker.delay_s".to_owned(),
                series => format!("tracker.delay_s.{series}"),
            };
            parameters.insert(name, Value::new(delay.value_s, delay.interval, "s", 0.0));
        }
    }
    let all_gains = fit_gains(study, &evidence, noise, &fitted_windows)?;
    let gains = controller::gains(&study.robot, &all_gains);
    let mut outcome = Identified {
        study: study.name(),
        ilon: env!("CARGO_PKG_VERSION").to_owned(),
        model: listed[chosen].name.clone(),
        parameters,
        derived: derived(fitted),
        controller: controller::controller(&study.robot, &gains, &valued),
        gains,
        held: held(fitted, &study.robot),
        fit: *fit_errors,
        held_out: *held_out_errors,
        judged_by,
        nominal: nominal.2,
        models: listed
            .iter()
            .zip(&tried)
            .map(|(file, (fitted, fit, held_out))| Judged {
                name: file.name.clone(),
                parameters: of_robot(fitted, &study.robot),
                held: held(fitted, &study.robot),
                fit: *fit,
                held_out: *held_out,
            })
            .collect(),
        residual: directions(
            &all_windows(&evidence),
            &study.robot,
            &own,
            &matrix,
            &trackers,
            study.file.window_s,
        ),
        series: series(study, &evidence, noise)?,
        runs: runs(study, &logs, &own, &matrix, &trackers),
        noise: NoiseFigures {
            position_m: noise.position_m,
            heading_rad: noise.heading_rad,
            left_out,
        },
        intervals_over: if fitted.over_runs {
            "runs"
        } else {
            "stretches"
        }
        .to_owned(),
        intervals_count: fitted.scatter.as_ref().map_or(0, Scatter::count),
        doubts: odd,
        simulated_keys: Vec::new(),
        simulation: None,
    };
    if let Some(section) = &study.file.simulate {
        let count = |count: u32| progress(Progress::Simulating(count));
        let all = all_windows(&evidence);
        let seen = Observations {
            windows: &all,
            held_out: &evidence.held_out,
            trackers: &trackers,
            logs: &logs,
        };
        let found = simulate(study, section, &seen, &own, &count)?;
        for (key, value) in found.parameters {
            outcome.simulated_keys.push(key.clone());
            outcome.parameters.insert(key, value);
        }
        for direction in &mut outcome.residual {
            let near = found.simulation.drives.iter().min_by(|a, b| {
                let apart = |drive: &Drive| apart_deg(drive.direction_deg, direction.direction_deg);
                apart(a).total_cmp(&apart(b))
            });
            let near =
                near.filter(|drive| apart_deg(drive.direction_deg, direction.direction_deg) < 4.0);
            direction.simulated = near.map(|drive| drive.simulated * found.simulation.scale);
        }
        outcome.simulation = Some(found.simulation);
    }
    Ok(outcome)
}

fn apart_deg(a: f64, b: f64) -> f64 {
    let apart = (a - b).rem_euclid(360.0);
    apart.min(360.0 - apart)
}

/// Fewer stretches of a run than this say nothing.
const FEWEST_WINDOWS: usize = 4;

fn all_windows(evidence: &Evidence) -> Vec<&Window> {
    evidence.windows.iter().collect()
}

fn nominal_model() -> ModelFile {
    ModelFile {
        name: "as it is known".to_owned(),
        free: Vec::new(),
    }
}

/// The models of a study, or those that fit any robot.
fn models(study: &Study) -> Vec<ModelFile> {
    if !study.file.models.is_empty() {
        return study.file.models.clone();
    }
    let model = |name: &str, free: &[&str]| ModelFile {
        name: name.to_owned(),
        free: free.iter().map(|name| (*name).to_owned()).collect(),
    };
    vec![
        nominal_model(),
        model("radius and lever", &["radius_m", "lever_m"]),
        model(
            "gains by direction",
            &["gain.ahead", "gain.sideways", "gain.turn"],
        ),
        model("each wheel's radius and lever", &["radius_m.*", "lever_m"]),
    ]
}

fn held(fitted: &Fitted, robot: &Robot) -> Vec<Held> {
    fitted
        .held
        .iter()
        .map(|(parameter, why)| Held {
            name: parameter.name(robot),
            value: parameter.nominal(robot),
            why: why.clone(),
        })
        .collect()
}

/// Each parameter of a model that was fitted, with its value.
fn valued(fitted: &Fitted, robot: &Robot) -> Vec<(Parameter, Value)> {
    let values = fitted.values.iter().zip(fitted.intervals());
    let parameters = fitted.model.parameters.iter().zip(values);
    parameters
        .map(|(parameter, (value, interval))| {
            let nominal = parameter.nominal(robot);
            let value = Value::new(*value, interval, parameter.unit(), nominal);
            (parameter.clone(), value)
        })
        .collect()
}

fn by_name(
    values: &[(Parameter, Value)],
    robot: &Robot,
    of: impl Fn(&Parameter) -> bool,
) -> BTreeMap<String, Value> {
    let chosen = values.iter().filter(|(parameter, _)| of(parameter));
    chosen
        .map(|(parameter, value)| (parameter.name(robot), value.clone()))
        .collect()
}

/// The parameters of a model that was fitted, those of the tracker left out.
fn of_robot(fitted: &Fitted, robot: &Robot) -> BTreeMap<String, Value> {
    let is_of_robot = |parameter: &Parameter| !parameter.is_of_tracker();
    by_name(&valued(fitted, robot), robot, is_of_robot)
}

/// Ratios that hold even where a common scale is not known.
fn derived(fitted: &Fitted) -> BTreeMap<String, Value> {
    let place = |wanted: &Parameter| {
        let mut parameters = fitted.model.parameters.iter();
        parameters.position(|parameter| parameter == wanted)
    };
    let mut derived = BTreeMap::new();
    let ratios = [
        (
            "sideways_over_ahead",
            Parameter::GainSideways,
            Parameter::GainAhead,
        ),
        ("turn_over_ahead", Parameter::GainTurn, Parameter::GainAhead),
    ];
    for (name, above, below) in ratios {
        if let (Some(above), Some(below)) = (place(&above), place(&below)) {
            let ratio = |a: f64, b: f64| a / b;
            let (a, b) = (fitted.values[above], fitted.values[below]);
            let interval = fitted
                .scatter
                .as_ref()
                .map(|scatter| scatter.interval(|step| ratio(a + step[above], b + step[below])));
            let interval = interval.unwrap_or_default();
            derived.insert(name.to_owned(), Value::new(ratio(a, b), interval, "", 1.0));
        }
    }
    derived
}

/// Gains by direction of some stretches, and their ratios, as far as they determine them.
fn fit_gains(
    study: &Study,
    evidence: &Evidence,
    noise: Noise,
    windows: &[&Window],
) -> Result<BTreeMap<String, Value>, Error> {
    let names = ["gain.ahead", "gain.sideways", "gain.turn"].map(str::to_owned);
    let series = evidence.series_of(windows);
    let model = Model::new(&study.robot, &names)?.with_tracker(&study.file.tracker, &series);
    let fitted = fit(&model, evidence, windows, noise)?;
    let mut gains = of_robot(&fitted, &study.robot);
    gains.extend(derived(&fitted));
    Ok(gains)
}

/// The gains of each series by itself.
fn series(study: &Study, evidence: &Evidence, noise: Noise) -> Result<Vec<Series>, Error> {
    let all = all_windows(evidence);
    let of = |name: &String| -> Result<Series, Error> {
        let windows: Vec<&Window> = all
            .iter()
            .copied()
            .filter(|window| evidence.series[window.run] == *name)
            .collect();
        Ok(Series {
            name: name.clone(),
            gains: fit_gains(study, evidence, noise, &windows)?,
        })
    };
    evidence.series_of(&all).iter().map(of).collect()
}

fn runs(
    study: &Study,
    logs: &[Log],
    own: &Matrix3xX<f64>,
    matrix: &Matrix3xX<f64>,
    trackers: &[Tracker],
) -> Vec<Run> {
    let one = |(run, log): (usize, &Log)| {
        let file = &study.file.runs[run];
        let path_m = reckoned(log, own, &Tracker::default())
            .windows(2)
            .map(|pair| libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]))
            .sum();
        let (end_position_m, end_heading_rad) = end(log, matrix, &trackers[run]);
        Run {
            file: file.file.display().to_string(),
            held_out: file.held_out,
            duration_s: log.duration_s(),
            path_m,
            end_position_nominal_m: end(log, own, &trackers[run]).0,
            end_position_m,
            end_heading_rad,
        }
    };
    logs.iter().enumerate().map(one).collect()
}
