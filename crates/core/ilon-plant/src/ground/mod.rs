//! The floor that a scenario describes, as the world and as the trace have it: surfaces of pairs of materials, patches, boxes, ramps and heights.

pub mod floor;
pub(crate) mod roughness;
pub(crate) mod surface;
pub(crate) mod timed_patch;
