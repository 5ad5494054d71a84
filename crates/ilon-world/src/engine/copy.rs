//! rapier's world as something that can be copied.

use std::ops::{Deref, DerefMut};

use rapier3d::prelude::*;

/// rapier's world. A copy goes on to the bit as the original does: all that lasts from one step to the next is copied, and
/// only the pipelines, which are room to work in, are made anew.
pub(crate) struct Engine(pub PhysicsWorld);

impl Clone for Engine {
    fn clone(&self) -> Self {
        // Taken apart whole, so that what rapier adds to it is not forgotten here.
        let PhysicsWorld {
            gravity,
            integration_parameters,
            physics_pipeline: _,
            collision_pipeline: _,
            islands,
            broad_phase,
            narrow_phase,
            bodies,
            colliders,
            impulse_joints,
            multibody_joints,
            soft_bodies,
            ccd_solver,
        } = &self.0;
        Self(PhysicsWorld {
            gravity: *gravity,
            integration_parameters: *integration_parameters,
            physics_pipeline: PhysicsPipeline::new(),
            collision_pipeline: CollisionPipeline::new(),
            islands: islands.clone(),
            broad_phase: broad_phase.clone(),
            narrow_phase: narrow_phase.clone(),
            bodies: bodies.clone(),
            colliders: colliders.clone(),
            impulse_joints: impulse_joints.clone(),
            multibody_joints: multibody_joints.clone(),
            soft_bodies: soft_bodies.clone(),
            ccd_solver: ccd_solver.clone(),
        })
    }
}

impl Deref for Engine {
    type Target = PhysicsWorld;

    fn deref(&self) -> &PhysicsWorld {
        &self.0
    }
}

impl DerefMut for Engine {
    fn deref_mut(&mut self) -> &mut PhysicsWorld {
        &mut self.0
    }
}
