//! The results folder. Each file appears whole or not at all, and the summary last: if it exists,
//! the results are complete.
//!
//! During a run its trace grows in the folder in parts. A run that is stopped at any time leaves a
//! trace that lacks at most the last part, and nothing that looks complete.

use std::fs;
use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_trace::{Recorded, Recording, Summary, TraceError};

use super::context;
use super::json::pretty;
use super::reserve::{self, ReservedOutput};
use crate::cli::failure::Failure;
use crate::judge::Verdict;
use crate::scenario::Tracked;
use crate::simulate::{Run, Simulation, load_robot};
use crate::{Scenario, report};

/// The files of a finished run; the first marks them as complete.
const RESULTS: [&str; 4] = ["summary.json", "report.html", TRACE, SCENARIO];

/// The complete trace.
const TRACE: &str = "trace.parquet";

/// The scenario of the run.
const SCENARIO: &str = "scenario.toml";

/// First line of a run's scenario, which distinguishes it from a scenario written by the user.
const RESOLVED: &str = "#: The scenario as ilon ran it, every default spelled out.\n";

/// The growing trace.
const GROWING: &str = "trace.partial";

/// Largest summary that is read, in bytes; chosen.
const SUMMARY_BYTES: u64 = 64 << 20;

/// Whether a run's report is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Report {
    Written,
    Left,
}

/// A results folder reserved for this run.
#[derive(Debug)]
pub(super) struct OutputFolder {
    path: PathBuf,
    /// The command line that made the results.
    command: String,
    _claim: ReservedOutput,
}

/// The files that a scenario uses, itself first.
pub(super) fn inputs(path: &Path, scenario: &Scenario) -> Vec<PathBuf> {
    let mut inputs = vec![path.to_owned(), scenario.resolve(&scenario.robot.file)];
    if let Some(file) = scenario.reference.as_ref().and_then(Tracked::file) {
        inputs.push(scenario.resolve(file));
    }
    let believed = scenario.controller.robot.as_ref();
    if let Some(file) = believed.and_then(|robot| robot.file.as_ref()) {
        inputs.push(scenario.resolve(file));
    }
    if let Some(playback) = &scenario.playback {
        inputs.push(scenario.resolve(&playback.file));
    }
    inputs
}

/// Whether a folder holds the results of a run, finished or not.
pub(super) fn holds_results(folder: &Path) -> bool {
    let has = |name: &str| folder.join(name).exists();
    has(SCENARIO) && (has(TRACE) || has(GROWING))
}

impl OutputFolder {
    /// Checks before simulation that results can be written to the folder named by an option,
    /// reserves it, and refuses a folder in which data would be lost.
    pub fn prepare(path: PathBuf, option: &str, inputs: &[PathBuf]) -> Result<Self, Failure> {
        Self::refuse_losses(&path, option, inputs)?;
        let claim = reserve::folder(&path, option)?;
        Ok(Self {
            path,
            command: context::command_line(),
            _claim: claim,
        })
    }

    /// Names what made results that were not made by this command line.
    pub fn made_by(mut self, command: &str) -> Self {
        self.command = command.to_owned();
        self
    }

    /// Refuses a folder in which results would replace an input, or a file that no run has written.
    pub fn refuse_losses(path: &Path, option: &str, inputs: &[PathBuf]) -> Result<(), Failure> {
        for name in RESULTS {
            let result = path.join(name);
            reserve::not_an_input(&result, option, inputs)?;
            // A folder is never a result and is not removed.
            if result.is_file() && !is_result(&result, name) {
                return Err(Failure::usage(
                    format!(
                        "`{}` was not written by a run, and results would replace it",
                        result.display()
                    ),
                    format!("move it elsewhere, or choose another folder with {option}"),
                ));
            }
        }
        Ok(())
    }

    /// Removes the results of an earlier run from a folder that was checked before, and the folder
    /// if it is then empty.
    pub fn clear(path: &Path) -> Result<(), Failure> {
        for name in RESULTS {
            remove(&path.join(name))?;
        }
        let _ = fs::remove_dir(path);
        Ok(())
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where the trace is while it grows.
    pub fn growing(&self) -> PathBuf {
        self.path.join(GROWING)
    }

    /// Removes the results of an earlier run, so that they are not taken for those of the run that
    /// begins, and starts the recording.
    pub fn begin(&self, simulation: &Simulation) -> Result<Recording, Failure> {
        // The parts are checked first, so that a foreign file is refused before anything is
        // removed.
        let recording = Recording::into_file(
            simulation.trace().header.clone(),
            self.path.join(TRACE),
            self.growing(),
        )?;
        for name in RESULTS {
            remove(&self.path.join(name))?;
        }
        self.write_scenario(simulation.scenario())?;
        Ok(recording)
    }

    /// Writes the report and then the summary of a run whose trace and scenario are already in the
    /// folder.
    ///
    /// Returns the report's answer in sentences.
    pub fn write(
        &self,
        run: &Run<Recorded>,
        verdicts: &[Verdict],
        report: Report,
    ) -> Result<Vec<String>, Failure> {
        let summary = self.summary_json(run)?;
        // It was read when the run began; if the file no longer exists, only the picture is
        // missing.
        let robot = load_robot(&run.scenario).ok();
        let context = context::of(run, robot.as_ref(), verdicts, &self.command);
        let answer = match report {
            Report::Written => {
                let page = self.path.join("report.html");
                report::write_recorded(&page, &run.trace, &run.summary, &context)?
            }
            Report::Left => report::answer(&run.trace, &run.summary)?,
        };
        self.write_text("summary.json", &summary)?;
        Ok(answer)
    }

    /// Writes all results of a run that was recorded elsewhere.
    pub fn write_all(&self, run: &Run<Recorded>, verdicts: &[Verdict]) -> Result<(), Failure> {
        // An older summary would mark the new files as complete too early.
        remove(&self.path.join("summary.json"))?;
        self.write_scenario(&run.scenario)?;
        run.trace.write_parquet(&self.path.join(TRACE))?;
        self.write(run, verdicts, Report::Written).map(|_| ())
    }

    /// The content of `summary.json`.
    pub fn summary_json(&self, run: &Run<Recorded>) -> Result<String, Failure> {
        check_finite(&run.summary)?;
        pretty("the summary", &run.summary)
    }

    fn write_scenario(&self, scenario: &Scenario) -> Result<(), Failure> {
        let text = scenario.moved_to(&self.path).to_toml()?;
        self.write_text(SCENARIO, &format!("{RESOLVED}\n{text}"))
    }

    fn write_text(&self, name: &str, text: &str) -> Result<(), Failure> {
        Ok(ilon_trace::file::write_text(&self.path.join(name), text)?)
    }
}

/// Removes a file if it exists.
pub(super) fn remove(path: &Path) -> Result<(), Failure> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(Failure::write(path, &error))
        }
        _ => Ok(()),
    }
}

/// Refuses a figure that is not finite: in JSON it would be null, which means that a figure does
/// not apply.
fn check_finite(summary: &Summary) -> Result<(), Failure> {
    let figures = toml::Value::try_from(summary);
    let figures = figures.map_err(|error| Failure::encode("the summary", &error))?;
    match not_finite(&figures) {
        None => Ok(()),
        Some((name, value)) => Err(TraceError::Diverged {
            signal: name,
            t_s: summary.duration_s,
            value,
        }
        .into()),
    }
}

/// The first non-finite number in a value, with its dotted name.
fn not_finite(value: &toml::Value) -> Option<(String, f64)> {
    let within = |name: &str, value| {
        let (inner, number) = not_finite(value)?;
        let dot = if inner.is_empty() { "" } else { "." };
        Some((format!("{name}{dot}{inner}"), number))
    };
    match value {
        toml::Value::Float(number) if !number.is_finite() => Some((String::new(), *number)),
        toml::Value::Table(table) => table.iter().find_map(|(name, value)| within(name, value)),
        toml::Value::Array(values) => values
            .iter()
            .enumerate()
            .find_map(|(index, value)| within(&index.to_string(), value)),
        _ => None,
    }
}

/// Whether a file is what a run writes under that name.
fn is_result(path: &Path, name: &str) -> bool {
    let begins_with = |text: &str| {
        let mut head = Vec::new();
        let read = FileAccess::anywhere().open(path).and_then(|file| {
            use std::io::Read;
            Ok(file.take(4096).read_to_end(&mut head)?)
        });
        read.is_ok() && String::from_utf8_lossy(&head).contains(text)
    };
    match name {
        TRACE => ilon_trace::file::is_trace(path),
        SCENARIO => begins_with(RESOLVED.trim_end()),
        "report.html" => begins_with(report::GENERATOR),
        _ => {
            let json = FileAccess::anywhere().read(path, SUMMARY_BYTES);
            let json = json
                .ok()
                .and_then(|json| serde_json::from_slice(&json).ok());
            json.is_some_and(|json: serde_json::Value| json.get("trace_hash").is_some())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_that_is_no_number_is_refused_by_its_name() {
        let mut summary = Summary::default();
        assert!(check_finite(&summary).is_ok());
        summary.position_error_rms_m = Some(f64::NAN);
        let told = check_finite(&summary).unwrap_err().to_string();
        assert!(told.ends_with("`position_error_rms_m` is NaN"), "{told}");
        summary.position_error_rms_m = None;
        summary.twist_mean = Some(ilon_robot::Twist::new(0.0, f64::INFINITY, 0.0));
        let told = check_finite(&summary).unwrap_err().to_string();
        assert!(told.ends_with("`twist_mean.vy_m_s` is inf"), "{told}");
    }
}
