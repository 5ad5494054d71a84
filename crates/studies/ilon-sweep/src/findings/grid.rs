//! Range and main effects of a quantity over a grid.

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
    /// Number of runs with it.
    pub runs: u64,
    /// Its mean over these runs.
    pub mean: f64,
    /// Its minimum.
    pub least: Extreme,
    /// Its maximum.
    pub largest: Extreme,
    /// The main effect of each axis.
    pub axes: Vec<MainEffect>,
}

/// The run at one end of the range of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Extreme {
    /// Value of the quantity.
    pub value: f64,
    /// Number of the run.
    pub run: u64,
    /// The value on each axis.
    pub values: BTreeMap<String, Value>,
}

/// The main effect of an axis: the quantity at each of its values, over all values of the other
/// axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MainEffect {
    /// The key of the axis.
    pub key: String,
    /// Its values, in order.
    pub levels: Vec<Level>,
    /// The share of the quantity's variance over the grid caused by this axis alone; what the
    /// shares of all axes leave to 1 are interactions. `None` if the quantity does not vary, or if
    /// a run of the grid lacks it, because its neighbours would then count more.
    pub share: Option<f64>,
}

/// One value of an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Level {
    /// The value.
    pub value: Value,
    /// Mean of the quantity over all runs at this value; `None` if none has it.
    pub mean: Option<f64>,
    /// The smallest of these.
    #[serde(default)]
    pub least: Option<f64>,
    /// The largest of these.
    #[serde(default)]
    pub largest: Option<f64>,
}

/// Returns the range of a quantity over the rows of one scenario; `None` if no run has it.
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
    // Differences between repetitions are not caused by axes: the variance is that of the points.
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
            let values = || {
                let known = known.iter().filter(|(row, _)| here(row));
                known.map(|known| known.1)
            };
            Level {
                value: (*value).clone(),
                mean: mean_of(&mut values()),
                least: values().reduce(f64::min),
                largest: values().reduce(f64::max),
            }
        };
        let levels: Vec<Level> = levels.iter().map(level).collect();
        // On a grid each value of an axis has equally many points.
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
