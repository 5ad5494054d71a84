//! Bodies of one's own near what ilon moves, as articulated bodies of its step.

use std::collections::BTreeSet;
use std::sync::Arc;

use ilon_robot::{Chassis, MassProperties, Scale};
use nalgebra::{Isometry3, Matrix3, Matrix6, Point3, Vector3, Vector6};
use rapier3d::prelude::*;

use super::{InRapier, Met, Raw};
use crate::contact::bounds::Bounds;
use crate::contact::reaction::{Part, Partner, Reaction};
use crate::dynamics::Attached;
use crate::engine::convert;
use crate::free::{Free, FreeBodyId, Guest, LEAST_GRAVITY_M_S2};
use crate::robot::articulated::Articulated;
use crate::robot::payload::ActingPush;
use crate::robot::shared_robot::{BodyShape, SharedRobot};
use crate::settings::{ContactSpring, Settings};
use crate::world::World;
use crate::world::free::islands::{id_of, near, place_among, rounded};

/// What cannot move along an axis, or about one, has so many times the mass of the heaviest that is near it.
const IMMOVABLE: f64 = 1e9;

/// What of one's own is one body: with its colliders, or a collider without a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Own {
    Body(Raw),
    Collider(Raw),
}

/// A contact with a guest in the last step: who has it, by a robot's place or a free body's identity, and with what of one's own.
#[derive(Clone)]
pub(super) struct Held {
    robot: usize,
    free: Option<FreeBodyId>,
    own: Own,
    reaction: Reaction,
}

/// A body of one's own as ilon's step needs it.
struct Seen {
    floor_from_body: Isometry3<f64>,
    mass: MassProperties,
    /// Of its centre of mass, and its turning.
    velocities: (Vector3<f64>, Vector3<f64>),
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
            let dt_s = self.settings.dt_s;
            let around = near(&self.bodies, dt_s, 1.0);
            let first = self.bodies.len();
            let heaviest_kg = self.bodies.iter().map(|body| body.robot.mass_kg());
            let heaviest_kg = heaviest_kg.fold(0.0, f64::max);
            for own in rapier.near(&around, dt_s) {
                let Some(guest) = rapier.guest(own, heaviest_kg, &self.settings) else {
                    continue;
                };
                let bounds = near(std::slice::from_ref(&guest), dt_s, 1.0);
                if bounds
                    .iter()
                    .any(|of| around.iter().any(|near| near.meets(of)))
                {
                    self.bodies.push(guest);
                }
            }
            let (here, guests) = self.bodies.split_at(first);
            let mut elsewhere = Vec::new();
            for held in std::mem::take(&mut rapier.held) {
                let a = match held.free {
                    Some(id) => place_among(here, id),
                    None => (held.robot < here.len() && here[held.robot].free.is_none())
                        .then_some(held.robot),
                };
                let b = guests
                    .iter()
                    .position(|guest| own_of(guest) == Some(held.own));
                match (a, b) {
                    (Some(a), Some(b)) => self.reactions.go_on(held.reaction, a, first + b),
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
        for reaction in self.reactions.split_off_partners(first) {
            let Partner::Of(member) = reaction.b else {
                continue;
            };
            let Some(own) = own_of(&self.bodies[member.body]) else {
                continue;
            };
            let a = reaction.a.body;
            // What lies on something that another engine moves may not be left alone.
            if let Some(free) = &mut self.bodies[a].free {
                free.slow_s = 0.0;
            }
            rapier.held_now.push(Held {
                robot: a,
                free: id_of(&self.bodies[a]),
                own,
                reaction,
            });
        }
        for body in self.bodies.drain(first..) {
            let Some((Own::Body(handle), guest)) = own_of(&body).zip(guest_of(&body)) else {
                continue;
            };
            let met = rapier.met.entry(handle).or_default();
            met.impulse_n_s += guest.impulse_n_s;
            met.moment_n_m_s += guest.moment_n_m_s;
            met.change.0 += guest.change.0;
            met.change.1 += guest.change.1;
        }
    }

    /// Counts what contacts did to guests in a part of a step.
    pub(in crate::world) fn count_guests(&mut self) {
        if self.bodies.last().is_none_or(|body| !body.is_guest()) {
            return;
        }
        for reaction in self.reactions.all() {
            let (Part::Chassis | Part::Link(_) | Part::Roller(..), Partner::Of(b)) =
                (reaction.a.part, reaction.b)
            else {
                continue;
            };
            let body = &mut self.bodies[b.body];
            let center_m = body.middle.center_m();
            let mean_m_s = body.middle.chassis_velocity_m_s(&reaction.at_m);
            let Some(guest) = body.free.as_mut().and_then(|free| free.guest.as_mut()) else {
                continue;
            };
            let normal = reaction.impulse.x * reaction.frame[0];
            let impulse_n_s = -(normal + reaction.friction_impulse_n_s());
            guest.impulse_n_s += impulse_n_s;
            guest.moment_n_m_s += (reaction.at_m - center_m).cross(&impulse_n_s);
            self.energies.outside_j -= impulse_n_s.dot(&mean_m_s);
        }
        for (index, body) in self.bodies.iter_mut().enumerate() {
            if let Some(guest) = body.free.as_mut().and_then(|free| free.guest.as_mut()) {
                let change = self.reactions.change(index);
                guest.change.0 += Vector3::from_column_slice(&change[..3]);
                guest.change.1 += Vector3::from_column_slice(&change[3..6]);
            }
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

fn guest_of(body: &Articulated) -> Option<&Guest> {
    body.free.as_ref()?.guest.as_deref()
}

fn own_of(body: &Articulated) -> Option<Own> {
    Some(guest_of(body)?.own)
}

impl InRapier {
    /// What of one's own may be near to bounds in the coming step, in a fixed order.
    fn near(&self, around: &[Bounds], dt_s: f64) -> BTreeSet<Own> {
        let mut found = BTreeSet::new();
        let query = self.world.query_pipeline();
        let comes_m = self.comes_m(dt_s);
        for bounds in around {
            let within = rounded(&bounds.grown(comes_m));
            for (handle, collider) in query.intersect_aabb_conservative(within) {
                if self.objects.contains_key(&handle.into_raw_parts()) || !touches(collider) {
                    continue;
                }
                found.insert(match collider.parent() {
                    Some(body) => Own::Body(body.into_raw_parts()),
                    None => Own::Collider(handle.into_raw_parts()),
                });
            }
        }
        let is_there = |own: &Own| match own {
            Own::Body(raw) => (self.world.bodies.get(body_of(*raw)))
                .is_some_and(|body| body.is_enabled() && !body.is_soft_frame()),
            Own::Collider(_) => true,
        };
        found.retain(is_there);
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
            f64::from((ball.center - center).length() + ball.radius)
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
                    least_m: convert::to_f64(around.mins),
                    most_m: convert::to_f64(around.maxs),
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
    fn guest(&mut self, own: Own, heaviest_kg: f64, settings: &Settings) -> Option<Articulated> {
        let (seen, shapes) = match own {
            Own::Body(handle) => {
                let body = self.world.bodies.get(body_of(handle))?;
                let shapes = self.colliders_of(body).flat_map(|collider| {
                    let body_from_collider = collider.position_wrt_parent();
                    shapes_of(collider, *body_from_collider.unwrap_or(&Pose::IDENTITY))
                });
                (Seen::of(body, settings.dt_s), shapes.collect())
            }
            Own::Collider(handle) => {
                let (index, generation) = handle;
                let handle = ColliderHandle::from_raw_parts(index, generation);
                let collider = self.world.colliders.get(handle)?;
                let shapes = shapes_of(collider, Pose::IDENTITY);
                (Seen::fixed(collider.position()), shapes)
            }
        };
        let mut guest = seen.built(own, shapes, settings);
        seen.hold(&mut guest, heaviest_kg);
        let mut velocities = seen.velocities;
        if let Own::Body(handle) = own {
            let met = self.met.entry(handle).or_default();
            if !std::mem::replace(&mut met.is_here, true) {
                *met = Met {
                    before: velocities,
                    by_rapier: met.by_rapier,
                    foreseen: met.foreseen,
                    is_here: true,
                    ..Met::default()
                };
            }
            // What met it before in this step.
            velocities.0 += met.change.0;
            velocities.1 += met.change.1;
            guest.pushes.push(seen.foreseen(met, settings.dt_s));
        }
        for state in [
            &mut guest.state,
            &mut guest.before,
            &mut guest.middle,
            &mut guest.ahead,
        ] {
            (state.velocity_m_s, state.angular_rad_s) = velocities;
        }
        Some(guest)
    }
}

impl Seen {
    fn fixed(floor_from_body: &Pose) -> Self {
        Self {
            floor_from_body: convert::isometry(floor_from_body),
            mass: MassProperties {
                mass_kg: 1.0,
                center_of_mass_m: Vector3::zeros(),
                inertia_kg_m2: Matrix3::identity(),
            },
            velocities: (Vector3::zeros(), Vector3::zeros()),
            locked: [true; 6],
        }
    }

    fn of(body: &RigidBody, dt_s: f64) -> Self {
        let of = &body.mass_properties().local_mprops;
        let mut seen = Self::fixed(body.position());
        seen.mass.center_of_mass_m = convert::to_f64(of.local_com);
        seen.velocities = velocities(body, dt_s);
        if !body.is_dynamic() {
            return seen;
        }
        let flags = body.locked_axes();
        let weighs = of.inv_mass > 0.0;
        let turns = of.inv_principal_inertia.cmpgt(Vector::ZERO).all();
        if weighs {
            seen.mass.mass_kg = 1.0 / f64::from(of.inv_mass);
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
    fn built(&self, own: Own, shapes: Vec<BodyShape>, settings: &Settings) -> Articulated {
        let around = shapes.iter().fold(Bounds::NONE, |around, of| {
            let bounds = of.shape.compute_local_aabb();
            let size = convert::to_f64(bounds.extents());
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
        guest.free = Some(Box::new(Free {
            id: FreeBodyId(u32::MAX),
            name: Arc::from(""),
            friction: 0.0,
            friction_on_robots: 0.0,
            slow_s: 0.0,
            from_robots: Vector3::zeros(),
            work_j: 0.0,
            guest: Some(Box::new(Guest::of(own))),
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

    /// What rapier will do to it, as a push in the step.
    fn foreseen(&self, met: &Met, dt_s: f64) -> ActingPush {
        let turn = self.floor_from_body.rotation.to_rotation_matrix();
        let inertia = turn * self.mass.inertia_kg_m2 * turn.transpose();
        ActingPush {
            force_n: self.mass.mass_kg * met.foreseen.0 / dt_s,
            lever_m: Vector3::zeros(),
            moment_n_m: inertia * met.foreseen.1 / dt_s,
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
        friction: Some(f64::from(collider.friction().max(0.0))),
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
            convert::to_f64(body.linvel()),
            convert::to_f64(body.angvel()),
        );
    }
    // It goes where the program wants it by the end of the step.
    let (from, to) = (
        convert::isometry(body.position()),
        convert::isometry(body.next_position()),
    );
    let center = Point3::from(convert::to_f64(body.local_center_of_mass()));
    let turned = to.rotation * from.rotation.inverse();
    (
        ((to * center) - (from * center)) / dt_s,
        turned.scaled_axis() / dt_s,
    )
}

/// The handle of a body by its key.
pub(super) fn body_of((index, generation): Raw) -> RigidBodyHandle {
    RigidBodyHandle::from_raw_parts(index, generation)
}
