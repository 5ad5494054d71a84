//! `ilon identify`: what a robot really is, fitted to logs of its drives.

mod answer;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Duration;

use ilon_identify::{Identified, Progress, Study, identify};
use ilon_trace::file::write_text;
use indicatif::ProgressBar;

use super::escape::one_line;
use super::sweep::out_folder;
use super::{Outcome, Sandbox, claim, say};
use crate::cli::failure::Failure;
use crate::pages;

/// Arguments of `ilon identify`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The study file: a robot, logs of its drives, and what is free.
    #[arg(required_unless_present = "plan")]
    study: Option<PathBuf>,
    /// Propose a short course for this robot that makes what is free known, as waypoints and as wheel rates.
    #[arg(long, value_name = "ROBOT", conflicts_with = "study")]
    plan: Option<PathBuf>,
    /// What a course shall make known, several with commas between.
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        default_value = "radius_m.*,lever_m",
        requires = "plan"
    )]
    free: Vec<String>,
    /// How fast a course is driven, in m/s.
    #[arg(long, value_name = "M/S", default_value_t = 0.2, requires = "plan")]
    speed: f64,
    /// Where to write results.
    #[arg(long, value_name = "DIR", default_value = "out/<study>")]
    out: PathBuf,
    /// Print what was found as JSON, and nothing else, on standard output.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    sandbox: Sandbox,
}

/// Reads, fits, writes, prints.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let Some(path) = &arguments.study else {
        return plan(arguments);
    };
    let study = Study::load_within(path, &arguments.sandbox.files()?)?;
    let out = out_folder(&arguments.out, &study.name());
    refuse_inputs(&out, &study, "--out")?;
    let _claim = claim::folder(&out, "--out")?;
    let bar = std::io::stderr()
        .is_terminal()
        .then(ProgressBar::new_spinner);
    if let Some(bar) = &bar {
        bar.enable_steady_tick(Duration::from_millis(100));
    }
    let found = identify(&study, &|progress| {
        if let Some(bar) = &bar {
            bar.set_message(one_line(&words(&progress)).into_owned());
        }
    });
    if let Some(bar) = &bar {
        bar.finish_and_clear();
    }
    let found = found?;
    for odd in &found.doubts {
        say::note(&format!(
            "note: {}: {} ({})",
            one_line(&odd.file),
            one_line(&odd.doubt.message),
            one_line(&odd.doubt.help)
        ));
    }
    let json = write(&study, &found, &out)?;
    if arguments.json {
        say::data(&json)?;
    } else {
        say::lines(&format!(
            "{}\nwritten to {}: {}\n",
            answer::words(&found),
            one_line(&out.display().to_string()),
            ilon_identify::FILES
                .iter()
                .filter(|name| out.join(name).is_file())
                .copied()
                .collect::<Vec<_>>()
                .join(", ")
        ))?;
    }
    Ok(Outcome::Done)
}

/// Writes a course and prints what it determines.
fn plan(arguments: &Arguments) -> Result<Outcome, Failure> {
    let Some(path) = &arguments.plan else {
        return Err(Failure::usage(
            "neither a study nor a robot was named",
            "name a study",
        ));
    };
    let mut options = ilon_robot::LoadOptions::default();
    options.files = arguments.sandbox.files()?;
    let robot = ilon_robot::Robot::load_with(path, &options)?.robot;
    let course = ilon_identify::plan::plan(&robot, &arguments.free, arguments.speed)?;
    let out = match arguments.out.to_str() {
        Some("out/<study>") => PathBuf::from("out").join("course"),
        _ => arguments.out.clone(),
    };
    for name in ["wheel_rates.csv", "waypoints.csv", "course.json"] {
        claim::not_an_input(&out.join(name), "--out", std::slice::from_ref(path))?;
    }
    let _claim = claim::folder(&out, "--out")?;
    let json = serde_json::to_string_pretty(&course);
    let json = json.map_err(|error| Failure::encode("the course", &error))? + "\n";
    write_text(&out.join("wheel_rates.csv"), &course.wheel_rates_csv)?;
    write_text(&out.join("waypoints.csv"), &course.waypoints_csv)?;
    write_text(&out.join("course.json"), &json)?;
    if arguments.json {
        say::data(&json)?;
    } else {
        say::lines(&format!(
            "{}\nwritten to {}: wheel_rates.csv, waypoints.csv, course.json\n",
            answer::course(&course),
            one_line(&out.display().to_string())
        ))?;
    }
    Ok(Outcome::Done)
}

fn words(progress: &Progress) -> String {
    match progress {
        Progress::Reading => "reading the logs".to_owned(),
        Progress::Fitting(model) => format!("fitting {model}"),
        Progress::Simulating(count) => format!("{count} drives simulated"),
    }
}

/// Refuses a folder, which an option names, in which results would replace what the study is made from.
pub(super) fn refuse_inputs(out: &Path, study: &Study, option: &str) -> Result<(), Failure> {
    let mut inputs = study.inputs();
    inputs.push(study.path.clone());
    for name in ilon_identify::FILES {
        claim::not_an_input(&out.join(name), option, &inputs)?;
    }
    Ok(())
}

/// Writes all results into a folder that is claimed for it.
pub(super) fn write_claimed(study: &Study, found: &Identified, out: &Path) -> Result<(), Failure> {
    let _claim = claim::folder(out, "another path")?;
    write(study, found, out).map(drop)
}

/// Writes all files of the results, `identified.json` last; gives its text.
fn write(study: &Study, found: &Identified, out: &Path) -> Result<String, Failure> {
    let json = serde_json::to_string_pretty(found);
    let json = json.map_err(|error| Failure::encode("what was found", &error))? + "\n";
    for (name, text) in ilon_identify::files(study, found, out)? {
        write_text(&out.join(name), &text)?;
    }
    pages::identify::write(&out.join("report.html"), found)?;
    write_text(&out.join("identified.json"), &json)?;
    Ok(json)
}
