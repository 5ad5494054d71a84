//! Determines which bodies are solved together in a step, which wake and which fall asleep.

use std::mem::{swap, take};

use super::islands::{Island, aabb, absorb, meet, near};
use crate::contact::reactions::ReactionSolver;
use crate::contact::search::bounds::Bounds;
use crate::free::FreeBodyId;
use crate::robot::articulated::Articulated;
use crate::world::World;

/// A body slower than this, in its unit of speed, is slow: 0.1 mm/s for a cube of 0.2 m. Chosen.
const SLOW: f64 = 1e-4;
/// The time after which a slow body falls asleep, in seconds. Chosen.
const SLEEPS_AFTER_S: f64 = 0.5;
/// Steps between two checks for groups that have come apart. Chosen.
const LOOKS_EVERY: u64 = 16;
/// Steps in which bodies put down at rest are tested for staying there. Chosen.
const TRIED: usize = 50;

impl World {
    /// Determines which bodies are solved together in the coming step, and wakes bodies that
    /// something approaches.
    pub(in crate::world) fn regroup(&mut self, solver: &mut ReactionSolver) {
        if self.islands.is_empty() {
            return;
        }
        if self.steps.is_multiple_of(LOOKS_EVERY) {
            self.take_apart();
        }
        self.put_together();
        self.try_new(solver);
    }

    /// Steps all islands that are awake, and puts those at rest to sleep.
    pub(in crate::world) fn step_islands(&mut self, solver: &mut ReactionSolver) {
        for at in 0..self.islands.awake.len() {
            self.exchange(at);
            self.step_together(solver);
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

    /// Updates for how long each free body has been slow.
    pub(in crate::world) fn count_slow(&mut self, dt_s: f64) {
        for body in &mut self.bodies {
            let slow = is_slow(body);
            if let Some(free) = body.free_mut() {
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

    /// Wakes all sleeping bodies.
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

    /// Exchanges an island with the robots' group.
    fn exchange(&mut self, at: usize) {
        let island = &mut self.islands.awake[at];
        swap(&mut self.bodies, &mut island.bodies);
        swap(&mut self.reactions, &mut island.reactions);
        swap(&mut self.energies.springs_j, &mut island.springs_j);
    }

    /// Joins groups that are near each other, until none are.
    fn put_together(&mut self) {
        let dt_s = self.settings.dt_s;
        let user = self.moving_user_bodies();
        // Two bodies with a user body between them are solved together, too.
        let meet = |one: &[Bounds], other: &[Bounds]| {
            let is_between = |of: &Bounds| {
                let of = std::slice::from_ref(of);
                meet(of, one) && meet(of, other)
            };
            meet(one, other) || user.iter().any(is_between)
        };
        loop {
            let robots = near(&self.bodies, dt_s, 1.0);
            let all = self.islands.awake.iter();
            let islands: Vec<Vec<Bounds>> = all.map(|of| near(&of.bodies, dt_s, 1.0)).collect();
            let woken = self.woken_by([&robots, &user].into_iter().chain(&islands));
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

    /// The sleeping islands near something that is awake.
    fn woken_by<'a>(&self, awake: impl Iterator<Item = &'a Vec<Bounds>>) -> Vec<u32> {
        let mut woken = Vec::new();
        if self.islands.asleep.is_empty() {
            return woken;
        }
        for bounds in awake.flatten() {
            let around = aabb(bounds);
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

    /// Separates groups that have come apart.
    fn take_apart(&mut self) {
        let only_robots = self.bodies.iter().all(Articulated::is_robot);
        if only_robots && self.islands.awake.is_empty() {
            return;
        }
        let dt_s = self.settings.dt_s;
        let mut parts = Vec::new();
        let here = Island::of(take(&mut self.bodies), take(&mut self.reactions));
        let robots = here.split(dt_s, &mut parts);
        (self.bodies, self.reactions) = (robots.bodies, robots.reactions);
        for island in take(&mut self.islands.awake) {
            let first = island.split(dt_s, &mut parts);
            parts.push(first);
        }
        self.islands.awake = parts;
    }

    /// Puts islands of bodies put down at rest to sleep at once, if they stay in place.
    fn try_new(&mut self, solver: &mut ReactionSolver) {
        let mut at = 0;
        while at < self.islands.awake.len() {
            let island = &mut self.islands.awake[at];
            let is_pushed = island
                .bodies
                .iter()
                .any(|body| !body.command.pushes.is_empty());
            if !take(&mut island.is_new) || is_pushed {
                at += 1;
                continue;
            }
            let put_down = self.islands.awake[at].clone();
            let (energies, solution) = (self.energies, self.solution);
            self.exchange(at);
            let before_j = self.energy_here_j();
            let dt_s = self.settings.dt_s;
            let stays = (0..TRIED).all(|step| {
                self.advance(solver, dt_s);
                // First it settles into its contacts.
                step < TRIED / 2 || self.bodies.iter().all(is_slow)
            });
            let sank_j = before_j - self.energy_here_j();
            let before = put_down.bodies.iter().zip(&self.bodies);
            let stays = stays && before.into_iter().all(|(then, now)| has_stayed(then, now));
            self.exchange(at);
            self.energies = energies;
            self.solution = solution;
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

fn is_slow(body: &Articulated) -> bool {
    let turns_m_s = body.state.angular_rad_s.norm() * body.scale.length_m;
    body.state.velocity_m_s.norm() + turns_m_s < SLOW * body.scale.speed_m_s()
}

/// Whether a body is in its place, except for the deflection of its contacts.
fn has_stayed(then: &Articulated, now: &Articulated) -> bool {
    /// In its unit of length. Chosen.
    const SETTLES: f64 = 1e-4;
    let moved_m = (now.state.center_m() - then.state.center_m()).norm();
    moved_m < SETTLES * now.scale.length_m
}
