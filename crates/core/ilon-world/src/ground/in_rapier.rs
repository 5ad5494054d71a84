//! The ground in a rapier world.

use rapier3d::pipeline::{ContactModificationContext, PhysicsHooks};
use rapier3d::prelude::*;

use super::Ground;
use crate::engine::{convert, groups};

/// Inserts the ground into a rapier world, whose frame is the floor's.
pub(crate) fn insert_into(ground: &Ground, colliders: &mut ColliderSet) {
    let mut insert = |shape: &SharedShape, pose: Pose| {
        colliders.insert(
            ColliderBuilder::new(shape.clone())
                .position(pose)
                .collision_groups(groups::GROUND),
        );
    };
    if ground.has_plane {
        insert(&SharedShape::halfspace(Vector::Z), Pose::IDENTITY);
    }
    for solid in &ground.solids {
        insert(&solid.shape, convert::pose(&solid.floor_from_solid));
    }
}

/// Answers rapier's queries if it solves contacts itself: the friction of the ground at a contact.
pub(crate) struct Grip<'a> {
    pub ground: &'a Ground,
}

impl PhysicsHooks for Grip<'_> {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let ground_first = context.rigid_body1.is_none();
        let ground = if ground_first {
            context.collider1
        } else {
            context.collider2
        };
        let Some(ground) = context.colliders.get(ground) else {
            return;
        };
        let rapier_from_ground = *ground.position();
        let Some(contact) = context.rigid_mut() else {
            return;
        };
        if let Some(point) = contact.manifold.points.first() {
            let on_ground = if ground_first {
                point.local_p1
            } else {
                point.local_p2
            };
            let place_m = convert::to_vector(rapier_from_ground * on_ground);
            *contact.friction = self.ground.footing_at(&place_m, None).friction;
        }
    }
}
