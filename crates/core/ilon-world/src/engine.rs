//! The interface to rapier and parry: shapes, collision groups, number types.

pub(crate) mod convert;
pub(crate) mod groups;
pub(crate) mod shapes;
