//! What a study's rows say: the answer to its question, and how sure it is.

pub mod gaps;
pub mod grid;
pub mod sensitivity;
pub mod statistics;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use toml::Value;

use self::gaps::Gap;
use self::grid::RangeOf;
use self::sensitivity::{Effects, Indices};
use self::statistics::{Quantile, quantile, share_interval};
use crate::file::Method;
use crate::minimise::Minimum;
use crate::row::{Row, Status, figure_index};
use crate::study::{Question, Study};
use crate::threshold::SearchOutcome;

/// The quantiles that are given of a sample.
const SHARES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// What a study found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Findings {
    /// The study's name.
    pub study: String,
    /// The version of ilon.
    pub ilon: String,
    /// How many runs there are.
    pub runs: u64,
    /// How many of them failed.
    pub failed: u64,
    /// Why they failed, the most frequent reason first.
    pub failures: Vec<Failures>,
    /// Quantities of which the study says less than was asked.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub gaps: Vec<Gap>,
    /// Of a grid: where the quantities are least and largest, and what each axis does to them.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub ranges: Vec<RangeOf>,
    /// Of `[find]`: where the quantity crosses its value, at each point of the axes.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub found: Vec<FoundAt>,
    /// Of `[minimise]`: where the quantity is least.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub minimum: Option<MinimumAt>,
    /// Of a sample: how its quantities are distributed.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub distributions: Vec<Distribution>,
    /// Of `"sobol_indices"`: which share of the variance of each quantity each axis causes.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub indices: Vec<IndicesOf>,
    /// Of `"morris"`: how much each axis changes each quantity.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub effects: Vec<EffectsOf>,
    /// Whether the runs keep the study's `[expect]`.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub expectations: Vec<Expectation>,
}

/// Runs that failed for one reason.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Failures {
    /// The reason.
    pub error: String,
    /// How many.
    pub count: u64,
    /// The first of them.
    pub first_run: u64,
}

/// What `[find]` found at one point of the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FoundAt {
    /// The scenario.
    pub scenario: String,
    /// The value on each axis.
    pub values: BTreeMap<String, Value>,
    /// What was found there.
    #[serde(flatten)]
    pub found: SearchOutcome,
}

/// What `[minimise]` found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MinimumAt {
    /// The quantity.
    pub quantity: String,
    /// The value on each axis; empty where no run kept the bounds.
    pub values: BTreeMap<String, Value>,
    /// The run that is best, the first of its repetitions.
    pub run: Option<u64>,
    /// What was found.
    #[serde(flatten)]
    pub minimum: Minimum,
}

/// How a quantity is distributed over the runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Distribution {
    /// The quantity.
    pub quantity: String,
    /// The scenario.
    pub scenario: String,
    /// How many runs have it.
    pub count: u64,
    /// How many points these are of: repetitions of a point are no independent draws of what is varied.
    pub draws: u64,
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// The least.
    pub least: f64,
    /// The largest.
    pub largest: f64,
    /// Quantiles with their intervals.
    pub quantiles: Vec<Quantile>,
}

/// Sobol indices of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct IndicesOf {
    /// The quantity.
    pub quantity: String,
    /// The scenario.
    pub scenario: String,
    /// Base points that are whole: none of their runs failed.
    pub base_points: u64,
    /// The quantity's mean over them.
    pub mean: f64,
    /// Its standard deviation: what the shares are of. Where it is small, none of the axes matters much.
    pub deviation: f64,
    /// Those of each axis.
    pub axes: Vec<Indices>,
}

/// Elementary effects on a quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EffectsOf {
    /// The quantity.
    pub quantity: String,
    /// The scenario.
    pub scenario: String,
    /// Those of each axis.
    pub axes: Vec<Effects>,
}

/// What came of a bound of the study's `[expect]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expectation {
    /// The quantity.
    pub quantity: String,
    /// The bound in words, such as `<= 0.02`.
    pub bound: String,
    /// The share of runs that must keep it.
    pub share_expected: f64,
    /// The share that does.
    pub share: f64,
    /// Where the share of all such runs lies with a confidence of 95 %, if the runs are a sample; repetitions of a point, and its runs
    /// in several scenarios, count as one draw.
    pub interval: Option<(f64, f64)>,
    /// How many runs keep it.
    pub kept: u64,
    /// Of how many.
    pub runs: u64,
    /// Whether enough do.
    pub held: bool,
    /// The run that is farthest beyond it, or that failed; `None` where all keep it.
    pub worst_run: Option<u64>,
}

impl Findings {
    /// What rows say by themselves; what searches found is added by them.
    pub(super) fn of(study: &Study, rows: &[Row]) -> Self {
        let mut findings = Self {
            study: study.name().to_owned(),
            ilon: env!("CARGO_PKG_VERSION").to_owned(),
            runs: rows.len() as u64,
            failed: rows
                .iter()
                .filter(|row| row.status == Status::Failed)
                .count() as u64,
            failures: failures(rows),
            expectations: expectations(study, rows),
            ..Self::default()
        };
        let quantities = study.quantities().iter();
        let quantities: Vec<(&String, usize)> = quantities
            .filter_map(|name| Some((name, figure_index(name)?)))
            .collect();
        for scenario in study.scenario_names() {
            let of_scenario: Vec<&Row> =
                rows.iter().filter(|row| row.scenario == scenario).collect();
            for (quantity, index) in &quantities {
                findings.add(study, scenario, &of_scenario, quantity, *index);
            }
        }
        findings
    }

    /// Adds what the rows of a scenario say of a quantity, which stands at a place among their figures.
    fn add(&mut self, study: &Study, scenario: &str, rows: &[&Row], quantity: &str, index: usize) {
        let figure = |row: &Row| row.figure(index);
        let values: Vec<f64> = rows.iter().filter_map(|row| figure(row)).collect();
        let absent = gaps::absent(quantity, scenario, rows, figure);
        // What is absent everywhere is no constant, and has been said.
        let is_known = !values.is_empty();
        self.gaps.extend(absent);
        let keys = || -> Vec<String> { study.axes().iter().map(|axis| axis.key.clone()).collect() };
        let (named, of_scenario) = (quantity.to_owned(), scenario.to_owned());
        let is_table = matches!(study.question(), Question::Table { .. });
        match study.file().method {
            Method::SobolIndices => {
                let base = whole_base_points(study, rows, index);
                let drawn = base.iter().flat_map(|row| row[..2].to_vec());
                let (mean, deviation) = mean_and_deviation(&drawn.collect::<Vec<f64>>());
                let base_points = base.len() as u64;
                let axes = sensitivity::sobol_indices(&keys(), &base, study.file().seed);
                match axes {
                    Some(axes) => self.indices.push(IndicesOf {
                        quantity: named,
                        scenario: of_scenario,
                        base_points,
                        mean,
                        deviation,
                        axes,
                    }),
                    None if is_known => {
                        let runs = rows.len() as u64;
                        self.gaps.push(match base_points {
                            0 | 1 => {
                                let each = study.axes().len() + 2;
                                gaps::broken(quantity, scenario, runs, base_points, each)
                            }
                            _ => gaps::constant(quantity, scenario, runs, mean),
                        });
                    }
                    None => {}
                }
            }
            // Of what is absent everywhere there is nothing to say beyond that.
            Method::Morris if is_known => {
                let axes = sensitivity::morris_effects(&keys(), &moves(study, rows, index));
                if axes.iter().all(|axis| axis.moves == 0) {
                    let each = study.axes().len() + 1;
                    let runs = rows.len() as u64;
                    self.gaps
                        .push(gaps::broken(quantity, scenario, runs, 0, each));
                    return;
                }
                self.effects.push(EffectsOf {
                    quantity: named,
                    scenario: of_scenario,
                    axes,
                });
            }
            method if method.is_sample() => {
                let has_it = rows.iter().filter(|row| figure(row).is_some()).copied();
                self.distributions
                    .extend(distribution(named, of_scenario, values, draws(has_it)));
            }
            // Where noise alone varies, each repetition is a draw of it.
            _ if is_table && study.axes().is_empty() => {
                let draws = values.len() as u64;
                self.distributions
                    .extend(distribution(named, of_scenario, values, draws));
            }
            Method::Grid if is_table => {
                self.ranges
                    .extend(grid::range(study, quantity, scenario, rows, figure));
            }
            _ => {}
        }
    }

    /// Whether every bound of the study's `[expect]` holds.
    pub fn held(&self) -> bool {
        self.expectations.iter().all(|expectation| expectation.held)
    }
}

fn failures(rows: &[Row]) -> Vec<Failures> {
    let mut failures: Vec<Failures> = Vec::new();
    for row in rows {
        let Some(error) = &row.error else {
            continue;
        };
        match failures.iter_mut().find(|known| known.error == *error) {
            Some(known) => known.count += 1,
            None => failures.push(Failures {
                error: error.clone(),
                count: 1,
                first_run: row.run,
            }),
        }
    }
    failures.sort_by(|a, b| b.count.cmp(&a.count).then(a.first_run.cmp(&b.first_run)));
    failures
}

/// How many points rows are of.
fn draws<'r>(rows: impl Iterator<Item = &'r Row>) -> u64 {
    rows.map(|row| row.point).collect::<BTreeSet<u64>>().len() as u64
}

fn distribution(
    quantity: String,
    scenario: String,
    mut values: Vec<f64>,
    draws: u64,
) -> Option<Distribution> {
    values.sort_by(f64::total_cmp);
    let (least, largest) = (*values.first()?, *values.last()?);
    let (mean, deviation) = mean_and_deviation(&values);
    Some(Distribution {
        quantity,
        scenario,
        count: values.len() as u64,
        draws,
        mean,
        deviation,
        least,
        largest,
        quantiles: SHARES
            .iter()
            .map(|share| quantile(&values, *share, draws))
            .collect(),
    })
}

/// Mean and standard deviation of a sample.
fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, (spread / (n - 1.0).max(1.0)).sqrt())
}

fn expectations(study: &Study, rows: &[Row]) -> Vec<Expectation> {
    let is_sample = study.file().method.is_sample();
    let of = |(quantity, bound): (&str, &crate::file::ShareBound)| {
        let index = figure_index(quantity);
        let value = |row: &Row| index.and_then(|index| row.figure(index));
        let limits = bound.bound();
        let keeps = |row: &&Row| value(row).is_some_and(|value| limits.holds(value));
        let kept = rows.iter().filter(keeps).count() as u64;
        let runs = rows.len() as u64;
        let breach = |row: &Row| value(row).map_or(f64::INFINITY, |value| limits.breach(value));
        let broken = rows.iter().filter(|row| !keeps(row));
        let worst = broken.max_by(|a, b| breach(a).total_cmp(&breach(b)).then(b.run.cmp(&a.run)));
        let share = if runs == 0 {
            0.0
        } else {
            kept as f64 / runs as f64
        };
        Expectation {
            quantity: quantity.to_owned(),
            bound: limits.to_string(),
            share_expected: bound.share,
            share,
            interval: is_sample.then(|| share_interval(share, draws(rows.iter()))),
            kept,
            runs,
            // Whole runs are counted: 0.99 of 100 are 99, whatever the rounding of 0.99.
            held: runs > 0 && kept as f64 >= bound.share * runs as f64 - 1e-9,
            worst_run: worst.map(|row| row.run),
        }
    };
    study.expect().map(of).collect()
}

/// The quantity at the runs of each base point of which none failed; the mean of their repetitions.
fn whole_base_points(study: &Study, rows: &[&Row], quantity: usize) -> Vec<Vec<f64>> {
    let means = means(study, rows, quantity);
    let runs = study.axes().len() + 2;
    means
        .chunks(runs)
        .filter(|chunk| chunk.len() == runs)
        .filter_map(|chunk| chunk.iter().copied().collect())
        .collect()
}

/// The moves of all trajectories of which neither end failed.
fn moves(study: &Study, rows: &[&Row], quantity: usize) -> Vec<(usize, f64, f64)> {
    let means = means(study, rows, quantity);
    let axes = study.axes().len() as u64;
    let mut moves = Vec::new();
    let Some(sample) = study.sample() else {
        return moves;
    };
    for (point, pair) in means.windows(2).enumerate() {
        let (trajectory, moved) = (point as u64 / (axes + 1), point as u64 % (axes + 1));
        if moved < axes
            && let [Some(before), Some(after)] = pair
        {
            let (axis, by) = sample.morris_move(trajectory, moved);
            moves.push((axis, by, after - before));
        }
    }
    moves
}

/// The quantity at each point: the mean of its repetitions; `None` where one of them failed or is missing.
fn means(study: &Study, rows: &[&Row], quantity: usize) -> Vec<Option<f64>> {
    let repetitions = f64::from(study.file().repetitions);
    let mut sums = vec![(0.0, 0.0); study.points() as usize];
    for row in rows {
        if let (Some(value), Some(sum)) = (row.figure(quantity), sums.get_mut(row.point as usize)) {
            *sum = (sum.0 + value, sum.1 + 1.0);
        }
    }
    let mean = |(sum, count): (f64, f64)| (count == repetitions).then(|| sum / count);
    sums.into_iter().map(mean).collect()
}
