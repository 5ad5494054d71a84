//! `ilon check`: runs scenarios side by side and holds each against its own `[expect]`.

mod junit;
mod update;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ilon_trace::{Recorded, Recording};
use rayon::prelude::*;

use self::update::Update;
use super::output::OutputFolder;
use super::table::Table;
use super::{Outcome, Settings};
use crate::judge::{Difference, Verdict, differences, judge_rows};
use crate::report::difference;
use crate::simulate::{Run, Simulation};
use crate::{Error, Scenario};

/// Arguments of `ilon check`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scenario files, and folders of them.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Write the results as JUnit XML, which continuous integration shows.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Run only scenarios whose name contains this.
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// Begin no further scenario once one has failed.
    #[arg(long)]
    fail_fast: bool,
    /// Write the results of scenarios that fail below this folder.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Write the trace of each scenario into this folder, as a baseline.
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// Hold the trace of each scenario against the baseline in this folder, within `[expect.tolerances]`; a difference is
    /// drawn in `difference.html` below `--keep`, or below `out/check`.
    #[arg(long, value_name = "DIR")]
    against: Option<PathBuf>,
    /// Rewrite the bounds on quantities of the summary in each scenario's file to what was measured, with this margin as
    /// a share of it; every change is told.
    #[arg(long, value_name = "MARGIN", num_args = 0..=1, default_missing_value = "0.1", value_parser = margin)]
    update: Option<f64>,
    #[command(flatten)]
    settings: Settings,
}

fn margin(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(margin) if margin.is_finite() && margin >= 0.0 => Ok(margin),
        _ => Err("write a share of 0 or more, such as 0.1 for 10 %".to_owned()),
    }
}

/// What came of one scenario.
struct Checked {
    name: String,
    path: PathBuf,
    took: Duration,
    result: Ended,
}

/// How one scenario ended.
enum Ended {
    /// It ran, and this is what was found.
    Judged(Judged),
    /// It could not run.
    Refused(Error),
    /// It was not begun, because another had failed.
    Skipped,
}

/// What was found of a scenario that ran.
struct Judged {
    verdicts: Vec<Verdict>,
    differences: Vec<Difference>,
    /// Where the differences are drawn, if there are any.
    drawn: Option<PathBuf>,
    /// What `--update` changes in the file, once it was shown.
    update: Option<Update>,
}

impl Judged {
    /// What `--update` changes, a line each.
    fn changes(&self) -> &str {
        self.update.as_ref().map_or("", |update| &update.changes)
    }

    /// What did not hold, a line each. Of many differences from a baseline the first few tell where it began.
    fn failures(&self) -> Vec<String> {
        const DIFFERENCES_TOLD: usize = 3;
        let failed = self.verdicts.iter().filter(|verdict| !verdict.held);
        let mut lines: Vec<String> = failed.map(ToString::to_string).collect();
        let told = self.differences.iter().take(DIFFERENCES_TOLD);
        lines.extend(told.map(ToString::to_string));
        if self.differences.len() > DIFFERENCES_TOLD {
            let more = self.differences.len() - DIFFERENCES_TOLD;
            lines.push(format!("{more} more signals leave their baseline"));
        }
        if let Some(drawn) = &self.drawn {
            lines.push(format!("drawn in {}", drawn.display()));
        }
        lines
    }
}

/// Runs all scenarios and prints a line for each.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let paths = scenarios(&arguments.paths, arguments.filter.as_deref())?;
    let stop = AtomicBool::new(false);
    let settings = &arguments.settings.settings;
    let settings: String = settings
        .iter()
        .map(|setting| format!(" --set '{setting}'"))
        .collect();
    let checked: Vec<Checked> = paths
        .par_iter()
        .map(|path| {
            let mut checked = check(path, arguments, &stop);
            if arguments.fail_fast && !checked.held() {
                stop.store(true, Ordering::Relaxed);
            }
            // One write a scenario, so that lines of different threads do not mix; a gone reader is no fault here.
            let _ = super::print(&checked.line(&settings));
            checked.write_update();
            checked
        })
        .collect();
    if let Some(path) = &arguments.junit {
        ilon_trace::file::write_text(path, &junit::xml(&checked)?)?;
    }
    super::print(&format!("\n{}", totals(&checked)))?;
    let mut outcome = Outcome::Done;
    for one in checked {
        let held = one.held();
        match one.result {
            Ended::Refused(error) => {
                eprintln!("{}:", one.path.display());
                super::tell(error);
                outcome = Outcome::BadInput;
            }
            Ended::Judged(_) if !held && outcome == Outcome::Done => outcome = Outcome::Unexpected,
            Ended::Judged(_) | Ended::Skipped => {}
        }
    }
    Ok(outcome)
}

/// The scenario files named, and those in the folders named, in order of their names.
fn scenarios(paths: &[PathBuf], filter: Option<&str>) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    for path in paths {
        let read = |source| Error::read(path, &source);
        if std::fs::metadata(path).map_err(read)?.is_dir() {
            let before = files.len();
            for entry in std::fs::read_dir(path).map_err(read)? {
                let file = entry.map_err(read)?.path();
                if file
                    .extension()
                    .is_some_and(|extension| extension == "toml")
                {
                    files.push(file);
                }
            }
            files[before..].sort();
        } else {
            files.push(path.clone());
        }
    }
    files.retain(|file| filter.is_none_or(|text| name_of(file).contains(text)));
    if files.is_empty() {
        return Err(Error::invalid(
            "there is no scenario to check",
            "name a scenario file, or a folder with `.toml` files, and a --filter that one of them meets",
        ));
    }
    Ok(files)
}

fn name_of(file: &Path) -> String {
    file.file_stem()
        .map(|stem| stem.to_string_lossy().into_owned())
        .unwrap_or_default()
}

fn check(path: &Path, arguments: &Arguments, stop: &AtomicBool) -> Checked {
    let start = Instant::now();
    let result = if stop.load(Ordering::Relaxed) {
        Ended::Skipped
    } else {
        match run_and_judge(path, arguments) {
            Ok(judged) => Ended::Judged(judged),
            Err(error) => Ended::Refused(error),
        }
    };
    Checked {
        name: name_of(path),
        path: path.to_owned(),
        took: start.elapsed(),
        result,
    }
}

fn run_and_judge(path: &Path, arguments: &Arguments) -> Result<Judged, Error> {
    let scenario = Scenario::load_with(path, &arguments.settings.settings)?;
    let simulation = Simulation::new(&scenario)?;
    let recording = Recording::temporary(simulation.trace().header.clone());
    let run = simulation.run_recorded(recording, |_, _| Ok::<(), Error>(()))?;
    let (differences, drawn) = match &arguments.against {
        Some(folder) => against(&run, folder, arguments)?,
        None => (Vec::new(), None),
    };
    if let Some(folder) = &arguments.save {
        std::fs::create_dir_all(folder).map_err(|source| Error::write(folder, &source))?;
        run.trace.write_parquet(&baseline_file(folder, &run))?;
    }
    let verdicts = judge_rows(&run)?;
    let update = match arguments.update {
        Some(margin) => Some(Update::of(path, &verdicts, margin)?),
        None => None,
    };
    let judged = Judged {
        verdicts,
        differences,
        drawn,
        update,
    };
    if let Some(folder) = &arguments.keep
        && !judged.failures().is_empty()
    {
        OutputFolder::prepare(folder.join(&run.scenario.name))?.write_all(&run)?;
    }
    Ok(judged)
}

/// Holds a run against its baseline, and draws where it leaves it.
fn against(
    run: &Run<Recorded>,
    folder: &Path,
    arguments: &Arguments,
) -> Result<(Vec<Difference>, Option<PathBuf>), Error> {
    let file = baseline_file(folder, run);
    if !file.exists() {
        return Err(Error::invalid(
            format!("there is no baseline `{}`", file.display()),
            format!("`ilon check --save {}` writes one", folder.display()),
        ));
    }
    let baseline = Recorded::open(&file)?;
    let found = differences(&run.trace, &baseline, &run.scenario.expect.tolerances)?;
    if found.is_empty() {
        return Ok((found, None));
    }
    let below = match &arguments.keep {
        Some(keep) => keep.clone(),
        None => Path::new("out").join("check"),
    };
    let kept = below.join(&run.scenario.name);
    std::fs::create_dir_all(&kept).map_err(|source| Error::write(&kept, &source))?;
    let drawn = kept.join("difference.html");
    difference::write(&drawn, &run.trace, &baseline, &found)?;
    Ok((found, Some(drawn)))
}

fn baseline_file(folder: &Path, run: &Run<Recorded>) -> PathBuf {
    folder.join(format!("{}.parquet", run.scenario.name))
}

impl Checked {
    fn held(&self) -> bool {
        match &self.result {
            Ended::Judged(judged) => judged.failures().is_empty(),
            Ended::Refused(_) => false,
            Ended::Skipped => true,
        }
    }

    /// Writes what `--update` changes, after it was shown.
    fn write_update(&mut self) {
        if let Ended::Judged(Judged {
            update: Some(update),
            ..
        }) = &self.result
            && let Err(error) = update.write()
        {
            self.result = Ended::Refused(error);
        }
    }

    /// What came of it, with the `settings` under which it would be seen again.
    fn line(&self, settings: &str) -> String {
        let took_s = self.took.as_secs_f64();
        let name = &self.name;
        match &self.result {
            Ended::Skipped => format!("skip   {name}\n"),
            Ended::Refused(error) => format!("ERROR  {name}: {error}\n"),
            Ended::Judged(judged) if self.held() => {
                let expected = match judged.verdicts.len() {
                    0 => "nothing expected".to_owned(),
                    1 => "1 bound".to_owned(),
                    count => format!("{count} bounds"),
                };
                format!(
                    "held   {name} ({took_s:.1} s, {expected})\n{}",
                    judged.changes()
                )
            }
            Ended::Judged(judged) => {
                let mut text = format!("FAILED {name} ({took_s:.1} s)\n");
                for failure in judged.failures() {
                    text.push_str(&format!("         {failure}\n"));
                }
                text.push_str(&format!(
                    "         to see it: ilon run {}{settings}\n",
                    self.path.display()
                ));
                text.push_str(judged.changes());
                text
            }
        }
    }
}

fn totals(checked: &[Checked]) -> String {
    let mut table = Table::new();
    table.heading("all scenarios");
    let mut row = |name: &str, of: fn(&Checked) -> bool| {
        let count = checked.iter().filter(|one| of(one)).count();
        table.row(name, Some(count as f64), 0, "");
    };
    row("held", |one| {
        matches!(one.result, Ended::Judged(_)) && one.held()
    });
    row("failed", |one| {
        matches!(one.result, Ended::Judged(_)) && !one.held()
    });
    row("could not run", |one| {
        matches!(one.result, Ended::Refused(_))
    });
    row("skipped", |one| matches!(one.result, Ended::Skipped));
    table.to_string()
}
