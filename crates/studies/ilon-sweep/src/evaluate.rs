//! One run of a study.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use ilon_trace::file::write_text;
use ilon_trace::{Recorded, Recording, Summary};
use miette::Diagnostic;

use crate::hash::Hash;
use crate::options::Stop;
use crate::robots;
use crate::row::{Row, Status, Task, figures_of};
use crate::study::Study;
use crate::table::write_json;
use ilon_sim::Error;
use ilon_sim::scenario::{Expect, Scenario};
use ilon_sim::simulate::design;
use ilon_sim::{Run, Simulation};

/// Runs one task; its error, if any, is stored in its row.
///
/// # Errors
/// [`Error::Stopped`] if stopped; the run then has no result.
pub(crate) fn evaluate(
    study: &Study,
    task: &Task,
    stop: &Stop,
) -> Result<(Row, Option<Run<Recorded>>), Error> {
    stop.check()?;
    let mut row = Row {
        run: task.run,
        key: String::new(),
        status: Status::Failed,
        error: None,
        scenario: study.scenario_name(task.scenario).to_owned(),
        point: task.point,
        repetition: task.repetition,
        values: task.values.clone(),
        trace_hash: None,
        notes: Vec::new(),
        figures: Vec::new(),
    };
    // A panic of ilon in one run must not end the others.
    let simulated = catch_unwind(AssertUnwindSafe(|| match study.file().physics {
        true => simulate(study, task, stop, &mut row.key),
        false => look_at(study, task, &mut row.key),
    }));
    let simulated = match simulated {
        Ok(Err(Error::Stopped)) => return Err(Error::Stopped),
        Ok(simulated) => simulated.map_err(|error| words(&error)),
        Err(_) => {
            Err("ilon failed in this run (a bug): please report it, with the study".to_owned())
        }
    };
    if row.key.is_empty() {
        // From the task, if no scenario could be built.
        let settings = study.settings(task);
        let settings: Vec<String> = settings.iter().map(ToString::to_string).collect();
        let asked = [env!("CARGO_PKG_VERSION"), &row.scenario].into_iter();
        let asked = asked.chain(settings.iter().map(String::as_str));
        row.key = Hash::of(&asked.collect::<Vec<_>>());
    }
    match simulated {
        Err(error) => {
            row.error = Some(error);
            Ok((row, None))
        }
        Ok((figures, run)) => {
            row.status = Status::Done;
            row.figures = figures;
            if let Some(run) = &run {
                row.trace_hash = Some(run.summary.trace_hash.clone());
                row.notes.clone_from(&run.warnings);
            }
            Ok((row, run))
        }
    }
}

/// The figures of a row, and their run; no run for a robot that was only inspected.
type Came = (Vec<Option<f64>>, Option<Run<Recorded>>);

/// Inspects a task's robot without a run.
fn look_at(study: &Study, task: &Task, key: &mut String) -> Result<Came, Error> {
    let scenario = scenario_of(study, task)?;
    let (robot, robot_hash) = robots::design(&study.robots, &scenario)?;
    *key = Hash::of(&[
        env!("CARGO_PKG_VERSION"),
        "design",
        &scenario.to_toml()?,
        &robot_hash,
    ]);
    let mut summary = Box::<Summary>::default();
    summary.design = design(&scenario, &robot)?;
    Ok((figures_of(&summary), None))
}

fn simulate(study: &Study, task: &Task, stop: &Stop, key: &mut String) -> Result<Came, Error> {
    let scenario = scenario_of(study, task)?;
    let robot = study.robots.of(&scenario)?;
    let simulation = Simulation::with_loaded(&scenario, &robot.loaded)?;
    let header = simulation.trace().header.clone();
    *key = Hash::of(&[
        env!("CARGO_PKG_VERSION"),
        &header.scenario_toml,
        &robot.urdf_hash,
    ]);
    let recording = Recording::temporary(header);
    let run = simulation.run_recorded(recording, |_, _| stop.check())?;
    Ok((figures_of(&run.summary), Some(run)))
}

/// Returns the scenario of a run without its own expectations, which apply to the scenario as
/// written in its file. A row only has the figures at the scenario's step.
pub(crate) fn scenario_of(study: &Study, task: &Task) -> Result<Scenario, Error> {
    let mut scenario = study.scenario_with(task.scenario, &study.settings(task))?;
    scenario.expect = Expect::default();
    scenario.run.converge = false;
    Ok(scenario)
}

/// Returns an error as one line: the fault and its remedy.
fn words(error: &Error) -> String {
    let help = error
        .help()
        .map(|help| help.to_string())
        .unwrap_or_default();
    let text = match help.as_str() {
        "" => error.to_string(),
        help => format!("{error} ({help})"),
    };
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Writes scenario, trace and summary into a folder, the summary last.
pub(crate) fn write(run: &Run<Recorded>, folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(Error::io("create", folder))?;
    let Run {
        scenario,
        trace,
        summary,
        ..
    } = run;
    let text = scenario.moved_to(folder).to_toml()?;
    write_text(&folder.join("scenario.toml"), &text)?;
    trace.write_parquet(&folder.join("trace.parquet"))?;
    write_json(&folder.join("summary.json"), "the summary", summary)
}
