//! Contact: where rollers and chassis are near the ground, and the impulses that follow.

pub(crate) mod ball_and_cylinder;
pub(crate) mod bounds;
pub(crate) mod candidate;
pub(crate) mod candidate_search;
pub(crate) mod chassis_search;
pub(crate) mod frame;
pub(crate) mod free_body_search;
pub(crate) mod handover;
pub(crate) mod handover_impulse;
pub(crate) mod linear;
pub(crate) mod nearest;
pub(crate) mod potential;
pub(crate) mod problem;
pub(crate) mod reaction;
pub(crate) mod reactions;
pub(crate) mod response;
pub(crate) mod row;
pub(crate) mod scene;
pub(crate) mod solid;
pub(crate) mod support;
pub(crate) mod thinning;
pub(crate) mod tread;
pub(crate) mod turned_profile;
pub(crate) mod wheel_contact;
