//! The folder of results. Files appear whole or not at all, and the summary last: where there is one, all is there.
//!
//! While a run is under way its trace grows beside them in parts, so that one which is stopped, however, leaves a trace
//! up to its last second and nothing that looks complete.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ilon_trace::{Recorded, Recording};

use crate::simulate::{Run, Simulation};
use crate::{Error, report};

/// The files of a finished run, the one that stands for all of them first.
const RESULTS: [&str; 4] = ["summary.json", "report.html", TRACE, "scenario.toml"];

/// The trace, once it is whole.
const TRACE: &str = "trace.parquet";

/// Where the trace stands while it grows.
const GROWING: &str = "trace.partial";

/// A part of a growing trace covers at least this much of simulated time, in seconds.
const PART_S: f64 = 1.0;

/// Time between parts: writing one takes a few milliseconds, which runs far faster than real time would feel.
const BETWEEN_PARTS: Duration = Duration::from_millis(200);

/// A folder that results can be written to.
#[derive(Debug)]
pub(super) struct OutputFolder {
    path: PathBuf,
}

/// When what a run records is written as a part.
#[derive(Debug)]
pub(super) struct KeepingUp {
    /// Simulated time up to which it is written, in seconds.
    until_s: f64,
    /// When it was last written.
    written: Instant,
}

impl KeepingUp {
    pub fn new() -> Self {
        Self {
            until_s: 0.0,
            written: Instant::now(),
        }
    }

    /// Writes what has been recorded since, once that is a second's worth.
    pub fn keep_up(&mut self, time_s: f64, recording: &mut Recording) -> Result<(), Error> {
        if time_s >= self.until_s + PART_S && self.written.elapsed() >= BETWEEN_PARTS {
            recording.keep()?;
            self.until_s = time_s;
            self.written = Instant::now();
        }
        Ok(())
    }
}

impl OutputFolder {
    /// Makes sure, before anything is simulated, that the folder is there and can be written to.
    pub fn prepare(path: PathBuf) -> Result<Self, Error> {
        std::fs::create_dir_all(&path).map_err(|source| Error::write(&path, &source))?;
        let probe = path.join(format!(".ilon-{}", std::process::id()));
        std::fs::write(&probe, b"")
            .and_then(|()| std::fs::remove_file(&probe))
            .map_err(|source| Error::write(&path, &source))?;
        Ok(Self { path })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes room for the results of a run that begins now: those of an earlier one go, so that they are not taken for
    /// its own. Gives what it is recorded into.
    pub fn begin(&self, simulation: &Simulation) -> Result<Recording, Error> {
        for name in RESULTS {
            self.remove(&self.path.join(name))?;
        }
        for entry in std::fs::read_dir(&self.path).map_err(|e| Error::write(&self.path, &e))? {
            let path = entry.map_err(|e| Error::write(&self.path, &e))?.path();
            // What a process that was killed in the middle of writing has left.
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if RESULTS
                .iter()
                .any(|result| name.starts_with(&format!(".{result}.")))
                && name.ends_with(".partial")
            {
                self.remove(&path)?;
            }
        }
        let scenario = simulation.scenario().moved_to(&self.path).to_toml()?;
        self.write_text("scenario.toml", &scenario)?;
        Ok(Recording::into_file(
            simulation.trace().header.clone(),
            self.path.join(TRACE),
            self.path.join(GROWING),
        )?)
    }

    /// Writes report and summary of a run whose trace and scenario stand in the folder, the summary last.
    pub fn write(&self, run: &Run<Recorded>) -> Result<(), Error> {
        report::write_recorded(&self.path.join("report.html"), &run.trace, &run.summary)?;
        self.write_text("summary.json", &self.summary_json(run)?)
    }

    /// Writes all results of a run that was recorded elsewhere.
    pub fn write_all(&self, run: &Run<Recorded>) -> Result<(), Error> {
        // An older summary would make the new files look complete before they are.
        self.remove(&self.path.join("summary.json"))?;
        let scenario = run.scenario.moved_to(&self.path).to_toml()?;
        self.write_text("scenario.toml", &scenario)?;
        run.trace.write_parquet(&self.path.join(TRACE))?;
        self.write(run)
    }

    /// The content of `summary.json`.
    pub fn summary_json(&self, run: &Run<Recorded>) -> Result<String, Error> {
        let json = serde_json::to_string_pretty(&run.summary)
            .map_err(|error| Error::invalid(error.to_string(), ""))?;
        Ok(json + "\n")
    }

    fn write_text(&self, name: &str, text: &str) -> Result<(), Error> {
        Ok(ilon_trace::file::write_text(&self.path.join(name), text)?)
    }

    /// Removes a file if it is there.
    fn remove(&self, path: &Path) -> Result<(), Error> {
        match std::fs::remove_file(path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::write(path, &error))
            }
            _ => Ok(()),
        }
    }
}
