//! In which figures runs differ most, and that in a sentence a run.

use ilon_trace::Quantity;
use ilon_trace::quantities::GROUPS;

use super::Comparison;
use crate::page::escape;

/// Figures that differ by less than this, as a logarithm of their ratio, are the same to who reads them: 1 %.
const SAME: f64 = 0.01;

/// The figures of a sentence.
const IN_A_SENTENCE: usize = 3;

/// A figure with a heading above it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Named {
    /// The heading that it stands under.
    pub heading: &'static str,
    /// The figure.
    pub quantity: &'static Quantity,
}

/// The figures in which the runs differ from the first, those that differ most in front; at most so many.
pub(super) fn most_different(comparison: &Comparison, most: usize) -> Vec<Named> {
    let others = 1..comparison.runs.len();
    let weight = |named: &Named| {
        let weights = others
            .clone()
            .map(|run| weight(comparison, named.quantity, run));
        weights.fold(0.0, f64::max)
    };
    ranked(comparison, weight, most)
}

fn ranked(comparison: &Comparison, weight: impl Fn(&Named) -> f64, most: usize) -> Vec<Named> {
    let open_loop = comparison.runs.iter().all(|run| run.trace.header.open_loop);
    let groups = GROUPS.iter().filter(|group| {
        // How a run was made is no outcome of it.
        group.heading != "run" && (open_loop || !group.open_loop_only)
    });
    let named = groups.flat_map(|group| {
        group
            .quantities
            .iter()
            .filter(|q| q.is_main)
            .map(|quantity| Named {
                heading: group.heading,
                quantity,
            })
    });
    let mut weighed: Vec<(f64, Named)> = named
        .map(|named| (weight(&named), named))
        .filter(|(weight, _)| *weight > SAME)
        .collect();
    weighed.sort_by(|a, b| b.0.total_cmp(&a.0));
    weighed
        .into_iter()
        .take(most)
        .map(|(_, named)| named)
        .collect()
}

/// How much a figure of a run differs from that of the first: the logarithm of their ratio, of magnitudes below what is shown of
/// them none.
fn weight(comparison: &Comparison, quantity: &Quantity, run: usize) -> f64 {
    let shown = |run: usize| quantity.shown(&comparison.runs[run].summary);
    let (Some(first), Some(other)) = (shown(0), shown(run)) else {
        return 0.0;
    };
    // Ten steps of the last digit that is shown: below, nobody compares.
    let least = 10.0 * 10f64.powi(-(quantity.decimals as i32));
    let size = |x: f64| x.abs().max(least);
    if first.signum() != other.signum() && first.abs().max(other.abs()) > least {
        return 1.0 + ((first - other).abs() / least).ln().max(0.0);
    }
    (size(other) / size(first)).ln().abs()
}

/// What came of each run beside the first, in a sentence each, as HTML.
pub(super) fn sentences(comparison: &Comparison) -> String {
    let Some((first, others)) = comparison.runs.split_first() else {
        return String::new();
    };
    let sentence = |(index, name): (usize, &str)| {
        let top = ranked(
            comparison,
            |named| weight(comparison, named.quantity, index + 1),
            IN_A_SENTENCE,
        );
        let what: Vec<String> = top
            .iter()
            .map(|named| {
                let Named { heading, quantity } = named;
                let value = |run: usize| {
                    let shown = quantity.shown(&comparison.runs[run].summary);
                    shown.map_or_else(|| "–".to_owned(), |x| format!("{x:.*}", quantity.decimals))
                };
                format!(
                    "{} <b>{} {}</b> instead of {} ({})",
                    escape(quantity.label),
                    value(index + 1),
                    escape(quantity.unit.symbol),
                    value(0),
                    escape(heading)
                )
            })
            .collect();
        let name = escape(name);
        let first = escape(&first.name);
        if what.is_empty() {
            format!(
                "<p><b>{name}</b> came to the same as {first}: no main figure differs by more than 1 %.</p>"
            )
        } else {
            format!("<p><b>{name}</b>, beside {first}: {}.</p>", what.join("; "))
        }
    };
    others
        .iter()
        .map(|run| run.name.as_str())
        .enumerate()
        .map(sentence)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::ComparedRun;
    use crate::sample::made_up_run;
    use ilon_trace::{Settings, Summary};

    fn comparison(change: impl Fn(&mut Summary)) -> Comparison {
        let run = |name: &str| {
            let trace = made_up_run(2.0, false);
            let summary = Summary::of(&trace, &Settings::default());
            ComparedRun::new(name.to_owned(), trace, summary)
        };
        let mut runs = vec![run("one"), run("two")];
        runs[1].trace.header.scenario_name = "two".to_owned();
        change(&mut runs[1].summary);
        Comparison::of(runs, &["one".into(), "two".into()]).expect("two runs")
    }

    #[test]
    fn what_differs_most_stands_first_and_noise_nowhere() {
        let compared = comparison(|summary| {
            summary.position_error_max_m =
                Some(1.0 + 10.0 * summary.position_error_max_m.unwrap_or(0.0));
            summary.travelled_m *= 1.001;
        });
        let top = most_different(&compared, 5);
        assert_eq!(top[0].quantity.key, "position_error_max_m");
        assert!(top.iter().all(|named| named.quantity.key != "travelled_m"));
        let said = sentences(&compared);
        assert!(said.contains("instead of"), "{said}");
    }

    #[test]
    fn runs_that_came_to_the_same_are_said_to() {
        let compared = comparison(|_| {});
        assert!(most_different(&compared, 5).is_empty());
        assert!(sentences(&compared).contains("came to the same"));
    }
}
