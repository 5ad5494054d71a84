//! Who may touch whom: the ground touches everything, the parts of a robot never each other.

use crate::ContactSolver;
use rapier3d::geometry::{Group, InteractionGroups, InteractionTestMode};

const fn groups(member: Group, filter: Group) -> InteractionGroups {
    InteractionGroups::new(member, filter, InteractionTestMode::And)
}

/// The ground and whatever else stands in the world.
pub(crate) const GROUND: InteractionGroups = groups(Group::GROUP_1, Group::ALL);
/// Whose contacts rapier solves: all of them in its own mode, else none.
pub(crate) fn solved(solver: ContactSolver) -> InteractionGroups {
    match solver {
        ContactSolver::Ilon => InteractionGroups::none(),
        ContactSolver::Rapier => InteractionGroups::all(),
    }
}

/// Rollers.
pub(crate) const ROLLER: InteractionGroups = groups(Group::GROUP_2, Group::GROUP_1);
/// Chassis.
pub(crate) const CHASSIS: InteractionGroups = groups(Group::GROUP_3, Group::GROUP_1);
