//! What a study of many runs found, in sentences.

mod tables;

pub(crate) use tables::tables;

use std::collections::BTreeMap;

use ilon_report::page::Answer;
use ilon_report::sweep::figure as number;
use ilon_sweep::findings::gaps::Gap;
use ilon_sweep::findings::grid::{Extreme, RangeOf};
use ilon_sweep::findings::{EffectsOf, Expectation, FoundAt, IndicesOf, MinimumAt};
use ilon_sweep::{Find, Findings, Minimise, Question, Study, number_of, text_of};
use ilon_trace::quantities::{self, Quantity};
use toml::Value;

/// Points of a search of which a sentence says what was found; a table has all.
const MOST_POINTS: usize = 12;

/// A minimum that lies in this share of an axis at either end is said to lie at its end.
const AT_THE_END: f64 = 0.01;

/// A quantity of the summary in words; its own name where it has no others.
pub(crate) fn words(quantity: &str) -> String {
    quantities::by_key(quantity).map_or_else(|| quantity.to_owned(), Quantity::words)
}

/// A value of a quantity as a person reads it, with its unit.
fn value_of(quantity: &str, value: f64) -> String {
    match quantities::by_key(quantity) {
        Some(known) if !known.unit.symbol.is_empty() => {
            format!(
                "{} {}",
                number(value * known.unit.per_si),
                known.unit.symbol
            )
        }
        _ => number(value),
    }
}

/// A value of a key as a person reads it.
fn shown(value: &Value) -> String {
    number_of(value).map_or_else(|| text_of(value), number)
}

/// A key in words by its last part, or all of it where another of the study ends so, and the unit that it is in: `period` and `s` of
/// `reference.figure_eight.period_s`, `center[0]` and `m` of `robot.spec.chassis.center_m.0`.
fn key_words(key: &str, study: &Study) -> (String, &'static str) {
    let split = |key: &str| -> (String, String) {
        let (path, index) = match key.rsplit_once('.') {
            Some((path, index)) if index.parse::<usize>().is_ok() => (path, format!("[{index}]")),
            _ => (key, String::new()),
        };
        let last = path.rsplit('.').next().unwrap_or(path);
        (last.to_owned(), index)
    };
    let (name, index) = split(key);
    let alike = study.columns().iter();
    let alike = alike.filter(|column| split(&column.key) == (name.clone(), index.clone()));
    if alike.count() > 1 {
        return (key.to_owned(), "");
    }
    let unit = quantities::si_unit(&name);
    let end = format!("_{}", unit.replace(['/', ' '], "_").to_lowercase());
    let (bare, unit) = match name.strip_suffix(&end) {
        Some(bare) if !unit.is_empty() => (bare, unit),
        _ => (name.as_str(), ""),
    };
    (format!("{}{index}", bare.replace('_', " ")), unit)
}

/// A value of a key with its unit.
fn level(value: &Value, unit: &str) -> String {
    format!("{} {unit}", shown(value)).trim_end().to_owned()
}

/// A key with its value, such as `period 12 s` for `reference.figure_eight.period_s = 12`.
fn setting(key: &str, value: &Value, study: &Study) -> String {
    let (name, unit) = key_words(key, study);
    format!("{name} {}", level(value, unit))
}

fn settings(values: &BTreeMap<String, Value>, study: &Study) -> String {
    let one = |(key, value): (&String, &Value)| setting(key, value, study);
    values.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Values of keys, `key = value` each, as a scenario has them.
fn at(values: &BTreeMap<String, Value>) -> String {
    let one = |(key, value): (&String, &Value)| format!("{key} = {}", shown(value));
    values.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// A quantity in words, of a study of several scenarios with the scenario.
fn title(quantity: &str, scenario: &str, study: &Study) -> String {
    match study.scenario_names().count() {
        0 | 1 => words(quantity),
        _ => format!("{}, {scenario}", words(quantity)),
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// A share in percent, to two digits.
fn percent(share: f64) -> String {
    format!(
        "{} %",
        ilon_trace::number(ilon_report::short(100.0 * share, 2))
    )
}

/// What came of the study, the bounds that were expected first, then what is not known.
pub(crate) fn answers(study: &Study, findings: &Findings) -> Vec<Answer> {
    let mut answers: Vec<Answer> = findings.expectations.iter().map(expected).collect();
    for failures in findings.failures.iter().take(3) {
        answers.push(Answer::bad(format!(
            "{} of {} runs failed, the first of them run {}: {}",
            failures.count, findings.runs, failures.first_run, failures.error
        )));
    }
    answers.extend(findings.gaps.iter().map(|gap| missing(gap, study)));
    let mut plain: Vec<String> = Vec::new();
    match study.question() {
        Question::Find(find) => plain.extend(found(find, &findings.found)),
        Question::Minimise(minimise) => {
            plain.extend(findings.minimum.iter().map(|at| least(minimise, at)));
        }
        Question::Table { .. } => {}
    }
    plain.extend(findings.ranges.iter().map(|one| range(one, study)));
    for one in &findings.distributions {
        if let Some(median) = one.quantiles.get(2) {
            let most = one.quantiles.last().unwrap_or(median);
            plain.push(format!(
                "{}: {} in the middle, below {} in {} of the runs, {} at most.",
                capital(&title(&one.quantity, &one.scenario, study)),
                value_of(&one.quantity, median.value),
                value_of(&one.quantity, most.value),
                percent(most.share),
                value_of(&one.quantity, one.largest)
            ));
        }
    }
    plain.extend(findings.indices.iter().filter_map(|one| shares(one, study)));
    plain.extend(
        findings
            .effects
            .iter()
            .filter_map(|one| effects(one, study)),
    );
    answers.extend(plain.into_iter().map(Answer::plain));
    answers
}

fn expected(one: &Expectation) -> Answer {
    Answer {
        is_good: Some(one.held),
        text: format!("{}.", expectation(one)),
    }
}

/// An expectation and what came of it.
pub(crate) fn expectation(one: &Expectation) -> String {
    let verb = if one.held { "held" } else { "failed" };
    let interval = one.interval.map_or(String::new(), |(low, high)| {
        format!(
            " (of all such runs {:.2} to {:.2} %, with 95 % confidence)",
            100.0 * low,
            100.0 * high
        )
    });
    let worst = one.worst_run;
    let worst = worst.map_or(String::new(), |run| format!("; the worst is run {run}"));
    format!(
        "{} {} in {} % of the runs {verb}: {} %, {} of {}{interval}{worst}",
        one.quantity,
        one.bound,
        number(100.0 * one.share_expected),
        number(100.0 * one.share),
        one.kept,
        one.runs
    )
}

fn missing(gap: &Gap, study: &Study) -> Answer {
    let title = capital(&title(&gap.quantity, &gap.scenario, study));
    Answer::bad(match gap.absent {
        0 => format!("{title} is not answered: {}.", gap.why),
        absent => format!(
            "{title} is absent in {absent} of {} runs: {}.",
            gap.runs, gap.why
        ),
    })
}

fn range(one: &RangeOf, study: &Study) -> String {
    let value = |value: f64| value_of(&one.quantity, value);
    let end = |end: &Extreme| {
        format!(
            "{} ({}, run {})",
            value(end.value),
            settings(&end.values, study),
            end.run
        )
    };
    let title = capital(&title(&one.quantity, &one.scenario, study));
    if value(one.least.value) == value(one.largest.value) {
        let all = value(one.mean);
        return format!("{title} is {all} in all runs, to four digits.");
    }
    let mut text = format!(
        "{title}: from {} to {}.",
        end(&one.least),
        end(&one.largest)
    );
    if one.axes.len() < 2 {
        return text;
    }
    let mut axes: Vec<_> = one.axes.iter().collect();
    axes.sort_by(|a, b| b.share.unwrap_or(0.0).total_cmp(&a.share.unwrap_or(0.0)));
    let effects = axes.iter().filter_map(|axis| {
        let [(least_at, least), (largest_at, largest)] = axis.ends()?;
        let (name, unit) = key_words(&axis.key, study);
        let share = axis.share.map_or(String::new(), |share| {
            format!(" causes {} of what varies", percent(share))
        });
        Some(format!(
            "{name}{share} (mean {} at {}, {} at {})",
            value(least),
            level(least_at, unit),
            value(largest),
            level(largest_at, unit)
        ))
    });
    let effects: Vec<String> = effects.collect();
    text += &format!(" {}", capital(&effects.join(", ")));
    let shares: Option<Vec<f64>> = one.axes.iter().map(|axis| axis.share).collect();
    if let Some(shares) = shares {
        let together = (1.0 - shares.iter().sum::<f64>()).max(0.0);
        text += &format!("; {} they cause only together", percent(together));
    }
    text + "."
}

fn shares(one: &IndicesOf, study: &Study) -> Option<String> {
    let total = |axis: &&ilon_sweep::findings::sensitivity::Indices| axis.total.value;
    let first = one
        .axes
        .iter()
        .max_by(|a, b| total(a).total_cmp(&total(b)))?;
    Some(format!(
        "{} is {} with a standard deviation of {}: {} causes {} of that variance ({:.0} to {:.0}, 95 %), {} by itself.",
        capital(&title(&one.quantity, &one.scenario, study)),
        value_of(&one.quantity, one.mean),
        value_of(&one.quantity, one.deviation),
        first.key,
        percent(first.total.value),
        100.0 * first.total.low,
        100.0 * first.total.high,
        percent(first.first.value)
    ))
}

fn effects(one: &EffectsOf, study: &Study) -> Option<String> {
    let known = one.axes.iter();
    let known = known.filter_map(|axis| Some((axis, axis.mean_magnitude?)));
    let (most, magnitude) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "{}: {} matters most, and changes it by {} over its range.",
        capital(&title(&one.quantity, &one.scenario, study)),
        most.key,
        value_of(&one.quantity, magnitude)
    ))
}

/// What a search along a key found, a sentence a point.
fn found(find: &Find, found: &[FoundAt]) -> Vec<String> {
    let quantity = words(&find.quantity);
    let crosses = value_of(&find.quantity, find.crosses);
    let sentence = |one: &FoundAt| {
        let what = &one.found;
        let place = match one.values.is_empty() {
            true => one.scenario.clone(),
            false => format!("{}, {}", one.scenario, at(&one.values)),
        };
        let failed = match what.failed {
            0 => String::new(),
            failed => format!("; {failed} of the {} values tried first failed", find.scan),
        };
        if what.crossings.is_empty() {
            let range = match (what.least, what.largest) {
                (Some(least), Some(largest)) => format!(
                    "it goes from {} to {}",
                    value_of(&find.quantity, least),
                    value_of(&find.quantity, largest)
                ),
                _ => "no run could be finished".to_owned(),
            };
            let (from, to) = (number(find.from), number(find.to));
            return format!(
                "{place}: {quantity} nowhere crosses {crosses} along {} from {from} to {to}: {range}{failed}.",
                find.key
            );
        }
        let mut ways = String::new();
        let mut was_rising = false;
        for crossing in &what.crossings {
            let (joined, way) = match (crossing.is_rising, was_rising) {
                (true, _) => (" or ", "above"),
                (false, true) => (" and ", "below"),
                (false, false) => (" or ", "below"),
            };
            if !ways.is_empty() {
                ways += joined;
            }
            let narrow = match crossing.is_narrow {
                true => "",
                false => ", not narrower because a run failed",
            };
            ways += &format!(
                "{way} {} (between {} and {}{narrow})",
                number(crossing.at),
                number(crossing.key_below),
                number(crossing.key_above)
            );
            was_rising = crossing.is_rising;
        }
        let bent = match what.is_monotonic {
            true => String::new(),
            false => format!(
                "; it is not monotonic, and crossings closer together than the {} values tried first are not seen",
                find.scan
            ),
        };
        format!(
            "{place}: {quantity} exceeds {crosses} where {} is {ways}{bent}{failed}.",
            find.key
        )
    };
    let mut lines: Vec<String> = found.iter().take(MOST_POINTS).map(sentence).collect();
    if let Some(more @ 1..) = found.len().checked_sub(MOST_POINTS) {
        lines.push(format!("{more} more are in the table below."));
    }
    lines
}

fn least(minimise: &Minimise, at_minimum: &MinimumAt) -> String {
    let MinimumAt {
        quantity,
        values,
        run,
        minimum,
        ..
    } = at_minimum;
    let (Some(value), Some(run)) = (minimum.value, run) else {
        let bounds: Vec<&str> = minimise.subject_to.keys().map(String::as_str).collect();
        let within = match bounds.is_empty() {
            true => String::new(),
            false => format!(" within the bounds on {}", bounds.join(", ")),
        };
        return format!(
            "No minimum of {} was found: none of {} points could be run{within}.",
            words(quantity),
            minimum.trials
        );
    };
    let bests = minimum.by_start.iter().flatten();
    let near = bests.filter(|best| (*best - value).abs() <= 0.01 * value.abs());
    let mut text = format!(
        "{} is least, {}, at {} (run {run}); {} of {} searches came within 1 % of it, in {} points.",
        capital(&words(quantity)),
        value_of(quantity, value),
        at(values),
        near.count(),
        minimum.by_start.len(),
        minimum.trials
    );
    let edges: Vec<&str> = (values.keys().zip(&minimum.place))
        .filter(|(_, share)| **share <= AT_THE_END || **share >= 1.0 - AT_THE_END)
        .map(|(key, _)| key.as_str())
        .collect();
    if !edges.is_empty() {
        text += &format!(
            " It lies at the end of {}: beyond it there may be less.",
            edges.join(", ")
        );
    }
    text
}
