//! `ilon check`: runs scenarios side by side and holds each against its own `[expect]`.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use rayon::prelude::*;

use super::{Outcome, Settings};
use crate::judge::{Verdict, judge};
use crate::simulate::{self, Run};
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
    #[command(flatten)]
    settings: Settings,
}

/// What came of one scenario.
struct Checked {
    name: String,
    path: PathBuf,
    took: Duration,
    result: Result<Judged, Error>,
}

/// What came of one scenario that ran.
struct Judged {
    verdicts: Vec<Verdict>,
}

impl Checked {
    fn outcome(&self) -> Outcome {
        match &self.result {
            Err(_) => Outcome::BadInput,
            Ok(judged) if judged.verdicts.iter().all(|verdict| verdict.held) => Outcome::Done,
            Ok(_) => Outcome::Unexpected,
        }
    }
}

/// Runs all scenarios and prints a line for each.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let paths = scenarios(&arguments.paths, arguments.filter.as_deref())?;
    let checked: Vec<Checked> = paths
        .par_iter()
        .map(|path| {
            let checked = check(path, &arguments.settings);
            // One write a scenario, so that lines of different threads do not mix; a gone reader is no fault here.
            let _ = super::print(&line(&checked));
            checked
        })
        .collect();
    if let Some(path) = &arguments.junit {
        ilon_trace::file::write_text(path, &junit(&checked)?)?;
    }
    let count = |outcome| {
        checked
            .iter()
            .filter(|one| one.outcome() == outcome)
            .count()
    };
    let (held, failed, bad) = (
        count(Outcome::Done),
        count(Outcome::Unexpected),
        count(Outcome::BadInput),
    );
    super::print(&format!(
        "{} scenarios: {held} held, {failed} failed, {bad} could not run\n",
        checked.len()
    ))?;
    for one in checked {
        if let Err(error) = one.result {
            eprintln!("{}:", one.path.display());
            super::tell(error);
        }
    }
    Ok(match (failed, bad) {
        (_, 1..) => Outcome::BadInput,
        (1.., _) => Outcome::Unexpected,
        _ => Outcome::Done,
    })
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

fn check(path: &Path, settings: &Settings) -> Checked {
    let start = Instant::now();
    let result = Scenario::load_with(path, &settings.settings)
        .and_then(|scenario| simulate::run(&scenario))
        .and_then(|run| judged(&run));
    Checked {
        name: name_of(path),
        path: path.to_owned(),
        took: start.elapsed(),
        result,
    }
}

fn judged(run: &Run) -> Result<Judged, Error> {
    let summary = serde_json::to_value(&run.summary)
        .map_err(|error| Error::invalid(error.to_string(), ""))?;
    Ok(Judged {
        verdicts: judge(&run.scenario.expect, &summary),
    })
}

fn line(checked: &Checked) -> String {
    let took_s = checked.took.as_secs_f64();
    match &checked.result {
        Err(error) => format!("ERROR  {}: {error}\n", checked.name),
        Ok(judged) => {
            let failed: Vec<&Verdict> = judged
                .verdicts
                .iter()
                .filter(|verdict| !verdict.held)
                .collect();
            let mut text = match (failed.is_empty(), judged.verdicts.len()) {
                (true, 0) => format!(
                    "held   {} ({took_s:.1} s, nothing expected)\n",
                    checked.name
                ),
                (true, count) => {
                    format!("held   {} ({took_s:.1} s, {count} bounds)\n", checked.name)
                }
                (false, _) => format!("FAILED {} ({took_s:.1} s)\n", checked.name),
            };
            for verdict in failed {
                text.push_str(&format!("         {verdict}\n"));
            }
            if !text.starts_with("held") {
                text.push_str(&format!(
                    "         to see it: ilon run {}\n",
                    checked.path.display()
                ));
            }
            text
        }
    }
}

fn junit(checked: &[Checked]) -> Result<String, Error> {
    let mut suite = TestSuite::new("ilon check");
    for one in checked {
        let status = match &one.result {
            Err(error) => {
                let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
                status.set_message(error.to_string());
                status
            }
            Ok(judged) => {
                let failed: Vec<String> = judged
                    .verdicts
                    .iter()
                    .filter(|verdict| !verdict.held)
                    .map(ToString::to_string)
                    .collect();
                if failed.is_empty() {
                    TestCaseStatus::success()
                } else {
                    let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                    status.set_message(failed.join("; "));
                    status
                }
            }
        };
        let mut case = TestCase::new(one.name.as_str(), status);
        case.set_classname(one.path.display().to_string());
        case.set_time(one.took);
        suite.add_test_case(case);
    }
    let mut report = Report::new("ilon");
    report.add_test_suite(suite);
    report
        .to_string()
        .map_err(|error| Error::invalid(error.to_string(), ""))
}
