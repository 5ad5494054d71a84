//! Functions for bindings in other languages: they write files and format errors as the command
//! does.

use std::path::Path;

use ilon_formats::{LoadRobot, Spec, SpecOnTyres};
use ilon_report as report;
use ilon_robot::Robot;
use ilon_sweep::{Findings, Row, Study};
use ilon_trace::Recorded;
use miette::Diagnostic;
use serde::Serialize;

use super::failure::Failure;
use super::output::OutputFolder;
use super::{again, answer, context, fault};
use crate::judge::judge;
use crate::simulate::{Simulation, load_robot};
use crate::{Error, Run, Scenario};

/// An error with its explanation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Explained {
    /// The message.
    pub message: String,
    /// How to repair it, if known.
    pub help: Option<String>,
    /// The whole text that the command shows, without colours: message, lines at fault, related
    /// errors and help.
    pub shown: String,
}

/// Explains an error as the command does.
pub fn explain(error: &dyn Diagnostic) -> Explained {
    Explained {
        message: error.to_string(),
        help: error.help().map(|help| help.to_string()),
        shown: fault::plain(error, "settings"),
    }
}

impl<E: Into<Error>> From<E> for Explained {
    fn from(error: E) -> Self {
        explain(&error.into())
    }
}

/// The URDF of a robot description, if it can be read and simulated.
///
/// # Errors
/// [`Error`] if the description is impossible, or its robot cannot be simulated.
pub fn generated(spec: &Path) -> Result<String, Error> {
    /// The smallest scenario of a robot.
    const STANDING: &str = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 0.1\n";
    let urdf = match SpecOnTyres::load(spec)? {
        Some(spec) => ilon_formats::generate_on_tyres(&spec),
        None => ilon_formats::generate(&Spec::load(spec)?)?,
    };
    let robot = Robot::from_urdf_str(&urdf, &format!("{} (generated)", spec.display()))?;
    Simulation::with_robot(&Scenario::from_toml(STANDING, "standing", "")?, &robot)?;
    Ok(urdf)
}

/// Writes the results of a run into a folder as `ilon run --out` does: each file whole, the summary
/// last. `command` is the equivalent command line for the report.
///
/// # Errors
/// If the folder cannot be written to, is in use, or holds files of these names that no run has
/// written.
pub fn write_results(folder: &Path, run: &Run, command: &str) -> Result<(), Failure> {
    let folder = OutputFolder::prepare(folder.to_owned(), "another path", &[])?.made_by(command);
    let verdicts = judge(run);
    let run = Run {
        scenario: run.scenario.clone(),
        trace: Recorded::Memory(run.trace.clone()),
        summary: run.summary.clone(),
        warnings: run.warnings.clone(),
    };
    folder.write_all(&run, &verdicts)
}

/// The report of a run as `ilon run` writes it, with its robot, expectations and provenance.
pub fn report_html(run: &Run, command: &str) -> String {
    // If the robot's file no longer exists, only its picture is missing.
    let robot = load_robot(&run.scenario).ok();
    let context = context::of(run, robot.as_ref(), &judge(run), command);
    report::html_with(&run.trace, &run.summary, &context)
}

/// The page of a study, as `ilon sweep` writes it.
pub fn study_page(study: &Study, rows: &[Row], findings: &Findings) -> String {
    let again = |run| again::command(study, rows, run);
    ilon_report::pages::sweep::html(study, rows, findings, &again)
}

/// The findings of a study, as `ilon sweep` prints them.
pub fn study_words(study: &Study, findings: &Findings) -> String {
    answer::of_study(study, findings)
}
