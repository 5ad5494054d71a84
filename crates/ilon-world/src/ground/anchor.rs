//! Where rapier counts from: for each articulated body a place near it.

use nalgebra::{Translation3, Vector3};
use rapier3d::pipeline::{ContactModificationContext, PhysicsHooks};
use rapier3d::prelude::*;

use super::Ground;
use crate::ContactSolver;
use crate::engine::{convert, groups};

/// The ground in the rapier world of one articulated body, and where that world counts from.
///
/// Its frame is the floor's, but it counts in f32 from near the body: contact points a few metres away would be rounded by as
/// much as a roller moves in a step. Bodies that are far apart count from different places.
#[derive(Clone, Debug)]
pub(crate) struct Anchor {
    /// rapier's origin in the floor's frame, in the plane, in metres.
    origin_m: Vector3<f64>,
    /// Of each solid of the ground in its order.
    solids: Vec<ColliderHandle>,
}

impl Anchor {
    /// Puts the ground into a rapier world that counts from the floor's origin.
    pub fn insert(ground: &Ground, colliders: &mut ColliderSet, solver: ContactSolver) -> Self {
        let mut insert = |shape: &SharedShape, pose: Pose| {
            colliders.insert(
                ColliderBuilder::new(shape.clone())
                    .position(pose)
                    .collision_groups(groups::GROUND)
                    .solver_groups(groups::solved(solver)),
            )
        };
        if ground.has_plane {
            insert(&SharedShape::halfspace(Vector::Z), Pose::IDENTITY);
        }
        let solids = ground.solids.iter();
        let solids =
            solids.map(|solid| insert(&solid.shape, convert::pose(&solid.floor_from_solid)));
        Self {
            solids: solids.collect(),
            origin_m: Vector3::zeros(),
        }
    }

    /// Moves the origin beneath a body once that has gone too far away from it, and the solids along with it.
    pub fn follow(&mut self, place_m: &Vector3<f64>, ground: &Ground, colliders: &mut ColliderSet) {
        /// Within this distance f32 resolves 1e-8 m, a hundredth of what a slow robot moves in a step.
        const LEASH_M: f64 = 0.1;
        let beneath_m = Vector3::new(place_m.x, place_m.y, 0.0);
        if (beneath_m - self.origin_m).norm() < LEASH_M {
            return;
        }
        self.origin_m = beneath_m;
        for (handle, solid) in self.solids.iter().zip(&ground.solids) {
            let in_rapier = Translation3::from(-beneath_m) * solid.floor_from_solid;
            if let Some(collider) = colliders.get_mut(*handle) {
                collider.set_position(convert::pose(&in_rapier));
            }
        }
    }

    /// rapier's origin in the floor's frame, in metres; the axes are the same.
    pub fn origin_m(&self) -> Vector3<f64> {
        self.origin_m
    }

    /// What takes places in the floor's frame to rapier's.
    pub fn rapier_from_floor(&self) -> Translation3<f64> {
        Translation3::from(-self.origin_m)
    }
}

/// What rapier asks where it solves contacts itself: how slippery the ground is where something touches it.
pub(crate) struct Grip<'a> {
    pub ground: &'a Ground,
    pub anchor: &'a Anchor,
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
            let place_m = self.anchor.origin_m + convert::to_f64(rapier_from_ground * on_ground);
            *contact.friction = self.ground.footing_at(&place_m, None).friction as Real;
        }
    }
}
