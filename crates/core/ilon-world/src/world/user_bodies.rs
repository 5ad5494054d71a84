//! **User bodies**: bodies that a program keeps in a rapier world of its own.
//!
//! The bodies that ilon moves are in that world as colliders without bodies; rapier finds their
//! contacts, but does not solve them. rapier moves the user bodies under gravity, on the ground, by
//! their joints and against one another. A user body near a robot or a free body is **coupled** to
//! ilon's step: it is one more articulated body there, with rapier's mass, pose and velocity. Its
//! contacts with ilon's bodies are solved with all others, and their impulses act in rapier's
//! following step, so that both sides get the same impulse.
//!
//! **Prediction of rapier's step.** In ilon's step a coupled body has its weight, and the contacts
//! that rapier found for it: on the ground, and with other user bodies, which are then coupled,
//! too. ilon's laws solve them, but only to determine the resistance against robots: a box that is
//! free, or one with its back to a wall. rapier solves them again. The effect of joints on a body
//! in both of the last two steps is assumed to continue.

mod body_in_rapier;
mod coupled;
mod links;
pub(super) mod rapier_world;
mod search;

use nalgebra::Vector3;
use rapier3d::prelude::*;

use super::World;
use crate::engine::convert;
use crate::ground::Ground;
use crate::{ContactSolver, WorldError, WorldObject};
use rapier_world::{Spatial, UserBodies, body_of};

/// Rate at which the estimate of joint forces follows them, as a share per step. Chosen.
const FOLLOWS: f64 = 0.25;

impl World {
    /// The rapier world, for adding user bodies with their colliders and joints, and for changing
    /// them. [`World::step`] steps it: do not step it yourself.
    ///
    /// Ground, robots and free bodies are in it as colliders without a body;
    /// [`World::object_in_rapier`] identifies them. Its frame is the world's. rapier moves user
    /// bodies, on the ground with the lower of its friction and theirs. Robots and free bodies
    /// interact with them under ilon's laws: stiff contacts without bounce, with the friction of
    /// the collider. Fixed and kinematic bodies push too. A collider whose groups do not meet those
    /// of [`InteractionGroups::all`], a sensor, or a disabled collider does not touch robots, and
    /// neither do soft bodies.
    ///
    /// The world of a program that never calls this has no rapier world, and no cost by it.
    ///
    /// # Errors
    /// [`WorldError::NotInRapier`] if rapier solves the robot's contacts: such a world has only one
    /// robot.
    pub fn rapier_mut(&mut self) -> Result<&mut PhysicsWorld, WorldError> {
        if self.settings.contacts == ContactSolver::Rapier {
            return Err(WorldError::NotInRapier {
                what: "user bodies".to_owned(),
                remedy: "leave the bodies out",
            });
        }
        let mut rapier = match self.user_bodies.take() {
            Some(rapier) => rapier,
            None => Box::new(self.new_user_bodies()),
        };
        rapier.is_changed = true;
        Ok(&mut self.user_bodies.insert(rapier).world)
    }

    /// The rapier world after the last step, for queries, drawing and poses of bodies; `None`
    /// before the first call of [`World::rapier_mut`].
    pub fn rapier(&self) -> Option<&PhysicsWorld> {
        self.user_bodies.as_ref().map(|rapier| &rapier.world)
    }

    /// The object of a collider of the rapier world; `None` for a user's collider.
    pub fn object_in_rapier(&self, collider: ColliderHandle) -> Option<WorldObject> {
        self.user_bodies
            .as_ref()?
            .objects
            .get(&collider.into_raw_parts())
            .copied()
    }

    /// Mean force of robots and free bodies on a user body in the last step, in the world frame, in
    /// N.
    pub fn force_on_user_body_n(&self, body: RigidBodyHandle) -> Vector3<f64> {
        let exchanges = self.user_bodies.as_ref().map(|of| &of.exchanges);
        let exchange = exchanges.and_then(|of| of.get(&body.into_raw_parts()));
        exchange.map_or_else(Vector3::zeros, |of| of.impulse[0] / self.settings.dt_s)
    }

    fn new_user_bodies(&self) -> UserBodies {
        let mut rapier = UserBodies::new();
        rapier.world.gravity = convert::vector(&self.gravity_in_world_m_s2());
        rapier.world.integration_parameters.dt = self.settings.dt_s;
        self.place_links(&mut rapier);
        rapier.look(&self.ground);
        rapier
    }

    /// Wakes all user bodies.
    pub(super) fn wake_user_bodies(&mut self) {
        if let Some(rapier) = &mut self.user_bodies {
            rapier.world.wake_up_all(true);
        }
    }

    /// Takes over the program's changes in the rapier world.
    pub(super) fn look_at_user_bodies(&mut self) {
        if let Some(rapier) = &mut self.user_bodies
            && std::mem::take(&mut rapier.is_changed)
        {
            rapier.look(&self.ground);
        }
    }

    /// Lets rapier take the step that ilon has taken.
    pub(super) fn step_user_bodies(&mut self) {
        let Some(mut rapier) = self.user_bodies.take() else {
            return;
        };
        self.place_links(&mut rapier);
        rapier.world.gravity = convert::vector(&self.gravity_in_world_m_s2());
        let dt_s = self.settings.dt_s;
        rapier.world.integration_parameters.dt = dt_s;
        rapier.contacts = std::mem::take(&mut rapier.contacts_now);
        (rapier.exchanges).retain(|_, exchange| std::mem::take(&mut exchange.is_coupled));
        if rapier.is_at_rest() {
            rapier.look(&self.ground);
        } else {
            rapier.step_with_impulses(&self.ground, dt_s);
        }
        self.user_bodies = Some(rapier);
    }
}

impl UserBodies {
    /// Whether there are any.
    fn has_any(&self) -> bool {
        self.world.colliders.len() > self.links.len() || !self.world.bodies.is_empty()
    }

    /// Whether all bodies sleep, and none has been pushed.
    fn is_at_rest(&self) -> bool {
        let is_pushed = self
            .exchanges
            .values()
            .any(|exchange| exchange.impulse != Spatial::default());
        let are_soft = self.world.soft_bodies().next().is_some();
        !is_pushed && !are_soft && self.world.active_bodies().next().is_none()
    }

    /// The number of stored contacts of coupled bodies.
    #[cfg(test)]
    pub(super) fn kept(&self) -> usize {
        self.contacts.len() + self.contacts_now.len()
    }

    /// Updates rapier's search without moving anything.
    fn look(&mut self, ground: &Ground) {
        let dt_s = std::mem::take(&mut self.world.integration_parameters.dt);
        self.world.step_with_events(&GroundFriction { ground }, &());
        self.world.integration_parameters.dt = dt_s;
    }

    /// Takes a step in which coupled bodies get the impulses of their contacts. The part that
    /// balances rapier's own forces acts as a force over the step, and the rest at once: so a body
    /// has from the beginning the velocity with which ilon's laws compute its displacement, and a
    /// resting body stays at rest.
    fn step_with_impulses(&mut self, ground: &Ground, dt_s: f64) {
        let mut loaded = Vec::with_capacity(self.exchanges.len());
        for (raw, exchange) in &self.exchanges {
            let handle = body_of(*raw);
            if exchange.impulse == Spatial::default() {
                continue;
            }
            let Some(body) = self.world.bodies.get_mut(handle) else {
                continue;
            };
            // rapier accepts only forces for a link of a multibody.
            let joints = &self.world.multibody_joints;
            let is_link = joints.rigid_body_link(handle).is_some();
            let over_step = if is_link {
                exchange.impulse
            } else {
                exchange.over_step
            };
            loaded.push((handle, body.user_force(), body.user_torque()));
            let [force, torque] = over_step.map(|of| convert::vector(&(of / dt_s)));
            body.add_force(force, true);
            body.add_torque(torque, true);
            let [impulse, moment] =
                [0, 1].map(|k| convert::vector(&(exchange.impulse[k] - over_step[k])));
            body.apply_impulse(impulse, true);
            body.apply_torque_impulse(moment, true);
        }
        self.world.step_with_events(&GroundFriction { ground }, &());
        for (handle, force, torque) in loaded {
            if let Some(body) = self.world.bodies.get_mut(handle) {
                body.reset_forces(false);
                body.reset_torques(false);
                body.add_force(force, false);
                body.add_torque(torque, false);
            }
        }
        for (raw, exchange) in &mut self.exchanges {
            let Some(body) = self.world.bodies.get(body_of(*raw)) else {
                continue;
            };
            let handle = body_of(*raw);
            let (joints, links) = (&self.world.impulse_joints, &self.world.multibody_joints);
            let mut joined = joints.attached_enabled_joints(handle);
            if joined.next().is_none() && links.rigid_body_link(handle).is_none() {
                (exchange.missed, exchange.foreseen) = Default::default();
                continue;
            }
            let after = [body.linvel(), body.angvel()].map(convert::to_vector);
            for (k, after) in after.iter().enumerate() {
                let missed = after - exchange.expected[k] + exchange.foreseen[k];
                let lasts = lasting(&missed, &exchange.missed[k]);
                exchange.foreseen[k] += FOLLOWS * (lasts - exchange.foreseen[k]);
                exchange.missed[k] = missed;
            }
        }
    }
}

/// The common part of two steps: the smaller of two vectors; zero if they point apart.
fn lasting(one: &Vector3<f64>, other: &Vector3<f64>) -> Vector3<f64> {
    if one.dot(other) <= 0.0 {
        return Vector3::zeros();
    }
    if one.norm_squared() < other.norm_squared() {
        *one
    } else {
        *other
    }
}

/// The friction of the ground for bodies on it in rapier, at each point.
struct GroundFriction<'a> {
    ground: &'a Ground,
}

impl PhysicsHooks for GroundFriction<'_> {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        // Only the ground's colliders use this: of a pair, the one without a body is the ground.
        let of_user = match (context.rigid_body1, context.rigid_body2) {
            (None, Some(_)) => context.collider2,
            (Some(_), None) => context.collider1,
            _ => return,
        };
        let Some(of_user) = context.colliders.get(of_user).map(Collider::friction) else {
            return;
        };
        let Some(rigid) = context.rigid_mut() else {
            return;
        };
        let Some(contact) = rigid.solver_contacts.first() else {
            return;
        };
        let place_m = convert::to_vector(contact.anchor1);
        let footing = self.ground.footing_at(&place_m, None);
        *rigid.friction = of_user.min(footing.friction);
    }
}
