//! Contact: where rollers and chassis are near the ground, and the impulses that follow.

pub(crate) mod frame;
pub(crate) mod law;
pub(crate) mod linear;
pub(crate) mod reactions;
pub(crate) mod scene;
pub(crate) mod search;
