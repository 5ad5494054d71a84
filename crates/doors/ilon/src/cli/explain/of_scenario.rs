//! Leaves out every cause of a scenario in turn; the largest effect comes first.

use std::path::PathBuf;

use ilon_files::FileAccess;
use ilon_trace::Rows;
use ilon_trace::effects::{self, Ablation, FLOORS};
use serde_json::{Value, json};

use super::arguments::{Arguments, OUT};
use crate::cli::escape::{path_in_line, sentences};
use crate::cli::failure::Failure;
use crate::cli::json::pretty;
use crate::cli::outcome::Outcome;
use crate::cli::output::{self, KeepingUp, OutputFolder, Report};
use crate::cli::progress::Bar;
use crate::cli::table::Table;
use crate::cli::{console, interrupt, open};
use crate::simulate::Simulation;
use crate::{Causes, Scenario};

pub(super) fn run(arguments: &Arguments, files: &FileAccess) -> Result<Outcome, Failure> {
    let scenario = Scenario::load_within(&arguments.file, &arguments.settings.settings, files)?;
    let out = match arguments.out.as_os_str() == OUT {
        true => PathBuf::from("out/explain").join(&scenario.name),
        false => arguments.out.clone(),
    };
    let inputs = output::inputs(&arguments.file, &scenario);
    let folder = OutputFolder::prepare(out, "--out", &inputs)?;
    let simulation = Simulation::new(&scenario)?.explaining(Causes::All);
    let bar = Bar::new(&scenario.name);
    let recording = folder.begin(&simulation)?;
    interrupt::leaves_trace(folder.growing());
    let mut kept = KeepingUp::new();
    let run = simulation.run_recorded(recording, |simulation, recording| {
        bar.simulated(simulation.progress());
        kept.keep_up(simulation.progress().time_s, recording)
    })?;
    bar.done();
    for warning in ilon_sim::gathered(&run.warnings) {
        bar.note(&format!("note: {warning}"));
    }
    let answer = folder.write(&run, &[], Report::Written)?;
    let mut ablations = effects::of_causes(&run.summary, run.trace.header());
    ablations.sort_by(|a, b| b.apart.most_m.total_cmp(&a.apart.most_m));
    let (helped, culprits): (Vec<&Ablation>, Vec<&Ablation>) =
        ablations.iter().partition(|one| one.helped());
    let helpers = match helped.is_empty() {
        true => String::new(),
        false => format!("\n{}", table(HELPERS, helped)),
    };
    if arguments.json {
        let causes: Vec<Value> = ablations.iter().map(as_json).collect();
        let all = json!({ "scenario": run.summary.scenario, "causes": causes });
        console::data(&pretty("the causes", &all)?)?;
    } else {
        console::lines(&format!(
            "{}\n{}{}\nwritten to {}: report.html, summary.json, trace.parquet, scenario.toml\n",
            sentences(&answer),
            table(CAUSES, culprits),
            helpers,
            path_in_line(folder.path()),
        ))?;
    }
    if arguments.open {
        open::page(&folder.path().join("report.html"));
    }
    Ok(Outcome::Done)
}

const CAUSES: &str = "the run minus the run without the cause: apart by up to, mm; at the end ahead, mm, to the left, mm, turned to the left, deg; sliding, J. \
     A dash is less than can be told";
const HELPERS: &str = "what helped: without it the robot would have been further off";

/// One row per cause: how far it moved the robot on the way and at the end.
fn table(heading: &str, ablations: Vec<&Ablation>) -> Table {
    let mut table = Table::new();
    table.heading(heading);
    let told = |x: f64, floor: f64, per_si: f64, decimals: usize| match x.abs() > FLOORS * floor {
        true => format!("{:.decimals$}", per_si * x),
        false => "-".to_owned(),
    };
    table.columns::<&Ablation>(
        &[
            ("apart", &|one| told(one.apart.most_m, one.floor[0], 1e3, 2)),
            ("ahead", &|one| {
                told(one.apart.ahead_m, one.end_floor[0], 1e3, 2)
            }),
            ("left", &|one| {
                told(one.apart.left_m, one.end_floor[0], 1e3, 2)
            }),
            ("turned", &|one| {
                told(one.apart.turned_rad, one.end_floor[1], 1f64.to_degrees(), 3)
            }),
            ("sliding", &|one| {
                let slip = one.get("slip_energy_j").filter(|slip| slip.differs);
                slip.map_or("-".to_owned(), |slip| format!("{:.3}", slip.difference))
            }),
        ],
        ablations.into_iter().map(|one| {
            let name = one
                .cause
                .map_or("all of them", |cause| cause.words.as_str());
            (name, one)
        }),
    );
    table
}

fn as_json(one: &Ablation) -> Value {
    json!({
        "cause": one.cause.map_or("all", |cause| &cause.key),
        "words": one.cause.map_or("all of them", |cause| &cause.words),
        "differs": one.differs(),
        "helped": one.helped(),
        "apart": one.apart,
        "floor_m": one.floor[0],
        "floor_rad": one.floor[1],
        "effects": one.effects,
    })
}
