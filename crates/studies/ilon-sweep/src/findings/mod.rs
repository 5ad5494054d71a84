//! The findings of a study: the answer to its question, with uncertainties.

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

/// The reported quantiles of a sample.
const SHARES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// The findings of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Findings {
    /// The study's name.
    pub study: String,
    /// The version of ilon.
    pub ilon: String,
    /// Number of runs.
    pub runs: u64,
    /// Number of failed runs.
    pub failed: u64,
    /// Reasons of failure, the most frequent first.
    pub failures: Vec<Failures>,
    /// What a person should know about the runs, the most frequent first.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub notes: Vec<Notes>,
    /// Quantities with incomplete findings.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub gaps: Vec<Gap>,
    /// For a grid: ranges of the quantities and effects of the axes.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub ranges: Vec<RangeOf>,
    /// For `[find]`: the crossings of the quantity at each point of the axes.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub found: Vec<FoundAt>,
    /// For `[minimise]`: the minimum.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub minimum: Option<MinimumAt>,
    /// For a sample: distributions of the quantities.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub distributions: Vec<Distribution>,
    /// For `"sobol_indices"`: the share of each quantity's variance caused by each axis.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub indices: Vec<IndicesOf>,
    /// For `"morris"`: the effect of each axis on each quantity.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub effects: Vec<EffectsOf>,
    /// Results of the study's `[expect]`.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub expectations: Vec<Expectation>,
}

/// Runs that failed for the same reason.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Failures {
    /// The reason.
    pub error: String,
    /// Number of runs.
    pub count: u64,
    /// Number of the first of them.
    pub first_run: u64,
}

/// Runs with the same note, whatever the numbers in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Notes {
    /// The note of the first of them.
    pub note: String,
    /// Number of runs.
    pub count: u64,
    /// Number of the first of them.
    pub first_run: u64,
}

/// Result of `[find]` at one point of the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FoundAt {
    /// The scenario.
    pub scenario: String,
    /// The value on each axis.
    pub values: BTreeMap<String, Value>,
    /// Result of the search.
    #[serde(flatten)]
    pub found: SearchOutcome,
}

/// Result of `[minimise]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MinimumAt {
    /// The quantity.
    pub quantity: String,
    /// The value on each axis; empty if no run kept the bounds.
    pub values: BTreeMap<String, Value>,
    /// Number of the best run, the first of its repetitions.
    pub run: Option<u64>,
    /// The bounded quantities of that run, in SI units.
    #[serde(default)]
    pub subject_to: BTreeMap<String, f64>,
    /// The notes of that run.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Result of the search.
    #[serde(flatten)]
    pub minimum: Minimum,
}

/// Distribution of a quantity over the runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Distribution {
    /// The quantity.
    pub quantity: String,
    /// The scenario.
    pub scenario: String,
    /// Number of runs with it.
    pub count: u64,
    /// Number of their points: repetitions of a point are not independent draws.
    pub draws: u64,
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// The smallest value.
    pub least: f64,
    /// The largest value.
    pub largest: f64,
    /// Quantiles with confidence intervals.
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
    /// Number of complete base points: none of their runs failed.
    pub base_points: u64,
    /// Mean of the quantity over them.
    pub mean: f64,
    /// Its standard deviation, the whole of the shares. If it is small, none of the axes matters
    /// much.
    pub deviation: f64,
    /// Indices of each axis.
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
    /// Effects of each axis.
    pub axes: Vec<Effects>,
}

/// Result of a bound of the study's `[expect]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expectation {
    /// The quantity.
    pub quantity: String,
    /// The bound as text, such as `<= 0.02`.
    pub bound: String,
    /// The share of runs that must keep it.
    pub share_expected: f64,
    /// The share that keeps it.
    pub share: f64,
    /// The 95 % confidence interval of the share of all such runs, if the runs are a sample;
    /// repetitions of a point, and its runs in several scenarios, count as one draw.
    pub interval: Option<(f64, f64)>,
    /// Number of runs that keep it.
    pub kept: u64,
    /// Number of all runs.
    pub runs: u64,
    /// Whether enough runs keep it.
    pub held: bool,
    /// The run furthest beyond it, or that failed; `None` if all keep it.
    pub worst_run: Option<u64>,
}

impl Findings {
    /// Returns the findings from rows alone; searches add their own.
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
            notes: notes(rows),
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

    /// Adds the findings of a quantity, at an index among the figures, from the rows of a scenario.
    fn add(&mut self, study: &Study, scenario: &str, rows: &[&Row], quantity: &str, index: usize) {
        let figure = |row: &Row| row.figure(index);
        let values: Vec<f64> = rows.iter().filter_map(|row| figure(row)).collect();
        let absent = gaps::absent(quantity, scenario, rows, figure);
        // A quantity that is absent everywhere is not constant, and was reported before.
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
            // A quantity that is absent everywhere needs no further report.
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
            // If only noise varies, each repetition is a draw.
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

/// Splits a note on a named part, such as "wheel `a`: too short", into the part and the rest. Other
/// notes have colons too, within their sentences.
fn of_part(note: &str) -> Option<(&str, &str)> {
    let (part, said) = note.split_once(": ")?;
    let kind = part.strip_suffix('`')?.split_once('`')?.0;
    let is_kind = |c: char| c.is_ascii_lowercase() || c == ' ';
    kind.chars().all(is_kind).then_some((part, said))
}

fn notes(rows: &[Row]) -> Vec<Notes> {
    /// The most parts that are named; chosen.
    const MOST_PARTS: usize = 4;
    let without_numbers = |note: &str| -> String {
        note.chars()
            .filter(|c| !c.is_ascii_digit() && *c != '.')
            .collect()
    };
    let mut notes: BTreeMap<String, (Notes, BTreeSet<&str>)> = BTreeMap::new();
    for row in rows {
        let mut counted = BTreeSet::new();
        for note in &row.notes {
            let (part, said) = of_part(note).map_or((None, note.as_str()), |(p, s)| (Some(p), s));
            let kind = without_numbers(said);
            let (known, parts) = notes.entry(kind.clone()).or_insert_with(|| {
                let known = Notes {
                    note: said.to_owned(),
                    count: 0,
                    first_run: row.run,
                };
                (known, BTreeSet::new())
            });
            parts.extend(part);
            known.count += u64::from(counted.insert(kind));
        }
    }
    let named = |(mut known, parts): (Notes, BTreeSet<&str>)| {
        let more = parts.len().saturating_sub(MOST_PARTS);
        let first: Vec<&str> = parts.into_iter().take(MOST_PARTS).collect();
        let more = (more > 0).then(|| format!(" and {more} more"));
        if !first.is_empty() {
            let more = more.unwrap_or_default();
            known.note = format!("{}{more}: {}", first.join(", "), known.note);
        }
        known
    };
    let mut notes: Vec<Notes> = notes.into_values().map(named).collect();
    notes.sort_by(|a, b| b.count.cmp(&a.count).then(a.first_run.cmp(&b.first_run)));
    notes
}

/// Returns the number of points of rows.
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

/// Returns mean and standard deviation of a sample.
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
            // Runs are counted: 0.99 of 100 are 99, whatever the rounding of 0.99.
            held: runs > 0 && kept as f64 >= bound.share * runs as f64 - 1e-9,
            worst_run: worst.map(|row| row.run),
        }
    };
    study.expect().map(of).collect()
}

/// Returns the quantity at the runs of each complete base point, as the mean of the repetitions.
fn whole_base_points(study: &Study, rows: &[&Row], quantity: usize) -> Vec<Vec<f64>> {
    let means = means(study, rows, quantity);
    let runs = study.axes().len() + 2;
    means
        .chunks(runs)
        .filter(|chunk| chunk.len() == runs)
        .filter_map(|chunk| chunk.iter().copied().collect())
        .collect()
}

/// Returns the moves of all trajectories without failed ends.
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

/// Returns the quantity at each point, as the mean of its repetitions; `None` if one of them failed
/// or is missing.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn row(run: u64, notes: &[&str]) -> Row {
        Row {
            run,
            key: "k".to_owned(),
            status: Status::Done,
            error: None,
            scenario: "s".to_owned(),
            point: run,
            repetition: 0,
            values: Vec::new(),
            trace_hash: None,
            notes: notes.iter().map(|note| (*note).to_owned()).collect(),
            figures: Vec::new(),
        }
    }

    /// Only numbers and the part that a note begins with may differ.
    #[test]
    fn a_note_keeps_its_subject_and_names_all_parts_that_have_it() {
        const FAST: &str = "the motion is too fast for 6.0 % of the run. At 0.50 s wheel `rr` needs 120 % of its grip on the \
                            floor: all wheels together need 102 % of theirs; drive slower";
        let faster = FAST.replace("102", "130");
        let rows = [
            row(3, &[FAST, "wheel `fl`: 2 gaps", "wheel `rr`: 1 gaps"]),
            row(4, &[&faster, "wheel `fr`: 7 gaps"]),
            row(5, &["the rollers of the wheel `fl`: too many"]),
        ];
        let found: Vec<(String, u64, u64)> = notes(&rows)
            .into_iter()
            .map(|of| (of.note, of.count, of.first_run))
            .collect();
        let gaps = "wheel `fl`, wheel `fr`, wheel `rr`: 2 gaps".to_owned();
        let of_rollers = "the rollers of the wheel `fl`: too many".to_owned();
        let mut expected = vec![(gaps, 2, 3), (FAST.to_owned(), 2, 3), (of_rollers, 1, 5)];
        expected.sort();
        let mut sorted = found.clone();
        sorted.sort();
        assert_eq!(sorted, expected);
        assert_eq!(found[2].1, 1, "the most frequent first");
        let of_six: Vec<String> = (0..6)
            .map(|wheel| format!("wheel `w{wheel}`: gaps"))
            .collect();
        let of_six: Vec<&str> = of_six.iter().map(String::as_str).collect();
        let [one] = &notes(&[row(0, &of_six)])[..] else {
            panic!("one note for all wheels");
        };
        assert!(
            one.note.ends_with("wheel `w3` and 2 more: gaps"),
            "{}",
            one.note
        );
    }
}
