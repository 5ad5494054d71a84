//! Converts the floor of a scenario for the world and the trace: surfaces of material pairs,
//! patches, boxes, ramps and heights.

pub mod floor;
pub(crate) mod roughness;
pub(crate) mod surface;
