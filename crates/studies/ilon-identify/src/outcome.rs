//! What was found, as `identified.json` holds it.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::log::Anomaly;
use crate::scatter::Interval;

/// All that an identification found.
#[derive(Clone, Debug, Serialize)]
pub struct Identified {
    /// The study's name.
    pub study: String,
    /// The version of ilon.
    pub ilon: String,
    /// The model of the kinematics that was chosen.
    pub model: String,
    /// The parameters of that model, and keys of the scenario that were fitted, by their names.
    pub parameters: BTreeMap<String, Value>,
    /// What follows from the parameters, such as `sideways_over_ahead`.
    pub derived: BTreeMap<String, Value>,
    /// What the robot does over what its matrix says, of the runs that were fitted, whichever model was chosen.
    pub gains: Gains,
    /// What a controller is to be set to.
    pub controller: Controller,
    /// What the log does not determine, and was held at the robot's own value.
    pub held: Vec<HeldParameter>,
    /// The errors on what was fitted.
    pub fit: Errors,
    /// The same on what was not.
    pub held_out: Errors,
    /// What was not fitted: `"runs"` that were kept back, or each run, or each stretch, in turn (`"each_run"`, `"each_stretch"`).
    pub judged_by: JudgedBy,
    /// The errors before the fit, on what was not fitted.
    pub nominal: Errors,
    /// All models that were tried, in the order of the study.
    pub models: Vec<Judged>,
    /// What is left, by direction of motion and speed.
    pub residual: Vec<Direction>,
    /// What each series of runs gives by itself.
    pub series: Vec<Series>,
    /// Each run.
    pub runs: Vec<Run>,
    /// How exactly displacements over one stretch are seen.
    pub noise: NoiseFigures,
    /// Over what the scatter was taken that the intervals follow from: whole `"runs"` or `"stretches"`.
    pub intervals_over: String,
    /// How many of them.
    pub intervals_count: usize,
    /// What simulating left, where keys of the scenario were fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulation: Option<Simulation>,
    /// Those of the parameters that are keys of the scenario, found by simulating.
    pub simulated_keys: Vec<String>,
    /// What is odd about the logs.
    pub doubts: Vec<RunDoubt>,
}

/// A value, and how sure it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Value {
    /// The value.
    pub value: f64,
    /// Where it lies with 95 %; null where that is not known.
    pub ci95: [Option<f64>; 2],
    /// Its unit; empty of a plain number.
    pub unit: String,
    /// What it was before the fit.
    pub nominal: f64,
}

impl Value {
    /// What follows from the value, which grows or falls with it on one side of 0: an end of its interval beyond 0 is not known.
    pub fn through(&self, f: impl Fn(f64) -> f64, unit: &str, nominal: f64) -> Self {
        let is_beyond = |end: &f64| end * self.value <= 0.0;
        let mut ends = self
            .ci95
            .map(|end| end.filter(|end| !is_beyond(end)).map(&f));
        if f(self.value + 1e-3 * self.value.abs()) < f(self.value) {
            ends.reverse();
        }
        Self {
            value: f(self.value),
            ci95: ends,
            unit: unit.to_owned(),
            nominal,
        }
    }

    /// A value with its interval.
    pub fn new(value: f64, interval: Interval, unit: &str, nominal: f64) -> Self {
        let known = |end: f64| end.is_finite().then_some(end);
        Self {
            value,
            ci95: [known(interval.low), known(interval.high)],
            unit: unit.to_owned(),
            nominal,
        }
    }
}

/// What a robot does over what its matrix says. Each is absent where the log does not determine it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Gains {
    /// Along x.
    pub ahead: Option<Value>,
    /// Along y.
    pub sideways: Option<Value>,
    /// In turns.
    pub turn: Option<Value>,
    /// Sideways over ahead, which holds where a common scale is not known.
    pub sideways_over_ahead: Option<Value>,
    /// In turns over ahead.
    pub turn_over_ahead: Option<Value>,
    /// What rigid rollers, of which one a wheel touches at a time, make of twists along x, along y and of turns; absent where the rollers are not
    /// known.
    pub rigid: Option<[f64; 3]>,
}

/// What a controller is to be set to that drives the robot by its ideal kinematics, so that the robot does what it is asked.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Controller {
    /// The controller of ros2_controllers for such wheels; absent where there is none.
    pub kind: Option<ControllerKind>,
    /// The radius rho of the wheels, in metres; of wheels that were fitted one by one their mean.
    pub radius_m: Option<Value>,
    /// The lever: of a ring its radius, of mecanum wheels the sum of the two arms, in metres.
    pub lever_m: Option<Value>,
    /// By what a speed sideways is multiplied before the controller, which has one radius for all directions.
    pub sideways_factor: Option<Value>,
    /// Each wheel, where wheels were fitted one by one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wheels: Vec<WheelSetting>,
}

/// A controller of ros2_controllers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerKind {
    /// `mecanum_drive_controller`.
    Mecanum,
    /// `omni_wheel_drive_controller`.
    Omni,
}

/// What one wheel is to be set to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WheelSetting {
    /// The wheel.
    pub wheel: String,
    /// Its radius, in metres.
    pub radius_m: Value,
    /// By what its rate is multiplied behind a controller that has the mean radius for all wheels.
    pub rate_factor: f64,
}

/// A parameter that was not fitted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldParameter {
    /// Its name.
    pub name: String,
    /// At what it was held.
    pub value: f64,
    /// Why, and what would help.
    pub why: String,
}

/// How far off a model is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Over how many stretches.
    pub stretches: usize,
    /// Root mean square of what displacements over a stretch miss, in metres.
    pub position_rms_m: f64,
    /// Root mean square of what turns over a stretch miss, in radians.
    pub heading_rms_rad: f64,
    /// Root mean square of both over the noise: 1 is all that can be had.
    pub over_noise: f64,
    /// Root mean square over runs of how far from the robot dead reckoning ends, in metres.
    pub end_position_rms_m: f64,
}

/// What a model was judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JudgedBy {
    /// By runs that were kept back.
    Runs,
    /// By each run in turn, fitted to the others.
    EachRun,
    /// By each eighth of the runs in turn, fitted to the rest.
    EachStretch,
}

/// A model that was tried.
#[derive(Clone, Debug, Serialize)]
pub struct Judged {
    /// Its name.
    pub name: String,
    /// Its parameters, those of the tracker left out.
    pub parameters: BTreeMap<String, Value>,
    /// What was held.
    pub held: Vec<HeldParameter>,
    /// The errors on what was fitted.
    pub fit: Errors,
    /// The errors on what was not.
    pub held_out: Errors,
}

/// What was done in one direction of motion.
#[derive(Clone, Debug, Serialize)]
pub struct Direction {
    /// The direction in the body frame in which the wheels drive the robot, in degrees.
    pub direction_deg: f64,
    /// The speed at which they do, in m/s.
    pub speed_m_s: f64,
    /// Over how many stretches.
    pub stretches: usize,
    /// The way made in that direction over what the wheels ask for, of the runs that were fitted and those kept back.
    pub measured: f64,
    /// The standard error of it, over stretches.
    pub measured_error: f64,
    /// The way made across that direction, to the left, over what the wheels ask for.
    pub measured_across: f64,
    /// What the touching rollers give, by their geometry, over what the matrix of the robot gives.
    pub contact: Option<f64>,
    /// What the chosen model gives.
    pub fitted: f64,
    /// What the chosen model gives across.
    pub fitted_across: f64,
    /// What the simulation gives with the fitted keys, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulated: Option<f64>,
    /// How fast the heading drifts from what the chosen model says, in radians a metre.
    pub drift_rad_per_m: f64,
}

/// What the fit of a simulation left.
#[derive(Clone, Debug, Serialize)]
pub struct Simulation {
    /// What is left of drives that were fitted.
    pub fit: Misses,
    /// The same of drives that were not.
    pub held_out: Misses,
    /// The common factor on measured ways, of the first series that was fitted; 1 where none was free.
    pub scale: f64,
    /// Whether the search ended by itself.
    pub has_converged: bool,
    /// How many drives were simulated.
    pub drives_simulated: u32,
    /// From how many sets of wheel angles each drive was simulated; 1 where they are known or do not matter.
    pub phases: u32,
    /// Whether it matters for what was found at which angles of their rollers the wheels began; null where the study says that they are known.
    pub phases_matter: Option<bool>,
    /// Pairs of keys that the log hardly tells apart.
    pub alike: Vec<[String; 2]>,
    /// Keys that change less than the noise over all of their range.
    pub insensitive: Vec<String>,
    /// Keys whose interval holds all of their range: the others may make up for whatever they are.
    pub open: Vec<String>,
    /// Keys whose interval reaches one end of their range: what lies beyond was not tried.
    pub cut_off: Vec<String>,
    /// Keys that one run alone tells: how sure they are is not known.
    pub of_one_run: Vec<String>,
    /// Keys that ended at an end of their range.
    pub at_bounds: Vec<String>,
    /// Keys with a second value, far from that found, that explains the drives about as well.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub elsewhere: Vec<Elsewhere>,
    /// Each series that drove ahead and sideways.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub series: Vec<SimulatedSeries>,
    /// Each drive.
    pub drives: Vec<SteadyDrive>,
    /// What other values of keys come to.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<Beside>,
}

/// A second value of a key: what lies between it and the value found explains the drives worse than either.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Elsewhere {
    /// The key.
    pub key: String,
    /// The best of the values there.
    pub value: f64,
}

/// Root mean squares over drives of what was measured less what was simulated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Misses {
    /// Of the way made over the way asked for; null where there is no drive.
    pub ratio: Option<f64>,
    /// Of the heading's drift, in rad/m.
    pub drift_rad_per_m: Option<f64>,
    /// Of the torques of wheels that turn, in N m; null where the log has no currents.
    pub torque_n_m: Option<f64>,
}

/// What other values of keys come to.
#[derive(Clone, Debug, Serialize)]
pub struct Beside {
    /// What the study calls them.
    pub name: String,
    /// What they leave of drives that were fitted.
    pub fit: Misses,
    /// The same of drives that were not.
    pub held_out: Misses,
    /// What they make of each drive, in the order of [`Simulation::drives`].
    pub drives: Vec<OtherDrive>,
}

/// What other values of keys make of a drive.
#[derive(Clone, Debug, Serialize)]
pub struct OtherDrive {
    /// The way made over the way asked for.
    pub simulated: f64,
    /// The way made across it, to the left.
    pub simulated_across: f64,
    /// The drift of the heading, in rad/m.
    pub simulated_drift_rad_per_m: f64,
    /// The torque of each wheel, in N m.
    pub simulated_torques_n_m: Vec<f64>,
}

/// The torque of a wheel in a drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DriveTorque {
    /// The wheel.
    pub wheel: String,
    /// By the current of its motor, in N m at the wheel.
    pub measured_n_m: f64,
    /// Its standard error.
    pub measured_error_n_m: f64,
    /// The same as simulated.
    pub simulated_n_m: f64,
}

/// What a series comes to sideways over what it comes to ahead, measured and simulated.
#[derive(Clone, Debug, Serialize)]
pub struct SimulatedSeries {
    /// Its name.
    pub name: String,
    /// Whether its first run was kept back.
    pub held_out: bool,
    /// As the logs show it, with what stretches of a run scatter by.
    pub sideways_over_ahead: Value,
    /// As simulated with the values that were found.
    pub simulated: f64,
}

/// What wheels and body do once a roller, measured and simulated: amplitudes, root mean square over stretches.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DriveRipple {
    /// Over how many stretches of the log.
    pub stretches: usize,
    /// How many rollers passed in a turn of the wheel as the log counts it, over how many it has: more than 1 where rows were lost.
    pub rollers_counted: f64,
    /// The ripple of the wheels' rates, root mean square over wheels, in rad/s.
    pub wheels_rad_s: f64,
    /// Its standard error.
    pub wheels_error_rad_s: f64,
    /// The same as simulated.
    pub wheels_simulated_rad_s: f64,
    /// The ripple of the body's way along its direction, in metres.
    pub body_m: f64,
    /// Its standard error.
    pub body_error_m: f64,
    /// The same as simulated.
    pub body_simulated_m: f64,
}

/// A steady drive in one direction, measured and simulated.
#[derive(Clone, Debug, Serialize)]
pub struct SteadyDrive {
    /// The log that it is of.
    pub file: String,
    /// Whether it was kept back.
    pub held_out: bool,
    /// The direction in the body frame in which the wheels drive the robot, in degrees.
    pub direction_deg: f64,
    /// The way made in that direction over what the wheels ask for, and over the common factor.
    pub measured: f64,
    /// Its standard error.
    pub measured_error: f64,
    /// The same as simulated, the mean over wheel angles.
    pub simulated: f64,
    /// Its standard deviation over the wheel angles from which it was simulated; 0 of one.
    pub simulated_scatter: f64,
    /// The way made across that direction, to the left.
    pub measured_across: f64,
    /// The same as simulated.
    pub simulated_across: f64,
    /// By how much the robot turned beyond what its wheels asked for, over the way that they asked for, in rad/m.
    pub measured_drift_rad_per_m: f64,
    /// Its standard error.
    pub measured_drift_error_rad_per_m: f64,
    /// The same as simulated.
    pub simulated_drift_rad_per_m: f64,
    /// The torques of the wheels that turn, where the log has currents.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub torques: Vec<DriveTorque>,
    /// What wheels and body do once a roller, where it was compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ripple: Option<DriveRipple>,
}

/// What a series of runs gives by itself.
#[derive(Clone, Debug, Serialize)]
pub struct Series {
    /// Its name.
    pub name: String,
    /// Gains ahead, sideways and in turns over the robot's matrix, as far as the series determines them, and their ratio.
    pub gains: BTreeMap<String, Value>,
}

/// One run.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// Its file.
    pub file: String,
    /// Whether it was kept back.
    pub held_out: bool,
    /// How long it is, in seconds.
    pub duration_s: f64,
    /// How far the wheels drive the robot, in metres.
    pub path_m: f64,
    /// How far from the robot dead reckoning ends before the fit, in metres.
    pub end_position_nominal_m: f64,
    /// And after it.
    pub end_position_m: f64,
    /// And in heading after it, in radians.
    pub end_heading_rad: f64,
}

/// How exactly displacements over one stretch are seen.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct NoiseFigures {
    /// Standard deviation of a displacement along one axis, in metres.
    pub position_m: f64,
    /// Standard deviation of a turn, in radians.
    pub heading_rad: f64,
    /// Stretches that were left out because they miss the freest linear model by eight times that or more.
    pub left_out: usize,
}

/// Something odd about a log.
#[derive(Clone, Debug, Serialize)]
pub struct RunDoubt {
    /// The file of the log.
    pub file: String,
    /// What is odd about it.
    #[serde(flatten)]
    pub doubt: Anomaly,
}
