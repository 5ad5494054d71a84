//! What there is in a world, by its identity.

use crate::FreeBodyId;

/// Which body of its world: a robot keeps its identity as long as the world exists, and in the world's copies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BodyId(pub(crate) usize);

/// What of a world is seen at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum WorldObject {
    /// The ground and what stands on it for good.
    Ground,
    /// A robot: its chassis, a body on a joint, or a wheel, as a cylinder of its radius.
    Robot(BodyId),
    /// A free body.
    Free(FreeBodyId),
}
