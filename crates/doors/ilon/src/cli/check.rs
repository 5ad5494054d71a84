//! `ilon check`: runs scenarios in parallel and compares each with its own `[expect]`.

mod junit;
mod outcome;
mod scenarios;
mod update;

use std::collections::BTreeSet;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ilon_files::FileAccess;
use ilon_sweep::{Options, Store, Study};
use ilon_trace::{Recorded, Recording, Rows as _, Summary, file};
use rayon::prelude::*;

use self::outcome::{Checked, Count, Ended, Judged};
use self::scenarios::CheckedFile;
use self::update::Update;
use super::answer::verdicts;
use super::converge::Converge;
use super::escape::one_line;
use super::kind::{Kind, kind, wants};
use super::options::{Sandbox, Settings};
use super::outcome::Outcome;
use super::output::{OutputFolder, remove};
use super::reserve::{self, ReservedOutput};
use super::{console, fault};
use crate::Scenario;
use crate::cli::failure::Failure;
use crate::judge::{Difference, differences, judge_changes, judge_rows};
use crate::report::difference;
use crate::simulate::{Run, Simulation};

/// Arguments of `ilon check`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scenario files and studies, and folders of them: every `.toml` file below counts.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Write the results as JUnit XML, for CI.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Add the results to this file as a table in Markdown: in GitHub's CI, `$GITHUB_STEP_SUMMARY`.
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    /// Print the results as JSON, and nothing else, on standard output.
    #[arg(long)]
    json: bool,
    /// Run only scenarios whose name, or subfolder, contains this.
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// Stop after the first failure.
    #[arg(long)]
    fail_fast: bool,
    /// Keep the results of failed scenarios below this folder.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Write the trace of each scenario into this folder, as a baseline.
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// Compare each trace with the baseline in this folder, within `[expect.tolerances]`.
    /// Differences are drawn in `difference.html` below `--keep` or `out/check`.
    #[arg(long, value_name = "DIR")]
    against: Option<PathBuf>,
    /// Reset bounds that fail to the measured values plus MARGIN (0.1 is 10 %) in the scenarios'
    /// files; every change is shown.
    #[arg(long, value_name = "MARGIN", num_args = 0..=1, default_missing_value = "0.1", value_parser = margin)]
    update: Option<f64>,
    /// Write bounds into scenarios that have none, MARGIN (0.1 is 10 %) from the measured headline
    /// figures: upper bounds on costs, both on ratios and on the largest commanded wheel rate.
    #[arg(
        long,
        value_name = "MARGIN",
        num_args = 0..=1,
        default_missing_value = "0.1",
        value_parser = margin,
        conflicts_with = "update"
    )]
    init: Option<f64>,
    /// Scenarios at a time [default: as many as there are processors].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    #[command(flatten)]
    converge: Converge,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    sandbox: Sandbox,
}

/// Largest margin; chosen. A wider bound tests nothing, and is a percentage that was taken for a
/// fraction.
const MOST_MARGIN: f64 = 10.0;

fn margin(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(margin) if (0.0..=MOST_MARGIN).contains(&margin) => Ok(margin),
        _ => Err(format!(
            "write a fraction from 0 to {MOST_MARGIN}, such as 0.1 for 10 %; files go before the option"
        )),
    }
}

/// Runs all scenarios and prints a line for each.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let files = arguments.sandbox.files()?;
    let rewrites = arguments.update.or(arguments.init).is_some();
    if rewrites && !arguments.settings.settings.is_empty() {
        let option = match arguments.update {
            Some(_) => "--update",
            None => "--init",
        };
        return Err(Failure::usage(
            format!(
                "{option} would write into the files what was measured under --set, which is not in them"
            ),
            "change the keys in the files, or leave one of the two out",
        ));
    }
    let found = scenarios::find(&arguments.paths, arguments.filter.as_deref(), &files)?;
    say_what_studies_leave_out(arguments, &found, &files);
    let _claims = claims(arguments, &found)?;
    let names: BTreeSet<PathBuf> = found.iter().map(|one| one.name.clone()).collect();
    let stop = AtomicBool::new(false);
    let settings = arguments.settings.words();
    let check_all = || {
        let each = found.into_par_iter();
        let each = each.map(|one| {
            let mut checked = check(one, arguments, &files, &stop);
            // Before it is reported as written.
            checked.write_update();
            if arguments.fail_fast && checked.has_failed() {
                stop.store(true, Ordering::Relaxed);
            }
            // One write per scenario, so that lines of different threads do not mix; a closed
            // reader is no error here.
            if !arguments.json {
                let lines = checked.lines(&settings);
                let _ = if checked.has_failed() {
                    console::failed(&lines)
                } else {
                    console::lines(&lines)
                };
            }
            checked
        });
        each.collect::<Vec<Checked>>()
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.jobs.map_or(0, usize::from))
        .build()
        .map_err(|error| {
            Failure::usage(
                format!("the threads could not be started: {error}"),
                "ask for fewer with --jobs",
            )
        })?;
    let checked = pool.install(check_all);
    if let Some(path) = &arguments.junit {
        file::write_text(path, &junit::xml(&checked, &settings)?)?;
    }
    if let Some(path) = &arguments.markdown {
        add_to(path, &outcome::markdown(&checked, &settings))?;
    }
    if arguments.json {
        console::data(&outcome::json(&checked)?)?;
    } else {
        console::lines(&format!("\n{}", outcome::totals(&checked)))?;
    }
    let is_whole = arguments.filter.is_none() && arguments.paths.iter().all(|path| path.is_dir());
    if let (Some(folder), true) = (&arguments.against, is_whole) {
        say_what_is_gone(folder, &names)?;
    }
    let expects_nothing = |one: &Checked| one.count() == Count::NothingExpected;
    if arguments.save.is_none() && checked.iter().all(expects_nothing) {
        fault::show(Failure::usage(
            "NOTHING WAS CHECKED: no scenario has an `[expect]`, so that none of them can fail",
            "write bounds, or let `ilon check --init` write the first ones",
        ));
        return Ok(Outcome::NothingChecked);
    }
    let mut outcome = Outcome::Done;
    for one in checked {
        match (one.count(), one.result) {
            (_, Ended::Refused(error)) => {
                console::watching(&format!("{}:\n", one_line(&one.label)));
                fault::show(error);
                outcome = Outcome::BadInput;
            }
            (Count::Failed, _) if outcome == Outcome::Done => outcome = Outcome::Unexpected,
            _ => {}
        }
    }
    Ok(outcome)
}

/// Appends text to a file, which is created if missing.
fn add_to(path: &Path, text: &str) -> Result<(), Failure> {
    let failed = |source| Failure::write(path, &source);
    let mut options = std::fs::OpenOptions::new();
    let mut file = options
        .append(true)
        .create(true)
        .open(path)
        .map_err(failed)?;
    file.write_all(text.as_bytes()).map_err(failed)
}

/// Names the options without effect on a study, for each study that is checked.
fn say_what_studies_leave_out(arguments: &Arguments, found: &[CheckedFile], files: &FileAccess) {
    let options = [
        ("--keep", arguments.keep.is_some()),
        ("--save", arguments.save.is_some()),
        ("--against", arguments.against.is_some()),
        ("--update", arguments.update.is_some()),
        ("--init", arguments.init.is_some()),
        ("--converge", arguments.converge.converge),
    ];
    let given = options.iter().filter(|(_, is_given)| *is_given);
    let given: Vec<&str> = given.map(|(option, _)| *option).collect();
    if given.is_empty() {
        return;
    }
    let is_study = |one: &&CheckedFile| kind(&one.path, files) == Some(Kind::Study);
    for study in found.iter().filter(is_study) {
        console::note(&format!(
            "note: `{}` is a study, of which {} does nothing",
            study.label,
            given.join(" and ")
        ));
    }
}

/// Reserves all outputs before simulation: each is writable, replaces no input, and belongs to one
/// scenario only.
fn claims(arguments: &Arguments, found: &[CheckedFile]) -> Result<Vec<ReservedOutput>, Failure> {
    let Arguments {
        junit,
        markdown,
        keep,
        save,
        against,
        ..
    } = arguments;
    let mut inputs: Vec<PathBuf> = found.iter().map(|one| one.path.clone()).collect();
    if let (Some(save), Some(against)) = (save, against)
        && (save == against || reserve::is_same_file(save, against))
    {
        return Err(Failure::usage(
            "--save and --against name the same folder: what fails against its baseline would become the baseline",
            "hold the scenarios --against it first, and then --save them",
        ));
    }
    let named = [("--save", save), ("--against", against), ("--keep", keep)];
    for (option, folder) in named {
        if folder.is_some() {
            scenarios::refuse_equal_names(found, option)?;
        }
    }
    if let Some(folder) = against {
        inputs.extend(found.iter().map(|one| baseline_file(folder, &one.name)));
    }
    let mut claims = Vec::new();
    for (option, path) in [("--junit", junit), ("--markdown", markdown)] {
        if let Some(path) = path {
            claims.push(reserve::file(path, option, &inputs)?);
        }
    }
    if let Some(folder) = save {
        claims.push(reserve::folder(folder, "--save")?);
        let baselines = found.iter().map(|one| baseline_file(folder, &one.name));
        let mut below = BTreeSet::new();
        for baseline in baselines {
            reserve::not_an_input(&baseline, "--save", &inputs)?;
            below.extend(baseline.parent().map(Path::to_owned));
        }
        for folder in below {
            std::fs::create_dir_all(&folder).map_err(|source| Failure::write(&folder, &source))?;
            file::clear_unfinished(&folder)?;
        }
    }
    if arguments.update.or(arguments.init).is_some() {
        let file = |one: &CheckedFile| one.path.canonicalize().ok();
        let folders: BTreeSet<_> = found
            .iter()
            .filter_map(|one| Some(file(one)?.parent()?.to_owned()))
            .collect();
        for folder in folders {
            file::clear_unfinished(&folder)?;
        }
    }
    if let Some(folder) = keep {
        claims.push(reserve::folder(folder, "--keep")?);
        for one in found {
            OutputFolder::refuse_losses(&folder.join(&one.name), "--keep", &inputs)?;
        }
    }
    Ok(claims)
}

fn check(
    found: CheckedFile,
    arguments: &Arguments,
    files: &FileAccess,
    stop: &AtomicBool,
) -> Checked {
    let start = Instant::now();
    let ended = |result, took| Checked {
        label: found.label.clone(),
        path: found.path.clone(),
        took,
        result,
    };
    if let Some(error) = found.refused {
        return Checked {
            label: found.label,
            path: found.path,
            took: Duration::ZERO,
            result: Ended::Refused(error),
        };
    }
    if stop.load(Ordering::Relaxed) {
        return ended(Ended::Skipped, Duration::ZERO);
    }
    // A panic in one scenario must not cost the verdicts on the others.
    let checked = AssertUnwindSafe(|| run_and_judge(&found.path, &found.name, arguments, files));
    let result = match catch_unwind(checked) {
        Ok(Ok(judged)) => Ended::Judged(judged),
        Ok(Err(error)) => Ended::Refused(error),
        Err(_) => Ended::Refused(Failure::BrokeDown),
    };
    ended(result, start.elapsed())
}

fn run_and_judge(
    path: &Path,
    name: &Path,
    arguments: &Arguments,
    files: &FileAccess,
) -> Result<Judged, Failure> {
    if kind(path, files) == Some(Kind::Study) {
        return run_and_judge_study(path, arguments, files);
    }
    wants(path, &[Kind::Scenario, Kind::Study], files)?;
    let mut scenario = Scenario::load_within(path, &arguments.settings.settings, files)?;
    scenario.run.converge |= arguments.converge.converge;
    scenario.expect.check_windows(&scenario.run)?;
    let baseline = arguments.against.as_deref();
    let baseline = baseline
        .map(|folder| baseline_in(folder, name))
        .transpose()?;
    let changes = scenario.expect.changes.clone();
    if let (Some(key), None, None) = (changes.keys().next(), &baseline, &arguments.save) {
        return Err(Failure::usage(
            format!("`expect.{key}` bounds a change against a baseline, and none is given"),
            "write a baseline with --save DIR, and compare with it by --against DIR",
        ));
    }
    let simulation = Simulation::new(&scenario)?;
    let recording = Recording::temporary(simulation.trace().header.clone());
    let run = simulation.run_recorded(recording, |_, _| Ok::<(), Failure>(()))?;
    // A baseline that is written agrees with its run.
    let is_first = arguments.save.is_some() && !changes.is_empty();
    let mut differences = is_first.then(Vec::new);
    let (mut drawn, mut moved) = (None, Vec::new());
    let mut changed = Vec::new();
    if let Some(baseline) = baseline {
        let (found, page) = against(&run, &baseline, name, arguments)?;
        if !found.is_empty() || !changes.is_empty() {
            let before = Summary::of_rows(&baseline, &Default::default())?;
            let before_it = (&before, baseline.header());
            changed = judge_changes(&run.scenario.expect, &run.summary, before_it);
            moved = outcome::moved(&run.summary, before_it);
        }
        // Where only changes of figures are bounded, no signal is compared.
        if changes.is_empty() || !run.scenario.expect.tolerances.is_empty() {
            (differences, drawn) = (Some(found), page);
        }
    }
    if let Some(folder) = &arguments.save {
        run.trace.write_parquet(&baseline_file(folder, name))?;
    }
    let mut verdicts = judge_rows(&run)?;
    verdicts.extend(changed);
    let update =
        match (arguments.update, arguments.init) {
            (Some(margin), _) => Some(Update::of(path, &verdicts, margin)?),
            (None, Some(margin)) if verdicts.is_empty() && changes.is_empty() => Some(
                Update::first(path, &run.summary, run.trace.header(), margin)?,
            ),
            _ => None,
        };
    let judged = Judged {
        verdicts,
        trace_hash: Some(run.summary.trace_hash.clone()),
        converge: run.summary.converge.clone(),
        differences,
        moved,
        drawn,
        update,
        is_study: false,
    };
    if let Some(folder) = &arguments.keep {
        let kept = folder.join(name);
        match judged.failures().is_empty() {
            true => OutputFolder::clear(&kept)?,
            false => {
                OutputFolder::prepare(kept, "--keep", &[])?.write_all(&run, &judged.verdicts)?
            }
        }
    }
    Ok(judged)
}

/// Runs a study, of which nothing is kept, and checks its expectations.
fn run_and_judge_study(
    path: &Path,
    arguments: &Arguments,
    files: &FileAccess,
) -> Result<Judged, Failure> {
    if !arguments.settings.settings.is_empty() {
        return Err(Failure::usage(
            format!(
                "--set changes scenarios, and `{}` is a study",
                path.display()
            ),
            "write what shall be otherwise below its `[set]`, or name the scenarios alone",
        ));
    }
    let study = Study::load_within(path, files)?;
    let findings = ilon_sweep::sweep(&study, &Store::in_memory(), &Options::default(), &|_| ())?;
    Ok(Judged {
        verdicts: verdicts(&findings),
        is_study: true,
        ..Judged::default()
    })
}

/// The page of differences from a baseline, in the scenario's folder.
const DRAWN: &str = "difference.html";

/// Compares a run with its baseline, and draws the differences.
fn against(
    run: &Run<Recorded>,
    baseline: &Recorded,
    name: &Path,
    arguments: &Arguments,
) -> Result<(Vec<Difference>, Option<PathBuf>), Failure> {
    // Figures with bounded changes may move, and other signals with them.
    let expect = &run.scenario.expect;
    let only_tolerated = !expect.changes.is_empty();
    let found = differences(&run.trace, baseline, &expect.tolerances, only_tolerated)?;
    let below = match &arguments.keep {
        Some(keep) => keep.clone(),
        None => Path::new("out").join("check"),
    };
    let kept = below.join(name);
    if found.is_empty() {
        // A drawing of an earlier run does not belong to this one.
        remove(&kept.join(DRAWN))?;
        return Ok((found, None));
    }
    std::fs::create_dir_all(&kept).map_err(|source| Failure::write(&kept, &source))?;
    file::clear_unfinished(&kept)?;
    let drawn = kept.join(DRAWN);
    let page = difference::html(&run.trace, baseline, &found)?;
    file::write_text(&drawn, &page)?;
    Ok((found, Some(drawn)))
}

/// The baseline of a scenario in a folder; it must exist before the scenario is run.
fn baseline_in(folder: &Path, name: &Path) -> Result<Recorded, Failure> {
    let file = baseline_file(folder, name);
    if !file.exists() {
        return Err(Failure::usage(
            format!("there is no baseline `{}`", file.display()),
            format!("`ilon check --save {}` writes one", folder.display()),
        ));
    }
    Ok(Recorded::open(&file)?)
}

/// Names the baselines of scenarios that a whole folder no longer holds.
fn say_what_is_gone(folder: &Path, names: &BTreeSet<PathBuf>) -> Result<(), Failure> {
    for baseline in scenarios::baselines(folder)? {
        if !names.contains(&baseline) {
            console::note(&format!(
                "note: `{}` has a baseline and no scenario: if it was removed on purpose, remove `{}` too",
                baseline.display(),
                baseline_file(folder, &baseline).display()
            ));
        }
    }
    Ok(())
}

fn baseline_file(folder: &Path, name: &Path) -> PathBuf {
    let mut file = folder.join(name).into_os_string();
    file.push(".parquet");
    file.into()
}
