//! The command line that repeats one run of a study.

use ilon_sweep::{Row, Study};

use super::flags::shell;

/// Returns the command line that repeats one run of a study.
pub fn command(study: &Study, rows: &[Row], run: u64) -> String {
    let Some(row) = rows
        .binary_search_by_key(&run, |row| row.run)
        .ok()
        .map(|at| &rows[at])
    else {
        return String::new();
    };
    let task = study.task_of(row);
    let settings: String = study
        .settings(&task)
        .iter()
        .map(|setting| format!(" --set {}", shell(&setting.to_string())))
        .collect();
    let path = study.scenario_path(task.scenario).display().to_string();
    format!("ilon run {}{settings}", shell(&path))
}
