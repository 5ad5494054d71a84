//! Calibration by tape measure and protractor: only the end of each run is measured, each
//! measurement with its own uncertainty.
//!
//! Wheels that turn by dq at constant ratios take the robot along one screw motion: it ends at
//! `exp(J dq)` from its start, and the measured values (x, y, heading) are fitted by least squares,
//! each over its standard error. The inverse of the information matrix J^T J is the covariance, and
//! shows which further drive would distinguish the parameters.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use ilon_control::Kinematics;
use ilon_files::FileAccess;
use ilon_files::defaults::thousandths;
use ilon_robot::{Pose, Robot, Twist};
use ilon_sim::Error;
use ilon_sim::scenario::{read_text, read_toml};
use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};
use toml::Table;

use crate::controller::{kind, rigid};
use crate::kinematic_fit::search_of;
use crate::least_squares::least_squares;
use crate::model::{Model, Parameter, is_held};
use crate::outcome::{Controller, HeldParameter, Value};
use crate::scatter::Interval;
use crate::study::robot_of;

/// Runs that were measured by tape, as they stand in a file. Paths are relative to it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "TapeStudy")]
pub struct TapeFile {
    /// The robot before the fit, with its nominal values.
    pub robot: PathBuf,
    /// Keys of `[robot]` where its file needs more to be read.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: Table,
    /// What is free: parameters of a model of the kinematics.
    #[serde(default = "radius_and_lever")]
    pub free: Vec<String>,
    /// The runs, each from rest at x = y = heading = 0.
    pub measured: Vec<MeasuredRun>,
}

fn radius_and_lever() -> Vec<String> {
    ["radius_m", "lever_m"].map(str::to_owned).to_vec()
}

/// One run: what its wheels turned or what was commanded, and where it ended. What was not measured
/// is left out.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredRun {
    /// What each wheel turned, by the names of the joints, in radians.
    #[serde(default)]
    pub wheels: BTreeMap<String, f64>,
    /// In place of `wheels`: the twist that was commanded, and for how long, by a controller that
    /// uses the nominal values.
    pub drive: Option<Drive>,
    /// Where it ended along its first x axis, in metres.
    pub x_m: Option<f64>,
    /// Along its first y axis, in metres.
    pub y_m: Option<f64>,
    /// How it is turned, in degrees; full turns need not be counted.
    pub heading_deg: Option<f64>,
    /// Standard error of `x_m` and `y_m`, in metres.
    #[serde(default = "thousandths::<2>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub error_m: f64,
    /// Standard error of `heading_deg`, in degrees.
    #[serde(default = "thousandths::<500>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub error_deg: f64,
}

/// A steady motion in the body frame.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Speed ahead, in m/s.
    #[serde(default)]
    pub vx_m_s: f64,
    /// Speed to the left, in m/s.
    #[serde(default)]
    pub vy_m_s: f64,
    /// Yaw rate, in rad/s.
    #[serde(default)]
    pub omega_rad_s: f64,
    /// How long, in seconds.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub for_s: f64,
}

/// Runs with their robot.
#[derive(Clone, Debug)]
pub struct Tape {
    /// The file.
    pub path: PathBuf,
    /// Content of the file.
    pub file: TapeFile,
    /// The robot before the fit, with its nominal values.
    pub robot: Robot,
}

/// Results of the fit.
#[derive(Clone, Debug, Serialize)]
pub struct TapeFit {
    /// The file's name.
    pub study: String,
    /// The version of ilon.
    pub ilon: String,
    /// The free parameters, by name.
    pub parameters: BTreeMap<String, Value>,
    /// Parameters that the runs do not determine; they were held at the robot's own value.
    pub held: Vec<HeldParameter>,
    /// Settings for a controller.
    pub controller: Controller,
    /// Motion ahead, sideways and of rotation by the rollers that touch, over that of the robot's
    /// matrix, if the runs are explained with it and not without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rollers: Option<[f64; 3]>,
    /// Residual of each measured value over its standard error, one row per run: x, y, heading.
    pub misses: Vec<[Option<f64>; 3]>,
    /// Root mean square of the residuals, over the remaining degrees of freedom: 1 if the stated
    /// errors are right. Above 1 the intervals are widened by it.
    pub over_errors: Option<f64>,
    /// Further drives, with the standard errors that three runs of each would leave.
    pub next: Vec<NextDrive>,
}

/// A proposed drive and its benefit.
#[derive(Clone, Debug, Serialize)]
pub struct NextDrive {
    /// Description of the drive.
    pub drive: String,
    /// The standard error of each free parameter after three more such runs, in its unit.
    pub errors: BTreeMap<String, f64>,
}

/// Measurements of a run: the rotation of its wheels, and each value with its standard error.
struct Seen {
    turned_rad: Vec<f64>,
    numbers: [Option<(f64, f64)>; 3],
}

/// Runs of each proposed drive.
const REPEATED: f64 = 3.0;

impl Tape {
    /// Reads runs measured by tape; `None` if the file is a study of logs instead.
    ///
    /// # Errors
    /// If the file or its robot cannot be read, or a run has no measurement.
    pub fn load_within(path: &Path, files: &FileAccess) -> Result<Option<Self>, Error> {
        Self::from_toml(&read_text(path, files)?, path, files)
    }

    /// Reads them from the text of a file, with relative paths of the file at `path`.
    ///
    /// # Errors
    /// Like [`Self::load_within`].
    pub fn from_toml(text: &str, path: &Path, files: &FileAccess) -> Result<Option<Self>, Error> {
        let is_tape = |table: Table| table.contains_key("measured");
        if !toml::from_str(text).is_ok_and(is_tape) {
            return Ok(None);
        }
        let file: TapeFile = read_toml(text, path)?;
        let robot = robot_of(&file.robot, &file.set, path, files)?;
        Ok(Some(Self {
            path: path.to_owned(),
            file,
            robot,
        }))
    }

    /// Its name: that of its file, without the extension.
    pub fn name(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// All files that it reads.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        vec![self.path.clone(), folder.join(&self.file.robot)]
    }

    /// Fits the free parameters by the ideal kinematics, or by the mean kinematics of the rollers
    /// that touch where only that explains the runs.
    ///
    /// # Errors
    /// An unknown parameter, a run without measurement, a length not in metres, and a robot that
    /// cannot be moved.
    pub fn fit(&self) -> Result<TapeFit, Error> {
        /// Runs that miss a fit by more times their stated errors are not explained. Chosen.
        const UNEXPLAINED: f64 = 2.0;
        let ideal = self.fit_with(None)?;
        let has_gains = self.file.free.iter().any(|name| name.starts_with("gain."));
        let (Some(over), false) = (ideal.over_errors, has_gains) else {
            return Ok(ideal);
        };
        if over <= UNEXPLAINED {
            return Ok(ideal);
        }
        let Some(rollers) = rigid(&self.robot) else {
            return Ok(ideal);
        };
        let by_contacts = self.fit_with(Some(rollers))?;
        let explains = by_contacts
            .over_errors
            .is_some_and(|by_contacts| by_contacts < 0.5 * over);
        Ok(if explains { by_contacts } else { ideal })
    }

    fn fit_with(&self, rollers: Option<[f64; 3]>) -> Result<TapeFit, Error> {
        let known = Kinematics::new(&self.robot)?;
        let runs = self.file.measured.iter().enumerate();
        let seen: Vec<Seen> = runs
            .map(|(index, run)| self.seen(index, run, &known))
            .collect::<Result<_, _>>()?;
        let [ahead, sideways, turn] = rollers.unwrap_or([1.0; 3]);
        let whole = Model::new(&self.robot, &self.file.free)?.with_gains([ahead, sideways, turn]);
        let (model, held) = determined(&whole, &seen, &self.robot);
        let residuals = |values: &[f64]| Ok(misses(&model, values, &seen).map(|of| flat(&of)));
        let found = least_squares(&residuals, &model.nominal(), &search_of(&model))?;
        must_be_lengths(&model, &found.values, &self.robot)?;
        let left = misses(&model, &found.values, &seen).unwrap_or_default();
        let free = flat(&left).len() as i64 - found.values.len() as i64;
        let over_errors = (free > 0).then(|| (found.residuals.norm_squared() / free as f64).sqrt());
        let normal = found.jacobian.transpose() * &found.jacobian;
        let covariance = normal.try_inverse();
        let half = |axis: usize| match &covariance {
            Some(covariance) => half_width(covariance[(axis, axis)].sqrt(), over_errors, free),
            None => f64::NAN,
        };
        let valued = model.parameters.iter().zip(&found.values).enumerate();
        let valued: Vec<(Parameter, Value)> = valued
            .map(|(axis, (parameter, value))| {
                let interval = Interval::around(*value, half(axis));
                let nominal = parameter.nominal(&self.robot);
                let value = Value::new(*value, interval, parameter.unit(), nominal);
                (parameter.clone(), value)
            })
            .collect();
        let value_of = |wanted: &Parameter| {
            let mut valued = valued.iter();
            valued.find(|(of, _)| of == wanted).map(|of| of.1.clone())
        };
        Ok(TapeFit {
            study: self.name(),
            ilon: env!("CARGO_PKG_VERSION").to_owned(),
            // A controller does not know the rollers: its lengths have what they take.
            controller: Controller {
                kind: kind(&model.robot(&found.values)),
                radius_m: value_of(&Parameter::Radius).map(|of| scaled(&of, ahead)),
                lever_m: value_of(&Parameter::Lever).map(|of| scaled(&of, ahead / turn)),
                gamma_deg: value_of(&Parameter::Gamma),
                sideways_factor: rollers.map(|_| {
                    let factor = ahead / sideways;
                    Value::new(factor, Interval::around(factor, 0.0), "", 1.0)
                }),
                ..Controller::default()
            },
            rollers,
            next: next_drives(&whole, &seen, &known)?,
            parameters: valued
                .iter()
                .map(|(parameter, value)| (parameter.name(&self.robot), value.clone()))
                .collect(),
            held,
            misses: left,
            over_errors,
        })
    }

    fn seen(&self, index: usize, run: &MeasuredRun, known: &Kinematics) -> Result<Seen, Error> {
        let invalid = |what: &str, help: &str| {
            Err(Error::invalid(
                format!("`measured` {}: {what}", index + 1),
                help,
            ))
        };
        let places = [("x_m", run.x_m), ("y_m", run.y_m)];
        if let Some((key, far_m)) = places
            .into_iter()
            .find_map(|(key, at)| Some((key, at.filter(|m| m.abs() > FURTHEST_M)?)))
        {
            return invalid(
                &format!("`{key}` = {far_m} m is further than a tape reaches"),
                "give metres, not centimetres or millimetres",
            );
        }
        let mut turned_rad = vec![0.0; self.robot.wheels.len()];
        match (&run.drive, run.wheels.is_empty()) {
            (Some(drive), true) => {
                let twist = Twist::new(drive.vx_m_s, drive.vy_m_s, drive.omega_rad_s);
                known.wheel_rates(twist.scaled(drive.for_s), &mut turned_rad);
            }
            (None, false) => {
                for (wheel, turned) in self.robot.wheels.iter().zip(&mut turned_rad) {
                    match run.wheels.get(&wheel.name) {
                        Some(rad) => *turned = *rad,
                        None => {
                            return invalid(
                                &format!("what `{}` turned is missing", wheel.name),
                                "give all wheels, by the names of their joints, in radians",
                            );
                        }
                    }
                }
                if run.wheels.len() > turned_rad.len() {
                    return invalid(
                        "it names a wheel that the robot does not have",
                        "see `ilon inspect`",
                    );
                }
            }
            _ => {
                return invalid(
                    "it needs exactly one of `wheels` and `drive`",
                    "give either `wheels = { NAME = RADIANS }` or `drive = { vx_m_s = 0.3, for_s = 6 }`",
                );
            }
        }
        let place = |value: Option<f64>| value.map(|m| (m, run.error_m));
        let heading = run
            .heading_deg
            .map(|deg| (deg.to_radians(), run.error_deg.to_radians()));
        let numbers = [place(run.x_m), place(run.y_m), heading];
        match numbers.iter().all(Option::is_none) {
            true => invalid(
                "nothing of its end was measured",
                "give `x_m`, `y_m` or `heading_deg`",
            ),
            false => Ok(Seen {
                turned_rad,
                numbers,
            }),
        }
    }
}

/// A longer way cannot be measured by tape, in metres. Chosen.
const FURTHEST_M: f64 = 50.0;

/// A value of a length, times a factor.
fn scaled(value: &Value, factor: f64) -> Value {
    value.through(|of| of * factor, "m", value.nominal)
}

/// Rejects a radius or a lever that is not above 0: the runs moved against their wheels' rotation;
/// and one of more than twice the nominal one, or less than half of it.
fn must_be_lengths(model: &Model, values: &[f64], robot: &Robot) -> Result<(), Error> {
    let is_length = |of: &Parameter| {
        matches!(
            of,
            Parameter::Radius | Parameter::WheelRadius(_) | Parameter::Lever
        )
    };
    let fitted = model.parameters.iter().zip(values);
    for (of, value) in fitted.filter(|(of, _)| is_length(of)) {
        let (name, nominal) = (of.name(robot), of.nominal(robot));
        if value.is_nan() || *value <= 0.0 {
            return Err(Error::invalid(
                format!("the runs give `{name}` = {value:.4}, but it must be above 0"),
                "look for a run whose end has the wrong sign, or axes exchanged: x is ahead, y to the left, headings count to the left",
            ));
        }
        if !(0.5 * nominal..=2.0 * nominal).contains(value) {
            return Err(Error::invalid(
                format!(
                    "the runs give `{name}` = {value:.4}, but the robot's file has {nominal:.4}"
                ),
                "give lengths in metres and angles in degrees, wheels in radians, and the file what the robot was built with",
            ));
        }
    }
    Ok(())
}

/// Returns half of a 95 % interval from the stated errors, widened if the runs scatter by more.
fn half_width(standard: f64, over_errors: Option<f64>, free: i64) -> f64 {
    match over_errors.filter(|over| *over > 1.0) {
        Some(over) => {
            let t =
                StudentsT::new(0.0, 1.0, free as f64).map_or(f64::NAN, |t| t.inverse_cdf(0.975));
            t * over * standard
        }
        None => 1.959964 * standard,
    }
}

/// Returns the residuals over their standard errors; `None` for values with which the robot cannot
/// be moved.
fn misses(model: &Model, values: &[f64], seen: &[Seen]) -> Option<Vec<[Option<f64>; 3]>> {
    let matrix = model.twist_matrix(values)?;
    let of = |run: &Seen| {
        let went = &matrix * DVector::from_column_slice(&run.turned_rad);
        let end = Pose::default().moved(Twist::new(went[0], went[1], went[2]));
        let off = [end.x_m, end.y_m, went[2]];
        std::array::from_fn(|axis| {
            let (measured, error) = run.numbers[axis]?;
            let mut missed = measured - off[axis];
            if axis == 2 {
                missed -= TAU * (missed / TAU).round();
            }
            Some(missed / error)
        })
    };
    Some(seen.iter().map(of).collect())
}

fn flat(misses: &[[Option<f64>; 3]]) -> Vec<f64> {
    misses.iter().flatten().flatten().copied().collect()
}

/// Returns J^T J of the measurements, each parameter over its expected deviation.
fn information(model: &Model, seen: &[Seen]) -> Option<DMatrix<f64>> {
    let nominal = model.nominal();
    let columns = model.scales().into_iter().enumerate().map(|(axis, scale)| {
        let side = |by: f64| {
            let mut values = nominal.clone();
            values[axis] += by * scale;
            misses(model, &values, seen).map(|of| DVector::from_vec(flat(&of)))
        };
        Some((side(1e-4)? - side(-1e-4)?) / 2e-4)
    });
    let columns = columns.collect::<Option<Vec<_>>>()?;
    let jacobian = match columns.is_empty() {
        true => return Some(DMatrix::zeros(0, 0)),
        false => DMatrix::from_columns(&columns),
    };
    Some(jacobian.transpose() * jacobian)
}

/// Returns the model with the parameters that the runs determine better than their expected
/// deviation; the others are held, the worst determined first.
fn determined(model: &Model, seen: &[Seen], robot: &Robot) -> (Model, Vec<HeldParameter>) {
    let mut model = model.clone();
    let mut held = Vec::new();
    while let Some(normal) = information(&model, seen) {
        let count = model.parameters.len();
        let prior = DMatrix::<f64>::identity(count, count) * 1e-9;
        let Some(covariance) = (normal + prior).try_inverse() else {
            break;
        };
        let worst = (0..count).max_by(|a, b| covariance[(*a, *a)].total_cmp(&covariance[(*b, *b)]));
        let Some(worst) = worst.filter(|worst| covariance[(*worst, *worst)] > 1.0) else {
            break;
        };
        let parameter = model.parameters[worst].clone();
        held.push(HeldParameter {
            name: parameter.name(robot),
            value: parameter.nominal(robot),
            why: "these runs do not determine it; the table of further drives shows which would"
                .to_owned(),
        });
        model = model.without(&[parameter]);
    }
    (model, held)
}

/// Returns drives that a person can measure, and the standard errors that three more runs of each
/// would leave. Before any run each parameter is known to its expected deviation.
fn next_drives(model: &Model, seen: &[Seen], known: &Kinematics) -> Result<Vec<NextDrive>, Error> {
    /// Translation in metres and rotation in rad: two metres of a tape, and three turns.
    const DRIVES: [(&str, [f64; 3]); 6] = [
        ("2 m ahead", [2.0, 0.0, 0.0]),
        ("2 m to the left", [0.0, 2.0, 0.0]),
        (
            "2 m ahead and to the left",
            [std::f64::consts::SQRT_2, std::f64::consts::SQRT_2, 0.0],
        ),
        ("3 turns on the spot", [0.0, 0.0, 3.0 * TAU]),
        (
            "half a circle ahead, 1 m across",
            [0.25 * TAU, 0.0, 0.5 * TAU],
        ),
        (
            "half a circle sideways, 1 m across",
            [0.0, 0.25 * TAU, 0.5 * TAU],
        ),
    ];
    let (scales, names) = (model.scales(), model.names());
    let Some(so_far) = information(model, seen) else {
        return Err(Error::invalid(
            "this robot cannot move in all three directions (ahead, sideways, turn)",
            "see `ilon inspect`",
        ));
    };
    let after = |drive: &str, more: DMatrix<f64>| {
        let count = names.len();
        let all = &so_far + more + DMatrix::<f64>::identity(count, count);
        let covariance = all
            .try_inverse()
            .unwrap_or_else(|| DMatrix::identity(count, count));
        let errors = (0..count).map(|axis| {
            let error = scales[axis] * covariance[(axis, axis)].max(0.0).sqrt();
            (names[axis].clone(), error)
        });
        NextDrive {
            drive: drive.to_owned(),
            errors: errors.collect(),
        }
    };
    let count = names.len();
    let mut drives = vec![after("none", DMatrix::zeros(count, count))];
    let is_held = is_held(&model.robot(&model.nominal()));
    for (drive, [x, y, turn]) in DRIVES
        .into_iter()
        .filter(|(_, of)| !is_held || of[1] == 0.0)
    {
        let mut turned_rad = vec![0.0; known.wheel_count()];
        known.wheel_rates(Twist::new(x, y, turn), &mut turned_rad);
        let place = Some((0.0, thousandths::<2>()));
        // Headings are compared up to full turns, near the expected one.
        let heading = Some((turn, thousandths::<500>().to_radians()));
        let run = Seen {
            turned_rad,
            numbers: [place, place, heading],
        };
        let more = information(model, &[run]);
        drives.extend(more.map(|more| after(drive, REPEATED * more)));
    }
    Ok(drives)
}
