//! Limits that were reached.

/// The limit that was reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spent {
    /// Too many steps: its macros or values do not end, or grow without bound.
    Steps,
    /// Nested too deep.
    Depth,
}

impl std::fmt::Display for Spent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Steps => {
                "its macros and expressions take more than four million steps: they do not come to an end, or make more than a \
                 robot needs"
            }
            Self::Depth => {
                "its macros, properties and expressions nest thousands of levels deep: they do not come to an end"
            }
        })
    }
}
