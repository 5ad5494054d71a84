//! Compares a run with the scenario's `[expect]`, and with a baseline.

mod signals;
mod verdict;

pub use signals::check_names;
pub use verdict::Verdict;
use verdict::readable;

pub use ilon_trace::{Difference, differences};
use ilon_trace::{Rows, Summary, quantities};

use crate::Run;
use crate::scenario::{Bound, Expect};

/// Compares a run with its own `[expect]`: first the quantities of the summary by name, then the
/// signals in the order of the file.
pub fn judge(run: &Run) -> Vec<Verdict> {
    let Ok(verdicts) = judge_rows(run);
    verdicts
}

/// Like [`judge`], for a run whose rows need not be in memory.
///
/// # Errors
/// If the rows cannot be read.
pub fn judge_rows<R: Rows>(run: &Run<R>) -> Result<Vec<Verdict>, R::Error> {
    let expect = &run.scenario.expect;
    let mut verdicts = judge_summary(expect, &run.summary);
    verdicts.extend(signals::judge(&expect.signals, &run.trace)?);
    Ok(verdicts)
}

/// Compares the figures of a run with bounds, in alphabetical order.
fn judge_summary(expect: &Expect, summary: &Summary) -> Vec<Verdict> {
    let bounds = expect.bounds.iter();
    bounds
        .map(|(key, bound)| verdict(key, Some(bound), bound.to_string(), summary))
        .collect()
}

/// Compares the figures of a run with those of its baseline, by the changes that are allowed.
pub fn judge_changes(expect: &Expect, summary: &Summary, baseline: &Summary) -> Vec<Verdict> {
    let of = |(key, change): (&String, &String)| {
        let before = quantities::by_key(key).and_then(|quantity| quantity.value(baseline));
        let bound = before.and_then(|before| Bound::of_change(change, before));
        let words = match before {
            Some(before) => format!("within {change} of {}", readable(before, "")),
            None => format!("within {change} of its baseline, which does not have it"),
        };
        verdict(key, bound.as_ref(), words, summary)
    };
    expect.changes.iter().map(of).collect()
}

/// Without a bound no value holds.
fn verdict(key: &str, bound: Option<&Bound>, words: String, summary: &Summary) -> Verdict {
    let measured = quantities::by_key(key).and_then(|quantity| quantity.value(summary));
    Verdict {
        quantity: key.to_owned(),
        bound: words,
        measured,
        at_s: None,
        share_beyond: bound
            .zip(measured)
            .and_then(|(bound, measured)| bound.share_beyond(measured)),
        held: (bound.zip(measured)).is_some_and(|(bound, measured)| bound.holds(measured)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tenth more than 2 J is 2.2 J.
    #[test]
    fn a_change_is_judged_against_the_baseline() {
        let expect: Expect = toml::from_str("slip_energy_j = \"+10 %\"").unwrap();
        let with = |slip_energy_j| {
            let mut summary = Summary::default();
            summary.slip_energy_j = slip_energy_j;
            summary
        };
        let verdict = |now: Option<f64>, before: Option<f64>| {
            judge_changes(&expect, &with(now), &with(before)).remove(0)
        };
        assert!(verdict(Some(2.19), Some(2.0)).held && verdict(Some(1.0), Some(2.0)).held);
        let failed = verdict(Some(2.42), Some(2.0));
        assert_eq!(
            failed.to_string(),
            "slip_energy_j within +10 % of 2 failed: measured 2.42 J (10.00 % beyond)"
        );
        assert!(!verdict(Some(1.0), None).held && !verdict(None, Some(1.0)).held);
    }

    #[test]
    fn a_quantity_that_does_not_apply_fails_its_bound() {
        let expect: Expect = toml::from_str("position_error_final_m = { max = 0.01 }").unwrap();
        let verdicts = judge_summary(&expect, &Summary::default());
        assert!(!verdicts[0].held);
        assert_eq!(
            verdicts[0].to_string(),
            "position_error_final_m <= 0.01 failed: it does not apply to this run: there is no path to follow; give the scenario a `[reference]`"
        );
    }
}
