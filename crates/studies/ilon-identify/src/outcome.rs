//! The results of an identification, the content of `identified.json`.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::log::Anomaly;
use crate::scatter::Interval;

/// All results of an identification.
#[derive(Clone, Debug, Serialize)]
pub struct Identified {
    /// The study's name.
    pub study: String,
    /// The version of ilon.
    pub ilon: String,
    /// The chosen model of the kinematics.
    pub model: String,
    /// The parameters of that model, and the fitted keys of the scenario, by name.
    pub parameters: BTreeMap<String, Value>,
    /// Quantities derived from the parameters, such as `sideways_over_ahead`.
    pub derived: BTreeMap<String, Value>,
    /// Motion over that of the matrix, for the fitted runs, whichever model was chosen.
    pub gains: Gains,
    /// Settings for a controller.
    pub controller: Controller,
    /// Parameters that the log does not determine; they were held at the robot's own value.
    pub held: Vec<HeldParameter>,
    /// Errors on fitted data.
    pub fit: Errors,
    /// Errors on held-out data.
    pub held_out: Errors,
    /// The held-out data: `"runs"` that were kept back, or each run, or each window, in turn
    /// (`"each_run"`, `"each_stretch"`).
    pub judged_by: JudgedBy,
    /// The length of the stretches of a log whose errors are compared, in seconds.
    pub window_s: f64,
    /// Errors before the fit, on held-out data.
    pub nominal: Errors,
    /// All models that were tried, in the order of the study.
    pub models: Vec<Judged>,
    /// Residuals by direction of motion and speed.
    pub residual: Vec<Direction>,
    /// Results of each series of runs alone.
    pub series: Vec<Series>,
    /// Each run.
    pub runs: Vec<Run>,
    /// Measurement noise of displacements over one window.
    pub noise: NoiseFigures,
    /// Unit of the scatter from which the intervals follow: whole `"runs"` or `"stretches"`.
    pub intervals_over: String,
    /// Number of these units.
    pub intervals_count: usize,
    /// Residuals of the simulation, if keys of the scenario were fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulation: Option<Simulation>,
    /// The parameters that are keys of the scenario, found by simulating.
    pub simulated_keys: Vec<String>,
    /// Doubts about the logs.
    pub doubts: Vec<RunDoubt>,
    /// Whether tyres hold the robot sideways.
    pub is_held: bool,
}

/// A value with its uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Value {
    /// The value.
    pub value: f64,
    /// The 95 % interval; null if unknown.
    pub ci95: [Option<f64>; 2],
    /// Its unit; empty if dimensionless.
    pub unit: String,
    /// The value before the fit.
    pub nominal: f64,
}

impl Value {
    /// Returns a monotonic function of the value, for values on one side of 0: an end of its
    /// interval beyond 0 becomes unknown.
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

/// Motion of a robot over that of its matrix. A gain that the log does not determine is absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Gains {
    /// Along x.
    pub ahead: Option<Value>,
    /// Along y.
    pub sideways: Option<Value>,
    /// In rotation.
    pub turn: Option<Value>,
    /// Sideways over ahead, which holds even if a common scale is unknown.
    pub sideways_over_ahead: Option<Value>,
    /// Rotation over ahead.
    pub turn_over_ahead: Option<Value>,
    /// Gains along x, along y and of rotation with rigid rollers, one per wheel touching at a time;
    /// absent if the rollers are unknown.
    pub rigid: Option<[f64; 3]>,
}

/// Settings of a controller with ideal kinematics that make the robot follow its commands.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Controller {
    /// The controller of ros2_controllers for such wheels; absent if there is none.
    pub kind: Option<ControllerKind>,
    /// The radius rho of the wheels, in metres; the mean of wheels that were fitted separately.
    pub radius_m: Option<Value>,
    /// The lever, in metres: the radius of a ring, the sum of the two arms of mecanum wheels.
    pub lever_m: Option<Value>,
    /// Factor on a sideways speed before the controller, which has one radius for all directions.
    pub sideways_factor: Option<Value>,
    /// The angle gamma of the rollers in degrees, where it was fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gamma_deg: Option<Value>,
    /// Settings of each wheel, if wheels were fitted separately.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wheels: Vec<WheelSetting>,
}

/// A controller of ros2_controllers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerKind {
    /// `diff_drive_controller`.
    Differential,
    /// `mecanum_drive_controller`.
    Mecanum,
    /// `omni_wheel_drive_controller`.
    Omni,
    /// `tricycle_controller`.
    Tricycle,
}

/// Settings of one wheel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WheelSetting {
    /// Name of the wheel; `left` or `right` of a robot whose controller has one radius a side.
    pub wheel: String,
    /// Its radius, in metres.
    pub radius_m: Value,
    /// Factor on its rate after a controller that has the mean radius for all wheels.
    pub rate_factor: f64,
}

/// A parameter that was held.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldParameter {
    /// Its name.
    pub name: String,
    /// The value at which it was held.
    pub value: f64,
    /// The reason, and a remedy.
    pub why: String,
}

/// Errors of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Number of windows.
    pub stretches: usize,
    /// Root mean square error of displacements over a window, in metres.
    pub position_rms_m: f64,
    /// Root mean square error of rotations over a window, in radians.
    pub heading_rms_rad: f64,
    /// Root mean square of both over the noise: 1 is the best possible.
    pub over_noise: f64,
    /// Root mean square over runs of the final error of dead reckoning, in metres.
    pub end_position_rms_m: f64,
}

/// The data by which a model was judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JudgedBy {
    /// Runs that were held out.
    Runs,
    /// Each run in turn, fitted to the others.
    EachRun,
    /// Each eighth of the runs in turn, fitted to the rest.
    EachStretch,
}

/// A fitted model.
#[derive(Clone, Debug, Serialize)]
pub struct Judged {
    /// Its name.
    pub name: String,
    /// Its parameters, without those of the tracker.
    pub parameters: BTreeMap<String, Value>,
    /// The held parameters.
    pub held: Vec<HeldParameter>,
    /// Errors on fitted data.
    pub fit: Errors,
    /// Errors on held-out data.
    pub held_out: Errors,
}

/// The motion in one direction.
#[derive(Clone, Debug, Serialize)]
pub struct Direction {
    /// Direction in the body frame in which the wheels drive the robot, in degrees.
    pub direction_deg: f64,
    /// Speed by the wheels, in m/s.
    pub speed_m_s: f64,
    /// Number of windows.
    pub stretches: usize,
    /// Distance in that direction over the one commanded by the wheels, for fitted and held-out
    /// runs.
    pub measured: f64,
    /// Its standard error, over windows.
    pub measured_error: f64,
    /// Distance across that direction, to the left, over the one commanded by the wheels.
    pub measured_across: f64,
    /// Motion by the touching rollers' geometry over that of the robot's matrix.
    pub contact: Option<f64>,
    /// `measured` by the chosen model.
    pub fitted: f64,
    /// `measured_across` by the chosen model.
    pub fitted_across: f64,
    /// `measured` by the simulation with the fitted keys, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulated: Option<f64>,
    /// Drift of the heading from the chosen model, in rad/m.
    pub drift_rad_per_m: f64,
}

/// Residuals and diagnostics of the fit by simulation.
#[derive(Clone, Debug, Serialize)]
pub struct Simulation {
    /// Residuals of fitted drives.
    pub fit: Misses,
    /// Residuals of held-out drives.
    pub held_out: Misses,
    /// Common factor on measured distances, for the first fitted series; 1 if it was not free.
    pub scale: f64,
    /// Whether the search converged.
    pub has_converged: bool,
    /// Number of simulated drives.
    pub drives_simulated: u32,
    /// Number of sets of initial wheel angles per drive; 1 if they are known or do not matter.
    pub phases: u32,
    /// Whether the initial angles of the rollers affect the results; null if the study states that
    /// they are known.
    pub phases_matter: Option<bool>,
    /// Pairs of keys that the log hardly distinguishes.
    pub alike: Vec<[String; 2]>,
    /// Keys whose effect over their whole range is below the noise.
    pub insensitive: Vec<String>,
    /// Keys whose interval is their whole range: the others may compensate for any value.
    pub open: Vec<String>,
    /// Keys whose interval reaches one end of their range: values beyond were not tried.
    pub cut_off: Vec<String>,
    /// Keys that only one run determines: their uncertainty is unknown.
    pub of_one_run: Vec<String>,
    /// Keys that ended at an end of their range.
    pub at_bounds: Vec<String>,
    /// Keys with a second value, far from the one found, that explains the drives about as well.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub elsewhere: Vec<Elsewhere>,
    /// Each series with drives ahead and sideways.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub series: Vec<SimulatedSeries>,
    /// Each drive.
    pub drives: Vec<SteadyDrive>,
    /// Results with other values of keys.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<Beside>,
}

/// A second value of a key: values between it and the one found explain the drives worse than
/// either.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Elsewhere {
    /// The key.
    pub key: String,
    /// The best of these values.
    pub value: f64,
}

/// Root mean squares over drives of measured less simulated values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Misses {
    /// Of the distance over the commanded distance; null if there is no drive.
    pub ratio: Option<f64>,
    /// Of the heading's drift, in rad/m.
    pub drift_rad_per_m: Option<f64>,
    /// Of the torques of wheels that turn, in N m; null if the log has no currents.
    pub torque_n_m: Option<f64>,
}

/// Results with other values of keys.
#[derive(Clone, Debug, Serialize)]
pub struct Beside {
    /// Their name in the study.
    pub name: String,
    /// Residuals of fitted drives.
    pub fit: Misses,
    /// Residuals of held-out drives.
    pub held_out: Misses,
    /// The result of each drive, in the order of [`Simulation::drives`].
    pub drives: Vec<OtherDrive>,
}

/// A drive with other values of keys.
#[derive(Clone, Debug, Serialize)]
pub struct OtherDrive {
    /// Distance over the commanded distance.
    pub simulated: f64,
    /// Distance across, to the left, over the commanded distance.
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
    /// Measured by the current of its motor, in N m at the wheel.
    pub measured_n_m: f64,
    /// Its standard error.
    pub measured_error_n_m: f64,
    /// The simulated torque, in N m.
    pub simulated_n_m: f64,
}

/// Ratio of sideways to ahead motion of a series, measured and simulated.
#[derive(Clone, Debug, Serialize)]
pub struct SimulatedSeries {
    /// Its name.
    pub name: String,
    /// Whether its first run was held out.
    pub held_out: bool,
    /// The measured ratio, with the scatter of the windows of a run.
    pub sideways_over_ahead: Value,
    /// The simulated ratio with the values found.
    pub simulated: f64,
}

/// Ripple of wheels and body at the roller frequency, measured and simulated: amplitudes, root mean
/// square over windows.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DriveRipple {
    /// Number of windows of the log.
    pub stretches: usize,
    /// Rollers passed per turn of the wheel in the log's count, over the wheel's number of rollers:
    /// more than 1 if rows were lost.
    pub rollers_counted: f64,
    /// Measured ripple of the wheels' rates, root mean square over wheels, in rad/s.
    pub wheels_rad_s: f64,
    /// Its standard error.
    pub wheels_error_rad_s: f64,
    /// The simulated ripple, in rad/s.
    pub wheels_simulated_rad_s: f64,
    /// Measured ripple of the body's position along its direction, in metres.
    pub body_m: f64,
    /// Its standard error.
    pub body_error_m: f64,
    /// The simulated ripple, in metres.
    pub body_simulated_m: f64,
}

/// A steady drive in one direction, measured and simulated.
#[derive(Clone, Debug, Serialize)]
pub struct SteadyDrive {
    /// Its log file.
    pub file: String,
    /// Whether it was held out.
    pub held_out: bool,
    /// Direction in the body frame in which the wheels drive the robot, in degrees.
    pub direction_deg: f64,
    /// Distance in that direction over the one commanded by the wheels, and over the common factor.
    pub measured: f64,
    /// Its standard error.
    pub measured_error: f64,
    /// The simulated value, mean over wheel angles.
    pub simulated: f64,
    /// Its standard deviation over the initial wheel angles; 0 for one set.
    pub simulated_scatter: f64,
    /// Distance across that direction, to the left, over the one commanded by the wheels.
    pub measured_across: f64,
    /// The simulated value.
    pub simulated_across: f64,
    /// Rotation beyond the one commanded by the wheels, over the commanded distance, in rad/m.
    pub measured_drift_rad_per_m: f64,
    /// Its standard error.
    pub measured_drift_error_rad_per_m: f64,
    /// The simulated value, in rad/m.
    pub simulated_drift_rad_per_m: f64,
    /// Torques of the wheels that turn, if the log has currents.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub torques: Vec<DriveTorque>,
    /// Ripple at the roller frequency, if it was compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ripple: Option<DriveRipple>,
}

/// Results of one series of runs.
#[derive(Clone, Debug, Serialize)]
pub struct Series {
    /// Its name.
    pub name: String,
    /// Gains ahead, sideways and of rotation over the robot's matrix, as far as the series
    /// determines them, and their ratio.
    pub gains: BTreeMap<String, Value>,
}

/// One run.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// Its file.
    pub file: String,
    /// Whether it was held out.
    pub held_out: bool,
    /// Its duration, in seconds.
    pub duration_s: f64,
    /// Distance that the wheels drive the robot, in metres.
    pub path_m: f64,
    /// Final position error of dead reckoning before the fit, in metres.
    pub end_position_nominal_m: f64,
    /// Final position error after the fit, in metres.
    pub end_position_m: f64,
    /// Final heading error after the fit, in radians.
    pub end_heading_rad: f64,
}

/// Measurement noise of displacements over one window.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct NoiseFigures {
    /// Standard deviation of a displacement along one axis, in metres.
    pub position_m: f64,
    /// Standard deviation of a rotation, in radians.
    pub heading_rad: f64,
    /// Number of windows removed because they miss the most general linear model by eight times the
    /// noise or more.
    pub left_out: usize,
}

/// A doubt about a log.
#[derive(Clone, Debug, Serialize)]
pub struct RunDoubt {
    /// The file of the log.
    pub file: String,
    /// The anomaly.
    #[serde(flatten)]
    pub doubt: Anomaly,
}
