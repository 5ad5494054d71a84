//! Values of variables.

/// A value of a variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// `Float64`.
    Real(f64),
    /// `Int64`.
    Whole(i64),
    /// `Boolean`.
    Flag(bool),
}
