//! The seam to rapier and parry: shapes, collision groups, numbers.

pub(crate) mod convert;
pub(crate) mod groups;
pub(crate) mod shapes;
