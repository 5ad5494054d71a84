//! Contact: where rollers and chassis are near the ground, and the impulses that follow.

pub(crate) mod barrel_shape;
pub(crate) mod candidates;
pub(crate) mod dispatcher;
pub(crate) mod jump;
pub(crate) mod nearest;
pub(crate) mod problem;
pub(crate) mod reaction;
pub(crate) mod readout;
pub(crate) mod solve;
