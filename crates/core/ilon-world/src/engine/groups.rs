//! Collision groups: the ground touches everything, parts of a robot never touch each other.

use rapier3d::geometry::{Group, InteractionGroups, InteractionTestMode};

const fn groups(member: Group, filter: Group) -> InteractionGroups {
    InteractionGroups::new(member, filter, InteractionTestMode::And)
}

/// The ground and everything else in the world.
pub(crate) const GROUND: InteractionGroups = groups(Group::GROUP_1, Group::ALL);
/// Rollers.
pub(crate) const ROLLER: InteractionGroups = groups(Group::GROUP_2, Group::GROUP_1);
/// Chassis.
pub(crate) const CHASSIS: InteractionGroups = groups(Group::GROUP_3, Group::GROUP_1);
