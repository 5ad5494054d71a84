//! What a study found, as a person reads it on a terminal.

use std::collections::BTreeMap;
use std::fmt::Write;

use ilon_report::sweep::figure as number;
use ilon_sim::judge::Verdict;
use ilon_sim::sweep::findings::{Expectation, FoundAt, MinimumAt};
use ilon_sim::sweep::{Find, Findings, Minimise, Question, Study, number_of, text_of};

use crate::cli::table::Table;

/// Points of which what was found is listed.
const MOST_POINTS: usize = 40;

/// A minimum that lies in this share of an axis at either end is said to lie at its end.
const AT_THE_END: f64 = 0.01;

/// What was found, in words and tables.
pub(in crate::cli) fn words(study: &Study, findings: &Findings) -> String {
    let mut text = String::new();
    let failed = match findings.failed {
        0 => String::new(),
        count => format!(", {count} of them failed"),
    };
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}: {} runs{failed}", study.name(), findings.runs);
    for failures in findings.failures.iter().take(3) {
        let _ = writeln!(
            text,
            "  failed, {} times, first run {}: {}",
            failures.count, failures.first_run, failures.error
        );
    }
    match study.question() {
        Question::Find(find) => found(&mut text, find, &findings.found),
        Question::Minimise(minimise) => {
            if let Some(at) = &findings.minimum {
                minimum(&mut text, minimise, at);
            }
        }
        Question::Table { .. } => {}
    }
    text.push_str(&tables(study, findings).to_string());
    for one in &findings.expectations {
        let _ = writeln!(text, "\nexpected: {}", expectation(one));
    }
    text
}

/// An expectation and what came of it.
pub(super) fn expectation(one: &Expectation) -> String {
    let Expectation {
        quantity,
        bound,
        share_expected,
        share,
        interval,
        kept,
        runs,
        held,
        worst_run,
    } = one;
    let verb = if *held { "held" } else { "failed" };
    let mut text = format!(
        "{quantity} {bound} in {} % of the runs {verb}: {} %, {kept} of {runs}",
        number(100.0 * share_expected),
        number(100.0 * share)
    );
    if let Some((low, high)) = interval {
        let _ = write!(
            text,
            " (of all such runs {:.2} to {:.2} %, with 95 % confidence)",
            100.0 * low,
            100.0 * high
        );
    }
    if let Some(run) = worst_run {
        let _ = write!(text, "; the worst is run {run}");
    }
    text
}

/// The expectations of a study as verdicts, as `ilon check` shows those of a scenario.
pub(in crate::cli) fn verdicts(findings: &Findings) -> Vec<Verdict> {
    let verdict = |one: &Expectation| Verdict {
        quantity: format!(
            "share of {} runs with {} {}",
            one.runs, one.quantity, one.bound
        ),
        bound: format!(">= {}", number(one.share_expected)),
        measured: Some(one.share),
        at_s: None,
        held: one.held,
    };
    findings.expectations.iter().map(verdict).collect()
}

/// Values of keys, `key = value` each.
fn at(values: &BTreeMap<String, toml::Value>) -> String {
    let shown = |value: &toml::Value| number_of(value).map_or_else(|| text_of(value), number);
    let one = |(key, value): (&String, &toml::Value)| format!("{key} = {}", shown(value));
    values.iter().map(one).collect::<Vec<_>>().join(", ")
}

fn found(text: &mut String, find: &Find, found: &[FoundAt]) {
    let _ = writeln!(
        text,
        "\nwhere {} crosses {} along {}",
        find.quantity,
        number(find.crosses),
        find.key
    );
    for one in found.iter().take(MOST_POINTS) {
        let place = match at(&one.values) {
            empty if empty.is_empty() => one.scenario.clone(),
            values => format!("{}, {values}", one.scenario),
        };
        let _ = write!(text, "  {place}: ");
        let what = &one.found;
        if what.crossings.is_empty() {
            let range = match (what.least, what.largest) {
                (Some(least), Some(largest)) => {
                    format!("it goes from {} to {}", number(least), number(largest))
                }
                _ => "no run could be finished".to_owned(),
            };
            let _ = writeln!(
                text,
                "nowhere from {} to {}: {range}{}",
                number(find.from),
                number(find.to),
                match what.failed {
                    0 => String::new(),
                    count => format!("; {count} of {} values failed", find.scan),
                }
            );
            continue;
        }
        let crossings: Vec<String> = what
            .crossings
            .iter()
            .map(|crossing| {
                let way = if crossing.is_rising {
                    "rising"
                } else {
                    "falling"
                };
                let (from, to) = (number(crossing.key_below), number(crossing.key_above));
                let narrow = if crossing.is_narrow {
                    ""
                } else {
                    ", not narrower because a run failed"
                };
                format!(
                    "{} ({way}, between {from} and {to}{narrow})",
                    number(crossing.at)
                )
            })
            .collect();
        let _ = writeln!(text, "{}", crossings.join("; "));
        if !what.is_monotonic {
            let _ = writeln!(
                text,
                "    it is not monotonic: the quantity rises in some parts of the range and falls in others; crossings closer \
                 together than the {} values tried first are not seen",
                find.scan
            );
        }
        if what.failed > 0 {
            let _ = writeln!(text, "    {} of the values tried first failed", what.failed);
        }
    }
    if found.len() > MOST_POINTS {
        let _ = writeln!(
            text,
            "  and {} more in findings.json",
            found.len() - MOST_POINTS
        );
    }
}

fn minimum(text: &mut String, minimise: &Minimise, at_minimum: &MinimumAt) {
    let MinimumAt {
        quantity,
        values,
        run,
        minimum,
        ..
    } = at_minimum;
    let (Some(value), Some(run)) = (minimum.value, run) else {
        let bounds: Vec<&str> = minimise.subject_to.keys().map(String::as_str).collect();
        let _ = writeln!(
            text,
            "\nno minimum of {quantity} was found: none of {} points could be run within the bounds on {}",
            minimum.trials,
            bounds.join(", ")
        );
        return;
    };
    let _ = writeln!(
        text,
        "\n{quantity} is least, {}, at run {run}:\n  {}",
        number(value),
        at(values)
    );
    let found = minimum.by_start.iter().flatten();
    let near = found
        .filter(|best| (*best - value).abs() <= 0.01 * value.abs())
        .count();
    let _ = writeln!(
        text,
        "  {near} of {} searches came within 1 % of it, in {} points",
        minimum.by_start.len(),
        minimum.trials
    );
    let edges: Vec<&str> = values
        .keys()
        .zip(&minimum.place)
        .filter(|(_, share)| **share <= AT_THE_END || **share >= 1.0 - AT_THE_END)
        .map(|(key, _)| key.as_str())
        .collect();
    if !edges.is_empty() {
        let _ = writeln!(
            text,
            "  it lies at the end of {}: beyond it there may be less",
            edges.join(", ")
        );
    }
}

fn tables(study: &Study, findings: &Findings) -> Table {
    let mut table = Table::new();
    let several = study.scenario_names().count() > 1;
    let title = |quantity: &str, scenario: &str| {
        if several {
            format!("{quantity}, {scenario}")
        } else {
            quantity.to_owned()
        }
    };
    for one in &findings.distributions {
        let of_points = match one.draws {
            draws if draws == one.count => String::new(),
            draws => format!(" of {draws} points"),
        };
        table.heading(&format!(
            "{} over {} runs{of_points}",
            title(&one.quantity, &one.scenario),
            one.count
        ));
        table.words(
            "mean, standard deviation",
            &[number(one.mean), number(one.deviation)],
        );
        table.words("least, largest", &[number(one.least), number(one.largest)]);
        for quantile in &one.quantiles {
            let end = |end: Option<f64>| end.map_or("?".to_owned(), number);
            table.words(
                &format!(
                    "{} %, and where it lies with 95 %",
                    number(100.0 * quantile.share)
                ),
                &[
                    number(quantile.value),
                    end(quantile.low),
                    end(quantile.high),
                ],
            );
        }
    }
    for one in &findings.indices {
        table.heading(&format!(
            "{}: {} +- {}; share of that variance by itself, with others (95 %)",
            title(&one.quantity, &one.scenario),
            number(one.mean),
            number(one.deviation)
        ));
        for axis in &one.axes {
            let range = |interval: &ilon_sim::sweep::findings::sensitivity::Interval| {
                format!("({:.2} to {:.2})", interval.low, interval.high)
            };
            let value = |value: f64| format!("{value:.3}");
            let words = [
                value(axis.first.value),
                range(&axis.first),
                value(axis.total.value),
                range(&axis.total),
            ];
            table.words(&axis.key, &words);
        }
    }
    for one in &findings.effects {
        table.heading(&format!(
            "effects over the whole axis on {}: mean magnitude, mean, deviation",
            title(&one.quantity, &one.scenario)
        ));
        for axis in &one.axes {
            let figures = [axis.mean_magnitude, axis.mean, axis.deviation];
            let words = figures.map(|figure| figure.map_or("-".to_owned(), number));
            table.words(&axis.key, &words);
        }
    }
    table
}
