//! Leaves out every cause of a scenario in turn; the largest effect comes first.

use std::path::PathBuf;

use ilon_files::FileAccess;
use ilon_report::{CAUSES, causes_table};
use ilon_trace::Rows;
use ilon_trace::effects::{self, Ablation};
use serde_json::{Value, json};

use super::arguments::{Arguments, OUT};
use crate::cli::escape::{path_in_line, sentences};
use crate::cli::failure::Failure;
use crate::cli::json::pretty;
use crate::cli::outcome::Outcome;
use crate::cli::output::{self, OutputFolder, Report};
use crate::cli::progress::Bar;
use crate::cli::run::recorded;
use crate::cli::table::Table;
use crate::cli::{console, open};
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
    let run = recorded(simulation, recording, &folder, &bar, &mut [])?;
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
        false => format!("\n{}", table(HELPERS, &helped)),
    };
    if arguments.json {
        let causes: Vec<Value> = ablations.iter().map(as_json).collect();
        let all = json!({ "scenario": run.summary.scenario, "causes": causes });
        console::data(&pretty("the causes", &all)?)?;
    } else {
        console::lines(&format!(
            "{}\n{}{}\nwritten to {}: report.html, summary.json, trace.parquet, scenario.toml\n",
            sentences(&answer),
            table(CAUSES, &culprits),
            helpers,
            path_in_line(folder.path()),
        ))?;
    }
    if arguments.open {
        open::page(&folder.path().join("report.html"));
    }
    Ok(Outcome::Done)
}

const HELPERS: &str = "what helped: without it the robot would have been further off";

fn table(heading: &str, ablations: &[&Ablation]) -> Table {
    let mut table = Table::new();
    table.of(&causes_table(heading, ablations));
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
