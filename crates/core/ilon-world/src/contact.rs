//! Contact: the search for places where rollers and bodies may touch, and the impulses there.

pub(crate) mod frame;
pub(crate) mod law;
pub(crate) mod linear;
pub(crate) mod reactions;
pub(crate) mod scene;
pub(crate) mod search;
