//! A rapier world that can be copied, and is small enough for many of them to fit into a cache.

use std::cell::RefCell;

use rapier3d::prelude::*;

use crate::Settings;

/// A rapier world without the work space of a step, in which nothing lasts from one step to the
/// next.
///
/// A copy continues identically to the bit. All worlds of a thread share one work space, so that
/// those of a fleet are smaller, and the work space stays in the processor's cache.
#[derive(Clone)]
pub(crate) struct Engine {
    pub gravity: Vector,
    pub integration_parameters: IntegrationParameters,
    pub islands: IslandManager,
    pub broad_phase: BroadPhaseBvh,
    pub narrow_phase: NarrowPhase,
    pub bodies: RigidBodySet,
    pub colliders: ColliderSet,
    pub multibody_joints: MultibodyJointSet,
}

/// rapier's work space, and sets of objects that no world here has, which rapier requires.
struct Room {
    pipeline: PhysicsPipeline,
    impulse_joints: ImpulseJointSet,
    soft_bodies: SoftBodySet,
    ccd_solver: CCDSolver,
}

thread_local! {
    static ROOM: RefCell<Room> = RefCell::new(Room {
        pipeline: PhysicsPipeline::new(),
        impulse_joints: ImpulseJointSet::new(),
        soft_bodies: SoftBodySet::new(),
        ccd_solver: CCDSolver::new(),
    });
}

/// Natural frequency of a contact's spring, in Hz, and its damping ratio. rapier's default of 30 Hz
/// lets light rollers sink in. Chosen.
const CONTACT_HZ: Real = 1000.0;
const CONTACT_DAMPING_RATIO: Real = 1.0;

/// Sweeps over the contacts of a step. Chosen.
const SWEEPS: usize = 32;

/// rapier's settings for light rollers under a heavy robot.
fn integration_parameters(settings: &Settings) -> IntegrationParameters {
    let softness = SpringCoefficients::new(CONTACT_HZ, CONTACT_DAMPING_RATIO);
    IntegrationParameters {
        dt: settings.dt_s,
        contact_softness: softness,
        static_contact_softness: softness,
        num_solver_iterations: 1,
        // With stabilisation, rapier solves friction after it has moved the bodies: large steps
        // then lose up to 40 %.
        num_internal_stabilization_iterations: 0,
        num_internal_pgs_iterations: SWEEPS,
        contact_clustering: false,
        // A recycled contact keeps its old lever arm, but a roller's contact moves along the roller
        // all the time.
        contact_recycling: false,
        friction_model: FrictionModel::Coulomb,
        max_ccd_substeps: 0,
        ..IntegrationParameters::default()
    }
}

impl Engine {
    /// An empty world.
    pub fn new(gravity: Vector, settings: &Settings, narrow_phase: NarrowPhase) -> Self {
        // The number of bodies and colliders of a robot with four wheels: more memory would be
        // wasted in each world of a fleet.
        const BODIES: usize = 5;
        Self {
            gravity,
            integration_parameters: integration_parameters(settings),
            narrow_phase,
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            bodies: RigidBodySet::with_capacity(BODIES),
            colliders: ColliderSet::new(),
            multibody_joints: MultibodyJointSet::new(),
        }
    }

    /// Takes a step.
    pub fn step(&mut self, hooks: &dyn PhysicsHooks) {
        ROOM.with_borrow_mut(|room| {
            room.pipeline.step(
                self.gravity,
                &self.integration_parameters,
                &mut self.islands,
                &mut self.broad_phase,
                &mut self.narrow_phase,
                &mut self.bodies,
                &mut self.colliders,
                &mut room.impulse_joints,
                &mut self.multibody_joints,
                &mut room.soft_bodies,
                &mut room.ccd_solver,
                hooks,
                &(),
            );
        });
    }

    /// Adds a collider to a body.
    pub fn insert_collider(
        &mut self,
        collider: impl Into<Collider>,
        body: RigidBodyHandle,
    ) -> ColliderHandle {
        self.colliders
            .insert_with_parent(collider, body, &mut self.bodies)
    }

    /// Joins two bodies by a joint of a multibody.
    pub fn insert_multibody_joint(
        &mut self,
        parent: RigidBodyHandle,
        child: RigidBodyHandle,
        joint: GenericJoint,
    ) {
        self.multibody_joints.insert(parent, child, joint, true);
    }
}
