//! Functions for bindings in other languages: they write files and format errors as the command
//! does.

use std::path::Path;

use ilon_formats::{LoadRobot, Spec, SpecOnTyres};
use ilon_identify::tape::{Tape, TapeFit};
use ilon_report as report;
use ilon_robot::Robot;
use ilon_sweep::{Findings, Row, Store, Study};
use ilon_trace::Recorded;
use miette::Diagnostic;

use super::failure::Failure;
use super::output::OutputFolder;
use super::{again, answer, context, fault, results};
use crate::judge::judge;
use crate::simulate::{Simulation, load_robot};
use crate::{Error, Run, Scenario};

/// An error with its explanation.
#[derive(Clone, Debug, PartialEq, Eq)]
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
pub fn write_results(folder: &Path, run: &Run, command: &str) -> Result<(), Explained> {
    write(folder, run, command).map_err(|failure| explain(&failure))
}

/// The report of a run as `ilon run` writes it, with its robot, expectations and provenance.
pub fn report_html(run: &Run, command: &str) -> String {
    // If the robot's file no longer exists, only its picture is missing.
    let robot = load_robot(&run.scenario).ok();
    let context = context::of(run, robot.as_ref(), &judge(run), command);
    report::html_with(&run.trace, &run.summary, &context)
}

/// Checks that the results of a study, written into a folder, would replace none of its inputs, as
/// `ilon sweep` does.
///
/// # Errors
/// If they would.
pub fn may_hold_study(folder: &Path, study: &Study) -> Result<(), Explained> {
    results::refuse_study_inputs(folder, study, "another path").map_err(|failure| explain(&failure))
}

/// Writes the findings of a study into its results folder, as `ilon sweep` does, if its store has
/// one.
///
/// # Errors
/// If it cannot be written.
pub fn write_study(study: &Study, store: &Store, findings: &Findings) -> Result<(), Explained> {
    results::write_study(study, store, findings).map_err(|failure| explain(&failure))
}

/// Checks that the results of an identification, written into a folder, would replace none of its
/// inputs, as `ilon identify` does.
///
/// # Errors
/// If they would.
pub fn may_hold_identified(folder: &Path, study: &ilon_identify::Study) -> Result<(), Explained> {
    results::refuse_identify_inputs(folder, study, "another path")
        .map_err(|failure| explain(&failure))
}

/// Writes the results of an identification into a folder, as `ilon identify` does.
///
/// # Errors
/// If the folder is in use or cannot be written to.
pub fn write_identified(
    folder: &Path,
    study: &ilon_identify::Study,
    found: &ilon_identify::Identified,
) -> Result<(), Explained> {
    results::claim_and_write_identified(study, found, folder).map_err(|failure| explain(&failure))
}

/// Fits runs measured by tape and writes what was found into a folder, as `ilon identify` does.
///
/// # Errors
/// Those of the fit; if the folder is in use or cannot be written to.
pub fn fit_tape_into(folder: &Path, tape: &Tape) -> Result<TapeFit, Explained> {
    let written = results::fit_tape(tape, folder, "another path");
    let written = written.map(|(found, _)| found);
    written.map_err(|failure| explain(&failure))
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

fn write(folder: &Path, run: &Run, command: &str) -> Result<(), Failure> {
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
