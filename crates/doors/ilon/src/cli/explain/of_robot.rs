//! The effects of common suspects on a robot, and which of them explain an observed drift.

use ilon_files::FileAccess;
use ilon_robot::Robot;
use ilon_sim::causes::{Drift, Lineup, Suspect};
use ilon_sim::standard_motions::MOTIONS;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::arguments::Arguments;
use super::seen::{Fit, Seen, each, fit};
use crate::cli::console;
use crate::cli::failure::Failure;
use crate::cli::json::pretty;
use crate::cli::outcome::Outcome;
use crate::cli::robot::load;
use crate::cli::table::Table;
use crate::inspect::conditions;

/// Largest number of matching suspects shown; chosen.
const MOST_SHOWN: usize = 8;
/// Share of the observed drift; chosen. If none explains as much, no single cause does.
const MOST_OF_IT: f64 = 0.7;
/// Shares of the observed drift, and of what the best suspect explains; chosen. A suspect that
/// explains less is not shown.
const LEAST_OF_IT: f64 = 0.05;
const LEAST_OF_BEST: f64 = 0.25;

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
    let none = arguments.seen.is_empty();
    let mut lengths = [none.then_some(1.0); MOTIONS.len()];
    for seen in &arguments.seen {
        if lengths[seen.motion].is_some() {
            return Err(Failure::usage(
                format!("the motion `{}` was given twice", MOTIONS[seen.motion]),
                "write all of a motion in one --seen, such as \"left 20 mm/m, turn 1 deg/m\"",
            ));
        }
        lengths[seen.motion] = Some(seen.length);
    }
    let lineup = Lineup::of(&robot, settings, files, lengths)?;
    let healthy = lineup.healthy();
    let beyond = |seen: &Seen| seen.beyond(&healthy[seen.motion].unwrap_or_default());
    let seen: Vec<Seen> = arguments.seen.iter().map(beyond).collect();
    let ranked = ranked(&lineup, &seen, arm_m(&robot));
    if arguments.json {
        let suspects: Vec<Value> = ranked.iter().map(as_json).collect();
        let all = json!({ "robot": robot.name, "motions": MOTIONS, "healthy": healthy, "suspects": suspects });
        console::data(&pretty("the suspects", &all)?)?;
        return Ok(Outcome::Done);
    }
    let tables = match arguments.seen.is_empty() {
        true => {
            // For suspects about one wheel, those of the first wheel represent all.
            let first = robot.wheels.first().map(|wheel| &wheel.name);
            let shown = ranked
                .iter()
                .map(|(suspect, _)| suspect)
                .filter(|one| one.wheel.is_none() || one.wheel.as_ref() == first);
            drifts(&robot.name, &healthy, shown).to_string()
        }
        false => {
            let anyway: String = seen.iter().map(|one| anyway(one, &healthy)).collect();
            let is_nothing = seen.iter().all(Seen::is_nothing);
            let unseen = match is_nothing {
                true => String::new(),
                false => unseen(&ranked),
            };
            let next = another_motion(&ranked, &seen, &healthy).unwrap_or_default();
            format!("{anyway}{}{next}{unseen}", fits(&ranked, is_nothing))
        }
    };
    console::lines(&tables)?;
    Ok(Outcome::Done)
}

/// The largest distance of a wheel, in metres: it converts angles to lengths.
fn arm_m(robot: &Robot) -> f64 {
    let places = robot.wheels.iter();
    let places = places.map(|wheel| wheel.position_m().xy().norm());
    places.fold(0.0, f64::max)
}

/// The suspects in the order of how much of the observed drift they explain, each with the best
/// amount; a run was made for each. Without an observation, all with their usual amounts.
fn ranked(lineup: &Lineup, seen: &[Seen], arm_m: f64) -> Vec<(Suspect, Option<Fit>)> {
    let usual = lineup.at_usual_amounts();
    let mut ranked: Vec<(usize, Suspect, Option<Fit>)> = usual
        .into_iter()
        .enumerate()
        .map(|(index, suspect)| {
            let fit = fit(seen, &suspect.drifts, suspect.times, arm_m);
            (index, suspect, fit)
        })
        .collect();
    // An unusual amount is less likely.
    let worth =
        |fit: &Option<Fit>| fit.map_or(-1.0, |fit| fit.share - 0.1 * fit.times.abs().ln().abs());
    ranked.sort_by(|(.., a), (.., b)| worth(b).total_cmp(&worth(a)));
    ranked
        .par_iter_mut()
        .take(MOST_SHOWN)
        .for_each(|(index, suspect, fitted)| {
            if let Some(first) = *fitted {
                (*suspect, *fitted) = settled((lineup, *index), seen, first, arm_m);
            }
        });
    ranked.sort_by(|(.., a), (.., b)| worth(b).total_cmp(&worth(a)));
    ranked
        .into_iter()
        .map(|(_, suspect, fit)| (suspect, fit))
        .collect()
}

/// A suspect with the amount at which its own runs explain most of the observed drift: drifts are
/// not quite proportional to the amount.
fn settled(
    (lineup, index): (&Lineup, usize),
    seen: &[Seen],
    first: Fit,
    arm_m: f64,
) -> (Suspect, Option<Fit>) {
    const ROUNDS: usize = 3;
    let mut times = first.times;
    let mut suspect = lineup.in_amount(index, times);
    for _ in 0..ROUNDS {
        let bounds = (suspect.times.0 / times, suspect.times.1 / times);
        let bounds = (bounds.0.min(bounds.1), bounds.0.max(bounds.1));
        match fit(seen, &suspect.drifts, bounds, arm_m) {
            Some(more) if (more.times - 1.0).abs() > 0.01 => {
                times *= more.times;
                suspect = lineup.in_amount(index, times);
            }
            _ => break,
        }
    }
    let fit = fit(seen, &suspect.drifts, (1.0, 1.0), arm_m);
    let fit = fit.map(|fit| Fit { times, ..fit });
    (suspect, fit)
}

/// The robot's drift without faults in a motion with an observation; empty if it is too small to
/// measure.
fn anyway(seen: &Seen, healthy: &[Option<Drift>]) -> String {
    let drift = healthy[seen.motion].unwrap_or_default();
    let each = each(seen.motion);
    let mut parts = Vec::new();
    let mut say = |x: f64, floor: f64, per_si: f64, unit: &str, words: [&str; 2]| {
        if x.abs() > floor {
            let way = words[usize::from(x < 0.0)];
            parts.push(format!("{:.1} {unit}/{each} {way}", (per_si * x).abs()));
        }
    };
    let [floor_m, floor_rad] = drift.floor;
    let (left, turned) = (
        ["to the left", "to the right"],
        ["to the left", "to the right"],
    );
    say(drift.ahead_m, floor_m, 1e3, "mm", ["ahead", "back"]);
    say(drift.left_m, floor_m, 1e3, "mm", left);
    say(
        drift.turned_rad,
        floor_rad,
        1f64.to_degrees(),
        "deg",
        turned,
    );
    if parts.is_empty() {
        return String::new();
    }
    format!(
        "in the motion `{}` the robot without faults drifts by {}: the causes are ranked by the rest\n",
        MOTIONS[seen.motion],
        parts.join(", ")
    )
}

/// The drift by each suspect in each motion, below that without faults.
fn drifts<'s>(
    robot: &str,
    healthy: &[Option<Drift>],
    suspects: impl Iterator<Item = &'s Suspect>,
) -> Table {
    let mut table = Table::new();
    table.heading(&format!(
        "{robot}: what each usual cause adds, per metre or per turn: mm ahead, mm to the left, degrees to the left (· = too small to tell). \
         Rank them by what you measured: --seen \"left 20 mm/m, turn 1 deg/m\""
    ));
    // Motions that the robot cannot drive have no column.
    let of_driven = |drifts: &[Option<Drift>]| -> Vec<String> {
        let pairs = drifts.iter().zip(healthy);
        let driven = pairs.filter(|(_, healthy)| healthy.is_some());
        driven.map(|(drift, _)| in_words(drift)).collect()
    };
    let names = MOTIONS.iter().zip(healthy);
    let names = names
        .filter(|(_, healthy)| healthy.is_some())
        .map(|(name, _)| (*name).to_owned());
    table.words("", &names.collect::<Vec<_>>());
    table.words("without faults, from the command", &of_driven(healthy));
    for suspect in suspects {
        table.words(&suspect.words, &of_driven(&suspect.drifts));
    }
    table
}

fn in_words(drift: &Option<Drift>) -> String {
    let Some(drift) = drift else {
        return "refused".to_owned();
    };
    let told = |x: f64, floor: f64, per_si: f64, decimals: usize| {
        let text = format!("{:+.decimals$}", per_si * x);
        match x.abs() > floor && text.contains(|c| matches!(c, '1'..='9')) {
            true => text,
            false => "·".to_owned(),
        }
    };
    [
        told(drift.ahead_m, drift.floor[0], 1e3, 1),
        told(drift.left_m, drift.floor[0], 1e3, 1),
        told(drift.turned_rad, drift.floor[1], 1f64.to_degrees(), 2),
    ]
    .join(" ")
}

/// The suspects that match the observed drift, the best first.
fn fits(ranked: &[(Suspect, Option<Fit>)], is_nothing: bool) -> Table {
    let mut table = Table::new();
    let fitting = ranked.iter().filter_map(|(one, fit)| Some((one, (*fit)?)));
    let fitting: Vec<(&Suspect, Fit)> = fitting.take(MOST_SHOWN).collect();
    let best = fitting.iter().map(|(_, fit)| fit.share).fold(0.0, f64::max);
    let least = LEAST_OF_IT.max(LEAST_OF_BEST * best);
    let rows = fitting.iter().filter(|(_, fit)| fit.share >= least);
    let rows: Vec<&(&Suspect, Fit)> = rows.collect();
    let best = if rows.is_empty() { 0.0 } else { best };
    table.heading(match best {
        0.0 if is_nothing => "nothing to explain: the robot without faults drifts as much",
        0.0 => "no usual cause looks like it",
        best if best < MOST_OF_IT => {
            "no single cause explains most of it: there may be several. How much of the drift each explains, in the amount that fits best"
        }
        _ => "causes that look like it, each in the amount that fits best: how much of the drift each explains, usual amounts first",
    });
    if !rows.is_empty() {
        table.columns::<&(&Suspect, Fit)>(
            &[("explains", &|(_, fit)| {
                format!("{:.0} %", 100.0 * fit.share)
            })],
            rows.into_iter().map(|row| (row.0.words.as_str(), row)),
        );
    }
    table
}

/// The motions that were not measured, if the two best suspects explain nearly the same.
fn another_motion(
    ranked: &[(Suspect, Option<Fit>)],
    seen: &[Seen],
    healthy: &[Option<Drift>],
) -> Option<String> {
    /// Shares that differ by less are as good. Chosen.
    const AS_GOOD: f64 = 0.15;
    let mut fits = ranked.iter().filter_map(|(_, fit)| *fit);
    let (best, second) = (fits.next()?, fits.next()?);
    let is_close = second.share >= LEAST_OF_IT && (best.share - second.share).abs() < AS_GOOD;
    let all = MOTIONS.iter().zip(healthy).enumerate();
    let open = all.filter(|(index, (_, healthy))| {
        // Of motions that were not simulated it is not known whether the robot drives them.
        healthy.is_none() && seen.iter().all(|one| one.motion != *index)
    });
    let open: Vec<String> = open.map(|(_, (name, _))| format!("`{name}`")).collect();
    (is_close && !open.is_empty()).then(|| {
        format!(
            "\nto tell causes this close apart, measure another motion too, with one more --seen: {}\n",
            open.join(", ")
        )
    })
}

/// The suspects that do nothing in the motions with an observation, as these are simulated: a weak
/// motor shows only where it reaches its limit. Empty if there are none.
fn unseen(ranked: &[(Suspect, Option<Fit>)]) -> String {
    let is_small = |drift: &Drift| {
        let [floor_m, floor_rad] = drift.floor;
        drift.ahead_m.hypot(drift.left_m) <= floor_m && drift.turned_rad.abs() <= floor_rad
    };
    let mut words: Vec<String> = Vec::new();
    for (suspect, _) in ranked {
        let mut tried = suspect.drifts.iter().flatten().peekable();
        let does_nothing = tried.peek().is_some() && tried.all(is_small);
        // The same of each wheel is one.
        let general = match &suspect.wheel {
            Some(wheel) => suspect.words.replace(wheel.as_str(), "a wheel"),
            None => suspect.words.clone(),
        };
        if does_nothing && !words.contains(&general) {
            words.push(general);
        }
    }
    match words.is_empty() {
        true => String::new(),
        false => format!(
            "\nnot ruled out, as they do nothing at the speed and acceleration of the simulated motion: {}\n",
            words.join("; ")
        ),
    }
}

fn as_json((suspect, fit): &(Suspect, Option<Fit>)) -> Value {
    json!({
        "words": suspect.words,
        "wheel": suspect.wheel,
        "drifts": suspect.drifts,
        "explains": fit.map(|fit| fit.share),
        "times": fit.map(|fit| fit.times),
    })
}
