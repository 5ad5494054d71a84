//! Parts of sentences.

use crate::text::time;

/// A time in a run that ends at some time, with rows of some length, as the beginning of a sentence's rest.
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

/// Things one after the other: a, b and c.
pub(super) fn list(things: &[String]) -> String {
    match things {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
