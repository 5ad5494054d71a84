//! Results of studies and identifications as text for a terminal.

use ilon_identify::Identified;
use ilon_identify::outcome::Gains;
use ilon_identify::plan::Plan;
use ilon_identify::tape::TapeFit;
use ilon_report::answers::{identify, sweep};
use ilon_report::sweep::figure as number;
use ilon_sim::judge::Verdict;
use ilon_sweep::findings::Expectation;
use ilon_sweep::{Findings, Study};

use super::escape::sentence;
use super::table::Table;

/// The findings of a study as sentences and tables.
pub(super) fn of_study(study: &Study, findings: &Findings) -> String {
    let failed = match findings.failed {
        0 => String::new(),
        count => format!(", {count} of them failed"),
    };
    let mut text = format!("{}: {} runs{failed}\n", study.name(), findings.runs);
    for answer in sweep::answers(study, findings) {
        text += &format!("\n{}\n", sentence(&answer.text));
    }
    let mut table = Table::new();
    for one in &sweep::tables(study, findings) {
        table.of(one);
    }
    format!("{text}\n{table}")
}

/// The expectations of a study as verdicts, in the form in which `ilon check` shows a scenario's.
pub(super) fn verdicts(findings: &Findings) -> Vec<Verdict> {
    let verdict = |one: &Expectation| Verdict {
        quantity: format!(
            "share of {} runs with {} {}",
            one.runs, one.quantity, one.bound
        ),
        bound: format!(">= {}", number(one.share_expected)),
        measured: Some(one.share),
        at_s: None,
        share_beyond: None,
        is_short: false,
        is_outside: false,
        held: one.held,
    };
    findings.expectations.iter().map(verdict).collect()
}

/// The results of an identification: sentences, the fitted values and, with `in_full`, all other
/// figures.
pub(super) fn of_identification(found: &Identified, in_full: bool) -> String {
    let mut text = format!("{}\n", found.study);
    for answer in identify::answers(found) {
        text += &format!("\n{}\n", sentence(&answer.text));
    }
    let mut table = Table::new();
    match in_full {
        true => identify::tables::tables(found)
            .iter()
            .for_each(|one| table.of(one)),
        false => table.of(&identify::tables::parameters(found)),
    }
    format!("{text}\n{table}")
}

/// What runs measured by tape determine, and what further runs would.
pub(super) fn of_tape(found: &TapeFit) -> String {
    let mut text = format!("{}\n", found.study);
    if let Some(over) = found.over_errors.filter(|over| *over > 2.0) {
        let over = number(over);
        text += &format!(
            "\nThe runs miss the fit by {over} times their stated errors: either a run is wrong, or more of the robot differs from its nominal values; \
             free `axis_deg.*`, `x_m.*` or `radius_m.*` too.\n"
        );
    }
    if let Some([ahead, sideways, turn]) = found.rollers {
        let less = |gain: f64| format!("{:.1} %", 100.0 * (1.0 - gain));
        text += &format!(
            "\nRollers that touch beside the middle of their wheels take {} of the way sideways and {} of turns, by the robot's geometry alone: with that \
             the runs are explained, and nothing of the robot need differ.\n",
            less(sideways / ahead),
            less(turn / ahead)
        );
    }
    for line in identify::set(&found.controller, &Gains::default()) {
        text += &format!("\n{}\n", sentence(&line));
    }
    for held in &found.held {
        text += &format!(
            "\n`{}` stays at {}: {}.\n",
            held.name,
            number(held.value),
            held.why
        );
    }
    let mut table = Table::new();
    table.heading("parameters: value, from, to (95 %), before");
    for (name, value) in &found.parameters {
        let end = |end: Option<f64>| end.map_or("-".to_owned(), number);
        let [low, high] = value.ci95.map(end);
        table.words(
            name,
            &[number(value.value), low, high, number(value.nominal)],
        );
    }
    table.heading("misses of each run, in its standard errors: x, y, heading");
    for (index, misses) in found.misses.iter().enumerate() {
        let words = misses.map(|miss| {
            miss.map_or("-".to_owned(), |miss| {
                number(((10.0 * miss).round() + 0.0) / 10.0)
            })
        });
        table.words(&format!("{}", index + 1), &words);
    }
    let first = found.next.first();
    let names: Vec<&str> = first.map_or_else(Vec::new, |of| {
        of.errors.keys().map(String::as_str).collect()
    });
    table.heading(&format!(
        "standard errors after three more runs of a drive: {}",
        names.join(", ")
    ));
    for next in &found.next {
        let errors: Vec<String> = next.errors.values().map(|error| number(*error)).collect();
        table.words(&next.drive, &errors);
    }
    format!("{text}\n{table}")
}

/// A course and the parameters that it determines.
pub(super) fn course(plan: &Plan) -> String {
    let mut table = Table::new();
    table.heading("drive: m/s ahead, m/s to the left, rad/s, seconds");
    for (index, way) in plan.ways.iter().enumerate() {
        let [vx, vy, omega] = way.twist;
        let words = [vx, vy, omega, way.for_s].map(number);
        table.words(&format!("{}", index + 1), &words);
    }
    table.heading(
        "standard error that it leaves, of displacements seen to 1 mm and 1 mrad a second",
    );
    for (name, error) in &plan.errors {
        table.words(name, &[number(*error)]);
    }
    table.to_string()
}
