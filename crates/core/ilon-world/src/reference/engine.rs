//! rapier's world as something that can be copied, and of which many fit into a cache.

use std::cell::RefCell;

use rapier3d::prelude::*;

use crate::Settings;

/// rapier's world but for the room in which it is stepped, of which nothing lasts from one step to the next.
///
/// A copy goes on to the bit as the original does. All worlds of a thread are stepped in one room, so that those of a fleet
/// are smaller, and the room is in the processor's cache for every one of them.
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

/// Where rapier works a step out, and sets of what no world here has: rapier asks for them, and they take room though they are empty.
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

/// Natural frequency of a contact's spring, in Hz, and its damping ratio. rapier's default of 30 Hz lets light rollers sink in.
const CONTACT_HZ: Real = 1000.0;
const CONTACT_DAMPING_RATIO: Real = 1.0;

/// Sweeps over the contacts of a step.
const SWEEPS: usize = 32;

/// rapier's solver as it has to be set for light rollers under a heavy robot.
fn integration_parameters(settings: &Settings) -> IntegrationParameters {
    let softness = SpringCoefficients::new(CONTACT_HZ, CONTACT_DAMPING_RATIO);
    IntegrationParameters {
        dt: settings.dt_s,
        contact_softness: softness,
        static_contact_softness: softness,
        num_solver_iterations: 1,
        // With stabilisation rapier solves friction after it has moved the bodies: large steps then lose up to 40 %.
        num_internal_stabilization_iterations: 0,
        num_internal_pgs_iterations: SWEEPS,
        contact_clustering: false,
        // A recycled contact keeps its old lever arm, but a roller's contact wanders along it all the time.
        contact_recycling: false,
        friction_model: FrictionModel::Coulomb,
        max_ccd_substeps: 0,
        ..IntegrationParameters::default()
    }
}

impl Engine {
    /// A world with nothing in it.
    pub fn new(gravity: Vector, settings: &Settings, narrow_phase: NarrowPhase) -> Self {
        // As many bodies and colliders as a robot of four wheels needs: room for more would lie idle in each of a fleet.
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

    /// Takes a body out, with its colliders and joints.
    pub fn remove_body(&mut self, body: RigidBodyHandle) {
        ROOM.with_borrow_mut(|room| {
            self.bodies.remove(
                body,
                &mut self.islands,
                &mut self.colliders,
                &mut room.impulse_joints,
                &mut self.multibody_joints,
                &mut room.soft_bodies,
                true,
            )
        });
    }
}
