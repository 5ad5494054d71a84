//! How a command ended.

/// How a command that found no fault ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Done.
    Done,
    /// An expectation did not hold.
    Unexpected,
    /// There was no expectation to hold.
    NothingChecked,
    /// Part of the input was bad, which has been shown.
    BadInput,
}
