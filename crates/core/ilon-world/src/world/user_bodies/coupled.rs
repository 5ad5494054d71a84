//! Couples user bodies near ilon's bodies to its step, as coupled bodies after all others.

use rapier3d::prelude::*;

use super::body_in_rapier::{BodyInRapier, shapes_of};
use super::rapier_world::{BodyKey, CoupledContact, UserBodies, body_of};
use crate::contact::reactions::reaction::Partner;
use crate::free::{RapierContact, UserBody};
use crate::robot::articulated::{Articulated, Kind};
use crate::settings::Settings;
use crate::world::World;
use crate::world::free::islands::{near, place_among};

/// The most coupled bodies: of a larger heap that a robot pushes, the furthest are moved by rapier
/// alone. Chosen.
const MOST: usize = 24;

impl World {
    /// Adds the user bodies near the bodies here, with their contacts of the last step.
    pub(in crate::world) fn couple_user_bodies(&mut self) {
        let Some(mut rapier) = self.user_bodies.take() else {
            return;
        };
        if rapier.has_any() && !self.bodies.is_empty() {
            let first = self.bodies.len();
            let found = rapier.coupled_to(&self.bodies, &self.settings);
            self.bodies.extend(found);
            let (here, coupled) = self.bodies.split_at(first);
            let place = |key: &BodyKey| match *key {
                BodyKey::Robot(index) => here.get(index)?.is_robot().then_some(index),
                BodyKey::Free(id) => place_among(here, id),
                BodyKey::User(body) => Some(first + place_of(coupled, body)?),
            };
            let mut elsewhere = Vec::new();
            for contact in std::mem::take(&mut rapier.contacts) {
                match (place(&contact.a), contact.b.as_ref().map(place)) {
                    (Some(a), None) => self.reactions.go_on(contact.reaction, a, None),
                    (Some(a), Some(Some(b))) => self.reactions.go_on(contact.reaction, a, Some(b)),
                    // It may belong to another island.
                    _ => elsewhere.push(contact),
                }
            }
            rapier.contacts = elsewhere;
        }
        self.user_bodies = Some(rapier);
    }

    /// Removes the coupled bodies, which are those from an index on, and records the impulses on
    /// them.
    pub(in crate::world) fn release_user_bodies(&mut self, first: usize) {
        let Some(rapier) = &mut self.user_bodies else {
            return;
        };
        let key = |at: usize| match &self.bodies[at].kind {
            Kind::Robot => BodyKey::Robot(at),
            Kind::Free(free) => BodyKey::Free(free.id),
            Kind::Coupled(coupled) => BodyKey::User(coupled.body),
        };
        for reaction in self.reactions.split_off_behind(first) {
            let b = match reaction.b {
                Partner::Of(member) => Some(key(member.body)),
                Partner::Ground | Partner::Itself => None,
            };
            let a = key(reaction.a.body);
            rapier.contacts_now.push(CoupledContact { a, b, reaction });
        }
        if self.bodies.len() > first {
            // A body near one that rapier moves must not fall asleep.
            let free = self.bodies[..first]
                .iter_mut()
                .filter_map(Articulated::free_mut);
            free.for_each(|free| free.slow_s = 0.0);
        }
        for body in self.bodies.drain(first..) {
            let Some((coupled, UserBody::Rigid(raw))) =
                body.coupled().map(|coupled| (coupled, coupled.body))
            else {
                continue;
            };
            let exchange = rapier.exchanges.entry(raw).or_default();
            exchange.expected = [body.state.velocity_m_s, body.state.angular_rad_s];
            let chassis = body.state.floor_from_chassis();
            let turn = chassis.rotation.to_rotation_matrix();
            let inertia = turn * body.chassis_mass.inertia_kg_m2 * turn.transpose();
            let gained = [0, 1].map(|k| exchange.expected[k] - coupled.start[k]);
            let momentum = [body.chassis_mass.mass_kg * gained[0], inertia * gained[1]];
            for (k, gains) in momentum.iter().enumerate() {
                exchange.impulse[k] += coupled.impulse[k];
                exchange.over_step[k] += coupled.impulse[k] - gains;
            }
        }
    }
}

/// The index of a user body among coupled bodies.
fn place_of(coupled: &[Articulated], user: UserBody) -> Option<usize> {
    let is_it = |body: &Articulated| body.coupled().is_some_and(|of| of.body == user);
    coupled.iter().position(is_it)
}

impl UserBodies {
    /// The user bodies near bodies, and those that these touch in rapier, as coupled bodies after
    /// them.
    fn coupled_to(&mut self, here: &[Articulated], settings: &Settings) -> Vec<Articulated> {
        let dt_s = settings.dt_s;
        let around = near(here, dt_s, 1.0);
        let heaviest_kg = here.iter().map(|body| body.robot.mass_kg());
        let heaviest_kg = heaviest_kg.fold(0.0, f64::max);
        let mut coupled = Vec::new();
        for user in self.near(&around, dt_s) {
            let Some(body) = self.as_articulated(user, heaviest_kg, settings) else {
                continue;
            };
            let bounds = near(std::slice::from_ref(&body), dt_s, 1.0);
            if bounds
                .iter()
                .any(|of| around.iter().any(|near| near.meets(of)))
            {
                coupled.push(body);
            }
        }
        let mut at = 0;
        while at < coupled.len() {
            let touched =
                (coupled[at].coupled()).map_or_else(Vec::new, |of| self.touched_by(of.body));
            let mut contacts = Vec::with_capacity(touched.len());
            for (user, contact) in touched {
                let Some(user) = user else {
                    contacts.push(contact);
                    continue;
                };
                let other = place_of(&coupled, user).or_else(|| {
                    if coupled.len() >= MOST {
                        return None;
                    }
                    coupled.push(self.as_articulated(user, heaviest_kg, settings)?);
                    Some(coupled.len() - 1)
                });
                // Each pair once: by the later one, or by the one that rapier moves.
                let is_counted = |other: &usize| *other < at || !self.moves(user);
                if let Some(other) = other.filter(is_counted) {
                    contacts.push(RapierContact {
                        other: Some(here.len() + other),
                        ..contact
                    });
                }
            }
            if let Some(of) = coupled[at].coupled_mut() {
                of.contacts = contacts;
            }
            at += 1;
        }
        coupled
    }

    /// A user body as a coupled one, given the mass of the heaviest body near it.
    fn as_articulated(
        &mut self,
        user: UserBody,
        heaviest_kg: f64,
        settings: &Settings,
    ) -> Option<Articulated> {
        let (in_rapier, shapes) = match user {
            UserBody::Rigid(handle) => {
                let body = self.world.bodies.get(body_of(handle))?;
                let shapes = self.colliders_of(body).flat_map(|collider| {
                    let body_from_collider = collider.position_wrt_parent();
                    shapes_of(collider, *body_from_collider.unwrap_or(&Pose::IDENTITY))
                });
                (
                    BodyInRapier::of(body, self.world.gravity, settings.dt_s),
                    shapes.collect(),
                )
            }
            UserBody::Collider(handle) => {
                let (index, generation) = handle;
                let handle = ColliderHandle::from_raw_parts(index, generation);
                let collider = self.world.colliders.get(handle)?;
                let shapes = shapes_of(collider, Pose::IDENTITY);
                (BodyInRapier::fixed(collider.position()), shapes)
            }
        };
        let mut body = in_rapier.built(user, shapes, settings);
        in_rapier.hold(&mut body, heaviest_kg);
        let velocities = in_rapier.velocities;
        if let UserBody::Rigid(handle) = user {
            let exchange = self.exchanges.entry(handle).or_default();
            if !std::mem::replace(&mut exchange.is_coupled, true) {
                (exchange.impulse, exchange.over_step) = Default::default();
            }
            let push = in_rapier.acts(exchange, settings.dt_s);
            body.command.pushes.push(push);
        }
        for state in body.states_mut() {
            (state.velocity_m_s, state.angular_rad_s) = velocities;
        }
        Some(body)
    }
}
