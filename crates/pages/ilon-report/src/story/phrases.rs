//! Parts of sentences.

use crate::text::time;

/// Returns a time in a run with a given end and row period, as the start of a phrase.
pub(super) fn span(from_s: f64, until_s: f64, end_s: f64, row_s: f64) -> String {
    let to_the_end = until_s >= end_s - 1.5 * row_s;
    if to_the_end && from_s <= 1.5 * row_s {
        "all through the run".to_owned()
    } else if to_the_end {
        format!("from {} to the end", time(from_s))
    } else {
        format!("from {from_s:.2} to {}", time(until_s))
    }
}

/// Joins items: a, b and c.
pub(super) fn list(things: &[String]) -> String {
    match things {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
