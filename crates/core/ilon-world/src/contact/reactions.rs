//! The reactions between bodies, the ground and dry bearings in a step.
//!
//! Each body first moves as if nothing touched it, with its mass matrix, gravity, motors and the
//! forces of rotating frames ([`crate::dynamics`]). The impulses of ground and bearings are then
//! solved for, all at once and to a tolerance, and change the rates with which the step is taken.
//! Each contact is between body A and its partner B, the ground or another body, and its rows hold
//! entries for these two alone.
//!
//! **The middle of the step.** Impulses act, and velocities are measured, at the poses in the
//! middle of the step. A contact's law is about its velocity u_1 at the *end* of the step, in the
//! pose that it has then. With J the rows in the middle, q'_0 and q'_1 the rates before and after,
//! and J_0 and J_1 the rows in the poses at the start and at the end by q'_0,
//!
//! u_0 = J q'_0 - b,  u_1 = J q'_1 + b,  b = (J_1 - J_0) q'_0 / 2:
//!
//! b is the change of the velocity by the rotation of the frame in half a step. That is right to
//! second order, and a contact that sticks, u_0 = u_1 = 0, takes no energy: J (q'_0 + q'_1) / 2 =
//! (u_0 + u_1) / 2 = 0. Holding it in the frame at the start would take a power of m v^2 omega^2 dt
//! / 2 from a robot that turns without sliding. Along the normal b is left out, because a roller
//! that hands over does not leave its place by its rotation. A roller that came down takes over
//! anywhere within half a step of the start, and on average at it: its tangents' rows are J_0, and
//! b is all after it.
//!
//! **The work.** An impulse takes its product with the mean of the velocities before and after it,
//! which is exact for a step of constant inertia; for rollers that come down,
//! [`crate::contact::reactions::handover_impulse`] defines the velocities.
//!
//! **The compliance.** Every contact of a robot is a spring of the same stiffness k with a damper k
//! tau parallel to it, which only pushes: p / dt = -k g_1 - k tau u_1, with g_1 = g_0 + dt u_1 the
//! gap at the end. As a law between p and u_1: u_1 + g_0 / (dt + tau) + p / (k dt (dt + tau)) = 0.
//! A gap that is still open is not damped.
//!
//! **Hand-overs.** A roller that comes down within a step bears its share of the load N over all of
//! it. If every roller that comes down before the step's end were included, rollers would take over
//! half a step early on average, and with v the speed of the approach each would take an additional
//! energy of N v dt / 2. So a roller is included if it comes down in the first half, g_0 + dt u_1 /
//! 2 >= 0: some are then late by as much as others are early, and the remaining error has no bias.
//! Impacts, and contacts on bumps and edges that would be deep by then, are stopped before they are
//! in the ground: there the impact is more than the load over a step.
//!
//! **Lifetime.** [`Reactions`] are those of the last step: each world and island keeps them. A
//! [`ReactionSolver`] finds those of the next one, and keeps nothing.

mod assembly;
mod compliance;
pub(crate) mod handover_impulse;
mod joints;
mod landing;
mod last_step;
mod nonlinear_drives;
pub(crate) mod potential;
pub(crate) mod reaction;
pub(crate) mod response;
mod rolling;
pub(crate) mod row;
pub(crate) mod support;
pub(crate) mod wheel_contact;
pub(crate) mod wheel_tally;

use nalgebra::Vector3;

use crate::contact::law::{Curve, ImpulseProblem, Solver, SolverEffort};
use crate::contact::reactions::handover_impulse::{BodyResponse, HandoverImpulse};
use crate::contact::reactions::potential::{Axle, PotentialContact};
use crate::contact::reactions::reaction::Reaction;
use crate::contact::reactions::response::Responses;
use crate::contact::reactions::row::Row;
use crate::contact::scene::Scenes;
use crate::contact::search::candidate::Candidate;
use crate::contact::search::on_ground::Workspace;
pub(crate) use last_step::Reactions;

/// Finds the reactions of a part of a step. Each part refills all of it, so that a solver may serve
/// any number of worlds in turn. It is the only large object of a step.
#[derive(Debug, Default)]
pub(crate) struct ReactionSolver {
    /// Places where bodies are near something: of one body, and of all.
    found: Vec<Candidate>,
    nearby: Vec<Candidate>,
    /// These places as contacts.
    potential: Vec<PotentialContact>,
    workspace: Workspace,
    /// For each contact in order the gap in the middle of the step and at its start, in metres.
    gaps_m: Vec<(f64, f64)>,
    /// The axles of the rollers that may touch.
    axles: Vec<Axle>,
    /// The reactions, in the order of the problem's laws.
    all: Vec<Reaction>,
    /// Their violation of the laws, in m/s or rad/s.
    error: f64,
    /// Energy of treads that left the ground, in J.
    released_j: f64,
    rows: Vec<Row>,
    problem: ImpulseProblem,
    solver: Solver,
    responses: Responses,
    /// Implicit damping of each joint of all bodies: the loss of impulse per rate gained, in N m s
    /// per rad/s or N s per m/s.
    held_n_m_s2: Vec<f64>,
    freed_axles: Vec<f64>,
    /// Change of the rates by the reactions, by degree of freedom of all bodies, one after the
    /// other.
    change: Vec<f64>,
    handover: HandoverImpulse,
    /// Wheels and joints, each with its body and its index in the tree, whose motors and servos
    /// reach a limit within the step.
    driven: Vec<(usize, usize)>,
    curve: Curve,
}

/// A roller that something touched in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TouchedRoller {
    pub wheel: usize,
    pub roller: usize,
    /// Mean rate about its axis over the step, in rad/s.
    pub mean_rad_s: f64,
    /// Rate about its axis after the step, in rad/s.
    pub rate_rad_s: f64,
    /// Rate along its axle after the step, in m/s; 0 without play.
    pub slide_m_s: f64,
}

impl ReactionSolver {
    /// Solves for the reactions of the step that the bodies have just taken without any.
    pub fn react(&mut self, scenes: Scenes<'_>) {
        self.nearby.clear();
        self.find(scenes);
        self.react_again(scenes);
    }

    /// The same again, for bodies at the same places but with other rates.
    pub fn react_again(&mut self, scenes: Scenes<'_>) {
        self.forget_laws();
        self.driven.clear();
        // Which motors reach a limit is known once the step is solved; few do, and each is found at
        // most once.
        loop {
            self.assemble(scenes);
            self.responses.clear(scenes);
            self.solve(scenes);
            if !self.find_bounded_motors(scenes) {
                break;
            }
            self.forget_laws();
        }
        self.handover.clear(self.rows.len(), self.responses.dofs());
        if HandoverImpulse::happens(&self.all, scenes.bodies) {
            self.find_handover_impulse(scenes);
        }
        self.count_work(scenes.reactions);
    }

    /// Separates the jump of rollers that came down from the rest of the step.
    fn find_handover_impulse(&mut self, scenes: Scenes<'_>) {
        self.held_n_m_s2.clear();
        self.responses.find_of_joints(scenes);
        for scene in scenes.each() {
            self.held_n_m_s2.extend_from_slice(&scene.step.held_n_m_s2);
        }
        self.freed_axles.clear();
        let axles = self.axles.iter();
        self.freed_axles
            .extend(axles.map(|axle| axle.free_response - axle.response.unwrap_or(0.0)));
        let held = BodyResponse {
            rows: &self.rows,
            responses: &self.responses,
            held_n_m_s2: &self.held_n_m_s2,
            freed_axles: &self.freed_axles,
        };
        self.handover.find(&self.all, &self.problem, &held);
        self.responses.complete(scenes, self.handover.change_mut());
        let over = 1.0 - self.handover.share();
        for (row, of) in self.rows.iter().enumerate() {
            for (axle, c) in of.sides().filter_map(|side| side.axle) {
                let axle = &mut self.axles[axle];
                axle.start_rad_s += over * self.handover.impulse(row) * c * axle.free_response;
            }
        }
    }

    /// Counts the energy taken by each impulse.
    fn count_work(&mut self, last: &Reactions) {
        let mut row = 0;
        for reaction in &mut self.all {
            for k in 0..reaction.rows() {
                let velocities = (reaction.velocity_before[k], reaction.velocity_after[k]);
                reaction.taken_j[k] = self.handover.taken_j(row, reaction.impulse[k], velocities);
                row += 1;
            }
        }
        let mut left_j = last.treads_j();
        for reaction in &mut self.all {
            let Some(tread) = reaction.tread().copied() else {
                continue;
            };
            // Energy stored in a tread is returned later.
            let gained_j = |k: usize| tread.stored_j[k] - tread.stored_before_j[k];
            reaction.taken_j.x -= gained_j(0);
            reaction.taken_j.y -= gained_j(1);
            left_j -= tread.stored_before_j.iter().sum::<f64>();
        }
        self.released_j = left_j;
    }

    /// Hands the reactions over to the storage of the last step.
    pub fn keep_in(&mut self, last: &mut Reactions, dt_s: f64) {
        last.take_solved(&mut self.all, (self.error, self.released_j), dt_s);
    }

    /// Change of each rate of an articulated body by the reactions.
    pub fn change(&self, body: usize) -> &[f64] {
        &self.change[self.responses.dofs_of(body)]
    }

    /// Change of the rates of an articulated body from the beginning of the step to the start of
    /// the mean over it.
    pub fn start_change(&self, body: usize) -> impl Iterator<Item = f64> {
        self.handover.start_change(self.responses.dofs_of(body))
    }

    /// The rollers of an articulated body that something touched.
    pub fn touched(&self, body: usize) -> impl Iterator<Item = TouchedRoller> {
        let axles = self.axles.iter().filter(move |axle| axle.body == body);
        axles.map(|axle| TouchedRoller {
            wheel: axle.wheel,
            roller: axle.roller,
            mean_rad_s: 0.5 * (axle.start_rad_s + axle.rate_rad_s),
            rate_rad_s: axle.rate_rad_s,
            slide_m_s: axle.slide.rate_m_s,
        })
    }

    /// The violation of the laws, in m/s or rad/s.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// The cost of solving since the last call.
    pub fn take_effort(&mut self) -> SolverEffort {
        self.solver.take_effort()
    }

    /// Whether something pressed on an articulated body in the last step.
    pub fn press_on(&self, body: usize) -> bool {
        self.all.iter().any(|reaction| {
            reaction.rows() == 3 && reaction.impulse.x > 0.0 && reaction.touches(body)
        })
    }

    /// Removes the laws of the step, but keeps the places where bodies are near something.
    fn forget_laws(&mut self) {
        self.all.clear();
        self.rows.clear();
        self.axles.clear();
        self.problem.clear();
        self.gaps_m.clear();
    }

    /// Solves for the impulses.
    fn solve(&mut self, scenes: Scenes<'_>) {
        self.responses.find(&self.rows, scenes);
        let (axles, responses) = (&self.axles, &self.responses);
        self.problem
            .set_delassus(|row, w| responses.fill_w(axles, row, w));
        let is_plain = axles.iter().all(|axle| axle.responses() == [0.0; 2]);
        (self.problem).set_halves(if is_plain { &responses.columns } else { &[] });
        // The impulses of the last step are a good start.
        for law in 0..self.all.len() {
            let now = &self.all[law];
            // Rollers with treads may come and go in any order: each continues from its own
            // impulse.
            let continues = |other: &&Reaction| match now.tread() {
                Some(_) => (other.a, other.b) == (now.a, now.b),
                None => now.follows(other),
            };
            // Of several places of a pair each from its own.
            let place = self.all[..law].iter().filter(continues).count();
            let mut before = scenes.reactions.all().iter().filter(continues);
            if let Some(before) = before.nth(place) {
                self.problem.warm_start(law, before.impulse);
            }
        }
        self.error = self.solver.solve(&mut self.problem);
        self.take_solution(scenes.dt_s);
        self.responses.complete(scenes, &mut self.change);
    }

    /// Takes over the impulses, and half of their effect on the bodies' rates.
    fn take_solution(&mut self, dt_s: f64) {
        self.change.clear();
        self.change.resize(self.responses.dofs(), 0.0);
        let mut row = 0;
        for (law, reaction) in self.all.iter_mut().enumerate() {
            let rows = row..row + reaction.rows();
            let read = |of: &[f64]| {
                let mut read = Vector3::zeros();
                read.as_mut_slice()[..rows.len()].copy_from_slice(&of[rows.clone()]);
                read
            };
            let slides = reaction.compliance.is_some() && !self.problem.holds(law);
            let impulse = read(self.problem.impulses());
            let velocity = read(self.problem.velocities());
            reaction.take(impulse, velocity, slides, dt_s);
            for _ in rows {
                let impulse = self.problem.impulses()[row];
                self.responses.add_row(row, impulse, &mut self.change);
                for side in self.rows[row].sides() {
                    let Some((axle, c)) = side.axle else {
                        continue;
                    };
                    let axle = &mut self.axles[axle];
                    let [about, along] = axle.responses();
                    axle.rate_rad_s += impulse * c * about;
                    axle.slide.rate_m_s += impulse * side.slide * along;
                }
                row += 1;
            }
        }
    }
}
