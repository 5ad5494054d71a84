//! What the usual suspects do to a robot, and which of them would look like what was seen.

use ilon_files::FileAccess;
use ilon_sim::causes::{Drift, Suspect, suspects};
use ilon_sim::standard_motions::MOTIONS;
use serde_json::{Value, json};

use super::arguments::Arguments;
use super::seen::{Fit, fit};
use crate::cli::console;
use crate::cli::failure::Failure;
use crate::cli::json::pretty;
use crate::cli::outcome::Outcome;
use crate::cli::robot::load;
use crate::cli::table::Table;
use crate::inspect::conditions;

/// Of a robot so many suspects that fit are shown.
const MOST_SHOWN: usize = 8;

pub(super) fn run(arguments: &Arguments, files: &FileAccess) -> Result<Outcome, Failure> {
    let mut options = arguments.reading.options();
    options.files = files.clone();
    let loaded = load(
        &arguments.file,
        &options,
        "ilon explain",
        &arguments.sandbox,
    )?;
    let settings = &arguments.settings.settings;
    let (_, robot) = conditions(settings, &loaded.robot, files)?;
    let found = suspects(&robot, settings, files)?;
    let places = robot
        .wheels
        .iter()
        .map(|wheel| wheel.position_m().xy().norm());
    let arm_m = places.fold(0.0, f64::max);
    let fit_of = |suspect: &Suspect| fit(&arguments.seen, &suspect.drifts, arm_m);
    let mut ranked: Vec<(&Suspect, Option<Fit>)> = found
        .iter()
        .map(|suspect| (suspect, fit_of(suspect)))
        .collect();
    let worth = |fit: &Option<Fit>| fit.map_or(-1.0, |fit| fit.share - 0.1 * fit.times.ln().abs());
    ranked.sort_by(|(_, a), (_, b)| worth(b).total_cmp(&worth(a)));
    if arguments.json {
        let suspects: Vec<Value> = ranked.iter().map(as_json).collect();
        let all = json!({ "robot": robot.name, "motions": MOTIONS, "suspects": suspects });
        console::data(&pretty("the suspects", &all)?)?;
        return Ok(Outcome::Done);
    }
    let table = match arguments.seen.is_empty() {
        true => {
            // Of suspects that are about one wheel, those of the first stand for all.
            let first = robot.wheels.first().map(|wheel| &wheel.name);
            let shown = found
                .iter()
                .filter(|one| one.wheel.is_none() || one.wheel.as_ref() == first);
            drifts(&robot.name, shown)
        }
        false => {
            let fitting = ranked.iter().filter_map(|(one, fit)| Some((*one, (*fit)?)));
            fits(fitting.take(MOST_SHOWN))
        }
    };
    console::lines(&table.to_string())?;
    Ok(Outcome::Done)
}

/// What each suspect does in each motion.
fn drifts<'s>(robot: &str, suspects: impl Iterator<Item = &'s Suspect>) -> Table {
    let mut table = Table::new();
    table.heading(&format!(
        "{robot}: what the usual suspects do, for each metre or for each turn on the spot: mm ahead, mm to the left, degrees to the left. A dot is less \
         than can be told"
    ));
    table.words("", &MOTIONS.map(str::to_owned));
    for suspect in suspects {
        let cells: Vec<String> = suspect.drifts.iter().map(in_words).collect();
        table.words(&suspect.words, &cells);
    }
    table
}

fn in_words(drift: &Option<Drift>) -> String {
    let Some(drift) = drift else {
        return "refused".to_owned();
    };
    let told = |x: f64, floor: f64, per_si: f64, decimals: usize| match x.abs() > floor {
        true => format!("{:+.decimals$}", per_si * x),
        false => "·".to_owned(),
    };
    [
        told(drift.ahead_m, drift.floor[0], 1e3, 1),
        told(drift.left_m, drift.floor[0], 1e3, 1),
        told(drift.turned_rad, drift.floor[1], 1f64.to_degrees(), 2),
    ]
    .join(" ")
}

/// The suspects that look like the measured drift, the best first.
fn fits<'s>(suspects: impl Iterator<Item = (&'s Suspect, Fit)>) -> Table {
    let mut table = Table::new();
    table.heading("causes that look like it: how much of the drift each explains, and at how many times its usual amount");
    let rows: Vec<(&Suspect, Fit)> = suspects.collect();
    table.columns::<&(&Suspect, Fit)>(
        &[
            ("explains", &|(_, fit)| {
                format!("{:.0} %", 100.0 * fit.share)
            }),
            ("times", &|(_, fit)| format!("{:.2}", fit.times)),
        ],
        rows.iter().map(|row| (row.0.words.as_str(), row)),
    );
    if rows.is_empty() {
        table.heading("none of the usual suspects would look like it");
    }
    table
}

fn as_json((suspect, fit): &(&Suspect, Option<Fit>)) -> Value {
    json!({
        "words": suspect.words,
        "wheel": suspect.wheel,
        "drifts": suspect.drifts,
        "explains": fit.map(|fit| fit.share),
        "times": fit.map(|fit| fit.times),
    })
}
