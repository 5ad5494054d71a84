//! rapier's world beside ilon's, and what lasts of it from step to step.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rapier3d::prelude::*;

use crate::contact::reactions::reaction::Reaction;
use crate::free::{RawHandle, UserBody};
use crate::{FreeBodyId, WorldObject};

/// rapier's world, and what of it is not one's own.
pub(in crate::world) struct InRapier {
    pub(super) world: PhysicsWorld,
    /// What of ilon's stands in it: each shape of each object, counted.
    pub(super) links: BTreeMap<(WorldObject, usize), ColliderHandle>,
    /// What each of these colliders is of.
    pub(super) objects: BTreeMap<RawHandle, WorldObject>,
    /// The bodies of one's own that were guests in the last step, or are in this one.
    pub(super) met: BTreeMap<RawHandle, Met>,
    /// The contacts of guests in the last step, and those that this one has had by now.
    pub(super) held: Vec<GuestContact>,
    pub(super) held_now: Vec<GuestContact>,
    /// Whether the program may have changed something since the last step.
    pub(super) is_changed: bool,
}

impl InRapier {
    /// A world in which nothing stands yet.
    pub(super) fn new() -> Self {
        Self {
            world: PhysicsWorld::new(),
            links: BTreeMap::new(),
            objects: BTreeMap::new(),
            met: BTreeMap::new(),
            held: Vec::new(),
            held_now: Vec::new(),
            is_changed: true,
        }
    }
}

/// A body of one's own that is a guest; velocities of its centre of mass and of its turning, in m/s and rad/s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Met {
    /// Impulse of its contacts with what ilon moves in the step, in N s, and its moment about its centre of mass.
    pub(super) impulse: Twin,
    /// What of it acts over the step: it balances what rapier will do.
    pub(super) over_step: Twin,
    /// The velocities that it should have after the step.
    pub(super) expected: Twin,
    /// How much more joints gave it in the last step, and what of that is foreseen.
    pub(super) missed: Twin,
    pub(super) foreseen: Twin,
    /// Whether it was a guest in this step.
    pub(super) is_here: bool,
}

/// A vector of motion along and one about the axes of the world.
pub(super) type Twin = [Vector3<f64>; 2];

impl Clone for InRapier {
    fn clone(&self) -> Self {
        // What lasts from step to step is copied; the pipelines and the solver of fast bodies hold room to work in alone.
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
            met: self.met.clone(),
            held: self.held.clone(),
            held_now: self.held_now.clone(),
            is_changed: self.is_changed,
        }
    }
}

/// A contact of a guest in the last step: who has it, and with whom, if it is not with what is fixed.
#[derive(Clone)]
pub(super) struct GuestContact {
    pub(super) a: Who,
    pub(super) b: Option<Who>,
    pub(super) reaction: Reaction,
}

/// A body of a step by what lasts: a robot's place, a free body's identity, or what of one's own.
#[derive(Clone, Copy)]
pub(super) enum Who {
    Robot(usize),
    Free(FreeBodyId),
    Own(UserBody),
}
