//! Free bodies that are not near a robot: which are solved together, and which sleep.
//!
//! Robots and the free bodies near them are one problem; free bodies near one another and far from
//! robots are an island. So the cost of a step depends on the moving bodies only. An island in
//! which everything has been slow for a while sleeps with its contacts, until something awake comes
//! near, pushes it, or changes the floor: then it continues from there.

use std::collections::BTreeMap;

use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::Bvh;

use crate::contact::reactions::Reactions;
use crate::contact::search::bounds::Bounds;
use crate::contact::search::free_bodies::{solids, travel_m};
use crate::engine::convert;
use crate::free::FreeBodyId;
use crate::robot::articulated::Articulated;
use crate::settings::NEAR;

/// Groups separate at this multiple of the distance at which they join. Chosen.
const APART: f64 = 3.0;

/// The free bodies that are not near a robot.
#[derive(Clone, Default)]
pub(in crate::world) struct Islands {
    next: u32,
    /// The identities of all free bodies, in order.
    ids: Vec<FreeBodyId>,
    pub(super) awake: Vec<Island>,
    pub(super) asleep: BTreeMap<u32, Island>,
    /// The island of each sleeping body.
    pub(super) homes: BTreeMap<FreeBodyId, u32>,
    next_home: u32,
    /// Bounding boxes of the sleeping islands.
    pub(super) tree: Bvh,
    /// Kinetic and potential energy of all sleeping bodies, in J.
    asleep_j: (f64, f64),
}

/// Free bodies that are solved together.
#[derive(Clone)]
pub(super) struct Island {
    pub bodies: Vec<Articulated>,
    pub reactions: Reactions,
    pub springs_j: f64,
    /// Whether all bodies were put down at rest, and have not been tested yet.
    pub is_new: bool,
    /// While it sleeps.
    kinetic_j: f64,
    potential_j: f64,
}

impl Islands {
    pub fn next_id(&self) -> FreeBodyId {
        FreeBodyId(self.next)
    }

    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    pub fn ids(&self) -> &[FreeBodyId] {
        &self.ids
    }

    /// Removes an identity.
    pub fn forget(&mut self, id: FreeBodyId) {
        self.ids.retain(|of| *of != id);
    }

    pub fn add(&mut self, body: Articulated, at_rest: bool) {
        self.ids.push(self.next_id());
        self.next += 1;
        let mut island = Island::of(vec![body], Reactions::default());
        island.is_new = at_rest;
        self.awake.push(island);
    }

    /// A body that is here, and whether it sleeps.
    pub fn find(&self, id: FreeBodyId) -> Option<(&Articulated, bool)> {
        let of = |island: &'_ Island| place_among(&island.bodies, id);
        if let Some(home) = self.homes.get(&id) {
            let island = &self.asleep[home];
            return of(island).map(|at| (&island.bodies[at], true));
        }
        let awake = self.awake.iter();
        awake
            .flat_map(|island| of(island).map(|at| (&island.bodies[at], false)))
            .next()
    }

    pub fn awake_mut(&mut self, id: FreeBodyId) -> Option<&mut Articulated> {
        let awake = self.awake.iter_mut().flat_map(|of| &mut of.bodies);
        awake.into_iter().find(|body| id_of(body) == Some(id))
    }

    /// Removes an awake body.
    pub fn remove(&mut self, id: FreeBodyId) -> Option<Articulated> {
        for (index, island) in self.awake.iter_mut().enumerate() {
            if let Some(at) = place_among(&island.bodies, id) {
                island.reactions.split_off(|body| body != at);
                let gone = island.bodies.remove(at);
                if island.bodies.is_empty() {
                    self.awake.remove(index);
                }
                return Some(gone);
            }
        }
        None
    }

    /// All bodies.
    pub fn bodies(&self) -> impl Iterator<Item = &Articulated> {
        let all = self.awake.iter().chain(self.asleep.values());
        all.flat_map(|island| &island.bodies)
    }

    /// Awake bodies.
    pub fn awake(&self) -> impl Iterator<Item = &Articulated> {
        self.awake.iter().flat_map(|island| &island.bodies)
    }

    /// Energy in the contacts of awake bodies, in J.
    pub fn springs_j(&self) -> f64 {
        self.awake.iter().map(|island| island.springs_j).sum()
    }

    /// Kinetic and potential energy of sleeping bodies, in J.
    pub fn asleep_j(&self) -> (f64, f64) {
        self.asleep_j
    }

    /// Wakes a sleeping island.
    pub(super) fn wake(&mut self, home: u32) -> Option<Island> {
        let mut island = self.asleep.remove(&home)?;
        self.tree.remove(home);
        for body in &mut island.bodies {
            if let Some(free) = body.free_mut() {
                free.slow_s = 0.0;
                self.homes.remove(&free.id);
            }
        }
        self.weigh();
        Some(island)
    }

    pub(super) fn let_sleep(&mut self, mut island: Island, (kinetic_j, potential_j): (f64, f64)) {
        let home = self.next_home;
        self.next_home += 1;
        (island.kinetic_j, island.potential_j) = (kinetic_j, potential_j);
        let all = island.bodies.iter();
        let around = all.fold(Bounds::NONE, |around, body| around.merged(&bounds(body)));
        self.tree.insert(aabb(&around), home);
        for id in island.bodies.iter().filter_map(id_of) {
            self.homes.insert(id, home);
        }
        self.asleep.insert(home, island);
        self.weigh();
    }

    /// Sums the energies of the sleeping bodies, always in the same order.
    fn weigh(&mut self) {
        let all = self.asleep.values();
        self.asleep_j = all.fold((0.0, 0.0), |(kinetic_j, potential_j), island| {
            (
                kinetic_j + island.kinetic_j,
                potential_j + island.potential_j,
            )
        });
    }
}

impl Island {
    /// Bodies with their reactions.
    pub fn of(bodies: Vec<Articulated>, reactions: Reactions) -> Self {
        Self {
            bodies,
            reactions,
            springs_j: 0.0,
            is_new: false,
            kinetic_j: 0.0,
            potential_j: 0.0,
        }
    }

    pub fn is_slow_for(&self, time_s: f64) -> bool {
        let mut free = self.bodies.iter().filter_map(Articulated::free);
        free.all(|free| free.slow_s >= time_s)
    }
}

impl Island {
    /// Splits off the parts that are separate from its first body and from all robots, as islands.
    pub fn split(mut self, dt_s: f64, parts: &mut Vec<Self>) -> Self {
        loop {
            let bounds = near(&self.bodies, dt_s, APART);
            let robots = self.bodies.iter().take_while(|body| body.is_robot());
            let mut linked: Vec<bool> = vec![false; self.bodies.len()];
            let first = robots.count().max(1);
            linked.iter_mut().take(first).for_each(|of| *of = true);
            let mut more = true;
            while more {
                more = false;
                for at in 0..bounds.len() {
                    let joins = |to: usize| linked[to] && bounds[to].meets(&bounds[at]);
                    if !linked[at] && (0..bounds.len()).any(joins) {
                        linked[at] = true;
                        more = true;
                    }
                }
            }
            if linked.iter().all(|of| *of) {
                return self;
            }
            let reactions = self.reactions.split_off(|body| linked[body]);
            let mut left = Vec::new();
            let mut kept = Vec::new();
            for (body, linked) in self.bodies.into_iter().zip(linked) {
                if linked { &mut kept } else { &mut left }.push(body);
            }
            self.bodies = kept;
            let first = Self::of(left, reactions).split(dt_s, parts);
            parts.push(first);
        }
    }
}

/// Appends bodies with their reactions.
pub(super) fn absorb(
    (bodies, reactions): (&mut Vec<Articulated>, &mut Reactions),
    (more, of_more): (Vec<Articulated>, Reactions),
) {
    reactions.append(of_more, bodies.len());
    bodies.extend(more);
}

/// The identity of a free body; `None` for a robot.
pub(in crate::world) fn id_of(body: &Articulated) -> Option<FreeBodyId> {
    body.free().map(|free| free.id)
}

/// The index of a free body among bodies.
pub(in crate::world) fn place_among(bodies: &[Articulated], id: FreeBodyId) -> Option<usize> {
    bodies.iter().position(|body| id_of(body) == Some(id))
}

/// The bounding box of a body, including its wheels.
pub(super) fn bounds(body: &Articulated) -> Bounds {
    bounds_of_parts(body).fold(Bounds::NONE, |around, of| around.merged(&of))
}

/// The bounding boxes of a body's solids and wheels.
pub(super) fn bounds_of_parts(body: &Articulated) -> impl Iterator<Item = Bounds> {
    let solids = solids(body, &body.state).map(|solid| solid.bounds());
    let hubs = body.state.hubs().iter().zip(&body.wheels);
    solids.chain(hubs.map(|(hub, wheel)| Bounds::of_ball(&hub.center_m, wheel.reach_m)))
}

/// Boxes around bodies, within which they may be near another one in the coming step, enlarged by a
/// factor.
pub(in crate::world) fn near(bodies: &[Articulated], dt_s: f64, times: f64) -> Vec<Bounds> {
    let around = |body: &Articulated| {
        let rates = body.state.wheel_rates_rad_s().iter().zip(&body.wheels);
        let rims_m_s = rates.map(|(rate, wheel)| rate.abs() * wheel.reach_m);
        let rims_m = dt_s * rims_m_s.fold(0.0, f64::max);
        let reach_m =
            NEAR * body.scale.length_m + 2.0 * (travel_m(body, &body.state, dt_s) + rims_m);
        bounds(body).grown(times * reach_m)
    };
    bodies.iter().map(around).collect()
}

pub(super) fn meet(some: &[Bounds], others: &[Bounds]) -> bool {
    some.iter()
        .any(|one| others.iter().any(|other| one.meets(other)))
}

/// The same box as parry's.
pub(in crate::world) fn aabb(bounds: &Bounds) -> Aabb {
    Aabb::new(
        convert::vector(&bounds.least_m),
        convert::vector(&bounds.most_m),
    )
}
