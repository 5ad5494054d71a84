//! Compares a run with the scenario's `[expect]`, and with a baseline.

mod signals;
mod verdict;

pub use signals::check_names;
pub use verdict::Verdict;

pub use ilon_trace::{Difference, differences};
use ilon_trace::{Rows, Summary, quantities};

use crate::Run;
use crate::scenario::Expect;

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
    expect
        .bounds
        .iter()
        .map(|(key, bound)| {
            let measured = quantities::by_key(key).and_then(|quantity| quantity.value(summary));
            Verdict {
                quantity: key.clone(),
                bound: bound.to_string(),
                measured,
                at_s: None,
                share_beyond: measured.and_then(|measured| bound.share_beyond(measured)),
                held: measured.is_some_and(|measured| bound.holds(measured)),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
