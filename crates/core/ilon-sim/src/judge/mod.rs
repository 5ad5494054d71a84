//! Compares a run with the scenario's `[expect]`, and with a baseline.

mod signals;
mod verdict;

pub use signals::check_names;
pub use verdict::Verdict;
use verdict::readable;

pub use ilon_trace::{Difference, differences};
use ilon_trace::{Header, Rows, Summary, number, quantities, significant};

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

/// Compares the figures of a run with those of its baseline, whose header is `header`, by the
/// changes that are allowed. Within the accuracy of a figure, or ten of its last digit, nothing has
/// changed.
pub fn judge_changes(
    expect: &Expect,
    summary: &Summary,
    (baseline, header): (&Summary, &Header),
) -> Vec<Verdict> {
    let of = |(key, change): (&String, &String)| {
        let quantity = quantities::by_key(key);
        let before = quantity.and_then(|quantity| Some((quantity, quantity.value(baseline)?)));
        let Some((quantity, before)) = before else {
            let words = format!("within {change} of its baseline, which does not have it");
            return verdict(key, None, words, summary);
        };
        let known = quantities::known_to(quantity, before, baseline, header);
        let least = known.max(quantities::least_change(quantity));
        let bound = Bound::of_change(change, before, least);
        let wider = bound != Bound::of_change(change, before, 0.0);
        let or = match wider {
            true => format!(
                " (or {}, too little to count)",
                number(significant(least, 2))
            ),
            false => String::new(),
        };
        let words = format!("within {change}{or} of {}", readable(before, ""));
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
        is_outside: false,
        is_short: (bound.zip(measured)).is_some_and(|(bound, measured)| bound.is_above(measured)),
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
            let baseline = (&with(before), &Header::default());
            judge_changes(&expect, &with(now), baseline).remove(0)
        };
        assert!(verdict(Some(2.19), Some(2.0)).held && verdict(Some(1.0), Some(2.0)).held);
        let failed = verdict(Some(2.42), Some(2.0));
        assert_eq!(
            failed.to_string(),
            "slip_energy_j within +10 % of 2 failed: measured 2.42 J (10.00 % beyond)"
        );
        assert!(!verdict(Some(1.0), None).held && !verdict(None, Some(1.0)).held);
        // Of energies four decimals are shown, and less than ten of the last is no change.
        assert!(verdict(Some(9e-4), Some(2e-5)).held);
        let failed = verdict(Some(2e-3), Some(2e-5)).to_string();
        let words = "slip_energy_j within +10 % (or 0.001, too little to count) of 2e-5 failed: measured 0.002 J";
        assert!(failed.starts_with(words), "{failed}");
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
