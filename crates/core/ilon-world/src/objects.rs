//! Identities of the objects in a world.

use crate::FreeBodyId;

/// The identity of a robot in its world and the world's copies; it never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BodyId(pub(crate) usize);

/// The object at a place in a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum WorldObject {
    /// The ground and its fixed obstacles.
    Ground,
    /// A robot: its chassis, a body on a joint, or a wheel, as a cylinder of its radius.
    Robot(BodyId),
    /// A free body.
    Free(FreeBodyId),
}
