//! How a command ends.

/// How a command without errors ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Success.
    Done,
    /// An expectation failed.
    Unexpected,
    /// Nothing was expected.
    NothingChecked,
    /// Part of the input was bad, which has been reported.
    BadInput,
}
