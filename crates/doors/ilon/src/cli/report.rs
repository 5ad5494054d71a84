//! `ilon report`: rebuilds the page of a run from its folder.

use std::path::{Path, PathBuf};

use ilon_trace::file::is_trace;
use ilon_trace::{Recorded, Settings, Summary};

use super::escape::{path_in_line, sentences};
use super::options::Sandbox;
use super::outcome::Outcome;
use super::{compare, console, context, flags, open, reserve};
use crate::Scenario;
use crate::cli::failure::Failure;
use crate::judge::judge_rows;
use crate::report;
use crate::simulate::{Run, load_robot};

/// Arguments of `ilon report`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The folder that `ilon run` wrote.
    folder: PathBuf,
    /// File of the page [default: `report.html` in the folder].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Open the page in the browser.
    #[arg(long)]
    open: bool,
    #[command(flatten)]
    sandbox: Sandbox,
}

/// The error for a path that is not the folder of a finished run.
fn no_run(path: &Path) -> Failure {
    let written = "name a folder that `ilon run` wrote: it holds trace.parquet and scenario.toml";
    if !path.is_file() {
        let message = format!("`{}` holds no finished run", path.display());
        return Failure::usage(message, written);
    }
    let above = path.parent().filter(|above| !above.as_os_str().is_empty());
    let above = above.unwrap_or(Path::new("."));
    if above.join("trace.parquet").exists() && above.join("scenario.toml").exists() {
        return Failure::usage(
            format!(
                "`{}` is a file, and a page is made from the folder of a run",
                path.display()
            ),
            format!(
                "name the folder: `ilon report {}`",
                flags::shell(&above.display().to_string())
            ),
        );
    }
    if is_trace(path) {
        return Failure::usage(
            format!(
                "`{}` is a trace without the scenario.toml of its run, and a page needs both",
                path.display()
            ),
            format!("{written}; `ilon compare` reads traces alone"),
        );
    }
    let message = format!("`{}` is a file, not the folder of a run", path.display());
    Failure::usage(message, written)
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let folder = &arguments.folder;
    let file = folder.join("trace.parquet");
    let resolved = folder.join("scenario.toml");
    if !file.exists() || !resolved.exists() {
        return Err(no_run(folder));
    }
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| folder.join("report.html"));
    let _claim = reserve::file(
        &out,
        "--out",
        &[file.clone(), resolved.clone(), folder.join("summary.json")],
    )?;
    let files = arguments.sandbox.files()?;
    compare::within(folder, &files)?;
    let trace = Recorded::open(&file)?;
    let summary = Summary::of_rows(&trace, &Settings::default())?;
    let run = Run {
        scenario: Scenario::load_within(&resolved, &[], &files)?,
        trace,
        summary,
        warnings: Vec::new(),
    };
    let verdicts = judge_rows(&run)?;
    let robot = load_robot(&run.scenario).ok();
    let context = context::of(&run, robot.as_ref(), &verdicts, &context::command_line());
    let answer = report::write_recorded(&out, &run.trace, &run.summary, &context)?;
    let (answer, page) = (sentences(&answer), path_in_line(&out));
    console::lines(&format!("{answer}\nwritten to {page}\n"))?;
    if arguments.open {
        open::page(&out);
    }
    Ok(Outcome::Done)
}
