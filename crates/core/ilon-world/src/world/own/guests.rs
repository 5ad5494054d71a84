//! Bodies of one's own near what ilon moves, as articulated bodies of its step.

use std::collections::BTreeSet;

use ilon_robot::{Chassis, MassProperties, Scale};
use nalgebra::{Isometry3, Matrix3, Matrix6, Point3, Vector3, Vector6};
use rapier3d::prelude::*;

use super::rapier_world::{GuestContact, InRapier, Met, Twin, Who};
use crate::contact::reactions::reaction::Partner;
use crate::contact::search::bounds::Bounds;
use crate::dynamics::Attached;
use crate::engine::convert;
use crate::free::{Coupled, LEAST_GRAVITY_M_S2, RapierContact, RawHandle, UserBody};
use crate::robot::articulated::{Articulated, Kind};
use crate::robot::payload::ActingPush;
use crate::robot::shared_robot::{BodyShape, SharedRobot};
use crate::settings::{ContactSpring, Settings};
use crate::world::World;
use crate::world::free::islands::{aabb, near, place_among};

/// At most so many guests: a heap of one's own that a robot pushes has more, of which the furthest are left to rapier.
const MOST: usize = 24;
/// What cannot move along an axis, or about one, has so many times the mass of the heaviest that is near it.
const IMMOVABLE: f64 = 1e9;

/// A body of one's own as ilon's step needs it.
struct GuestBody {
    floor_from_body: Isometry3<f64>,
    mass: MassProperties,
    /// Of its centre of mass, and its turning.
    velocities: (Vector3<f64>, Vector3<f64>),
    /// Its weight and what the program lets act on it: force in N and torque in N m.
    force: Twin,
    /// The axes of the world along which, and then about which, nothing moves it.
    locked: [bool; 6],
}

impl World {
    /// Lets what of one's own is near the bodies here take part in the step, behind them.
    pub(in crate::world) fn seat_guests(&mut self) {
        let Some(mut rapier) = self.rapier.take() else {
            return;
        };
        if rapier.has_own() && !self.bodies.is_empty() {
            let first = self.bodies.len();
            let found = rapier.guests_of(&self.bodies, &self.settings);
            self.bodies.extend(found);
            let (here, guests) = self.bodies.split_at(first);
            let place = |who: &Who| match *who {
                Who::Robot(index) => here.get(index)?.is_robot().then_some(index),
                Who::Free(id) => place_among(here, id),
                Who::Own(own) => Some(first + place_of(guests, own)?),
            };
            let mut elsewhere = Vec::new();
            for held in std::mem::take(&mut rapier.held) {
                match (place(&held.a), held.b.as_ref().map(place)) {
                    (Some(a), None) => self.reactions.go_on(held.reaction, a, None),
                    (Some(a), Some(Some(b))) => self.reactions.go_on(held.reaction, a, Some(b)),
                    // Another island may have it.
                    _ => elsewhere.push(held),
                }
            }
            rapier.held = elsewhere;
        }
        self.rapier = Some(rapier);
    }

    /// Takes the guests out again that stand behind so many bodies, and notes what was done to them.
    pub(in crate::world) fn dismiss_guests(&mut self, first: usize) {
        let Some(rapier) = &mut self.rapier else {
            return;
        };
        let who = |at: usize| match &self.bodies[at].kind {
            Kind::Robot => Who::Robot(at),
            Kind::Free(free) => Who::Free(free.id),
            Kind::Coupled(coupled) => Who::Own(coupled.body),
        };
        for reaction in self.reactions.split_off_behind(first) {
            let b = match reaction.b {
                Partner::Of(member) => Some(who(member.body)),
                Partner::Ground | Partner::Itself => None,
            };
            let a = who(reaction.a.body);
            rapier.held_now.push(GuestContact { a, b, reaction });
        }
        if self.bodies.len() > first {
            // What touches something that rapier moves may not be left alone.
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
            let met = rapier.met.entry(raw).or_default();
            met.expected = [body.state.velocity_m_s, body.state.angular_rad_s];
            let chassis = body.state.floor_from_chassis();
            let turn = chassis.rotation.to_rotation_matrix();
            let inertia = turn * body.chassis_mass.inertia_kg_m2 * turn.transpose();
            let gained = [0, 1].map(|k| met.expected[k] - coupled.start[k]);
            let momentum = [body.chassis_mass.mass_kg * gained[0], inertia * gained[1]];
            for (k, gains) in momentum.iter().enumerate() {
                met.impulse[k] += coupled.impulse[k];
                met.over_step[k] += coupled.impulse[k] - gains;
            }
        }
    }

    /// Counts what contacts did to guests in a part of a step.
    pub(in crate::world) fn count_guests(&mut self) {
        if self
            .bodies
            .last()
            .is_none_or(|body| body.coupled().is_none())
        {
            return;
        }
        for (reaction, b) in self.reactions.on_bodies() {
            if self.bodies[reaction.a.body].coupled().is_some() {
                continue;
            }
            let body = &mut self.bodies[b];
            let center_m = body.step.middle.center_m();
            let mean_m_s = body.step.middle.chassis_velocity_m_s(&reaction.at_m);
            let Some(coupled) = body.coupled_mut() else {
                continue;
            };
            let normal = reaction.impulse.x * reaction.frame[0];
            let impulse_n_s = -(normal + reaction.friction_impulse_n_s());
            coupled.impulse[0] += impulse_n_s;
            coupled.impulse[1] += (reaction.at_m - center_m).cross(&impulse_n_s);
            self.energies.outside_j -= impulse_n_s.dot(&mean_m_s);
        }
    }

    /// Around what of one's own moves, as far as it may be near to something in the coming step.
    pub(in crate::world) fn own_that_moves(&self) -> Vec<Bounds> {
        let Some(rapier) = &self.rapier else {
            return Vec::new();
        };
        rapier.moving(self.settings.dt_s)
    }
}

/// The place of what is one's own among guests.
fn place_of(guests: &[Articulated], own: UserBody) -> Option<usize> {
    guests
        .iter()
        .position(|body| body.coupled().is_some_and(|coupled| coupled.body == own))
}

impl InRapier {
    /// What of one's own is near bodies, and what that touches in rapier, as guests behind these bodies.
    fn guests_of(&mut self, here: &[Articulated], settings: &Settings) -> Vec<Articulated> {
        let dt_s = settings.dt_s;
        let around = near(here, dt_s, 1.0);
        let heaviest_kg = here.iter().map(|body| body.robot.mass_kg());
        let heaviest_kg = heaviest_kg.fold(0.0, f64::max);
        let mut guests = Vec::new();
        for own in self.near(&around, dt_s) {
            let Some(guest) = self.guest(own, heaviest_kg, settings) else {
                continue;
            };
            let bounds = near(std::slice::from_ref(&guest), dt_s, 1.0);
            if bounds
                .iter()
                .any(|of| around.iter().any(|near| near.meets(of)))
            {
                guests.push(guest);
            }
        }
        let mut at = 0;
        while at < guests.len() {
            let touched =
                (guests[at].coupled()).map_or_else(Vec::new, |of| self.touched_by(of.body));
            let mut rests = Vec::with_capacity(touched.len());
            for (own, rest) in touched {
                let Some(own) = own else {
                    rests.push(rest);
                    continue;
                };
                let other = place_of(&guests, own).or_else(|| {
                    if guests.len() >= MOST {
                        return None;
                    }
                    guests.push(self.guest(own, heaviest_kg, settings)?);
                    Some(guests.len() - 1)
                });
                // Each pair once, by the one that stands behind, or by the one that rapier moves.
                let is_ours = |other: &usize| *other < at || !self.moves(own);
                if let Some(other) = other.filter(is_ours) {
                    rests.push(RapierContact {
                        other: Some(here.len() + other),
                        ..rest
                    });
                }
            }
            if let Some(coupled) = guests[at].coupled_mut() {
                coupled.contacts = rests;
            }
            at += 1;
        }
        guests
    }

    /// Whether rapier moves what is one's own by forces.
    fn moves(&self, own: UserBody) -> bool {
        self.moved(own).is_some()
    }

    /// A body that rapier moves by forces.
    fn moved(&self, own: UserBody) -> Option<&RigidBody> {
        let UserBody::Rigid(raw) = own else {
            return None;
        };
        let body = self.world.bodies.get(body_of(raw))?;
        body.is_dynamic().then_some(body)
    }

    /// The contacts that rapier solves for a body of one's own, each with the body that it touches if that is not fixed.
    fn touched_by(&self, own: UserBody) -> Vec<(Option<UserBody>, RapierContact)> {
        let Some(body) = self.moved(own) else {
            return Vec::new();
        };
        let colliders = body.colliders().iter();
        let pairs = colliders.flat_map(|collider| self.world.contact_pairs_with(*collider));
        // What ilon moves is found too, but rapier does nothing there: counted as a rest it would bear a guest in ilon's step and not in rapier's.
        let is_solved = |manifold: &&ContactManifold| {
            let flags = manifold.data.solver_flags;
            flags.contains(SolverFlags::COMPUTE_RIGID_IMPULSES)
        };
        let manifolds = pairs.flat_map(|pair| pair.solver_manifolds());
        let contacts = manifolds.filter(is_solved).flat_map(|manifold| {
            let (data, of) = (&manifold.data, &manifold.data.solver_contacts);
            of.iter().map(move |contact| self.rest(own, data, contact))
        });
        contacts.collect()
    }

    /// A contact that rapier found for a body of one's own, and the body that it touches if that is not fixed.
    fn rest(
        &self,
        own: UserBody,
        data: &ContactManifoldData,
        contact: &SolverContact,
    ) -> (Option<UserBody>, RapierContact) {
        let as_own =
            |body: Option<RigidBodyHandle>| body.map(|of| UserBody::Rigid(of.into_raw_parts()));
        let bodies = [data.rigid_body1, data.rigid_body2].map(as_own);
        let anchors = [contact.anchor1, contact.anchor2];
        let (this, other) = if bodies[0] == Some(own) {
            (0, 1)
        } else {
            (1, 0)
        };
        // rapier keeps a place on what moves along that body's axes, and any other in the world.
        let handles = [data.rigid_body1, data.rigid_body2];
        let place = |k: usize| {
            let body = handles[k].and_then(|handle| self.world.bodies.get(handle));
            match body.filter(|body| !body.is_fixed()) {
                Some(body) => body.center_of_mass() + body.rotation() * anchors[k],
                None => anchors[k],
            }
        };
        // rapier's normal points out of the first.
        let normal = convert::to_vector(data.normal) * if this == 0 { -1.0 } else { 1.0 };
        let gap_m = normal.dot(&convert::to_vector(place(this) - place(other)));
        let is_fixed = |own: &UserBody| match own {
            UserBody::Rigid(raw) => {
                (self.world.bodies.get(body_of(*raw))).is_none_or(RigidBody::is_fixed)
            }
            UserBody::Collider(_) => true,
        };
        let rest = RapierContact {
            in_body_m: convert::to_vector(anchors[this]),
            normal,
            gap_m: gap_m.max(0.0),
            other: None,
            friction: data.friction,
        };
        (bodies[other].filter(|own| !is_fixed(own)), rest)
    }

    /// What of one's own may be near to bounds in the coming step, in a fixed order.
    fn near(&self, around: &[Bounds], dt_s: f64) -> BTreeSet<UserBody> {
        let mut found = BTreeSet::new();
        let query = self.world.query_pipeline();
        let comes_m = self.comes_m(dt_s);
        for bounds in around {
            let within = aabb(&bounds.grown(comes_m));
            for (handle, collider) in query.intersect_aabb_conservative(within) {
                if self.objects.contains_key(&handle.into_raw_parts()) || !touches(collider) {
                    continue;
                }
                found.insert(match collider.parent() {
                    Some(body) => UserBody::Rigid(body.into_raw_parts()),
                    None => UserBody::Collider(handle.into_raw_parts()),
                });
            }
        }
        // Of a body that is switched off rapier has switched off the colliders too.
        let is_rigid = |own: &UserBody| match own {
            UserBody::Rigid(raw) => {
                let body = self.world.bodies.get(body_of(*raw));
                body.is_some_and(|body| !body.is_soft_frame())
            }
            UserBody::Collider(_) => true,
        };
        found.retain(is_rigid);
        found
    }

    /// The furthest that anything of one's own comes in a step, in metres.
    fn comes_m(&self, dt_s: f64) -> f64 {
        let moving = self.world.active_bodies();
        let comes_m = moving.map(|(_, body)| self.travel_m(body, dt_s));
        comes_m.fold(0.0, f64::max)
    }

    /// The furthest that a place of a body may come in a step, in metres.
    fn travel_m(&self, body: &RigidBody, dt_s: f64) -> f64 {
        let (velocity_m_s, angular_rad_s) = velocities(body, dt_s);
        if angular_rad_s == Vector3::zeros() {
            return dt_s * velocity_m_s.norm();
        }
        let center = body.center_of_mass();
        let reach_m = self.colliders_of(body).map(|collider| {
            let ball = collider.compute_aabb().bounding_sphere();
            (ball.center - center).length() + ball.radius
        });
        let rim_m_s = angular_rad_s.norm() * reach_m.fold(0.0, f64::max);
        dt_s * (velocity_m_s.norm() + rim_m_s)
    }

    /// Around each body of one's own that moves, as far as it may be near to something in the coming step.
    fn moving(&self, dt_s: f64) -> Vec<Bounds> {
        let around = |(_, body): (RigidBodyHandle, &RigidBody)| {
            let bounds = self.colliders_of(body).map(|collider| {
                let around = collider.compute_aabb();
                Bounds {
                    least_m: convert::to_vector(around.mins),
                    most_m: convert::to_vector(around.maxs),
                }
            });
            let bounds = bounds.fold(Bounds::NONE, |all, of| all.merged(&of));
            bounds.grown(2.0 * self.travel_m(body, dt_s))
        };
        self.world.active_bodies().map(around).collect()
    }

    /// What of a body may touch what ilon moves.
    fn colliders_of<'a>(&'a self, body: &'a RigidBody) -> impl Iterator<Item = &'a Collider> {
        let all = body.colliders().iter();
        let colliders = all.filter_map(|handle| self.world.colliders.get(*handle));
        colliders.filter(|collider| touches(collider))
    }

    /// What of one's own is one body, as one more of the step's; the heaviest beside it has so much.
    fn guest(
        &mut self,
        own: UserBody,
        heaviest_kg: f64,
        settings: &Settings,
    ) -> Option<Articulated> {
        let (seen, shapes) = match own {
            UserBody::Rigid(handle) => {
                let body = self.world.bodies.get(body_of(handle))?;
                let shapes = self.colliders_of(body).flat_map(|collider| {
                    let body_from_collider = collider.position_wrt_parent();
                    shapes_of(collider, *body_from_collider.unwrap_or(&Pose::IDENTITY))
                });
                (
                    GuestBody::of(body, self.world.gravity, settings.dt_s),
                    shapes.collect(),
                )
            }
            UserBody::Collider(handle) => {
                let (index, generation) = handle;
                let handle = ColliderHandle::from_raw_parts(index, generation);
                let collider = self.world.colliders.get(handle)?;
                let shapes = shapes_of(collider, Pose::IDENTITY);
                (GuestBody::fixed(collider.position()), shapes)
            }
        };
        let mut guest = seen.built(own, shapes, settings);
        seen.hold(&mut guest, heaviest_kg);
        let velocities = seen.velocities;
        if let UserBody::Rigid(handle) = own {
            let met = self.met.entry(handle).or_default();
            if !std::mem::replace(&mut met.is_here, true) {
                (met.impulse, met.over_step) = Default::default();
            }
            guest.command.pushes.push(seen.acts(met, settings.dt_s));
        }
        for state in guest.states_mut() {
            (state.velocity_m_s, state.angular_rad_s) = velocities;
        }
        Some(guest)
    }
}

impl GuestBody {
    fn fixed(floor_from_body: &Pose) -> Self {
        Self {
            floor_from_body: convert::isometry(floor_from_body),
            mass: MassProperties {
                mass_kg: 1.0,
                center_of_mass_m: Vector3::zeros(),
                inertia_kg_m2: Matrix3::identity(),
            },
            velocities: (Vector3::zeros(), Vector3::zeros()),
            force: Twin::default(),
            locked: [true; 6],
        }
    }

    fn of(body: &RigidBody, gravity: Vector, dt_s: f64) -> Self {
        let of = &body.mass_properties().local_mprops;
        let mut seen = Self::fixed(body.position());
        seen.mass.center_of_mass_m = convert::to_vector(of.local_com);
        seen.velocities = velocities(body, dt_s);
        if !body.is_dynamic() {
            return seen;
        }
        let weight = body.mass() * body.gravity_scale() * gravity;
        seen.force = [weight + body.user_force(), body.user_torque()].map(convert::to_vector);
        let flags = body.locked_axes();
        let weighs = of.inv_mass > 0.0;
        let turns = of.inv_principal_inertia.cmpgt(Vector::ZERO).all();
        if weighs {
            seen.mass.mass_kg = 1.0 / of.inv_mass;
        }
        if turns {
            let inertia = convert::to_matrix(of.reconstruct_inertia_matrix());
            seen.mass.inertia_kg_m2 = 0.5 * (inertia + inertia.transpose());
        }
        seen.locked = [
            !weighs || flags.contains(LockedAxes::TRANSLATION_LOCKED_X),
            !weighs || flags.contains(LockedAxes::TRANSLATION_LOCKED_Y),
            !weighs || flags.contains(LockedAxes::TRANSLATION_LOCKED_Z),
            !turns || flags.contains(LockedAxes::ROTATION_LOCKED_X),
            !turns || flags.contains(LockedAxes::ROTATION_LOCKED_Y),
            !turns || flags.contains(LockedAxes::ROTATION_LOCKED_Z),
        ];
        seen
    }

    /// As an articulated body at rest.
    fn built(&self, own: UserBody, shapes: Vec<BodyShape>, settings: &Settings) -> Articulated {
        let around = shapes.iter().fold(Bounds::NONE, |around, of| {
            let bounds = of.shape.compute_local_aabb();
            let size = convert::to_vector(bounds.extents());
            around.merged(&Bounds {
                least_m: Vector3::zeros(),
                most_m: size,
            })
        });
        let scale = self.scale(&around, settings);
        let chassis = Chassis {
            name: String::new(),
            mass: self.mass.clone(),
            collisions: Vec::new(),
        };
        let robot = SharedRobot::of_one(chassis, shapes);
        let mut guest = Articulated::build(robot, &self.floor_from_body, settings);
        guest.scale = scale;
        guest.spring = ContactSpring::of(settings, &guest.scale);
        guest.kind = Kind::Coupled(Box::new(Coupled {
            body: own,
            start: self.velocities.into(),
            contacts: Vec::new(),
            impulse: Twin::default(),
        }));
        guest
    }

    /// Its own units, as of a free body within the same box; what is large is no coarser than a robot.
    fn scale(&self, around: &Bounds, settings: &Settings) -> Scale {
        /// In metres.
        const LARGE: f64 = 0.25;
        let sizes_m = (around.most_m - around.least_m).map(|size| size.clamp(1e-3, 1e3));
        let is_fixed = self.locked[..3].iter().all(|locked| *locked);
        Scale {
            length_m: (0.5 * libm::cbrt(sizes_m.product())).min(LARGE),
            // What nothing moves is as hard as anything.
            load_kg: if is_fixed {
                1e6
            } else {
                0.25 * self.mass.mass_kg
            },
            gravity_m_s2: settings.gravity_m_s2.max(LEAST_GRAVITY_M_S2),
        }
    }

    /// Lets nothing move it along its locked axes, nor about them.
    fn hold(&self, guest: &mut Articulated, heaviest_kg: f64) {
        if !self.locked.contains(&true) {
            return;
        }
        let immovable = IMMOVABLE * heaviest_kg.max(self.mass.mass_kg);
        let held = self
            .locked
            .map(|locked| if locked { immovable } else { 0.0 });
        let inertia = Matrix6::from_diagonal(&Vector6::from(held));
        guest.mechanics.attached = Some(Box::new(Attached::new(inertia, &Vector3::zeros())));
    }

    /// What will act on it in rapier besides contacts, as a push in the step.
    fn acts(&self, met: &Met, dt_s: f64) -> ActingPush {
        let turn = self.floor_from_body.rotation.to_rotation_matrix();
        let inertia = turn * self.mass.inertia_kg_m2 * turn.transpose();
        ActingPush {
            force_n: self.force[0] + self.mass.mass_kg * met.foreseen[0] / dt_s,
            lever_m: Vector3::zeros(),
            moment_n_m: self.force[1] + inertia * met.foreseen[1] / dt_s,
        }
    }
}

/// Whether a collider of one's own touches what ilon moves.
fn touches(collider: &Collider) -> bool {
    let all = InteractionGroups::all();
    collider.is_enabled()
        && !collider.is_sensor()
        && collider.collision_groups().test(all)
        && collider.solver_groups().test(all)
}

/// The shapes of a collider in the frame of its body, with its friction.
fn shapes_of(collider: &Collider, body_from_collider: Pose) -> Vec<BodyShape> {
    let shape = |body_from_shape: Pose, shape: &SharedShape| BodyShape {
        joint: None,
        carrier_from_shape: convert::isometry(&body_from_shape),
        shape: shape.clone(),
        friction: Some(collider.friction().max(0.0)),
    };
    match collider.shape().as_compound() {
        Some(compound) => {
            let parts = compound.shapes().iter();
            parts
                .map(|(pose, part)| shape(body_from_collider * *pose, part))
                .collect()
        }
        None => vec![shape(body_from_collider, collider.shared_shape())],
    }
}

/// Velocity of a body's centre of mass and its angular velocity in the coming step, in m/s and rad/s.
fn velocities(body: &RigidBody, dt_s: f64) -> (Vector3<f64>, Vector3<f64>) {
    if body.body_type() != RigidBodyType::KinematicPositionBased {
        return (
            convert::to_vector(body.linvel()),
            convert::to_vector(body.angvel()),
        );
    }
    // It goes where the program wants it by the end of the step.
    let (from, to) = (
        convert::isometry(body.position()),
        convert::isometry(body.next_position()),
    );
    let center = Point3::from(convert::to_vector(body.local_center_of_mass()));
    let turned = to.rotation * from.rotation.inverse();
    (
        ((to * center) - (from * center)) / dt_s,
        turned.scaled_axis() / dt_s,
    )
}

/// The handle of a body by its key.
pub(super) fn body_of((index, generation): RawHandle) -> RigidBodyHandle {
    RigidBodyHandle::from_raw_parts(index, generation)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How far a ball of 0.1 m comes in a second, half a metre from the middle of a body that moves.
    fn travel_m(velocity_m_s: Vector, angular_rad_s: Vector) -> f64 {
        let mut rapier = InRapier::new();
        let mass = rapier3d::dynamics::MassProperties::new(Vector::ZERO, 1.0, Vector::ONE);
        let body = RigidBodyBuilder::dynamic()
            .additional_mass_properties(mass)
            .linvel(velocity_m_s)
            .angvel(angular_rad_s);
        let ball = ColliderBuilder::ball(0.1).density(0.0);
        let beside = ball.translation(Vector::new(0.5, 0.0, 0.0));
        let (body, _) = rapier.world.insert(body, beside);
        // A step of no time places the ball.
        rapier.world.integration_parameters.dt = 0.0;
        rapier.world.step();
        rapier.travel_m(&rapier.world.bodies[body], 1.0)
    }

    /// What turns comes as far as its furthest place, 0.6 m out, and little more is looked through: the ball around the box around it. What does not turn comes as
    /// far as it goes.
    #[test]
    fn what_turns_comes_as_far_as_its_rim() {
        let (goes, turns) = (Vector::new(0.0, 3.0, 4.0), Vector::new(0.0, 0.0, 2.0));
        assert!((travel_m(goes, Vector::ZERO) - 5.0).abs() < 1e-12);
        let most_m = 0.5 + 0.1 * 3.0_f64.sqrt();
        let found_m = travel_m(goes, turns);
        assert!(
            found_m >= 5.0 + 2.0 * 0.6 && found_m < 5.0 + 2.0 * most_m + 1e-12,
            "{found_m}"
        );
    }
}
