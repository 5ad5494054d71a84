//! rapier's world with the user bodies, and the data that last from step to step.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rapier3d::prelude::*;

use crate::contact::reactions::reaction::Reaction;
use crate::free::{RawHandle, UserBody};
use crate::{FreeBodyId, WorldObject};

/// rapier's world with the user bodies, and with ilon's shapes as colliders among them.
pub(in crate::world) struct UserBodies {
    pub(super) world: PhysicsWorld,
    /// Each shape of each of ilon's objects, numbered.
    pub(super) links: BTreeMap<(WorldObject, usize), ColliderHandle>,
    /// The object of each of these colliders.
    pub(super) objects: BTreeMap<RawHandle, WorldObject>,
    /// For each body coupled to the last step, or to this one.
    pub(super) exchanges: BTreeMap<RawHandle, Exchange>,
    /// The contacts of coupled bodies in the last step, and in this one so far.
    pub(super) contacts: Vec<CoupledContact>,
    pub(super) contacts_now: Vec<CoupledContact>,
    /// Whether the program may have changed something since the last step.
    pub(super) is_changed: bool,
}

impl UserBodies {
    /// An empty world.
    pub(super) fn new() -> Self {
        Self {
            world: PhysicsWorld::new(),
            links: BTreeMap::new(),
            objects: BTreeMap::new(),
            exchanges: BTreeMap::new(),
            contacts: Vec::new(),
            contacts_now: Vec::new(),
            is_changed: true,
        }
    }
}

/// The exchange between a coupled body and ilon's step; velocities in m/s and rad/s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Exchange {
    /// Impulse of its contacts with ilon's bodies in the step, in N s, and its moment about its
    /// centre of mass.
    pub(super) impulse: Spatial,
    /// The part of it that acts over the step: it balances rapier's own forces.
    pub(super) over_step: Spatial,
    /// Its expected velocities after the step.
    pub(super) expected: Spatial,
    /// The additional velocity change by joints in the last step, and its predicted part.
    pub(super) missed: Spatial,
    pub(super) foreseen: Spatial,
    /// Whether it is coupled to this step.
    pub(super) is_coupled: bool,
}

/// A spatial vector in the world's axes: the linear part, of the centre of mass, and the angular
/// one.
pub(super) type Spatial = [Vector3<f64>; 2];

impl Clone for UserBodies {
    fn clone(&self) -> Self {
        // Data that last from step to step are copied; the pipelines and the solver of fast bodies
        // have only work space.
        let world = &self.world;
        Self {
            world: PhysicsWorld {
                gravity: world.gravity,
                integration_parameters: world.integration_parameters,
                physics_pipeline: PhysicsPipeline::new(),
                collision_pipeline: CollisionPipeline::new(),
                islands: world.islands.clone(),
                broad_phase: world.broad_phase.clone(),
                narrow_phase: world.narrow_phase.clone(),
                bodies: world.bodies.clone(),
                colliders: world.colliders.clone(),
                impulse_joints: world.impulse_joints.clone(),
                multibody_joints: world.multibody_joints.clone(),
                soft_bodies: world.soft_bodies.clone(),
                ccd_solver: world.ccd_solver.clone(),
            },
            links: self.links.clone(),
            objects: self.objects.clone(),
            exchanges: self.exchanges.clone(),
            contacts: self.contacts.clone(),
            contacts_now: self.contacts_now.clone(),
            is_changed: self.is_changed,
        }
    }
}

/// A contact of a coupled body: between A and B, or between A and a fixed one.
#[derive(Clone)]
pub(super) struct CoupledContact {
    pub(super) a: BodyKey,
    pub(super) b: Option<BodyKey>,
    pub(super) reaction: Reaction,
}

/// The identity of a body from step to step.
#[derive(Clone, Copy)]
pub(super) enum BodyKey {
    Robot(usize),
    Free(FreeBodyId),
    User(UserBody),
}

/// The handle of a body by its key.
pub(super) fn body_of((index, generation): RawHandle) -> RigidBodyHandle {
    RigidBodyHandle::from_raw_parts(index, generation)
}
