//! `[run]`: duration and time steps.

use ilon_files::defaults::{number, thousandths};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Tolerance for times that are sums of steps, in seconds: the rounding of `12.3` must not shift
/// anything by a step. Chosen.
pub const TIME_SLACK_S: f64 = 1e-9;

/// Duration and time steps.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "RunSection")]
pub struct Run {
    /// Simulated time, in seconds; required except for a `playback`, which runs to the end of its
    /// log.
    #[serde(default = "until_its_log_ends", skip_serializing_if = "is_open")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub duration_s: f64,
    /// Physics step in seconds, or `"auto"`: the longest that is accurate for this robot and its
    /// loop.
    #[serde(default)]
    pub physics_dt_s: Step,
    /// Control period, in seconds: a whole number of physics steps.
    #[serde(default = "thousandths::<10>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub control_dt_s: f64,
    /// Control periods per row of the trace. Rows keep the means and extremes in between; figures
    /// are of all periods, sentences and plots are of rows.
    #[serde(default = "number::<1, u32>")]
    #[schemars(range(min = 1))]
    pub record_every: u32,
    /// Rate at which all roller angles are recorded, in Hz, for the 3D view [default: not].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub roller_angles_hz: Option<f64>,
    /// Repeat the run at half the physics step and half of `world.solver.split_dt_s`, and report
    /// how far its figures move.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub converge: bool,
}

impl Default for Run {
    fn default() -> Self {
        Self {
            duration_s: until_its_log_ends(),
            physics_dt_s: Step::default(),
            control_dt_s: thousandths::<10>(),
            record_every: 1,
            roller_angles_hz: None,
            converge: false,
        }
    }
}

impl Run {
    /// Whether the scenario leaves the duration open: it is then that of the log.
    pub fn is_open(&self) -> bool {
        is_open(&self.duration_s)
    }

    /// Number of control periods of the run: its duration, rounded to whole ones, and at least one.
    pub fn control_periods(&self) -> u64 {
        (self.duration_s / self.control_dt_s).round().max(1.0) as u64
    }

    /// Number of rows of its trace: the first control instant, each `record_every`-th after it, and
    /// the end.
    pub fn row_count(&self) -> u64 {
        let every = u64::from(self.record_every.max(1));
        1 + self.control_periods().div_ceil(every)
    }

    /// Time between rows of its trace, in seconds; the last may follow sooner.
    pub fn row_s(&self) -> f64 {
        self.control_dt_s * f64::from(self.record_every.max(1))
    }

    /// Time of the last row of its trace, in seconds: the end.
    pub fn last_row_s(&self) -> f64 {
        self.control_periods() as f64 * self.control_dt_s
    }
}

/// A time step, given or chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Step {
    /// Chosen by the program.
    Auto(Auto),
    /// In seconds.
    Seconds(#[schemars(extend("exclusiveMinimum" = 0.0))] f64),
}

/// The word that leaves a choice to the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Auto {
    /// The program chooses.
    Auto,
}

impl Default for Step {
    fn default() -> Self {
        Self::Auto(Auto::Auto)
    }
}

/// An infinite duration, until the log sets it.
fn until_its_log_ends() -> f64 {
    f64::INFINITY
}

fn is_open(duration_s: &f64) -> bool {
    *duration_s == f64::INFINITY
}
