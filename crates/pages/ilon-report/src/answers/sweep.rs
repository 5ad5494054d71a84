//! The findings of a study in sentences.

mod phrases;
mod tables;

pub use phrases::words;
pub use tables::tables;

use crate::page::Answer;
use crate::sweep::figure as number;
use crate::text::capital;
use ilon_sweep::findings::gaps::Gap;
use ilon_sweep::findings::grid::{Extreme, Level, MainEffect, RangeOf};
use ilon_sweep::findings::{EffectsOf, Expectation, FoundAt, IndicesOf, MinimumAt, Notes};
use ilon_sweep::{Find, Findings, Minimise, Question, Study, number_of};
use ilon_trace::quantities::{by_key, is_cost, least_change};

use self::phrases::{MOST_POINTS, at, key_words, level, named, percent, settings, title, value_of};

/// A minimum within this share of an axis from its end is reported as at the end.
const AT_THE_END: f64 = 0.01;

/// Returns the findings of the study, the expected bounds first, then what is unknown.
pub fn answers(study: &Study, findings: &Findings) -> Vec<Answer> {
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
    // What a note says of a varied key limits all that follows.
    let notes: Vec<String> = match &findings.minimum {
        // What is said of other points of a search is of no use at the best one.
        Some(MinimumAt {
            run: Some(run),
            notes,
            ..
        }) => notes
            .iter()
            .map(|note| format!("Note of run {run}: {}.", note.trim_end_matches('.')))
            .collect(),
        _ => notes(findings).collect(),
    };
    let (of_keys, others): (Vec<String>, Vec<String>) = notes.into_iter().partition(|note| {
        let mut keys = study.columns().iter();
        keys.any(|column| note.contains(&format!("`{}`", column.key)))
    });
    plain.extend(of_keys);
    plain.extend(trade_offs(&findings.ranges, study).map(|trade| trade.text));
    // What hardly changes stands last.
    let mut ranges: Vec<&RangeOf> = findings.ranges.iter().collect();
    ranges.sort_by_key(|one| !changes(one));
    plain.extend(ranges.into_iter().map(|one| range(one, study)));
    for one in &findings.distributions {
        if let Some(median) = one.quantiles.get(2) {
            let most = one.quantiles.last().unwrap_or(median);
            plain.push(format!(
                "{}: median {}, below {} in {} of the runs, {} at most.",
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
    plain.extend(others);
    answers.extend(plain.into_iter().map(Answer::plain));
    answers
}

/// Largest number of notes of the runs that are reported.
const MOST_NOTES: usize = 5;

/// Reports the notes of the runs, the most frequent first.
fn notes(findings: &Findings) -> impl Iterator<Item = String> {
    let note = |one: &Notes| {
        let runs = match one.count == findings.runs {
            true => format!("all {} runs", one.count),
            false => format!(
                "{} of {} runs, first in run {}",
                one.count, findings.runs, one.first_run
            ),
        };
        format!("Note in {runs}: {}.", one.note.trim_end_matches('.'))
    };
    let more = findings.notes.len().saturating_sub(MOST_NOTES);
    let more = (more > 0).then(|| match more {
        1 => "1 more note is in findings.json.".to_owned(),
        _ => format!("{more} more notes are in findings.json."),
    });
    let shown: Vec<String> = findings.notes.iter().take(MOST_NOTES).map(note).collect();
    shown.into_iter().chain(more)
}

fn expected(one: &Expectation) -> Answer {
    Answer {
        is_good: Some(one.held),
        text: format!("{}.", expectation(one)),
    }
}

/// Reports an expectation and its result.
pub fn expectation(one: &Expectation) -> String {
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

/// An axis of numbers along which costs change.
pub struct Trade {
    /// Its key.
    pub key: String,
    /// The value nearest to the least of each cost, as shares of their ranges.
    pub best: f64,
    /// The first two costs whose least values do not lie together, if any do not.
    pub apart: Option<[String; 2]>,
    text: String,
}

/// Reports, of each axis of numbers, the value that is best for all costs, or between which values
/// they pull, and a compromise.
pub fn trade_offs(ranges: &[RangeOf], study: &Study) -> impl Iterator<Item = Trade> {
    /// A cost whose means over an axis differ by less than this share is not traded. Chosen.
    const LEAST_GAIN: f64 = 0.1;
    let costs = || ranges.iter().filter(|one| is_cost(&one.quantity));
    let mut keys: Vec<(&str, &str)> = Vec::new();
    for one in costs() {
        let axes = one
            .axes
            .iter()
            .map(|axis| (one.scenario.as_str(), axis.key.as_str()));
        keys.extend(axes.filter(|key| !keys.contains(key)).collect::<Vec<_>>());
    }
    let of_axis = |(scenario, key): (&str, &str)| {
        let of_scenario = costs().filter(|one| one.scenario == scenario);
        let axes = of_scenario.map(|one| {
            let axis = one.axes.iter().find(|axis| axis.key == key)?;
            Some((one, &axis.levels))
        });
        let axes: Vec<_> = axes.collect::<Option<_>>()?;
        let levels = axes.first()?.1;
        let numbers: Vec<f64> = levels
            .iter()
            .map(|level| number_of(&level.value))
            .collect::<Option<_>>()?;
        // A level whose runs all failed is none.
        let has_all = |index: &usize| {
            axes.iter()
                .all(|(_, levels)| levels.get(*index).is_some_and(|level| level.mean.is_some()))
        };
        let kept: Vec<usize> = (0..levels.len()).filter(has_all).collect();
        let mut traded = Vec::new();
        for (one, levels) in axes.iter().filter(|_| kept.len() > 2) {
            let means: Vec<f64> = kept
                .iter()
                .filter_map(|index| levels[*index].mean)
                .collect();
            let least = means.iter().copied().fold(f64::INFINITY, f64::min);
            let room = means.iter().copied().fold(f64::NEG_INFINITY, f64::max) - least;
            let digits = by_key(&one.quantity).map_or(0.0, least_change);
            // Work that is given back is no cost that is best least.
            if least >= 0.0 && room > (LEAST_GAIN * least).max(digits) {
                let lies = means.iter().position(|mean| mean - least <= digits)?;
                traded.push((*one, means, least, room, lies));
            }
        }
        let off = |index: &usize| -> f64 {
            let offs = traded
                .iter()
                .map(|(_, means, least, room, _)| (means[*index] - least) / room);
            offs.map(|off| off * off).sum()
        };
        traded.first()?;
        let best = (0..kept.len()).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let (name, unit) = key_words(key, study);
        let at = |index: usize| level((key, unit), &levels[kept[index]].value, study);
        let mut is_best = true;
        let parts = traded.iter().map(|(one, means, least, _, lies)| {
            let [here, there] = [means[best], *least].map(|mean| value_of(&one.quantity, mean));
            let title = title(&one.quantity, &one.scenario, study);
            if *lies == best || here == there {
                return format!("{title} {here}, the least");
            }
            is_best = false;
            format!("{title} {here} (least: {there} at {})", at(*lies))
        });
        let parts = parts.collect::<Vec<String>>().join("; ");
        let words = format!("{name} {}", at(best));
        let others = axes[0].0.axes.iter().filter(|axis| axis.key != key);
        let others: Vec<String> = others.map(|axis| key_words(&axis.key, study).0).collect();
        let over = match others.is_empty() {
            true => String::new(),
            false => format!(" (means over {})", others.join(", ")),
        };
        Some(Trade {
            key: key.to_owned(),
            best: numbers[kept[best]],
            apart: traded
                .iter()
                .enumerate()
                .find_map(|(place, (one, .., lies))| {
                    let mut after = traded[place + 1..].iter();
                    let other = after.find(|(.., other)| other != lies)?.0;
                    Some([one, other].map(|of| of.quantity.clone()))
                }),
            text: match is_best {
                true => format!("Best is {words}{over}: {parts}."),
                false => format!(
                    "No {name} is best for everything. {} is the compromise{over}: {parts}.",
                    capital(&words)
                ),
            },
        })
    };
    let trades: Vec<Trade> = keys.into_iter().filter_map(of_axis).collect();
    trades.into_iter()
}

/// The least share of the variation that a sentence names, of an axis or of an interaction.
const LEAST_SHARE: f64 = 0.01;

/// Whether a quantity changes by more than a hundredth.
fn changes(one: &RangeOf) -> bool {
    let [least, largest] = [one.least.value, one.largest.value];
    largest - least > 0.01 * least.abs().max(largest.abs())
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
    if !changes(one) {
        let [least, largest] = [one.least.value, one.largest.value].map(value);
        return format!("{title} hardly changes: {least} to {largest}.");
    }
    let mut text = format!(
        "{title}: from {} to {}.",
        end(&one.least),
        end(&one.largest)
    );
    text += &at_the_ends(one, study);
    if one.axes.len() < 2 {
        return text;
    }
    let mut axes: Vec<_> = one.axes.iter().collect();
    axes.sort_by(|a, b| b.share.unwrap_or(0.0).total_cmp(&a.share.unwrap_or(0.0)));
    let most = axes.first().and_then(|axis| axis.share);
    axes.retain(|axis| {
        axis.share
            .is_none_or(|share| share >= LEAST_SHARE || Some(share) == most)
    });
    let effects = axes.iter().filter_map(|axis| {
        let share = percent(axis.share?);
        Some(format!(
            "{} explains {share} of the variation",
            key_words(&axis.key, study).0
        ))
    });
    let effects: Vec<String> = effects.collect();
    if effects.is_empty() {
        return text;
    }
    text += &format!(" {}", capital(&effects.join(", ")));
    let shares: Option<Vec<f64>> = one.axes.iter().map(|axis| axis.share).collect();
    if let Some(shares) = shares {
        let together = 1.0 - shares.iter().sum::<f64>();
        if together > LEAST_SHARE {
            text += &format!("; their interaction explains {}", percent(together));
        }
    }
    text + "."
}

/// Reports that the least or the largest value of a grid lies at the end of axes that matter, so
/// that the grid may have missed what lies beyond.
fn at_the_ends(one: &RangeOf, study: &Study) -> String {
    let ends = |extreme: &Extreme, of: fn(&Level) -> Option<f64>| -> String {
        let axes = one.axes.iter();
        let axes = axes.filter(|axis| axis.share.is_none_or(|share| share >= LEAST_SHARE));
        let axes = axes.filter(|axis| is_at_an_end_alone(&one.quantity, extreme, axis, of));
        let names: Vec<String> = axes.map(|axis| key_words(&axis.key, study).0).collect();
        names.join(" and ")
    };
    let least = ends(&one.least, |level| level.least);
    let largest = match is_cost(&one.quantity) {
        true => String::new(),
        false => ends(&one.largest, |level| level.largest),
    };
    match (least, largest) {
        (least, largest) if least.is_empty() && largest.is_empty() => String::new(),
        (least, largest) if least == largest => {
            format!(" Both lie at the end of {least}: further out there may be less, and more.")
        }
        (least, largest) => [("least", least, "less"), ("largest", largest, "more")]
            .iter()
            .filter(|(_, ends, _)| !ends.is_empty())
            .map(|(which, ends, beyond)| {
                format!(
                    " The {which} lies at the end of {ends}: further out there may be {beyond}."
                )
            })
            .collect(),
    }
}

/// Whether a run has the lowest or the highest value of an axis of numbers, and no value between
/// them comes to the same, to four digits. Two values are all ends, and a seed has no order.
fn is_at_an_end_alone(
    quantity: &str,
    extreme: &Extreme,
    axis: &MainEffect,
    of: fn(&Level) -> Option<f64>,
) -> bool {
    let levels = axis.levels.iter();
    let values: Option<Vec<f64>> = levels.map(|level| number_of(&level.value)).collect();
    let at = extreme.values.get(&axis.key).and_then(number_of);
    let (Some(values), Some(at), false) = (values, at, axis.key.ends_with("seed")) else {
        return false;
    };
    let is_inner = |at: f64| values.iter().any(|x| *x < at) && values.iter().any(|x| *x > at);
    let shown = |value: f64| value_of(quantity, value);
    let comes_to_it = |level: &Level| of(level).map(shown) == Some(shown(extreme.value));
    let mut levels = values.iter().zip(&axis.levels);
    values.len() > 2
        && !is_inner(at)
        && !levels.any(|(value, level)| is_inner(*value) && comes_to_it(level))
}

fn shares(one: &IndicesOf, study: &Study) -> Option<String> {
    let total = |axis: &&ilon_sweep::findings::sensitivity::Indices| axis.total.value;
    let first = one
        .axes
        .iter()
        .max_by(|a, b| total(a).total_cmp(&total(b)))?;
    // Shares that are known this badly are only an order.
    const VAGUE: f64 = 0.5;
    if first.total.high - first.total.low > VAGUE {
        return Some(format!(
            "{} is {} with a standard deviation of {}: {} seems to cause more of it than any other; more points would tell how much.",
            capital(&title(&one.quantity, &one.scenario, study)),
            value_of(&one.quantity, one.mean),
            value_of(&one.quantity, one.deviation),
            first.key
        ));
    }
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

/// Reports the results of a search along a key, one sentence per point.
fn found(find: &Find, found: &[FoundAt]) -> Vec<String> {
    let quantity = named(&find.quantity);
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
        let is = if more == 1 { "is" } else { "are" };
        lines.push(format!("{more} more {is} in the table below."));
    }
    lines
}

/// Why no point is within the bounds. `bounded`: the least and the largest value of each bounded
/// quantity over the points that ran; empty if none ran.
fn kept_none(minimise: &Minimise, bounded: &[[f64; 2]]) -> String {
    if bounded.is_empty() {
        return "could be run".to_owned();
    }
    let broken = minimise.subject_to.iter().zip(bounded);
    let broken = broken.flat_map(|((quantity, bound), [least, most])| {
        let value = |value: f64| value_of(quantity, value);
        let over = bound.max.filter(|max| least > max);
        let over = over.map(|max| {
            format!(
                "{quantity} <= {}: the least was {}",
                value(max),
                value(*least)
            )
        });
        let under = bound.min.filter(|min| most < min);
        let under = under.map(|min| {
            format!(
                "{quantity} >= {}: the most was {}",
                value(min),
                value(*most)
            )
        });
        over.into_iter().chain(under)
    });
    let broken: Vec<String> = broken.collect();
    match broken.is_empty() {
        true => {
            let all: Vec<&str> = minimise.subject_to.keys().map(String::as_str).collect();
            format!("kept all bounds at once, those on {}", all.join(", "))
        }
        false => format!("kept {}", broken.join("; ")),
    }
}

fn least(minimise: &Minimise, at_minimum: &MinimumAt) -> String {
    let MinimumAt {
        quantity,
        values,
        run,
        subject_to,
        minimum,
        ..
    } = at_minimum;
    let (Some(value), Some(run)) = (minimum.value, run) else {
        return format!(
            "No minimum of {} was found: none of {} points {}.",
            named(quantity),
            minimum.trials,
            kept_none(minimise, &minimum.bounded)
        );
    };
    let bests = minimum.by_start.iter().flatten();
    let near = bests.filter(|best| (*best - value).abs() <= 0.01 * value.abs());
    let kept: Vec<String> = (subject_to.iter())
        .map(|(quantity, value)| format!("{} {}", named(quantity), value_of(quantity, *value)))
        .collect();
    let kept = (!kept.is_empty()).then(|| format!(", with {}", kept.join(", ")));
    let mut text = format!(
        "{} is least, {}, at {} (run {run}); {} of {} searches came within 1 % of it, in {} points.",
        capital(&named(quantity)),
        value_of(quantity, value),
        at(values) + &kept.unwrap_or_default(),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The least is 1, at the first of three values of an axis: at its end, unless the middle one
    /// reaches it too.
    #[test]
    fn a_least_that_is_reached_between_the_ends_too_does_not_lie_at_an_end() {
        let is_at_end = |inner: f64, outer: f64| {
            let level = |value: f64, least: f64| serde_json::json!({ "value": value, "mean": 2.0, "least": least });
            let range = serde_json::json!({
                "quantity": "travelled_m", "scenario": "a.toml", "runs": 3, "mean": 2.0,
                "least": { "value": 1.0, "run": 0, "values": { "a.first": 0.1 } },
                "largest": { "value": 3.0, "run": 8, "values": { "a.first": 0.3 } },
                "axes": [{ "key": "a.first", "levels": [level(0.1, 1.0), level(0.2, inner), level(0.3, outer)] }],
            });
            let range: RangeOf = serde_json::from_value(range).unwrap();
            is_at_an_end_alone(&range.quantity, &range.least, &range.axes[0], |level| {
                level.least
            })
        };
        assert!(is_at_end(1.2, 1.4));
        // At both ends.
        assert!(is_at_end(1.2, 1.0));
        assert!(!is_at_end(1.0, 1.0));
        // Rounding.
        assert!(!is_at_end(1.0 + 1e-12, 1.4));
    }

    /// A share between 20 and 60 % has a number; one between 20 and 90 % may be most or little.
    #[test]
    fn a_share_that_is_hardly_known_is_an_order_alone() {
        let shipped = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../../assets/studies/friction_path_loss.toml"
        );
        let study = Study::load(shipped).unwrap();
        let said = |high: f64| {
            let known = |value: f64, high: f64| serde_json::json!({ "value": value, "low": 0.2, "high": high });
            let one = serde_json::json!({
                "quantity": "travelled_m", "scenario": "a.toml", "base_points": 8, "mean": 2.0, "deviation": 0.1,
                "axes": [
                    { "key": "a.less", "first": known(0.2, 0.3), "total": known(0.3, 0.4) },
                    { "key": "a.most", "first": known(0.4, high), "total": known(0.5, high) },
                ],
            });
            shares(&serde_json::from_value(one).unwrap(), &study).unwrap()
        };
        assert!(
            said(0.6)
                .ends_with("a.most causes 50 % of that variance (20 to 60, 95 %), 40 % by itself."),
            "{}",
            said(0.6)
        );
        assert!(
            said(0.9).ends_with(
                "a.most seems to cause more of it than any other; more points would tell how much."
            ),
            "{}",
            said(0.9)
        );
    }

    /// From a hundredth of the larger of both ends on, also below zero.
    #[test]
    fn a_quantity_changes_by_more_than_a_hundredth() {
        let changes_from = |least: f64, largest: f64| {
            let end = |value: f64| serde_json::json!({ "value": value, "run": 0, "values": {} });
            changes(
                &serde_json::from_value(serde_json::json!({
                    "quantity": "end_x_m", "scenario": "a.toml", "runs": 2, "mean": 1.0,
                    "least": end(least), "largest": end(largest), "axes": [],
                }))
                .unwrap(),
            )
        };
        assert!(changes_from(1.0, 1.02) && changes_from(-1.02, -1.0));
        assert!(!changes_from(1.0, 1.009) && !changes_from(-1.009, -1.0));
        assert!(changes_from(-0.001, 0.001) && !changes_from(0.0, 0.0));
    }

    /// The error falls from 4 to 1 mm over the axis, the energy rises from 1 to 5 J: at 2 they are
    /// (2 - 1)/3 and (2 - 1)/4 above the least, at the ends 1; what falls with both is best at 3.
    #[test]
    fn costs_that_pull_apart_are_a_trade_off_and_others_have_a_best_value() {
        let with_gaps = |quantity: &str, means: &[Option<f64>]| -> RangeOf {
            let levels: Vec<_> = [1.0, 2.0, 3.0, 4.0]
                .iter()
                .zip(means)
                .map(|(value, mean)| serde_json::json!({ "value": value, "mean": mean }))
                .collect();
            let end = serde_json::json!({ "value": 1.0, "run": 0, "values": {} });
            serde_json::from_value(serde_json::json!({
                "quantity": quantity, "scenario": "a.toml", "runs": 3, "mean": 2.0,
                "least": end, "largest": end, "axes": [{ "key": "a.gain", "levels": levels }],
            }))
            .unwrap()
        };
        let shipped = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../../assets/studies/friction_path_loss.toml"
        );
        let study = Study::load(shipped).unwrap();
        let range = |quantity: &str, means: [f64; 3]| with_gaps(quantity, &means.map(Some));
        let error = range("position_error_rms_m", [4e-3, 2e-3, 1e-3]);
        let energy = range("slip_energy_j", [1.0, 2.0, 5.0]);
        let apart = |ranges: &[RangeOf]| trade_offs(ranges, &study).next()?.apart;
        let said = |ranges: &[RangeOf]| -> Vec<(f64, String)> {
            let trades = trade_offs(ranges, &study);
            trades.map(|trade| (trade.best, trade.text)).collect()
        };
        let words = "No gain is best for everything. Gain 2 is the compromise: rms position error 2 mm (least: 1 mm at 3); energy lost to sliding 2 J \
                     (least: 1 J at 1).";
        let both = [error.clone(), energy];
        assert_eq!(said(&both), [(2.0, words.to_owned())]);
        let names = ["position_error_rms_m", "slip_energy_j"].map(str::to_owned);
        assert_eq!(apart(&both), Some(names));
        // A level at which a run failed is left out: three others have the same trade-off.
        let failed = [
            with_gaps(
                "position_error_rms_m",
                &[Some(4e-3), Some(2e-3), Some(1e-3), None],
            ),
            with_gaps(
                "slip_energy_j",
                &[Some(1.0), Some(2.0), Some(5.0), Some(9.0)],
            ),
        ];
        assert_eq!(said(&failed), [(2.0, words.to_owned())]);
        // Rounding, and work that is given back, pull nowhere.
        let rounding = range("slip_energy_j", [3e-8, 1e-8, 2e-8]);
        let given_back = range("energy.motor_j", [-1.0, -3.0, -2.0]);
        assert_eq!(said(&[rounding, given_back]), []);
        // What varies by less than a tenth pulls nowhere.
        let steady = range("slip_energy_j", [1.0, 1.0, 1.05]);
        let words = "Best is gain 3: rms position error 1 mm, the least.";
        let one = [error, steady];
        assert_eq!(
            (said(&one), apart(&one)),
            (vec![(3.0, words.to_owned())], None)
        );
    }

    /// Where several keys vary, the figures at a value of one are means over the others.
    #[test]
    fn a_compromise_names_the_keys_over_which_it_is_a_mean() {
        let level = |value: f64, mean: f64| serde_json::json!({ "value": value, "mean": mean });
        let end = serde_json::json!({ "value": 1.0, "run": 0, "values": {} });
        let range: RangeOf = serde_json::from_value(serde_json::json!({
            "quantity": "position_error_rms_m", "scenario": "a.toml", "runs": 9, "mean": 2.0,
            "least": end, "largest": end, "axes": [
                { "key": "a.gain", "levels": [level(1.0, 4e-3), level(2.0, 2e-3), level(3.0, 1e-3)] },
                { "key": "b.bandwidth_per_s", "levels": [level(1.0, 2e-3), level(2.0, 2e-3)] },
            ],
        }))
        .unwrap();
        let shipped = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../../assets/studies/friction_path_loss.toml"
        );
        let study = Study::load(shipped).unwrap();
        let said = trade_offs(&[range], &study).next().unwrap().text;
        assert_eq!(
            said,
            "Best is gain 3 (means over bandwidth): rms position error 1 mm, the least."
        );
    }

    #[test]
    fn no_minimum_says_which_bound_no_point_kept_and_how_near_one_came() {
        let minimise: Minimise = serde_json::from_value(serde_json::json!({
            "quantity": "slip_energy_j",
            "subject_to": { "travelled_m": { "min": 2 }, "wheel_torque_max_n_m": { "max": 1.2 } },
        }))
        .unwrap();
        let said = |bounded: &[[f64; 2]]| {
            let found = serde_json::json!({
                "quantity": "slip_energy_j", "values": {}, "run": null, "trial": null, "value": null,
                "place": [], "by_start": [null], "trials": 16, "bounded": bounded,
            });
            least(&minimise, &serde_json::from_value(found).unwrap())
        };
        let start = "No minimum of energy lost to sliding was found: none of 16 points ";
        let of_torque = "kept wheel_torque_max_n_m <= 1.2 N m: the least was 1.5 N m.";
        assert_eq!(
            said(&[[1.0, 3.0], [1.5, 1.5]]),
            format!("{start}{of_torque}")
        );
        let of_way = said(&[[0.5, 1.0], [1.0, 1.5]]);
        assert!(
            of_way.ends_with("kept travelled_m >= 2 m: the most was 1 m."),
            "{of_way}"
        );
        // Each bound is kept somewhere.
        assert!(said(&[[1.0, 3.0], [1.0, 1.5]]).contains("kept all bounds at once"));
        assert_eq!(said(&[]), format!("{start}could be run."));
    }

    #[test]
    fn a_minimum_says_how_many_searches_agree_and_whether_it_lies_at_an_end() {
        let minimise: Minimise =
            serde_json::from_value(serde_json::json!({ "quantity": "travelled_m" })).unwrap();
        let said = |place: [f64; 2]| {
            // The errors of the searches are zero, half a percent and 5 %; one found nothing.
            let found = serde_json::json!({
                "quantity": "travelled_m", "values": { "a.first": 0.5, "b.second": 0.5 }, "run": 7,
                "trial": 7, "value": 2.0, "place": place, "by_start": [2.0, 2.01, 2.1, null], "trials": 40,
            });
            least(&minimise, &serde_json::from_value(found).unwrap())
        };
        let inside = said([0.5, 0.5]);
        assert!(inside.contains("2 of 4 searches came within 1 % of it, in 40 points."));
        assert!(!inside.contains("at the end"), "{inside}");
        assert!(said([0.0, 0.5]).contains("at the end of a.first: "));
        assert!(said([0.5, 1.0]).contains("at the end of b.second: "));
        assert!(said([1.0, 0.0]).contains("at the end of a.first, b.second: "));
    }
}
