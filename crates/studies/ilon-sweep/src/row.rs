//! The result of one run: a row of `runs.parquet`.

use ilon_trace::{Quantity, Summary, quantities};
use serde::{Deserialize, Serialize};
use toml::Value;

/// Final state of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Simulated to the end.
    Done,
    /// Not simulated, or not to the end.
    Failed,
}

impl Status {
    /// The word in `runs.parquet`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Failed => "failed",
        }
    }
}

/// One run of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// Its number.
    pub run: u64,
    /// Index of its scenario.
    pub scenario: usize,
    /// The number of its point on the axes.
    pub point: u64,
    /// Number of earlier runs of the same point.
    pub repetition: u32,
    /// The value on each axis, in the order of [`Study::columns`](crate::Study::columns).
    pub values: Vec<Value>,
}

/// Result of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Row {
    /// The number of the run.
    pub run: u64,
    /// Hash of the resolved scenario, the robot and the version of ilon.
    pub key: String,
    /// Its final state.
    pub status: Status,
    /// Reason of the failure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// The name of its scenario.
    pub scenario: String,
    /// The number of its point on the axes.
    pub point: u64,
    /// Number of earlier runs of the same point.
    pub repetition: u32,
    /// The value of each varied key, in the order of [`Study::columns`](crate::Study::columns).
    pub values: Vec<Value>,
    /// Hash of all recorded signals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trace_hash: Option<String>,
    /// What a person should know about the run, although it could be made.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// The numbers of its summary, in the order of [`figure_names`]; empty if it failed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<Option<f64>>,
}

impl Row {
    /// Returns a number of its summary; `None` if the run failed or the quantity does not apply.
    pub fn figure(&self, quantity: usize) -> Option<f64> {
        self.figures.get(quantity).copied().flatten()
    }
}

/// The run's cost on a machine is no property of the run: rows of two machines are equal.
const OF_THE_MACHINE: &str = "sim_seconds_per_cpu_second";

/// Returns the quantities stored in a row.
fn figures() -> impl Iterator<Item = &'static Quantity> {
    quantities::all().filter(|quantity| quantity.key != OF_THE_MACHINE)
}

/// Returns the dotted names of the figures in a row.
pub fn figure_names() -> &'static [&'static str] {
    static NAMES: std::sync::OnceLock<Vec<&'static str>> = std::sync::OnceLock::new();
    NAMES.get_or_init(|| figures().map(|quantity| quantity.key).collect())
}

/// Returns the index of a quantity among the figures of a row.
pub fn figure_index(quantity: &str) -> Option<usize> {
    figure_names().iter().position(|name| *name == quantity)
}

/// Returns the figures of a summary, in the order of [`figure_names`].
pub(crate) fn figures_of(summary: &Summary) -> Vec<Option<f64>> {
    figures().map(|quantity| quantity.value(summary)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_holds_the_numbers_of_a_summary_but_for_those_of_the_machine() {
        assert!(figure_index("position_error_max_m").is_some());
        assert!(figure_index("twist_ratio_ideal.vy").is_some());
        assert!(figure_index(OF_THE_MACHINE).is_none());
        let mut summary = Summary::default();
        summary.duration_s = 2.5;
        summary.twist_ratio_ideal.vy = Some(0.98);
        let figures = figures_of(&summary);
        assert_eq!(figures[figure_index("duration_s").unwrap()], Some(2.5));
        assert_eq!(
            figures[figure_index("twist_ratio_ideal.vy").unwrap()],
            Some(0.98)
        );
        assert_eq!(figures[figure_index("slip_energy_j").unwrap()], None);
    }
}
