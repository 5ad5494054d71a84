//! The world: bodies on the ground, and their steps.

mod advance;
mod body;
mod check;
mod check_joints;
mod disturbance;
mod equilibrium;
mod free;
mod standing;
#[cfg(test)]
mod tests;
mod truth;
mod user_bodies;

use std::cell::RefCell;

use ilon_robot::Pose as PlanarPose;

use crate::contact::law::SolverEffort;
use crate::contact::reactions::{ReactionSolver, Reactions};
use crate::ground::Ground;
use crate::reference::Reference;
use crate::robot::articulated::Articulated;
pub use crate::robot::payload::Payload;
use crate::robot::shared_robot::SharedRobot;
use crate::{ContactSolver, Floor, Settings, WorldError};
pub use body::{Body, BodyMut, BodyState, PlaceMotion};
pub use check_joints::longest_step_of_springs_s;
pub use disturbance::Push;
use free::islands::Islands;
pub use free::{FreeBodyState, RayHit};
use user_bodies::rapier_world::UserBodies;

/// Robots on the ground, usually one, and free bodies.
///
/// One step is: [`BodyMut::drive`] with the motors' torques, then [`World::step`]. The readable
/// values are the truth; sensors are not part of this crate.
///
/// A copy continues identically to the bit.
#[derive(Clone)]
pub struct World {
    ground: Ground,
    settings: Settings,
    /// The bodies on the ground: robots in the order of their identities, and then the free bodies
    /// near them.
    bodies: Vec<Articulated>,
    /// The robot in rapier, if rapier moves it.
    reference: Option<Box<Reference>>,
    /// The other free bodies.
    islands: Islands,
    /// The reactions between the bodies and the ground.
    reactions: Reactions,
    /// The rapier world with the user bodies, if the program has asked for it.
    user_bodies: Option<Box<UserBodies>>,
    energies: Energies,
    /// How the laws of contact were solved in the step.
    solution: ContactSolution,
    steps: u64,
    /// The part of the coming step that has already been simulated, in seconds.
    gone_s: f64,
}

thread_local! {
    /// The solver shared by the worlds of a thread. It is several times as large as a world: a
    /// fleet has one for each thread, not one for each robot, and it stays in the processor's
    /// cache.
    static SOLVER: RefCell<ReactionSolver> = RefCell::default();
}

/// Lends the thread's solver to `work`.
fn with_solver<T>(work: impl FnOnce(&mut ReactionSolver) -> T) -> T {
    SOLVER.with_borrow_mut(work)
}

/// How the laws of contact were solved in a step, of all bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ContactSolution {
    /// Largest violation of the laws, in m/s or rad/s.
    pub residual_m_s: f64,
    /// Number of contact searches and solutions: one in each part of the step, including discarded
    /// ones.
    pub searches: u32,
    /// Steps of Newton's method.
    pub newton_steps: u32,
    /// Number of times that Newton's method needed another start.
    pub restarts: u32,
    /// Number of times that a part of the step was discarded and taken in two, because something
    /// landed in it or its laws could not be satisfied.
    pub halvings: u32,
}

impl ContactSolution {
    fn add(&mut self, effort: SolverEffort) {
        self.newton_steps += effort.newton_steps;
        self.restarts += effort.restarts;
    }
}

/// Energies since the start, by kind, in J.
#[derive(Clone, Copy, Debug, Default)]
struct Energies {
    slip_j: f64,
    spin_up_j: f64,
    impact_j: f64,
    motor_j: f64,
    /// The positive part of that, motor by motor and step by step.
    motor_positive_j: f64,
    bearing_j: f64,
    outside_j: f64,
    /// In the springs of rigid contacts, current.
    springs_j: f64,
    /// In the treads of rollers, current.
    treads_j: f64,
}

impl Energies {
    /// Counts the work of one motor in a step, in J.
    fn count_motor(&mut self, work_j: f64) {
        self.motor_j += work_j;
        self.motor_positive_j += work_j.max(0.0);
    }
}

impl World {
    /// Builds a robot standing on a floor with its body frame at `start`, at rest, its wheels just
    /// touching. Many worlds of one robot share its constant parts if they are built from a
    /// [`SharedRobot`].
    ///
    /// On a slope `start` is in the slope's plane. On boxes and bumps the robot is lowered upright
    /// until the first of its wheels touches; the others fall the rest of the way in the first
    /// steps. A robot with joints begins in the equilibrium of springs, stops and the ground;
    /// [`Body::joint_positions`] has its deflections.
    ///
    /// # Errors
    /// [`WorldError`] if a setting or the floor is invalid, a roller has no shape, or at the start
    /// the robot would lie on its chassis, a wheel would hang by more than its radius, or a body on
    /// a joint would be in the ground.
    pub fn new(
        robot: impl Into<SharedRobot>,
        floor: &Floor,
        start: PlanarPose,
        settings: &Settings,
    ) -> Result<Self, WorldError> {
        Self::of_bodies([(robot.into(), start)], floor, settings)
    }

    /// Like [`World::new`], for several robots, each with its own start. Their chassis touch each
    /// other; rollers touch only the ground. [`World::bodies`] has their identities in the same
    /// order.
    ///
    /// # Errors
    /// Like [`World::new`]; also if two chassis would overlap at the start, if there is no robot,
    /// or if rapier solves the contacts, which it does for one robot only.
    pub fn of_bodies(
        robots: impl IntoIterator<Item = (SharedRobot, PlanarPose)>,
        floor: &Floor,
        settings: &Settings,
    ) -> Result<Self, WorldError> {
        let ground = Ground::of(floor);
        let mut bodies = Vec::with_capacity(1);
        for (robot, start) in robots {
            check::check(&robot, floor, settings)?;
            let on_plane = standing::on_plane(&robot, start);
            let mut body = Articulated::build(robot, &on_plane, settings);
            body.raise(standing::raised_m(&body, floor, &ground)?);
            bodies.push(body);
        }
        check::check_together(&bodies, &ground, settings)?;
        bodies
            .iter()
            .try_for_each(|body| check::check_links(body, &ground))?;
        let in_rapier = bodies
            .first()
            .filter(|_| settings.contacts == ContactSolver::Rapier);
        let reference = in_rapier.map(|robot| Box::new(Reference::new(robot, &ground, settings)));
        let mut world = Self {
            ground,
            settings: settings.clone(),
            bodies,
            reference,
            islands: Islands::default(),
            reactions: Reactions::default(),
            user_bodies: None,
            energies: Energies::default(),
            solution: ContactSolution::default(),
            steps: 0,
            gone_s: 0.0,
        };
        world.find_equilibrium();
        Ok(world)
    }

    /// Advances the world by one physics step; in parts if [`Settings::split_dt_s`] demands it.
    pub fn step(&mut self) {
        self.look_at_user_bodies();
        with_solver(|solver| {
            self.regroup(solver);
            self.solution = ContactSolution::default();
            self.step_together(solver);
            self.step_islands(solver);
        });
        self.step_user_bodies();
        self.steps += 1;
    }

    /// Advances the world by a time in seconds, at most a step; a part of a step if a host's own
    /// step ends within it.
    pub fn step_for(&mut self, part_s: f64) {
        let dt_s = self.settings.dt_s;
        if part_s >= dt_s {
            return self.step();
        }
        self.settings.dt_s = part_s;
        self.step();
        self.settings.dt_s = dt_s;
        self.steps -= 1;
        self.gone_s += part_s;
        if self.gone_s > dt_s * (1.0 - 1e-9) {
            self.gone_s = 0.0;
            self.steps += 1;
        }
    }

    /// Steps the bodies that are solved together.
    fn step_together(&mut self, solver: &mut ReactionSolver) {
        let hosts = self.bodies.len();
        self.couple_user_bodies();
        let dt_s = self.settings.dt_s;
        for body in &mut self.bodies {
            body.begin_step(dt_s);
        }
        let mut taken = 0;
        let mut left_s = dt_s;
        while left_s > 0.0 {
            let span_s = self.span_s(left_s);
            let parts = self.parts(span_s);
            for _ in 0..parts {
                self.advance(solver, span_s / f64::from(parts));
            }
            left_s -= span_s;
            taken += parts;
        }
        self.count_slow(dt_s);
        let in_parts = taken > 1 || self.solution.halvings > 0;
        for body in &mut self.bodies {
            body.end_step(in_parts, dt_s);
        }
        self.release_user_bodies(hosts);
    }

    /// Sums the results of the wheels in a part of the step.
    fn tally(&mut self, part_s: f64) {
        for body in &mut self.bodies {
            let wheels = body.done.counts.iter_mut().zip(&body.done.contacts);
            for ((counts, contact), torque_n_m) in wheels.zip(&body.done.acted_n_m) {
                counts.tally.add_part(contact, *torque_n_m, part_s);
            }
        }
    }

    /// The part of the remaining step until a servo's target reaches its aim: its rate jumps there.
    fn span_s(&self, left_s: f64) -> f64 {
        /// A shorter part, or a shorter remainder, as a share of the step, is not taken separately.
        /// Chosen.
        const LEAST: f64 = 1e-3;
        let catches_up = self.bodies.iter().map(Articulated::catches_up_s);
        let span_s = catches_up.fold(f64::INFINITY, f64::min);
        let least_s = LEAST * self.settings.dt_s;
        if (least_s..left_s - least_s).contains(&span_s) {
            span_s
        } else {
            left_s
        }
    }

    /// The number of parts into which a span of a step is split.
    fn parts(&self, span_s: f64) -> u32 {
        match self.settings.split_dt_s {
            Some(part_s) if self.reactions.slides_soon(&self.bodies) => {
                (span_s / part_s).ceil().max(1.0) as u32
            }
            _ => 1,
        }
    }
}
