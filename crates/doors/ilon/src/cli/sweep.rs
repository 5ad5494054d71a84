//! `ilon sweep`: many runs of a scenario with varied keys, and their findings.

use std::path::{Path, PathBuf};

use ilon_sweep::{Findings, Options, Progress, Shard, Store, Study};

use super::escape::{one_line, path_in_line, sentence};
use super::json::pretty;
use super::kind::{Kind, wants};
use super::options::{Open, Out, Printing, Sandbox};
use super::outcome::Outcome;
use super::progress::Bar;
use super::{answer, console, flags, interrupt, results};
use crate::cli::failure::Failure;

/// Arguments of `ilon sweep`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The study file.
    #[arg(required_unless_present = "merge")]
    study: Option<PathBuf>,
    #[command(flatten)]
    out: Out,
    /// Runs at a time [default: as many as there are processors].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Run only part I of N, into its own subfolder, for job arrays.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["merge", "open"])]
    shard: Option<Shard>,
    /// Gather the results of one study from these folders and their shards, without running it.
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with = "study")]
    merge: Vec<PathBuf>,
    #[command(flatten)]
    printing: Printing,
    #[command(flatten)]
    open: Open,
    #[command(flatten)]
    sandbox: Sandbox,
}

/// Runs what is missing, writes, prints.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let Some(path) = &arguments.study else {
        return merge(arguments);
    };
    let files = arguments.sandbox.files()?;
    wants(path, &[Kind::Study], &files)?;
    let study = Study::load_within(path, &files)?;
    let out = arguments.out.or_of(study.name());
    results::refuse_study_inputs(&out, &study, "--out")?;
    let store = Store::open(&out, &study, arguments.shard)?;
    if store.damaged() > 0 {
        console::note(&format!(
            "note: {} rows could not be read again, and are run anew",
            store.damaged()
        ));
    }
    interrupt::leaves(|| ": the same command continues, and repeats no finished run".to_owned());
    let bar = Bar::new(study.name());
    let watch = |progress: Progress| {
        bar.show(progress.done as f64, progress.likely as f64, || {
            words_of(progress)
        });
    };
    let options = Options::new(arguments.jobs.map(usize::from), arguments.shard);
    let findings = ilon_sweep::sweep(&study, &store, &options, &watch)?;
    bar.done();
    if let Some(shard) = arguments.shard {
        let folder = store.folder().unwrap_or(&out).display().to_string();
        let part = serde_json::json!({
            "study": study.name(),
            "shard": shard.to_string(),
            "runs": store.rows().len(),
            "failed": findings.failed,
            "folder": folder,
        });
        let words = || {
            let whole = flags::shell(&out.display().to_string());
            format!(
                "shard {shard} of {}: {} runs in {}\nonce all shards have ended: ilon sweep --merge {whole} --out {whole}\n",
                study.name(),
                store.rows().len(),
                one_line(&folder),
            )
        };
        arguments.printing.answer(&format!("{part:#}\n"), words)?;
        return Ok(outcome(&findings));
    }
    show(arguments, &study, &store, &findings, &out)
}

/// Merges rows that were made elsewhere.
fn merge(arguments: &Arguments) -> Result<Outcome, Failure> {
    let out = match (&arguments.out.out, arguments.merge.as_slice()) {
        (Some(out), _) => out.clone(),
        // One folder is merged in place.
        (None, [one]) => one.clone(),
        (None, _) => {
            return Err(Failure::usage(
                "several folders are merged into one that --out does not name",
                "add --out DIR",
            ));
        }
    };
    let (study, store) = Store::merge(&arguments.merge, &out)?;
    let findings = ilon_sweep::findings(&study, &store);
    ilon_sweep::write_results(&study, &store, &findings)?;
    let options = Options::new(arguments.jobs.map(usize::from), None);
    ilon_sweep::keep_traces(&study, &store, &options)?;
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
    results::write_study(study, store, findings)?;
    let json = pretty("the findings", findings)?;
    arguments.printing.answer(&json, || {
        let kept = if out.join("kept").is_dir() {
            ", kept/"
        } else {
            ""
        };
        format!(
            "{}\nwritten to {}: report.html, runs.parquet, findings.json{kept}\n",
            answer::of_study(study, findings),
            path_in_line(out)
        )
    })?;
    for expectation in findings
        .expectations
        .iter()
        .filter(|expectation| !expectation.held)
    {
        let words = ilon_report::answers::sweep::expectation(expectation);
        console::note(&sentence(&format!("note: expected {words}")));
    }
    arguments.open.page(&out.join("report.html"));
    Ok(outcome(findings))
}

/// A study without a completed run has no results.
fn outcome(findings: &Findings) -> Outcome {
    if findings.runs > 0 && findings.failed == findings.runs {
        console::note("note: NO RUN CAME TO ITS END: nothing is known of the study");
        return Outcome::BadInput;
    }
    Outcome::Done
}

/// The progress of a study as text.
fn words_of(progress: Progress) -> String {
    let Progress {
        done,
        failed,
        likely,
        ..
    } = progress;
    let of = if progress.is_search { "of about" } else { "of" };
    let failed = match failed {
        0 => String::new(),
        failed => format!(", {failed} failed"),
    };
    format!("{done} {of} {likely} runs{failed}")
}
