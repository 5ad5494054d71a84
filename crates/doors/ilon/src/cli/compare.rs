//! `ilon compare`: several runs side by side, as a table and as one page.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_trace::Quantity;
use ilon_trace::file::write_text;

use super::escape::{path_in_line, sentences};
use super::json::pretty;
use super::kind::{Kind, wants};
use super::options::Sandbox;
use super::outcome::Outcome;
use super::progress::Bar;
use super::table::Table;
use super::{console, open, reserve};
use crate::cli::failure::Failure;
use crate::compare::{CompareError, ComparedRun, Comparison};
use crate::simulate::Simulation;
use crate::{Scenario, report};
use ilon_sim::gathered;

/// Kinds of input that can be compared.
const WHAT_TO_NAME: &str =
    "name a folder that `ilon run --out` wrote, a trace file, or a scenario file to run";

/// Arguments of `ilon compare`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Folders that `ilon run` wrote, trace files, or scenario files to run.
    #[arg(required = true, num_args = 2.., value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// File of the page.
    #[arg(long, value_name = "FILE", default_value = "out/compare.html")]
    out: PathBuf,
    /// Open the page in the browser.
    #[arg(long)]
    open: bool,
    #[command(flatten)]
    sandbox: Sandbox,
    /// Print names, differing keys and summaries as JSON, and nothing else, on standard output.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let out = &arguments.out;
    if let Some(folder) = out.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(|source| Failure::write(folder, &source))?;
    }
    let within = |run: &PathBuf| {
        [
            run.clone(),
            run.join("trace.parquet"),
            run.join("summary.json"),
        ]
    };
    let inputs: Vec<PathBuf> = arguments.runs.iter().flat_map(within).collect();
    let _claim = reserve::file(out, "--out", &inputs)?;
    let files = arguments.sandbox.files()?;
    let runs = arguments.runs.iter().map(|path| load(path, &files));
    let comparison =
        Comparison::of(runs.collect::<Result<_, Failure>>()?, &arguments.runs).map_err(refused)?;
    write_text(out, &report::compare::html(&comparison))?;
    if arguments.json {
        console::data(&json(&comparison)?)?;
    } else {
        console::lines(&format!(
            "{}\n{}\nwritten to {}\n",
            sentences(&report::compare::answers(&comparison)),
            table(&comparison),
            path_in_line(out)
        ))?;
    }
    if arguments.open {
        open::page(out);
    }
    Ok(Outcome::Done)
}

/// The error for runs that cannot be compared, with what to pass instead.
fn refused(error: CompareError) -> Failure {
    match error {
        CompareError::Read { path, source } => Failure::read(&path, source),
        CompareError::Summary { .. } => Failure::usage(
            error.to_string(),
            "delete it, and the figures are computed from the trace, or run the scenario again",
        ),
        CompareError::TooFew => Failure::usage(
            error.to_string(),
            "name at least two run folders, trace files or scenario files",
        ),
        _ => Failure::usage(error.to_string(), WHAT_TO_NAME),
    }
}

/// Refuses a run (folder or trace) with a file outside the permitted folders, also through a link.
pub(super) fn within(run: &Path, files: &FileAccess) -> Result<(), Failure> {
    let names = ["", "trace.parquet", "summary.json", "scenario.toml"];
    let mut there = names.iter().map(|name| match *name {
        "" => run.to_owned(),
        name => run.join(name),
    });
    let refused = there.find_map(|file| {
        let reason = match file.is_file() && files.is_confined() {
            true => files.open(&file).err()?,
            false => return None,
        };
        Some((file, reason))
    });
    match refused {
        None => Ok(()),
        Some((file, reason)) => Err(Failure::usage(
            format!("cannot read `{}`: {reason}", path_in_line(&file)),
            "name runs below the folders of --sandbox",
        )),
    }
}

/// Loads a run from its folder or trace; a scenario is simulated.
fn load(path: &Path, files: &FileAccess) -> Result<ComparedRun, Failure> {
    let is_scenario = path.extension().is_some_and(|end| end == "toml") && path.is_file();
    if !is_scenario {
        within(path, files)?;
        return ComparedRun::load(path).map_err(refused);
    }
    wants(path, &[Kind::Scenario], files)?;
    let scenario = Scenario::load_within(path, &[], files)?;
    let simulation = Simulation::new(&scenario)?;
    let bar = Bar::new(&scenario.name);
    for warning in gathered(simulation.warnings()) {
        bar.note(&format!("note: {warning}"));
    }
    let run = simulation.run_observed(|progress| bar.simulated(progress));
    bar.done();
    run.trace.check_finite()?;
    Ok(ComparedRun::new(run.scenario.name, run.trace, run.summary))
}

/// The differences and the figures, one column per run.
fn table(comparison: &Comparison) -> Table {
    let mut table = Table::new();
    let names: Vec<String> = comparison.runs.iter().map(|run| run.name.clone()).collect();
    table.heading("runs");
    table.words("", &names);
    if !comparison.differences.is_empty() {
        table.heading("set differently");
        for row in &comparison.differences {
            let values = row.values.iter();
            let words = values.map(|value| value.clone().unwrap_or_else(|| "-".to_owned()));
            table.words(&row.key, &words.collect::<Vec<_>>());
        }
    }
    for (verdict, all) in report::compare::verdicts(comparison) {
        table.heading(verdict);
        for named in all {
            table.words(
                &format!("{}: {}", named.heading, named.quantity.label),
                &changes(comparison, named.quantity),
            );
        }
    }
    for (heading, quantities) in comparison.groups() {
        table.heading(heading);
        for quantity in quantities {
            let values: Vec<_> = comparison
                .runs
                .iter()
                .map(|run| quantity.shown(&run.summary))
                .collect();
            table.row_of(
                quantity.label,
                &values,
                quantity.decimals,
                quantity.unit.symbol,
            );
        }
    }
    table
}

/// A figure of the first run, and those of the others with their change.
fn changes(comparison: &Comparison, quantity: &Quantity) -> Vec<String> {
    let shown = comparison
        .runs
        .iter()
        .map(|run| quantity.shown(&run.summary));
    let shown: Vec<Option<f64>> = shown.collect();
    let change = |x: f64| report::compare::change(quantity, shown[0]?, x);
    let word = |(index, x): (usize, &Option<f64>)| match x {
        None => "-".to_owned(),
        Some(x) => {
            let change = change(*x).filter(|_| index > 0);
            let change = change.map_or(String::new(), |change| format!(" ({change})"));
            format!("{x:.*} {}{change}", quantity.decimals, quantity.unit.symbol)
        }
    };
    shown.iter().enumerate().map(word).collect()
}

fn json(comparison: &Comparison) -> Result<String, Failure> {
    let all = serde_json::json!({ "runs": comparison.summaries(), "differences": comparison.differences });
    pretty("the comparison", &all)
}
