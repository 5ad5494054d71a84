//! Limits that were reached.

/// The limit that was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Spent {
    /// Too many steps: its macros or values do not end, or grow without bound.
    #[error(
        "its macros and expressions take more than four million steps: they do not come to an end, or make more than a robot needs"
    )]
    Steps,
    /// Nested too deep.
    #[error(
        "its macros, properties and expressions nest thousands of levels deep: they do not come to an end"
    )]
    Depth,
}
