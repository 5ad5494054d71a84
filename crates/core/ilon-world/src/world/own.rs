//! rapier's world in which a program keeps bodies of its own, beside what ilon moves.
//!
//! What ilon moves stands there as colliders without bodies, which touch but whose contacts rapier does not solve. The bodies of one's own are
//! rapier's: it moves them under gravity, on the ground, by their joints and against one another. Where one is near a robot or a free body, it is
//! in ilon's step a **guest**: one more articulated body, with the mass, place and velocity that rapier has of it. Its contacts with what ilon
//! moves are solved there with all others, and what they did to it acts in rapier's step that follows as a force, so that both sides get the same
//! impulse.
//!
//! **What rapier will do.** In ilon's step a guest has its weight, and the contacts that rapier found for it, on the ground and with other bodies of
//! one's own, which are guests then, too, solved by ilon's laws. What follows for them is not used: it only says what robots meet, a box that is free
//! or one with its back to a wall. What joints do to it is foreseen to go on as in the last two steps.

mod guests;
mod links;
pub(super) mod rapier_world;

use nalgebra::Vector3;
use rapier3d::prelude::*;

use super::World;
use crate::engine::convert;
use crate::ground::Ground;
use crate::{ContactSolver, WorldError, WorldObject};
use guests::body_of;
use rapier_world::{InRapier, Twin};

/// How much of what joints are seen to do is foreseen a step later.
const FOLLOWS: f64 = 0.25;

impl World {
    /// The world in rapier, to put bodies of one's own into, with their colliders and joints, and to change them. [`World::step`] steps it: do not
    /// step it yourself.
    ///
    /// Ground, robots and free bodies stand in it as colliders without a body; [`World::object_in_rapier`] says which is which. Its frame is the
    /// world's. Bodies of one's own move by rapier, on the ground with its friction or their own, the lower of both. Robots and free bodies
    /// push them, and are pushed by them, under ilon's laws: stiff contacts without bounce, with the friction of the collider. Fixed and kinematic
    /// bodies push too. A collider whose groups do not meet those of [`InteractionGroups::all`], a sensor, or what is disabled does not touch robots,
    /// and neither do soft bodies.
    ///
    /// The world of a program that never calls this has no rapier world, and costs nothing by it.
    ///
    /// # Errors
    /// [`WorldError::NotInRapier`] where rapier solves the robot's contacts: such a world has one robot and nothing beside it.
    pub fn rapier_mut(&mut self) -> Result<&mut PhysicsWorld, WorldError> {
        if self.settings.contacts == ContactSolver::Rapier {
            return Err(WorldError::NotInRapier {
                what: "bodies of one's own".to_owned(),
                remedy: "leave the bodies out",
            });
        }
        let mut rapier = match self.rapier.take() {
            Some(rapier) => rapier,
            None => Box::new(self.new_in_rapier()),
        };
        rapier.is_changed = true;
        Ok(&mut self.rapier.insert(rapier).world)
    }

    /// The world in rapier as it is after the last step, for queries, drawing and places of bodies; `None` before
    /// [`World::rapier_mut`] was called for the first time.
    pub fn rapier(&self) -> Option<&PhysicsWorld> {
        self.rapier.as_ref().map(|rapier| &rapier.world)
    }

    /// What a collider of the world in rapier is of; `None` of one's own.
    pub fn object_in_rapier(&self, collider: ColliderHandle) -> Option<WorldObject> {
        self.rapier
            .as_ref()?
            .objects
            .get(&collider.into_raw_parts())
            .copied()
    }

    /// What robots and free bodies did to a body of one's own in the last step: the mean force, in the world frame, in N.
    pub fn force_on_own_n(&self, body: RigidBodyHandle) -> Vector3<f64> {
        let met = self
            .rapier
            .as_ref()
            .and_then(|rapier| rapier.met.get(&body.into_raw_parts()));
        met.map_or_else(Vector3::zeros, |met| met.impulse[0] / self.settings.dt_s)
    }

    fn new_in_rapier(&self) -> InRapier {
        let mut rapier = InRapier::new();
        rapier.world.gravity = convert::vector(&self.gravity_in_world_m_s2());
        rapier.world.integration_parameters.dt = self.settings.dt_s;
        self.place_links(&mut rapier);
        rapier.look(&self.ground);
        rapier
    }

    /// Wakes all bodies of one's own.
    pub(super) fn wake_own(&mut self) {
        if let Some(rapier) = &mut self.rapier {
            rapier.world.wake_up_all(true);
        }
    }

    /// Takes over what the program has changed.
    pub(super) fn look_in_rapier(&mut self) {
        if let Some(rapier) = &mut self.rapier
            && std::mem::take(&mut rapier.is_changed)
        {
            rapier.look(&self.ground);
        }
    }

    /// Lets rapier take the step that ilon has taken.
    pub(super) fn step_in_rapier(&mut self) {
        let Some(mut rapier) = self.rapier.take() else {
            return;
        };
        self.place_links(&mut rapier);
        rapier.world.gravity = convert::vector(&self.gravity_in_world_m_s2());
        let dt_s = self.settings.dt_s;
        rapier.world.integration_parameters.dt = dt_s;
        rapier.held = std::mem::take(&mut rapier.held_now);
        (rapier.met).retain(|_, met| std::mem::take(&mut met.is_here));
        if rapier.is_at_rest() {
            rapier.look(&self.ground);
        } else {
            rapier.step_with_impulses(&self.ground, dt_s);
        }
        self.rapier = Some(rapier);
    }
}

impl InRapier {
    /// Whether there is anything of one's own.
    fn has_own(&self) -> bool {
        self.world.colliders.len() > self.links.len() || !self.world.bodies.is_empty()
    }

    /// Whether all sleeps, and nothing has been pushed.
    fn is_at_rest(&self) -> bool {
        let is_pushed = self.met.values().any(|met| met.impulse != Twin::default());
        let are_soft = self.world.soft_bodies().next().is_some();
        !is_pushed && !are_soft && self.world.active_bodies().next().is_none()
    }

    /// How many contacts of guests are kept.
    #[cfg(test)]
    pub(super) fn kept(&self) -> usize {
        self.held.len() + self.held_now.len()
    }

    /// Finds what is where, without moving anything.
    fn look(&mut self, ground: &Ground) {
        let dt_s = std::mem::take(&mut self.world.integration_parameters.dt);
        self.world.step_with_events(&Underfoot { ground }, &());
        self.world.integration_parameters.dt = dt_s;
    }

    /// Takes a step in which guests get what their contacts did to them. What balances what rapier will do acts as a force over the step, and the
    /// rest at once: so a guest has from the beginning the velocity with which ilon's laws count its way, and what rests is left at rest.
    fn step_with_impulses(&mut self, ground: &Ground, dt_s: f64) {
        let mut loaded = Vec::with_capacity(self.met.len());
        for (raw, met) in &self.met {
            let handle = body_of(*raw);
            if met.impulse == Twin::default() {
                continue;
            }
            let Some(body) = self.world.bodies.get_mut(handle) else {
                continue;
            };
            // Of a link of a multibody rapier takes forces alone.
            let joints = &self.world.multibody_joints;
            let is_link = joints.rigid_body_link(handle).is_some();
            let over_step = if is_link { met.impulse } else { met.over_step };
            loaded.push((handle, body.user_force(), body.user_torque()));
            let [force, torque] = over_step.map(|of| convert::vector(&(of / dt_s)));
            body.add_force(force, true);
            body.add_torque(torque, true);
            let [impulse, moment] =
                [0, 1].map(|k| convert::vector(&(met.impulse[k] - over_step[k])));
            body.apply_impulse(impulse, true);
            body.apply_torque_impulse(moment, true);
        }
        self.world.step_with_events(&Underfoot { ground }, &());
        for (handle, force, torque) in loaded {
            if let Some(body) = self.world.bodies.get_mut(handle) {
                body.reset_forces(false);
                body.reset_torques(false);
                body.add_force(force, false);
                body.add_torque(torque, false);
            }
        }
        for (raw, met) in &mut self.met {
            let Some(body) = self.world.bodies.get(body_of(*raw)) else {
                continue;
            };
            let handle = body_of(*raw);
            let (joints, links) = (&self.world.impulse_joints, &self.world.multibody_joints);
            let mut joined = joints.attached_enabled_joints(handle);
            if joined.next().is_none() && links.rigid_body_link(handle).is_none() {
                (met.missed, met.foreseen) = Default::default();
                continue;
            }
            let after = [body.linvel(), body.angvel()].map(convert::to_vector);
            for (k, after) in after.iter().enumerate() {
                let missed = after - met.expected[k] + met.foreseen[k];
                let lasts = lasting(&missed, &met.missed[k]);
                met.foreseen[k] += FOLLOWS * (lasts - met.foreseen[k]);
                met.missed[k] = missed;
            }
        }
    }
}

/// What was there in both of two steps: the smaller of two vectors; none where they point apart.
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

/// Gives what lies on the ground in rapier the ground's friction where it lies.
struct Underfoot<'a> {
    ground: &'a Ground,
}

impl PhysicsHooks for Underfoot<'_> {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        // Only the ground's colliders ask for this: of two that touch, the one without a body is the ground.
        let own = match (context.rigid_body1, context.rigid_body2) {
            (None, Some(_)) => context.collider2,
            (Some(_), None) => context.collider1,
            _ => return,
        };
        let Some(own) = context.colliders.get(own).map(Collider::friction) else {
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
        *rigid.friction = own.min(footing.friction);
    }
}
