//! `ilon sweep`: many runs of a scenario under keys that vary, and what they say.

mod answer;
mod progress;

use std::path::{Path, PathBuf};

use ilon_sim::sweep::{self, Findings, Options, Shard, Store, Study};

use self::progress::Bar;
use super::escape::one_line;
use super::{Outcome, Sandbox, claim, flags, say};
use crate::cli::failure::Failure;
use crate::pages;

/// Arguments of `ilon sweep`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The study file.
    #[arg(required_unless_present = "merge")]
    study: Option<PathBuf>,
    /// Where to write results. Where some of this study are there already, only what is missing is run.
    #[arg(long, value_name = "DIR", default_value = "out/<study>")]
    out: PathBuf,
    /// Runs at a time [default: as many as the machine has cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Make only this part of the runs, the I-th of N, into a folder of its own within that of the study: for job arrays.
    #[arg(long, value_name = "I/N", conflicts_with = "merge")]
    shard: Option<Shard>,
    /// Gather the results of one study from these folders, and from the shards in them, instead of running it.
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with = "study")]
    merge: Vec<PathBuf>,
    /// Print what was found as JSON, and nothing else, on standard output; of a shard, what it ran.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    sandbox: Sandbox,
}

/// Runs what is missing, writes, prints.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let Some(path) = &arguments.study else {
        return merge(arguments);
    };
    let study = Study::load_within(path, &arguments.sandbox.files()?)?;
    let out = out_folder(&arguments.out, study.name());
    refuse_inputs(&out, &study, "--out")?;
    let store = Store::open(&out, &study, arguments.shard)?;
    if store.damaged() > 0 {
        say::note(&format!(
            "note: {} rows could not be read again, and are run anew",
            store.damaged()
        ));
    }
    let bar = Bar::new(study.name());
    let options = Options::new(arguments.jobs.map(usize::from), arguments.shard);
    let findings = sweep::sweep(&study, &store, &options, &|progress| bar.show(progress))?;
    bar.done();
    if let Some(shard) = arguments.shard {
        let folder = store.folder().unwrap_or(&out).display().to_string();
        if arguments.json {
            let part = serde_json::json!({
                "study": study.name(),
                "shard": shard.to_string(),
                "runs": store.rows().len(),
                "failed": findings.failed,
                "folder": folder,
            });
            say::data(&format!("{part:#}\n"))?;
            return Ok(outcome(&findings));
        }
        say::lines(&format!(
            "shard {shard} of {}: {} runs in {}\nonce all shards have ended: ilon sweep --merge {} --out {}\n",
            study.name(),
            store.rows().len(),
            one_line(&folder),
            flags::shell(&out.display().to_string()),
            flags::shell(&out.display().to_string()),
        ))?;
        return Ok(outcome(&findings));
    }
    show(arguments, &study, &store, &findings, &out)
}

/// Refuses a folder, which an option names, in which results would replace what the study is made from.
pub(super) fn refuse_inputs(out: &Path, study: &Study, option: &str) -> Result<(), Failure> {
    let scenarios = (0..study.scenario_names().count()).map(|index| study.scenario_path(index));
    let inputs: Vec<PathBuf> = std::iter::once(study.path())
        .chain(scenarios)
        .map(Path::to_owned)
        .collect();
    for name in ["runs.parquet", "findings.json", "report.html", "study.json"] {
        claim::not_an_input(&out.join(name), option, &inputs)?;
    }
    Ok(())
}

/// Writes the results and their page, if the store has a folder.
pub(super) fn write(study: &Study, store: &Store, findings: &Findings) -> Result<(), Failure> {
    sweep::write_results(study, store, findings)?;
    if let Some(folder) = store.folder() {
        pages::sweep::write(&folder.join("report.html"), study, &store.rows(), findings)?;
    }
    Ok(())
}

/// Gathers rows that were made elsewhere.
fn merge(arguments: &Arguments) -> Result<Outcome, Failure> {
    let out = match (arguments.out.to_str(), arguments.merge.as_slice()) {
        // One folder is merged in its place.
        (Some("out/<study>"), [one]) => one.clone(),
        (Some("out/<study>"), _) => {
            return Err(Failure::usage(
                "several folders are merged into one that --out does not name",
                "add --out DIR",
            ));
        }
        _ => arguments.out.clone(),
    };
    let (study, store) = Store::merge(&arguments.merge, &out)?;
    let findings = sweep::findings(&study, &store);
    sweep::write_results(&study, &store, &findings)?;
    let options = Options::new(arguments.jobs.map(usize::from), None);
    sweep::keep_traces(&study, &store, &options)?;
    show(arguments, &study, &store, &findings, &out)
}

/// Writes the results, and prints them.
fn show(
    arguments: &Arguments,
    study: &Study,
    store: &Store,
    findings: &Findings,
    out: &Path,
) -> Result<Outcome, Failure> {
    write(study, store, findings)?;
    if arguments.json {
        let json = serde_json::to_string_pretty(findings);
        let json = json.map_err(|error| Failure::encode("the findings", &error))?;
        say::data(&(json + "\n"))?;
    } else {
        let kept = if out.join("kept").is_dir() {
            ", kept/"
        } else {
            ""
        };
        say::lines(&format!(
            "{}\nwritten to {}: report.html, runs.parquet, findings.json{kept}\n",
            answer::words(study, findings),
            one_line(&out.display().to_string())
        ))?;
    }
    for expectation in findings
        .expectations
        .iter()
        .filter(|expectation| !expectation.held)
    {
        say::note(&one_line(&format!(
            "note: expected {}",
            answer::expectation(expectation)
        )));
    }
    Ok(outcome(findings))
}

/// A study of which no run came to its end has no results.
fn outcome(findings: &Findings) -> Outcome {
    if findings.runs > 0 && findings.failed == findings.runs {
        say::note("note: NO RUN CAME TO ITS END: nothing is known of the study");
        return Outcome::BadInput;
    }
    Outcome::Done
}

/// The folder of a study's results: the default is one of its name.
pub(super) fn out_folder(out: &Path, study: &str) -> PathBuf {
    match out.to_str() {
        Some("out/<study>") => PathBuf::from("out").join(study),
        _ => out.to_owned(),
    }
}

pub(super) use answer::{verdicts, words};
