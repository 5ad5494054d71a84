//! The command that runs a run of a study again.

use ilon_sweep::{Row, Study, Task};

use super::flags::shell;

/// The command that runs a run again.
pub fn command(study: &Study, rows: &[Row], run: u64) -> String {
    let Some(row) = rows
        .binary_search_by_key(&run, |row| row.run)
        .ok()
        .map(|at| &rows[at])
    else {
        return String::new();
    };
    let scenario = study
        .scenario_names()
        .position(|name| name == row.scenario)
        .unwrap_or(0);
    let task = Task {
        run,
        scenario,
        point: row.point,
        repetition: row.repetition,
        values: row.values.clone(),
    };
    let settings: String = study
        .settings(&task)
        .iter()
        .map(|setting| format!(" --set {}", shell(&setting.to_string())))
        .collect();
    let path = study.scenario_path(scenario).display().to_string();
    format!("ilon run {}{settings}", shell(&path))
}
