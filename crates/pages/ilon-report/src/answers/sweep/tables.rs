//! Tables with the figures behind the sentences.

use crate::page::Table;
use crate::sweep::figure as number;
use ilon_sweep::findings::grid::{Level, MainEffect, RangeOf};
use ilon_sweep::findings::sensitivity::{Effects, Indices, Interval};
use ilon_sweep::findings::{Distribution, EffectsOf, FoundAt, IndicesOf};
use ilon_sweep::{Findings, Study};

use super::phrases::{MOST_POINTS, at, percent, shown, title, value_of};
use crate::text::capital;

/// Returns the details that the sentences omit.
pub fn tables(study: &Study, findings: &Findings) -> Vec<Table> {
    let mut tables = Vec::new();
    if let Some(find) = &study.file().find
        && findings.found.len() > MOST_POINTS
    {
        tables.push(crossings(&find.quantity, &findings.found));
    }
    for scenario in study.scenario_names() {
        let ranges = findings.ranges.iter();
        let ranges: Vec<&RangeOf> = ranges.filter(|one| one.scenario == scenario).collect();
        tables.extend(means(study, scenario, &ranges));
    }
    let titled = |quantity: &str, scenario: &str| capital(&title(quantity, scenario, study));
    let of = &findings.distributions;
    tables.extend(
        of.iter()
            .map(|of| distribution(of, titled(&of.quantity, &of.scenario))),
    );
    let of = &findings.indices;
    tables.extend(
        of.iter()
            .map(|of| indices(of, titled(&of.quantity, &of.scenario))),
    );
    let of = &findings.effects;
    tables.extend(
        of.iter()
            .map(|of| effects(of, titled(&of.quantity, &of.scenario))),
    );
    tables
}

fn strings(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Returns the table of crossings at each point.
fn crossings(quantity: &str, found: &[FoundAt]) -> Table {
    let end = |value: Option<f64>| value.map_or("-".to_owned(), |value| value_of(quantity, value));
    let row = |one: &FoundAt| {
        let crossings = one.found.crossings.iter();
        let crossings: Vec<String> = crossings.map(|crossing| number(crossing.at)).collect();
        vec![
            format!("{}, {}", one.scenario, at(&one.values)),
            crossings.join(", "),
            end(one.found.least),
            end(one.found.largest),
        ]
    };
    Table {
        title: "Where it crosses, and the range of the quantity over the values tried first"
            .to_owned(),
        head: strings(&["point", "crossings", "least", "largest"]),
        rows: found.iter().map(row).collect(),
    }
}

/// Returns a table for each axis of a grid: the mean of each quantity at each of its values.
fn means(study: &Study, scenario: &str, ranges: &[&RangeOf]) -> Vec<Table> {
    let axes = ranges.first().map_or(&[][..], |one| &one.axes);
    let table = |(place, axis): (usize, &MainEffect)| {
        let mean = |one: &RangeOf, level: usize| {
            let axis = one.axes.get(place);
            let mean = axis.and_then(|axis| axis.levels.get(level)?.mean);
            mean.map_or("-".to_owned(), |mean| value_of(&one.quantity, mean))
        };
        let row = |(level, of): (usize, &Level)| {
            let means = ranges.iter().map(|one| mean(one, level));
            let name = shown(&axis.key, &of.value, study);
            std::iter::once(name).chain(means).collect()
        };
        let heads = ranges.iter();
        let heads = heads.map(|one| title(&one.quantity, scenario, study));
        Table {
            title: format!("Means at each {}", axis.key),
            head: std::iter::once(axis.key.clone()).chain(heads).collect(),
            rows: axis.levels.iter().enumerate().map(row).collect(),
        }
    };
    axes.iter().enumerate().map(table).collect()
}

fn distribution(one: &Distribution, title: String) -> Table {
    let of_points = match one.draws {
        draws if draws == one.count => String::new(),
        draws => format!(" of {draws} points"),
    };
    let end = |end: Option<f64>| end.map_or("?".to_owned(), |end| value_of(&one.quantity, end));
    let plain = |name: &str, value: f64| {
        let value = value_of(&one.quantity, value);
        vec![name.to_owned(), value, String::new(), String::new()]
    };
    let quantiles = one.quantiles.iter().map(|quantile| {
        vec![
            format!("below it {}", percent(quantile.share)),
            value_of(&one.quantity, quantile.value),
            end(quantile.low),
            end(quantile.high),
        ]
    });
    let rows = [
        plain("mean", one.mean),
        plain("standard deviation", one.deviation),
        plain("least", one.least),
        plain("largest", one.largest),
    ];
    Table {
        title: format!("{title} over {} runs{of_points}", one.count),
        head: strings(&["", "value", "from (95 %)", "to"]),
        rows: rows.into_iter().chain(quantiles).collect(),
    }
}

fn indices(one: &IndicesOf, title: String) -> Table {
    let range = |share: &Interval| {
        [
            format!("{:.3}", share.value),
            format!("{:.2} to {:.2}", share.low, share.high),
        ]
    };
    let row = |axis: &Indices| {
        let shares = range(&axis.first).into_iter().chain(range(&axis.total));
        std::iter::once(axis.key.clone()).chain(shares).collect()
    };
    Table {
        title: format!("{title}: share of its variance"),
        head: strings(&["axis", "by itself", "95 %", "with others", "95 %"]),
        rows: one.axes.iter().map(row).collect(),
    }
}

fn effects(one: &EffectsOf, title: String) -> Table {
    let figure = |figure: Option<f64>| {
        figure.map_or("-".to_owned(), |figure| value_of(&one.quantity, figure))
    };
    let row = |axis: &Effects| {
        let figures = [axis.mean_magnitude, axis.mean, axis.deviation].map(figure);
        std::iter::once(axis.key.clone()).chain(figures).collect()
    };
    Table {
        title: format!("{title}: effects over the whole axis"),
        head: strings(&["axis", "mean magnitude", "mean", "deviation"]),
        rows: one.axes.iter().map(row).collect(),
    }
}
