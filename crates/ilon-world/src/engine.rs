//! The seam to rapier and parry: shapes, collision groups, numbers.

pub(crate) mod barrel_shape;
pub(crate) mod convert;
pub(crate) mod copy;
pub(crate) mod dispatcher;
pub(crate) mod groups;
pub(crate) mod shapes;
