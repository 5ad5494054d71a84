//! The answers of a study in sentences.

use ilon_report::sweep::{self, Answer};
use ilon_sim::sweep::findings::{Expectation, FoundAt, MinimumAt};
use ilon_sim::sweep::{Find, Findings, Question, Row, Study, text_of};
use ilon_trace::number;
use ilon_trace::quantities::{self, Quantity};

/// A quantity of the summary in words; its own name where it has no others.
pub(super) fn words(quantity: &str) -> String {
    quantities::by_key(quantity).map_or_else(|| quantity.to_owned(), Quantity::words)
}

/// A value of a quantity as a person reads it, with its unit.
fn value_of(quantity: &str, value: f64) -> String {
    match quantities::by_key(quantity) {
        Some(known) if !known.unit.symbol.is_empty() => format!(
            "{} {}",
            sweep::figure(value * known.unit.per_si),
            known.unit.symbol
        ),
        _ => sweep::figure(value),
    }
}

/// A key that is varied by its last part, where no other of the study ends so.
fn short_key<'k>(key: &'k str, study: &Study) -> &'k str {
    let last = |key: &'k str| key.rsplit('.').next().unwrap_or(key);
    let ends = study.columns().iter();
    let alike = ends.filter(|column| column.key.rsplit('.').next() == Some(last(key)));
    match alike.count() {
        0 | 1 => last(key),
        _ => key,
    }
}

/// From where to where the first quantities go, of a study that asks nothing more.
fn ranges(study: &Study, rows: &[Row]) -> Vec<String> {
    let at = |row: &Row| {
        let values = study.columns().iter().zip(&row.values);
        let values = values.filter(|(column, _)| column.key != "sensors.seed");
        let values: Vec<String> = values
            .map(|(column, value)| setting(&column.key, &text_of(value), study))
            .collect();
        values.join(", ")
    };
    let range = |quantity: &String| {
        let index = ilon_sim::sweep::figure_index(quantity)?;
        let value = |row: &&Row| row.figure(index);
        let known = || rows.iter().filter(|row| value(row).is_some());
        let by = |a: &&Row, b: &&Row| value(a).unwrap_or(0.0).total_cmp(&value(b).unwrap_or(0.0));
        let (least, largest) = (known().min_by(by)?, known().max_by(by)?);
        Some(format!(
            "{}: from {} ({}) to {} ({}).",
            capital(&words(quantity)),
            value_of(quantity, value(&least)?),
            at(least),
            value_of(quantity, value(&largest)?),
            at(largest)
        ))
    };
    study
        .quantities()
        .iter()
        .take(4)
        .filter_map(range)
        .collect()
}

/// What came of the study, the bounds that were expected first.
pub(super) fn answers(study: &Study, rows: &[Row], findings: &Findings) -> Vec<Answer> {
    let mut answers: Vec<Answer> = findings.expectations.iter().map(expectation).collect();
    let plain = |text: String| Answer {
        is_good: None,
        text,
    };
    match study.question() {
        Question::Find(find) => answers.extend(found(find, &findings.found).into_iter().map(plain)),
        Question::Minimise(_) => {
            answers.extend(findings.minimum.iter().map(|minimum| plain(least(minimum))))
        }
        Question::Table { .. } if study.file().method == ilon_sim::sweep::Method::Grid => {
            answers.extend(ranges(study, rows).into_iter().map(plain));
        }
        Question::Table { .. } => {}
    }
    for one in &findings.distributions {
        if let Some(median) = one.quantiles.get(2) {
            let most = one.quantiles.last().unwrap_or(median);
            answers.push(plain(format!(
                "{} of {}: {} in the middle, below {} in {} % of the runs, {} at most.",
                one.quantity,
                one.scenario,
                sweep::figure(median.value),
                sweep::figure(most.value),
                number(100.0 * most.share),
                sweep::figure(one.largest)
            )));
        }
    }
    for one in &findings.indices {
        let mut ranked = one.axes.clone();
        ranked.sort_by(|a, b| b.total.value.total_cmp(&a.total.value));
        if let Some(first) = ranked.first() {
            answers.push(plain(format!(
                "{} is {} with a standard deviation of {}: {} causes {:.0} % of that variance, by itself {:.0} %.",
                one.quantity,
                sweep::figure(one.mean),
                sweep::figure(one.deviation),
                first.key,
                100.0 * first.total.value,
                100.0 * first.first.value
            )));
        }
    }
    for one in &findings.effects {
        let known = one
            .axes
            .iter()
            .filter_map(|axis| Some((axis, axis.mean_magnitude?)));
        if let Some((most, magnitude)) = known.max_by(|a, b| a.1.total_cmp(&b.1)) {
            answers.push(plain(format!(
                "{}: {} matters most, and changes it by {} over its range.",
                one.quantity,
                most.key,
                sweep::figure(magnitude)
            )));
        }
    }
    for failures in findings.failures.iter().take(3) {
        answers.push(Answer {
            is_good: Some(false),
            text: format!(
                "{} of {} runs failed, the first of them run {}: {}",
                failures.count, findings.runs, failures.first_run, failures.error
            ),
        });
    }
    answers
}

/// A key with its value, such as `period 12 s` for `reference.figure_eight.period_s = 12`.
fn setting(key: &str, value: &str, study: &Study) -> String {
    let name = short_key(key, study);
    let unit = quantities::si_unit(name);
    let end = unit.replace(['/', ' '], "_").to_lowercase();
    match name.strip_suffix(&format!("_{end}")) {
        Some(bare) if !unit.is_empty() => format!("{} {value} {unit}", bare.replace('_', " ")),
        _ => format!("{} {value}", name.replace('_', " ")),
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

fn expectation(one: &Expectation) -> Answer {
    let interval = one.interval.map_or(String::new(), |(low, high)| {
        format!(
            "; of all such runs {:.2} to {:.2} %, with a confidence of 95 %",
            100.0 * low,
            100.0 * high
        )
    });
    Answer {
        is_good: Some(one.held),
        text: format!(
            "{} is {} in {} of {} runs, {:.2} %, where {} % are expected{interval}.",
            one.quantity,
            one.bound,
            one.kept,
            one.runs,
            100.0 * one.share,
            number(100.0 * one.share_expected)
        ),
    }
}

fn found(find: &Find, found: &[FoundAt]) -> Vec<String> {
    const MOST: usize = 12;
    let mut lines: Vec<String> = Vec::new();
    for one in found.iter().take(MOST) {
        let values = one
            .values
            .iter()
            .map(|(key, value)| format!("{key} = {}", text_of(value)));
        let place = std::iter::once(one.scenario.clone())
            .chain(values)
            .collect::<Vec<_>>()
            .join(", ");
        let crossings: Vec<String> = one
            .found
            .crossings
            .iter()
            .map(|crossing| {
                format!(
                    "{} {}",
                    if crossing.is_rising { "above" } else { "below" },
                    sweep::figure(crossing.at)
                )
            })
            .collect();
        lines.push(if crossings.is_empty() {
            format!(
                "{place}: {} never crosses {}.",
                words(&find.quantity),
                value_of(&find.quantity, find.crosses)
            )
        } else {
            let bent = if one.found.is_monotonic {
                ""
            } else {
                ", and is not monotonic between"
            };
            format!(
                "{place}: {} exceeds {} where {} is {}{bent}.",
                words(&find.quantity),
                value_of(&find.quantity, find.crosses),
                find.key,
                crossings.join(" and ")
            )
        });
    }
    if found.len() > MOST {
        lines.push(format!(
            "{} more are in the table below.",
            found.len() - MOST
        ));
    }
    lines
}

fn least(at: &MinimumAt) -> String {
    let Some(value) = at.minimum.value else {
        return format!(
            "No run kept the bounds: there is no minimum of {}.",
            at.quantity
        );
    };
    let values = at
        .values
        .iter()
        .map(|(key, value)| format!("{key} = {}", text_of(value)));
    format!(
        "{} is least, {}, at {}.",
        capital(&words(&at.quantity)),
        value_of(&at.quantity, value),
        values.collect::<Vec<_>>().join(", ")
    )
}
