//! What a grid says of a quantity: where it is least and largest, and what each axis does to it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use toml::Value;

use crate::axis::text_of;
use crate::row::Row;
use crate::study::Study;

/// The range of a quantity over a grid, and the main effects of its axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RangeOf {
    /// The quantity.
    pub quantity: String,
    /// The scenario.
    pub scenario: String,
    /// How many runs have it.
    pub runs: u64,
    /// Its mean over them.
    pub mean: f64,
    /// Where it is least.
    pub least: Extreme,
    /// Where it is largest.
    pub largest: Extreme,
    /// What each axis does to it.
    pub axes: Vec<MainEffect>,
}

/// The run at one end of the range of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Extreme {
    /// The quantity there.
    pub value: f64,
    /// The run.
    pub run: u64,
    /// The value on each axis.
    pub values: BTreeMap<String, Value>,
}

/// The main effect of an axis: the quantity at each of its values, over all values of the other axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MainEffect {
    /// The key of the axis.
    pub key: String,
    /// Its values, in their order.
    pub levels: Vec<Level>,
    /// The share of the quantity's variance over the grid that the axis causes by itself; what the shares of all axes leave to 1 is what
    /// they cause together. `None` where the quantity does not vary, and where a run of the grid has none: its neighbours would count more.
    pub share: Option<f64>,
}

/// One value of an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Level {
    /// The value.
    pub value: Value,
    /// The mean of the quantity over all runs there; `None` where none has it.
    pub mean: Option<f64>,
}

impl MainEffect {
    /// The values at which the mean is least and largest, with these means; `None` where no run has the quantity.
    pub fn ends(&self) -> Option<[(&Value, f64); 2]> {
        let known = || {
            let levels = self.levels.iter();
            levels.filter_map(|level| Some((&level.value, level.mean?)))
        };
        let least = known().reduce(|a, b| if b.1 < a.1 { b } else { a })?;
        let largest = known().reduce(|a, b| if b.1 > a.1 { b } else { a })?;
        Some([least, largest])
    }
}

/// What the rows of one scenario say of a quantity; `None` where no run has it.
pub(super) fn range(
    study: &Study,
    quantity: &str,
    scenario: &str,
    rows: &[&Row],
    figure: impl Fn(&Row) -> Option<f64>,
) -> Option<RangeOf> {
    let known: Vec<(&Row, f64)> = rows
        .iter()
        .filter_map(|row| Some((*row, figure(row)?)))
        .collect();
    let mean_of = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = values.fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
        (count > 0.0).then(|| sum / count)
    };
    let mean = mean_of(&mut known.iter().map(|(_, value)| *value))?;
    let axes: Vec<(usize, &str)> = (study.columns().iter().enumerate())
        .filter(|(_, column)| study.axes().iter().any(|axis| axis.key == column.key))
        .map(|(place, column)| (place, column.key.as_str()))
        .collect();
    let extreme = |(row, value): &(&Row, f64)| Extreme {
        value: *value,
        run: row.run,
        values: axes
            .iter()
            .filter_map(|(place, key)| Some(((*key).to_owned(), row.values.get(*place)?.clone())))
            .collect(),
    };
    let least = known.iter().reduce(|a, b| if b.1 < a.1 { b } else { a })?;
    let largest = known.iter().reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    let is_whole = known.len() == rows.len();
    // Repetitions of a point differ by what no axis causes: the variance is that of the points.
    let mut points: BTreeMap<u64, (f64, f64)> = BTreeMap::new();
    for (row, value) in &known {
        let (sum, count) = points.entry(row.point).or_default();
        *sum += value;
        *count += 1.0;
    }
    let squared = |value: f64| (value - mean) * (value - mean);
    let all: f64 = points
        .values()
        .map(|(sum, count)| squared(sum / count))
        .sum();
    let effect = |(place, key): &(usize, &str)| {
        let mut levels: Vec<&Value> = Vec::new();
        for value in rows.iter().filter_map(|row| row.values.get(*place)) {
            if !levels.iter().any(|level| text_of(level) == text_of(value)) {
                levels.push(value);
            }
        }
        let level = |value: &&Value| {
            let here = |row: &Row| row.values.get(*place).map(text_of) == Some(text_of(value));
            let mut values = known
                .iter()
                .filter(|(row, _)| here(row))
                .map(|known| known.1);
            Level {
                value: (*value).clone(),
                mean: mean_of(&mut values),
            }
        };
        let levels: Vec<Level> = levels.iter().map(level).collect();
        // On a grid each value of an axis has as many points.
        let each = points.len() as f64 / levels.len() as f64;
        let between: f64 = levels
            .iter()
            .filter_map(|level| level.mean)
            .map(squared)
            .sum();
        MainEffect {
            key: (*key).to_owned(),
            levels,
            share: (is_whole && all > 1e-24 * mean * mean * points.len() as f64)
                .then(|| each * between / all),
        }
    };
    Some(RangeOf {
        quantity: quantity.to_owned(),
        scenario: scenario.to_owned(),
        runs: known.len() as u64,
        mean,
        least: extreme(least),
        largest: extreme(largest),
        axes: axes.iter().map(effect).collect(),
    })
}
