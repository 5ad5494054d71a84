//! Keys, values and quantities of a study as text.

use std::collections::BTreeMap;

use ilon_sweep::{Study, number_of, text_of};
use ilon_trace::quantities::{self, Quantity};
use toml::Value;

use crate::sweep::figure as number;
use crate::text::spoken;

/// Largest number of a search's points reported in sentences; the table has all.
pub(super) const MOST_POINTS: usize = 12;

/// Returns the text for a quantity of the summary; by default its name.
pub fn words(quantity: &str) -> String {
    quantities::by_key(quantity).map_or_else(|| quantity.to_owned(), Quantity::words)
}

/// Returns a value of a quantity as text, with its unit.
pub(super) fn value_of(quantity: &str, value: f64) -> String {
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

/// Returns a value of a key as text.
pub(super) fn shown(key: &str, value: &Value, study: &Study) -> String {
    number_of(value).map_or_else(|| study.name_of(key, value), number)
}

/// Returns the text for a key and its unit: its last part, or all of it if another key of the study
/// has the same last part: `period` and `s` for `reference.figure_eight.period_s`, `center[0]` and
/// `m` for `robot.spec.chassis.center_m.0`.
pub(super) fn key_words(key: &str, study: &Study) -> (String, &'static str) {
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
    let (bare, unit) = match quantities::without_unit(&name) {
        ("", _) => (name.as_str(), ""),
        split => split,
    };
    (format!("{}{index}", bare.replace('_', " ")), unit)
}

/// A value of a key with its unit: `12 s`, and `20/s` of a gain.
pub(super) fn level((key, unit): (&str, &str), value: &Value, study: &Study) -> String {
    let value = shown(key, value, study);
    match unit.strip_prefix("1/") {
        Some(per) => format!("{value}/{per}"),
        None => format!("{value} {unit}").trim_end().to_owned(),
    }
}

/// A key with its value, such as `period 12 s` for `reference.figure_eight.period_s = 12`.
pub(super) fn setting(key: &str, value: &Value, study: &Study) -> String {
    let (name, unit) = key_words(key, study);
    format!("{name} {}", level((key, unit), value, study))
}

pub(super) fn settings(values: &BTreeMap<String, Value>, study: &Study) -> String {
    let one = |(key, value): (&String, &Value)| setting(key, value, study);
    values.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Returns values of keys, `key = value` each, in the scenario's format.
pub(super) fn at(values: &BTreeMap<String, Value>) -> String {
    let one = |(key, value): (&String, &Value)| {
        let value = number_of(value).map_or_else(|| text_of(value), number);
        format!("{key} = {value}")
    };
    values.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Returns the text for a quantity, with the scenario if the study has several.
pub(super) fn title(quantity: &str, scenario: &str, study: &Study) -> String {
    match study.scenario_names().count() {
        0 | 1 => named(quantity),
        _ => format!("{} of {scenario}", named(quantity)),
    }
}

/// A quantity's name in a sentence.
pub(super) fn named(quantity: &str) -> String {
    quantities::by_key(quantity).map_or_else(|| quantity.to_owned(), spoken)
}

/// Returns a share in percent, with two digits.
pub(super) fn percent(share: f64) -> String {
    format!(
        "{} %",
        ilon_trace::number(ilon_trace::significant(100.0 * share, 2))
    )
}
