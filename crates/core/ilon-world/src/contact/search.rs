//! The search for places where bodies are near the ground and one another, and may touch in a step.

pub(crate) mod ball_and_cylinder;
pub(crate) mod bounds;
pub(crate) mod candidate;
pub(crate) mod free_bodies;
pub(crate) mod handover;
pub(crate) mod nearest;
pub(crate) mod on_ground;
pub(crate) mod solid;
mod straight_sides;
pub(crate) mod thinning;
pub(crate) mod turned_profile;
