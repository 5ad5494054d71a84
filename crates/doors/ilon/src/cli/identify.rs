//! `ilon identify`: fits a robot's parameters to logs of its drives.

use ilon_formats::LoadRobot;
use std::path::PathBuf;

use ilon_identify::tape::Tape;
use ilon_identify::{Progress, Study, identify};
use ilon_trace::file::write_text;

use super::escape::{path_in_line, sentence};
use super::json::pretty;
use super::kind::{Kind, wants};
use super::options::{Detail, Open, Out, Printing, Sandbox};
use super::outcome::Outcome;
use super::progress::Bar;
use super::{answer, console, reserve, results};
use crate::cli::failure::Failure;

/// Arguments of `ilon identify`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The study file: a robot, logs of its drives or runs measured by tape, and the free
    /// parameters.
    #[arg(required_unless_present = "plan")]
    study: Option<PathBuf>,
    /// Propose a short course for this robot that determines the free parameters, as waypoints and
    /// as wheel rates.
    #[arg(long, value_name = "ROBOT", conflicts_with_all = ["study", "open"])]
    plan: Option<PathBuf>,
    /// Parameters that the course shall determine, separated by commas.
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        default_value = "radius_m.*,lever_m",
        conflicts_with = "study"
    )]
    free: Vec<String>,
    /// Speed of the course, in m/s.
    #[arg(
        long,
        value_name = "M/S",
        default_value_t = 0.2,
        conflicts_with = "study"
    )]
    speed: f64,
    #[command(flatten)]
    out: Out,
    #[command(flatten)]
    printing: Printing,
    #[command(flatten)]
    detail: Detail,
    #[command(flatten)]
    open: Open,
    #[command(flatten)]
    sandbox: Sandbox,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let Some(path) = &arguments.study else {
        return plan(arguments);
    };
    let files = arguments.sandbox.files()?;
    wants(path, &[Kind::Calibration], &files)?;
    if let Some(tape) = Tape::load_within(path, &files)? {
        return by_tape(arguments, &tape);
    }
    let study = Study::load_within(path, &files)?;
    let out = arguments.out.or_of(&study.name());
    results::refuse_identify_inputs(&out, &study, "--out")?;
    let _claim = reserve::folder(&out, "--out")?;
    // The number of drives that a search simulates is not known in advance.
    let bar = Bar::without_end(&study.name());
    let found = identify(&study, &|progress| {
        bar.show(0.0, 0.0, || words(&progress));
    });
    bar.done();
    let found = found?;
    if arguments.printing.json {
        // In text output they stand beside the answer.
        for odd in &found.doubts {
            let (doubt, file) = (&odd.doubt, &odd.file);
            let text = format!("note: {file}: {} ({})", doubt.message, doubt.help);
            console::note(&sentence(&text));
        }
    }
    let json = results::write_identified(&study, &found, &out)?;
    arguments.printing.answer(&json, || {
        let written = ilon_identify::FILES.iter().copied();
        let written: Vec<&str> = written.filter(|name| out.join(name).is_file()).collect();
        format!(
            "{}\nwritten to {}: {}\n",
            answer::of_identification(&found, arguments.detail.table),
            path_in_line(&out),
            written.join(", ")
        )
    })?;
    arguments.open.page(&out.join("report.html"));
    Ok(Outcome::Done)
}

/// Fits parameters to runs measured by tape.
fn by_tape(arguments: &Arguments, tape: &Tape) -> Result<Outcome, Failure> {
    let out = arguments.out.or_of(&tape.name());
    let (found, json) = results::fit_tape(tape, &out, "--out")?;
    arguments.printing.answer(&json, || {
        let written = path_in_line(&out);
        format!(
            "{}\nwritten to {written}: identified.json\n",
            answer::of_tape(&found)
        )
    })?;
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
    let mut options = ilon_formats::LoadOptions::default();
    options.files = arguments.sandbox.files()?;
    let robot = ilon_robot::Robot::load_with(path, &options)?.robot;
    let course = ilon_identify::plan::plan(&robot, &arguments.free, arguments.speed)?;
    let out = arguments.out.or_of("course");
    for name in ["wheel_rates.csv", "waypoints.csv", "course.json"] {
        reserve::not_an_input(&out.join(name), "--out", std::slice::from_ref(path))?;
    }
    let _claim = reserve::folder(&out, "--out")?;
    let json = pretty("the course", &course)?;
    write_text(&out.join("wheel_rates.csv"), &course.wheel_rates_csv)?;
    write_text(&out.join("waypoints.csv"), &course.waypoints_csv)?;
    write_text(&out.join("course.json"), &json)?;
    arguments.printing.answer(&json, || {
        format!(
            "{}\nwritten to {}: wheel_rates.csv, waypoints.csv, course.json\n",
            answer::course(&course),
            path_in_line(&out)
        )
    })?;
    Ok(Outcome::Done)
}

fn words(progress: &Progress) -> String {
    match progress {
        Progress::Reading => "reading the logs".to_owned(),
        Progress::Fitting(model) => format!("fitting {model}"),
        Progress::Simulating(count) => format!("{count} drives simulated"),
    }
}
