//! The figures behind the sentences.

use crate::page::Table;
use crate::sweep::figure as number;
use ilon_sweep::findings::FoundAt;
use ilon_sweep::findings::grid::{Level, RangeOf};
use ilon_sweep::findings::sensitivity::{Effects, Indices, Interval};
use ilon_sweep::{Findings, Study};

use super::phrases::{MOST_POINTS, at, capital, percent, shown, title, value_of};

/// What the sentences leave out.
pub fn tables(study: &Study, findings: &Findings) -> Vec<Table> {
    let mut tables: Vec<Table> = Vec::new();
    let strings =
        |words: &[&str]| -> Vec<String> { words.iter().map(|word| (*word).to_owned()).collect() };
    if findings.found.len() > MOST_POINTS {
        let row = |one: &FoundAt| {
            let crossings: Vec<String> = one
                .found
                .crossings
                .iter()
                .map(|crossing| number(crossing.at))
                .collect();
            let end = |value: Option<f64>| value.map_or("-".to_owned(), number);
            let place = format!("{}, {}", one.scenario, at(&one.values));
            vec![
                place,
                crossings.join(", "),
                end(one.found.least),
                end(one.found.largest),
            ]
        };
        tables.push(Table {
            title: "Where it crosses, and the range of the quantity over the values tried first"
                .to_owned(),
            head: strings(&["point", "crossings", "least", "largest"]),
            rows: findings.found.iter().map(row).collect(),
        });
    }
    for scenario in study.scenario_names() {
        let ranges: Vec<&RangeOf> = findings
            .ranges
            .iter()
            .filter(|one| one.scenario == scenario)
            .collect();
        for (place, axis) in ranges
            .first()
            .map_or(&[][..], |one| &one.axes)
            .iter()
            .enumerate()
        {
            let mean = |one: &RangeOf, level: usize| {
                let mean = one
                    .axes
                    .get(place)
                    .and_then(|axis| axis.levels.get(level)?.mean);
                mean.map_or("-".to_owned(), |mean| value_of(&one.quantity, mean))
            };
            let row = |(level, of): (usize, &Level)| {
                let means = ranges.iter().map(|one| mean(one, level));
                std::iter::once(shown(&of.value)).chain(means).collect()
            };
            let heads = ranges
                .iter()
                .map(|one| title(&one.quantity, scenario, study));
            tables.push(Table {
                title: format!("Means at each {}", axis.key),
                head: std::iter::once(axis.key.clone()).chain(heads).collect(),
                rows: axis.levels.iter().enumerate().map(row).collect(),
            });
        }
    }
    for one in &findings.distributions {
        let of_points = match one.draws {
            draws if draws == one.count => String::new(),
            draws => format!(" of {draws} points"),
        };
        let end = |end: Option<f64>| end.map_or("?".to_owned(), |end| value_of(&one.quantity, end));
        let plain = |name: &str, value: f64| {
            vec![
                name.to_owned(),
                value_of(&one.quantity, value),
                String::new(),
                String::new(),
            ]
        };
        let quantiles = one.quantiles.iter().map(|quantile| {
            let value = value_of(&one.quantity, quantile.value);
            vec![
                format!("below it {}", percent(quantile.share)),
                value,
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
        let title = capital(&title(&one.quantity, &one.scenario, study));
        tables.push(Table {
            title: format!("{title} over {} runs{of_points}", one.count),
            head: strings(&["", "value", "from (95 %)", "to"]),
            rows: rows.into_iter().chain(quantiles).collect(),
        });
    }
    for one in &findings.indices {
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
        tables.push(Table {
            title: format!(
                "{}: share of its variance",
                capital(&title(&one.quantity, &one.scenario, study))
            ),
            head: strings(&["axis", "by itself", "95 %", "with others", "95 %"]),
            rows: one.axes.iter().map(row).collect(),
        });
    }
    for one in &findings.effects {
        let row = |axis: &Effects| {
            let figures = [axis.mean_magnitude, axis.mean, axis.deviation];
            let figures = figures.map(|figure| {
                figure.map_or("-".to_owned(), |figure| value_of(&one.quantity, figure))
            });
            std::iter::once(axis.key.clone()).chain(figures).collect()
        };
        tables.push(Table {
            title: format!(
                "{}: effects over the whole axis",
                capital(&title(&one.quantity, &one.scenario, study))
            ),
            head: strings(&["axis", "mean magnitude", "mean", "deviation"]),
            rows: one.axes.iter().map(row).collect(),
        });
    }
    tables
}
