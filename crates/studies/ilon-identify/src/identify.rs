//! Runs an identification, from the logs of a study to the results.

use std::collections::BTreeMap;

use ilon_robot::Robot;
use ilon_sim::Error;
use nalgebra::{DVector, Matrix3xX};

use crate::checked_logs::{CheckedLogs, fits_delays};
use crate::controller;
use crate::delay::Delay;
use crate::directions::directions;
use crate::kinematic_fit::{Evidence, Fitted, Noise, fit};
use crate::log::anomalies::anomaly;
use crate::log::{AnomalyKind, Log};
use crate::model::{Model, Parameter, is_held};
use crate::model_choice::{choose, end, judge, judged_by, matrix_of, trackers_of};
use crate::motion::{Tracker, Window, reckoned};
use crate::outcome::{
    Controller, Errors, HeldParameter, Identified, Judged, JudgedBy, NoiseFigures, Run, RunDoubt,
    Series, SteadyDrive, Value,
};
use crate::scatter::Scatter;
use crate::simulate::{Observations, SimulationFit, simulate};
use crate::steered::is_steered;
use crate::study::{ModelFile, Study};

/// Progress of an identification.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// Reading logs.
    Reading,
    /// Fitting a model of the kinematics, with its name.
    Fitting(String),
    /// Simulating drives, with the number so far.
    Simulating(u32),
}

/// Fits all free parameters of a study.
///
/// # Errors
/// If a log cannot be read, differs from its stated format, or does not contain enough motion.
pub fn identify(study: &Study, progress: &(dyn Fn(Progress) + Sync)) -> Result<Identified, Error> {
    progress(Progress::Reading);
    let checked = CheckedLogs::read(study)?;
    let candidates = Candidates::judge(study, &checked, progress)?;
    let kinematics = Kinematics::of(study, &checked, &candidates)?;
    let mut outcome = outcome(study, &checked, &candidates, &kinematics)?;
    if let Some(section) = &study.file.simulate {
        let count = |count: u32| progress(Progress::Simulating(count));
        let all = checked.evidence.all();
        let seen = Observations {
            windows: &all,
            held_out: &checked.evidence.held_out,
            trackers: &kinematics.trackers,
            logs: &checked.logs,
        };
        let found = simulate(study, section, &seen, &kinematics.nominal, &count)?;
        add_simulated(&mut outcome, found);
    }
    Ok(outcome)
}

/// A fitted model of the kinematics, with its errors on fitted and on held-out data.
type FittedModel = (Fitted, Errors, Errors);

/// All models of the kinematics that were fitted.
struct Candidates {
    files: Vec<ModelFile>,
    fits: Vec<FittedModel>,
    /// Index of the chosen one.
    chosen: usize,
    /// The robot with its nominal values.
    nominal: FittedModel,
    judged_by: JudgedBy,
}

impl Candidates {
    fn judge(
        study: &Study,
        checked: &CheckedLogs,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<Self, Error> {
        let CheckedLogs {
            logs,
            evidence,
            noise,
            ..
        } = checked;
        let judged_by = judged_by(evidence, &evidence.kept_back());
        let mut files = models(study);
        let mut fits = Vec::new();
        for model in &files {
            progress(Progress::Fitting(model.name.clone()));
            fits.push(judge(study, model, evidence, *noise, logs, judged_by)?);
        }
        let is_off = |(_, _, held_out): &FittedModel| held_out.over_noise > FAR_OFF;
        if study.file.models.is_empty() && is_off(&fits[choose(&fits)]) {
            let model = model("each wheel's axis", &["radius_m", "lever_m", "axis_deg.*"]);
            progress(Progress::Fitting(model.name.clone()));
            fits.push(judge(study, &model, evidence, *noise, logs, judged_by)?);
            files.push(model);
        }
        Ok(Self {
            chosen: choose(&fits),
            nominal: judge(study, &nominal_model(), evidence, *noise, logs, judged_by)?,
            files,
            fits,
            judged_by,
        })
    }

    fn chosen(&self) -> &FittedModel {
        &self.fits[self.chosen]
    }
}

/// The maps from wheel rates to twists and from the robot's poses to tracked ones.
struct Kinematics {
    /// Map of the nominal robot.
    nominal: Matrix3xX<f64>,
    /// Map of the chosen model.
    fitted: Matrix3xX<f64>,
    /// Tracker of each run.
    trackers: Vec<Tracker>,
}

impl Kinematics {
    fn of(study: &Study, checked: &CheckedLogs, candidates: &Candidates) -> Result<Self, Error> {
        let (chosen, ..) = candidates.chosen();
        Ok(Self {
            fitted: matrix_of(chosen)?,
            nominal: matrix_of(&candidates.nominal.0)?,
            trackers: trackers_of(study, chosen, &checked.evidence, checked.noise)?,
        })
    }
}

/// Builds the results of the kinematics alone.
fn outcome(
    study: &Study,
    checked: &CheckedLogs,
    candidates: &Candidates,
    kinematics: &Kinematics,
) -> Result<Identified, Error> {
    let (evidence, noise) = (&checked.evidence, checked.noise);
    let (fitted, fit_errors, held_out_errors) = candidates.chosen();
    let valued = valued(fitted, &study.unsteered.robot);
    let mut parameters = by_name(&valued, &study.unsteered.robot, |_| true);
    parameters.extend(fitted_delays(study, checked));
    let all_gains = fit_gains(study, evidence, noise, &evidence.fitted())?;
    let gains = controller::gains(&study.unsteered.robot, &all_gains);
    Ok(Identified {
        study: study.name(),
        ilon: env!("CARGO_PKG_VERSION").to_owned(),
        model: candidates.files[candidates.chosen].name.clone(),
        parameters,
        derived: derived(fitted),
        controller: Controller {
            kind: controller::kind(&fitted.model.robot(&fitted.values)),
            ..controller::controller(&study.unsteered.robot, &gains, &valued)
        },
        gains,
        held: held(fitted, &study.unsteered.robot),
        fit: *fit_errors,
        held_out: *held_out_errors,
        judged_by: candidates.judged_by,
        window_s: study.file.window_s,
        nominal: candidates.nominal.2,
        models: candidates
            .files
            .iter()
            .zip(&candidates.fits)
            .map(|(file, (fitted, fit, held_out))| Judged {
                name: file.name.clone(),
                parameters: of_robot(fitted, &study.unsteered.robot),
                held: held(fitted, &study.unsteered.robot),
                fit: *fit,
                held_out: *held_out,
            })
            .collect(),
        residual: directions(
            &evidence.all(),
            &study.unsteered.robot,
            &kinematics.nominal,
            &kinematics.fitted,
            &kinematics.trackers,
            study.file.window_s,
        ),
        series: series(study, evidence, noise)?,
        runs: runs(study, &checked.logs, kinematics),
        noise: NoiseFigures {
            position_m: noise.position_m,
            heading_rad: noise.heading_rad,
            left_out: checked.left_out,
        },
        intervals_over: if fitted.over_runs {
            "runs"
        } else {
            "stretches"
        }
        .to_owned(),
        intervals_count: fitted.scatter.as_ref().map_or(0, Scatter::count),
        doubts: (checked.doubts.iter().cloned())
            .chain(contradiction(fitted, evidence))
            .collect(),
        is_held: is_held(&study.unsteered.robot),
        simulated_keys: Vec::new(),
        simulation: None,
    })
}

/// Returns a doubt about steered wheels that contradict each other by the fitted model too.
fn contradiction(fitted: &Fitted, evidence: &Evidence) -> Option<RunDoubt> {
    /// Tyres that scrub contradict each other by less than a hundredth of their ways. Chosen.
    const MUCH: f64 = 0.05;
    let apart = fitted.model.contradiction(&fitted.values)?;
    let robot = fitted.model.robot(&fitted.values);
    let (mut off, mut all) = (0.0, 0.0);
    for window in &evidence.windows {
        let turned = DVector::from_column_slice(&window.turned_rad);
        let ways = turned.iter().zip(&robot.wheels);
        all += ways
            .map(|(rad, wheel)| (rad * wheel.radius_m).powi(2))
            .sum::<f64>();
        off += (&apart * turned).norm_squared();
    }
    let share = (off / all).sqrt();
    (share > MUCH).then(|| RunDoubt {
        file: "all runs".to_owned(),
        doubt: anomaly(
            AnomalyKind::Wiring,
            false,
            format!(
                "by this model the wheels contradict each other by {:.0} % of their ways",
                100.0 * share
            ),
            "a column of a wheel or of its steering may be that of another module, or modules slide; nothing fitted here holds before that is repaired",
        ),
    })
}

/// Returns the fitted delays of the poses behind the wheels.
fn fitted_delays(study: &Study, checked: &CheckedLogs) -> BTreeMap<String, Value> {
    if !fits_delays(study) {
        return BTreeMap::new();
    }
    let of = |(series, delay): &(String, Delay)| {
        let name = match series.as_str() {
            "" => "tracker.delay_s".to_owned(),
            series => format!("tracker.delay_s.{series}"),
        };
        (name, Value::new(delay.value_s, delay.interval, "s", 0.0))
    };
    checked.delays.iter().map(of).collect()
}

/// Adds the results of the simulation.
fn add_simulated(outcome: &mut Identified, found: SimulationFit) {
    for (key, value) in found.parameters {
        outcome.simulated_keys.push(key.clone());
        outcome.parameters.insert(key, value);
    }
    for direction in &mut outcome.residual {
        let apart = |drive: &&SteadyDrive| apart_deg(drive.direction_deg, direction.direction_deg);
        let drives = found.simulation.drives.iter();
        let near = drives.min_by(|a, b| apart(a).total_cmp(&apart(b)));
        direction.simulated = near
            .filter(|drive| apart(drive) < NEAR_DEG)
            .map(|drive| drive.simulated * found.simulation.scale);
    }
    outcome.simulation = Some(found.simulation);
}

/// Directions no further apart than this count as one, in degrees.
const NEAR_DEG: f64 = 4.0;

fn apart_deg(a: f64, b: f64) -> f64 {
    let apart = (a - b).rem_euclid(360.0);
    apart.min(360.0 - apart)
}

fn nominal_model() -> ModelFile {
    ModelFile {
        name: "nominal values".to_owned(),
        free: Vec::new(),
    }
}

/// If all models miss by this many times the noise, wheels may not be at their stated places.
const FAR_OFF: f64 = 20.0;

fn model(name: &str, free: &[&str]) -> ModelFile {
    ModelFile {
        name: name.to_owned(),
        free: free.iter().map(|name| (*name).to_owned()).collect(),
    }
}

/// Returns the models of a study, by default those that suit any robot.
fn models(study: &Study) -> Vec<ModelFile> {
    if !study.file.models.is_empty() {
        return study.file.models.clone();
    }
    let mut models = vec![
        nominal_model(),
        model("radius and lever", &["radius_m", "lever_m"]),
        model("gains by direction", gains_of(study)),
        model("each wheel's radius and lever", &["radius_m.*", "lever_m"]),
    ];
    if is_steered(&study.robot) {
        let free = ["radius_m", "lever_m", "steering_deg.*"];
        models.push(model("radius, lever and steering angles", &free));
        let free = ["radius_m.*", "lever_m", "steering_deg.*"];
        let name = "each wheel's radius and steering angle, and lever";
        models.push(model(name, &free));
    }
    models
}

/// The gains that a robot has: none sideways on tyres.
fn gains_of(study: &Study) -> &'static [&'static str] {
    match is_held(&study.unsteered.robot) {
        true => &["gain.ahead", "gain.turn"],
        false => &["gain.ahead", "gain.sideways", "gain.turn"],
    }
}

fn held(fitted: &Fitted, robot: &Robot) -> Vec<HeldParameter> {
    fitted
        .held
        .iter()
        .map(|(parameter, why)| HeldParameter {
            name: parameter.name(robot),
            value: parameter.nominal(robot),
            why: why.clone(),
        })
        .collect()
}

/// Returns the fitted parameters of a model with their values.
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

/// Returns the fitted parameters of a model without those of the tracker.
fn of_robot(fitted: &Fitted, robot: &Robot) -> BTreeMap<String, Value> {
    let is_of_robot = |parameter: &Parameter| !parameter.is_of_tracker();
    by_name(&valued(fitted, robot), robot, is_of_robot)
}

/// Returns ratios that hold even if a common scale is unknown.
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

/// Fits gains by direction to windows, and their ratios, as far as the windows determine them.
fn fit_gains(
    study: &Study,
    evidence: &Evidence,
    noise: Noise,
    windows: &[&Window],
) -> Result<BTreeMap<String, Value>, Error> {
    let names: Vec<String> = gains_of(study)
        .iter()
        .map(|name| (*name).to_owned())
        .collect();
    let series = evidence.series_of(windows);
    let model =
        Model::new(&study.unsteered.robot, &names)?.with_tracker(&study.file.tracker, &series);
    let fitted = fit(&model, evidence, windows, noise)?;
    let mut gains = of_robot(&fitted, &study.unsteered.robot);
    gains.extend(derived(&fitted));
    Ok(gains)
}

/// Returns the gains of each series separately.
fn series(study: &Study, evidence: &Evidence, noise: Noise) -> Result<Vec<Series>, Error> {
    let of = |name: &String| -> Result<Series, Error> {
        let windows = evidence.of_series(name);
        Ok(Series {
            name: name.clone(),
            gains: fit_gains(study, evidence, noise, &windows)?,
        })
    };
    evidence.series_of(&evidence.all()).iter().map(of).collect()
}

fn runs(study: &Study, logs: &[Log], kinematics: &Kinematics) -> Vec<Run> {
    let Kinematics {
        nominal,
        fitted,
        trackers,
    } = kinematics;
    let one = |(run, log): (usize, &Log)| {
        let file = &study.file.runs[run];
        let path_m = reckoned(log, nominal, &Tracker::default())
            .windows(2)
            .map(|pair| libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]))
            .sum();
        let (end_position_m, end_heading_rad) = end(log, fitted, &trackers[run]);
        Run {
            file: file.file.display().to_string(),
            held_out: file.held_out,
            duration_s: log.duration_s(),
            path_m,
            end_position_nominal_m: end(log, nominal, &trackers[run]).0,
            end_position_m,
            end_heading_rad,
        }
    };
    logs.iter().enumerate().map(one).collect()
}
