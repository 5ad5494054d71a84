//! Which bodies are solved together, and which sleep.
//!
//! Robots and the free bodies near them are one problem; free bodies near one another and far from robots are an island of their own. So a
//! step costs what moves, and not what lies about. An island in which all has been slow for a while sleeps as it is, with its contacts, until
//! something that is awake comes near, pushes it, or changes the floor: then it goes on from there.

use std::collections::BTreeMap;
use std::mem::swap;

use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::Bvh;

use super::{id_of, place_among};
use crate::contact::beside::{solids, travel_m};
use crate::contact::reactions::Reactions;
use crate::contact::solid::Bounds;
use crate::engine::convert;
use crate::free::FreeBodyId;
use crate::robot::articulated::Articulated;
use crate::world::{Energies, NEAR, ROOM, World};

/// Slower than this, in a body's unit of speed, is slow: 0.1 mm/s for a cube of 0.2 m.
const SLOW: f64 = 1e-4;
/// What has been slow for so long sleeps, in seconds.
const SLEEPS_AFTER_S: f64 = 0.5;
/// Steps between two looks at what has come apart.
const LOOKS_EVERY: u64 = 16;
/// Steps in which bodies that are put down at rest may show that they do not stay.
const TRIED: usize = 50;
/// What has come apart is further from each other than what comes together by this factor.
const APART: f64 = 3.0;

/// The free bodies that are not near a robot.
#[derive(Clone, Default)]
pub(in crate::world) struct Islands {
    next: u32,
    /// Of all free bodies, in order.
    ids: Vec<FreeBodyId>,
    awake: Vec<Island>,
    asleep: BTreeMap<u32, Island>,
    /// Where each body that sleeps does so.
    homes: BTreeMap<FreeBodyId, u32>,
    next_home: u32,
    /// Around each island that sleeps.
    tree: Bvh,
    /// Kinetic and potential energy of all that sleeps, in J.
    asleep_j: (f64, f64),
}

/// Free bodies that are solved together.
#[derive(Clone)]
struct Island {
    bodies: Vec<Articulated>,
    reactions: Reactions,
    springs_j: f64,
    /// Whether all has been put down at rest, and has not been tried yet.
    is_new: bool,
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

    /// A body with an identity is there no more.
    pub fn forget(&mut self, id: FreeBodyId) {
        self.ids.retain(|of| *of != id);
    }

    pub fn add(&mut self, body: Articulated, at_rest: bool) {
        self.ids.push(self.next_id());
        self.next += 1;
        self.awake.push(Island {
            bodies: vec![body],
            reactions: Reactions::default(),
            springs_j: 0.0,
            is_new: at_rest,
            kinetic_j: 0.0,
            potential_j: 0.0,
        });
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

    /// Takes a body out that is awake.
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

    /// Bodies that are not asleep.
    pub fn awake(&self) -> impl Iterator<Item = &Articulated> {
        self.awake.iter().flat_map(|island| &island.bodies)
    }

    /// Energy in the contacts of what is awake, in J.
    pub fn springs_j(&self) -> f64 {
        self.awake.iter().map(|island| island.springs_j).sum()
    }

    /// Kinetic and potential energy of what sleeps, in J.
    pub fn asleep_j(&self) -> (f64, f64) {
        self.asleep_j
    }

    /// Lets what sleeps in a place go on.
    fn wake(&mut self, home: u32) -> Option<Island> {
        let mut island = self.asleep.remove(&home)?;
        self.tree.remove(home);
        for body in &mut island.bodies {
            if let Some(free) = &mut body.free {
                free.slow_s = 0.0;
                self.homes.remove(&free.id);
            }
        }
        self.weigh();
        Some(island)
    }

    fn let_sleep(&mut self, mut island: Island, (kinetic_j, potential_j): (f64, f64)) {
        let home = self.next_home;
        self.next_home += 1;
        (island.kinetic_j, island.potential_j) = (kinetic_j, potential_j);
        let all = island.bodies.iter();
        let around = all.fold(Bounds::NONE, |around, body| around.merged(&bounds(body)));
        self.tree.insert(rounded(&around), home);
        for id in island.bodies.iter().filter_map(id_of) {
            self.homes.insert(id, home);
        }
        self.asleep.insert(home, island);
        self.weigh();
    }

    /// Adds up the energies of what sleeps, always in the same order.
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
    fn is_slow_for(&self, time_s: f64) -> bool {
        let mut free = self.bodies.iter().filter_map(|body| body.free.as_ref());
        free.all(|free| free.slow_s >= time_s)
    }
}

impl World {
    /// Finds out which bodies are to be solved together in the coming step, and wakes what something comes near to.
    pub(in crate::world) fn regroup(&mut self) {
        if self.islands.is_empty() {
            return;
        }
        if self.steps.is_multiple_of(LOOKS_EVERY) {
            self.take_apart();
        }
        self.put_together();
        self.try_new();
    }

    /// Steps all islands that are awake, and lets those sleep that have come to rest.
    pub(in crate::world) fn step_islands(&mut self) {
        for at in 0..self.islands.awake.len() {
            self.exchange(at);
            self.step_together();
            self.exchange(at);
        }
        let mut at = 0;
        while at < self.islands.awake.len() {
            if self.islands.awake[at].is_slow_for(SLEEPS_AFTER_S) {
                self.lay_down(at);
            } else {
                at += 1;
            }
        }
    }

    /// Says how long each free body among the bodies has been slow.
    pub(in crate::world) fn count_slow(&mut self, dt_s: f64) {
        for body in &mut self.bodies {
            let slow = is_slow(body);
            if let Some(free) = &mut body.free {
                free.slow_s = if slow { free.slow_s + dt_s } else { 0.0 };
            }
        }
    }

    /// Wakes the island of a body.
    pub(in crate::world) fn wake(&mut self, id: FreeBodyId) {
        if let Some(home) = self.islands.homes.get(&id).copied() {
            let woken = self.islands.wake(home);
            self.islands.awake.extend(woken);
        }
    }

    /// Wakes all that sleeps.
    pub(in crate::world) fn wake_all(&mut self) {
        while let Some(home) = self.islands.asleep.keys().next().copied() {
            let woken = self.islands.wake(home);
            self.islands.awake.extend(woken);
        }
    }

    fn lay_down(&mut self, at: usize) {
        let island = self.islands.awake.remove(at);
        let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
        let all = island.bodies.iter();
        let kinetic_j = all.clone().map(Articulated::kinetic_j).sum();
        let potential_j: f64 = all.map(|body| body.potential_j(&gravity)).sum();
        let potential_j = potential_j + island.springs_j;
        self.islands.let_sleep(island, (kinetic_j, potential_j));
    }

    /// Puts an island in the robots' place, or back.
    fn exchange(&mut self, at: usize) {
        let island = &mut self.islands.awake[at];
        swap(&mut self.bodies, &mut island.bodies);
        swap(&mut self.reactions, &mut island.reactions);
        swap(&mut self.energies.springs_j, &mut island.springs_j);
    }

    /// Joins what comes near to each other, until nothing does.
    fn put_together(&mut self) {
        let dt_s = self.settings.dt_s;
        loop {
            let robots = near(&self.bodies, dt_s, 1.0);
            let all = self.islands.awake.iter();
            let islands: Vec<Vec<Bounds>> = all.map(|of| near(&of.bodies, dt_s, 1.0)).collect();
            let woken = self.woken_by(std::iter::once(&robots).chain(&islands));
            if !woken.is_empty() {
                for home in woken {
                    let island = self.islands.wake(home);
                    self.islands.awake.extend(island);
                }
                continue;
            }
            if let Some(at) = islands.iter().position(|of| meet(of, &robots)) {
                let island = self.islands.awake.remove(at);
                self.energies.springs_j += island.springs_j;
                absorb(
                    (&mut self.bodies, &mut self.reactions),
                    (island.bodies, island.reactions),
                );
                continue;
            }
            let pair = (0..islands.len()).find_map(|one| {
                let mut others = one + 1..islands.len();
                let other = others.find(|other| meet(&islands[one], &islands[*other]))?;
                Some((one, other))
            });
            let Some((one, other)) = pair else {
                return;
            };
            let island = self.islands.awake.remove(other);
            let into = &mut self.islands.awake[one];
            into.springs_j += island.springs_j;
            into.is_new &= island.is_new;
            absorb(
                (&mut into.bodies, &mut into.reactions),
                (island.bodies, island.reactions),
            );
        }
    }

    /// The places of what sleeps and is near to something that is awake.
    fn woken_by<'a>(&self, awake: impl Iterator<Item = &'a Vec<Bounds>>) -> Vec<u32> {
        let mut woken = Vec::new();
        if self.islands.asleep.is_empty() {
            return woken;
        }
        for bounds in awake.flatten() {
            let around = rounded(bounds);
            for home in self.islands.tree.intersect_aabb(&around) {
                let island = &self.islands.asleep[&home];
                let asleep = near(&island.bodies, self.settings.dt_s, 1.0);
                if asleep.iter().any(|of| of.meets(bounds)) && !woken.contains(&home) {
                    woken.push(home);
                }
            }
        }
        woken.sort_unstable();
        woken
    }

    /// Parts what has come apart.
    fn take_apart(&mut self) {
        let only_robots = self.bodies.iter().all(|body| body.free.is_none());
        if only_robots && self.islands.awake.is_empty() {
            return;
        }
        let dt_s = self.settings.dt_s;
        let mut parts = Vec::new();
        let here = Island {
            bodies: std::mem::take(&mut self.bodies),
            reactions: std::mem::take(&mut self.reactions),
            springs_j: 0.0,
            is_new: false,
            kinetic_j: 0.0,
            potential_j: 0.0,
        };
        let robots = here.split(dt_s, &mut parts);
        (self.bodies, self.reactions) = (robots.bodies, robots.reactions);
        for island in std::mem::take(&mut self.islands.awake) {
            let first = island.split(dt_s, &mut parts);
            parts.push(first);
        }
        self.islands.awake = parts;
    }

    /// Lets islands sleep at once that were put down at rest, if they stay where they are.
    fn try_new(&mut self) {
        let mut at = 0;
        while at < self.islands.awake.len() {
            let island = &mut self.islands.awake[at];
            let is_pushed = island.bodies.iter().any(|body| !body.pushes.is_empty());
            if !std::mem::take(&mut island.is_new) || is_pushed {
                at += 1;
                continue;
            }
            let put_down = self.islands.awake[at].clone();
            let (energies, residual_m_s) = (self.energies, self.residual_m_s);
            self.exchange(at);
            let before_j = self.energy_here_j();
            let dt_s = self.settings.dt_s;
            let stays = ROOM.with_borrow_mut(|room| {
                self.reactions.swap_room(room);
                let stays = (0..TRIED).all(|step| {
                    self.advance(dt_s);
                    // First it settles into its contacts.
                    step < TRIED / 2 || self.bodies.iter().all(is_slow)
                });
                self.reactions.swap_room(room);
                stays
            });
            let sank_j = before_j - self.energy_here_j();
            let before = put_down.bodies.iter().zip(&self.bodies);
            let stays = stays && before.into_iter().all(|(then, now)| has_stayed(then, now));
            self.exchange(at);
            self.energies = energies;
            self.residual_m_s = residual_m_s;
            if stays {
                self.energies.impact_j += sank_j;
                self.lay_down(at);
            } else {
                self.islands.awake[at] = put_down;
                at += 1;
            }
        }
    }

    /// Energy of the bodies that are being stepped, in J.
    fn energy_here_j(&self) -> f64 {
        let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
        let all = self.bodies.iter();
        let of_all = all.map(|body| body.kinetic_j() + body.potential_j(&gravity));
        of_all.sum::<f64>() + self.energies.springs_j
    }
}

impl Island {
    /// Splits off what is apart from its first body and from all robots, as islands.
    fn split(mut self, dt_s: f64, parts: &mut Vec<Self>) -> Self {
        loop {
            let bounds = near(&self.bodies, dt_s, APART);
            let robots = self.bodies.iter().take_while(|body| body.free.is_none());
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
            let left = Self {
                bodies: left,
                reactions,
                springs_j: 0.0,
                is_new: false,
                kinetic_j: 0.0,
                potential_j: 0.0,
            };
            let first = left.split(dt_s, parts);
            parts.push(first);
        }
    }
}

/// Appends bodies with what acted on them.
fn absorb(
    (bodies, reactions): (&mut Vec<Articulated>, &mut Reactions),
    (more, of_more): (Vec<Articulated>, Reactions),
) {
    reactions.append(of_more, bodies.len());
    bodies.extend(more);
}

fn is_slow(body: &Articulated) -> bool {
    let turns_m_s = body.state.angular_rad_s.norm() * body.scale.length_m;
    body.state.velocity_m_s.norm() + turns_m_s < SLOW * body.scale.speed_m_s()
}

/// Whether a body is where it was but for what its contacts give.
fn has_stayed(then: &Articulated, now: &Articulated) -> bool {
    /// In its unit of length.
    const SETTLES: f64 = 1e-4;
    let moved_m = (now.state.center_m() - then.state.center_m()).norm();
    moved_m < SETTLES * now.scale.length_m
}

/// A box around a body, its wheels and all.
fn bounds(body: &Articulated) -> Bounds {
    let shapes = solids(body, &body.state).map(|solid| solid.bounds());
    let hubs = body.state.hubs().iter().zip(&body.wheels);
    let wheels = hubs.map(|(hub, wheel)| Bounds::of_ball(&hub.center_m, wheel.reach_m));
    shapes
        .chain(wheels)
        .fold(Bounds::NONE, |around, of| around.merged(&of))
}

/// Around each of some bodies, as far as it may be near to another in the coming step; some times as far.
fn near(bodies: &[Articulated], dt_s: f64, times: f64) -> Vec<Bounds> {
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

fn meet(some: &[Bounds], others: &[Bounds]) -> bool {
    some.iter()
        .any(|one| others.iter().any(|other| one.meets(other)))
}

/// As f32 has it, and no smaller.
fn rounded(bounds: &Bounds) -> Aabb {
    /// More than the rounding of a coordinate, of its size.
    const ROUNDED: f64 = 1e-6;
    let far_m = bounds.least_m.amax().max(bounds.most_m.amax());
    let grown = bounds.grown(ROUNDED * far_m);
    Aabb::new(
        convert::vector(&grown.least_m),
        convert::vector(&grown.most_m),
    )
}

impl Energies {
    /// What the islands have is not among the robots' own.
    pub(in crate::world) fn stored_in_contacts_j(&self, islands: &Islands) -> f64 {
        self.springs_j + self.treads_j + islands.springs_j()
    }
}
