//! What programs of other languages need of the command: to be it, to write what it writes, and to say what it says.

use std::ffi::OsString;
use std::path::Path;

use clap::Parser;
use ilon_report as report;
use ilon_sweep::{Findings, Store, Study};
use ilon_trace::Recorded;
use miette::Diagnostic;

use super::failure::Failure;
use super::output::OutputFolder;
use super::{Cli, Outcome, context, dispatch, fault, identify, say, sweep};
use crate::Run;
use crate::judge::judge;
use crate::simulate::load_robot;

/// Runs the command of some arguments, the first of which is the command's own name; gives its exit code.
pub fn run_arguments(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            let printed = error.print();
            // Help is a result and has to arrive; of a fault the code says enough where nobody listens.
            if !error.use_stderr()
                && let Err(failure) = say::written(printed)
            {
                fault::show(failure);
                return 2;
            }
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    say::be_quiet(cli.quiet);
    match dispatch(cli.command) {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Unexpected) => 1,
        Ok(Outcome::BadInput) => 2,
        Err(error) => {
            fault::show(error);
            2
        }
    }
}

/// A fault as the command explains it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explained {
    /// What is wrong.
    pub message: String,
    /// How to repair it, where that is known.
    pub help: Option<String>,
    /// All of it as the command shows it: what, the lines at fault, what else is wrong, and how to repair it; without colours.
    pub shown: String,
}

/// Explains a fault as the command does.
pub fn explain(error: &dyn Diagnostic) -> Explained {
    Explained {
        message: error.to_string(),
        help: error.help().map(|help| help.to_string()),
        shown: fault::plain(error, "settings"),
    }
}

/// Writes the results of a run into a folder, as `ilon run --out` does: files appear whole, the summary last. `command` is what a
/// person would type for it, which stands in the report.
///
/// # Errors
/// Where the folder cannot be written to, is in use, or holds files of these names that no run has written.
pub fn write_results(folder: &Path, run: &Run, command: &str) -> Result<(), Explained> {
    write(folder, run, command).map_err(|failure| explain(&failure))
}

/// The report of a run as `ilon run` writes it, with its robot, its expectations and what made it.
pub fn report_html(run: &Run, command: &str) -> String {
    // A file that has gone since costs its picture alone.
    let robot = load_robot(&run.scenario).ok();
    let context = context::of(run, robot.as_ref(), &judge(run), command);
    report::html_with(&run.trace, &run.summary, &context)
}

/// Makes sure that the results of a study, written into a folder, replace nothing that it is made from, as `ilon sweep` does.
///
/// # Errors
/// Where they would.
pub fn may_hold_study(folder: &Path, study: &Study) -> Result<(), Explained> {
    sweep::refuse_inputs(folder, study, "another path").map_err(|failure| explain(&failure))
}

/// Writes what a study found into the folder of its results, as `ilon sweep` does, if its store has one.
///
/// # Errors
/// Where it cannot be written.
pub fn write_study(study: &Study, store: &Store, findings: &Findings) -> Result<(), Explained> {
    sweep::write(study, store, findings).map_err(|failure| explain(&failure))
}

/// Makes sure that what is identified, written into a folder, replaces nothing that it is made from, as `ilon identify` does.
///
/// # Errors
/// Where it would.
pub fn may_hold_identified(folder: &Path, study: &ilon_identify::Study) -> Result<(), Explained> {
    identify::refuse_inputs(folder, study, "another path").map_err(|failure| explain(&failure))
}

/// Writes what was identified into a folder, as `ilon identify` does.
///
/// # Errors
/// Where it is in use or cannot be written to.
pub fn write_identified(
    folder: &Path,
    study: &ilon_identify::Study,
    found: &ilon_identify::Identified,
) -> Result<(), Explained> {
    identify::write_claimed(study, found, folder).map_err(|failure| explain(&failure))
}

/// What a study found, as `ilon sweep` prints it.
pub fn study_words(study: &Study, findings: &Findings) -> String {
    sweep::words(study, findings)
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
