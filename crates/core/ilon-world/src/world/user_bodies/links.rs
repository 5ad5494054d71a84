//! ilon's bodies and the ground as colliders of rapier's world.

use rapier3d::prelude::*;

use super::rapier_world::UserBodies;
use crate::WorldObject;
use crate::engine::convert;
use crate::world::World;

impl World {
    /// Updates the pose of every shape of ilon's bodies; new ones are inserted, and vanished ones
    /// removed.
    pub(super) fn place_links(&self, rapier: &mut UserBodies) {
        let UserBodies {
            world,
            links,
            objects,
            ..
        } = rapier;
        let mut before = std::mem::take(links);
        let mut shapes_of = std::collections::BTreeMap::<WorldObject, usize>::new();
        self.each_part(|object, part| {
            let counted = shapes_of.entry(object).or_default();
            let key = (object, *counted);
            *counted += 1;
            let pose = convert::pose(&part.floor_from_shape);
            // The program may have removed it.
            let stands = before
                .remove(&key)
                .filter(|handle| world.colliders.contains(*handle));
            let handle = stands.unwrap_or_else(|| {
                let handle = world
                    .colliders
                    .insert(collider(object, part.shape.clone(), pose));
                objects.insert(handle.into_raw_parts(), object);
                handle
            });
            if let Some(collider) = world.colliders.get(handle)
                && *collider.position() != pose
                && let Some(collider) = world.colliders.get_mut(handle)
            {
                collider.set_position(pose);
            }
            links.insert(key, handle);
        });
        for handle in before.into_values() {
            objects.remove(&handle.into_raw_parts());
            world.remove_collider(handle);
        }
    }
}

fn collider(object: WorldObject, shape: SharedShape, pose: Pose) -> ColliderBuilder {
    let collider = ColliderBuilder::new(shape).position(pose);
    if object == WorldObject::Ground {
        collider.active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS)
    } else {
        // rapier finds their contacts, but ilon solves them.
        collider.solver_groups(InteractionGroups::none())
    }
}
