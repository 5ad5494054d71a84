//! What the ground and dry bearings do to the robot in a step.
//!
//! rapier moves chassis and hubs as if nothing touched them: their mass matrix, gravity, motors and the forces of turning
//! frames. The impulses of ground and bearings that follow are solved for here, all at once and to the end, and change the
//! rates with which the step is taken.
//!
//! **The middle of the step.** Impulses act, and velocities are measured, at the poses in the middle of the step. What a
//! contact's law speaks of is its velocity u_1 at the *end* of the step, in the pose that it has then. With J the rows in
//! the middle, q'_0 and q'_1 the rates before and after, and J_0 and J_1 the rows in the poses at the start and where q'_0
//! leads by the end,
//!
//! u_0 = J q'_0 - b,  u_1 = J q'_1 + b,  b = (J_1 - J_0) q'_0 / 2:
//!
//! b is what the turning of the frame does to the velocity in half a step. That is right to second order, and a contact
//! that is held, u_0 = u_1 = 0, takes no energy: J (q'_0 + q'_1) / 2 = (u_0 + u_1) / 2 = 0. To hold it in the frame at the
//! start would take m v^2 omega^2 dt / 2 of power from a robot in a turn in which nothing slides. Across the ground b is
//! left out: a roller that hands over leaves its place there in another way than it turns. A roller that came down takes
//! over anywhere within half a step of the start, and on average at it: its tangents' rows are J_0, and b is all after it.
//!
//! **The work.** An impulse takes its product with the mean of the velocities before and after it, which is exact for a
//! step of constant inertia; where rollers come down, [`crate::contact::jump`] says of which velocities.
//!
//! **The compliance.** Every contact is a spring of the same stiffness k with a damper k tau beside it, which only pushes:
//! p / dt = -k g_1 - k tau u_1, with g_1 = g_0 + dt u_1 the gap to come. As a law between p and u_1:
//! u_1 + g_0 / (dt + tau) + p / (k dt (dt + tau)) = 0. A gap that is still open is not damped.

use ilon_robot::Robot;
use nalgebra::{DMatrixViewMut, Vector3};
use rapier3d::prelude::*;

use crate::contact::candidates::{Candidate, Workspace, frame};
use crate::contact::jump::{Jump, Responses};
use crate::contact::problem::{ImpulseProblem, Law};
use crate::contact::reaction::{Part, Reaction};
use crate::ground::Ground;
use crate::robot::assembly::Assembly;
use crate::robot::state::State;
use crate::{MotorTorque, Settings};

/// A contact that would still open at this rate, in m/s, after a step without impulses is none: other contacts do not
/// change it by as much, unless they have to stop more. It spares rough ground most of its foreseen contacts.
const OPEN_M_S: f64 = 0.1;

/// What is deeper in the ground than its load explains is pushed out at this speed, in m/s: too slowly to bounce, 1 um.
const PUSH_OUT_M_S: f64 = 5e-3;

/// How a velocity follows from the robot's rates, and what a unit impulse there does to them: those of the chassis, of a
/// wheel, and of a roller about its axis.
#[derive(Clone, Copy, Debug)]
struct Row {
    chassis: [f64; 6],
    /// Degree of freedom and share.
    hub: Option<(usize, f64)>,
    /// Place among the axles and share.
    axle: Option<(usize, f64)>,
}

impl Row {
    /// The part of the velocity that chassis and wheel make, with these rates by degree of freedom.
    fn of_bodies(&self, rates: &[f64]) -> f64 {
        self.sum(|dof| rates[dof])
    }

    /// The same of rates as rapier has them.
    fn of_bodies_f32(&self, rates: &[Real]) -> f64 {
        self.sum(|dof| f64::from(rates[dof]))
    }

    fn sum(&self, rate: impl Fn(usize) -> f64) -> f64 {
        let chassis = self.chassis.iter().enumerate().map(|(i, c)| c * rate(i));
        chassis.sum::<f64>() + self.hub.map_or(0.0, |(dof, c)| c * rate(dof))
    }
}

/// A roller that may touch the ground.
#[derive(Clone, Copy, Debug)]
struct Axle {
    wheel: usize,
    roller: usize,
    /// Its axis in the middle of the step, in the floor's frame.
    axis: Vector3<f64>,
    /// Its rate about its axis when the step began, in rad/s.
    before_rad_s: f64,
    /// What it starts from once a jump is over.
    start_rad_s: f64,
    /// Its rate at the end of the step without any reaction, and then with them, in rad/s.
    rate_rad_s: f64,
    /// What an angular impulse of 1 N m s does to it, in rad/s; `None` where it turns with the hub because it has seized.
    response: Option<f64>,
    /// What it would do if its bearing did not act; 0 where it has seized.
    free_response: f64,
}

/// A place near the ground, as the contact that it would be.
#[derive(Clone, Copy, Debug)]
struct Foreseen {
    candidate: Candidate,
    /// Distance from the ground when the step began, in metres, as its velocity in the middle has it.
    gap_before_m: f64,
    /// Normal and two tangents.
    frame: [Vector3<f64>; 3],
    /// The share of an axle stands in them, its place among the axles not yet.
    rows: [Row; 3],
    axle: Option<Axle>,
    /// Velocity along the frame when the step began, in m/s.
    before: Vector3<f64>,
    /// And at its end without any reaction.
    free: Vector3<f64>,
}

/// The reactions of the last step, and room for those of the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reactions {
    found: Vec<Candidate>,
    nearby: Vec<Candidate>,
    foreseen: Vec<Foreseen>,
    workspace: Workspace,
    /// Of each contact in its order: how far from the ground it is in the middle of the step and was at its start.
    gaps_m: Vec<(f64, f64)>,
    /// Of the rollers that may touch.
    axles: Vec<Axle>,
    all: Vec<Reaction>,
    before: Vec<Reaction>,
    rows: Vec<Row>,
    problem: ImpulseProblem,
    /// What the unit impulse of each row does to every rate, row by row; and of each wheel, where that is needed.
    responses: Vec<Real>,
    wheel_responses: Vec<Real>,
    wheel_dofs: Vec<usize>,
    row_axles: Vec<Option<(usize, f64)>>,
    freed_axles: Vec<f64>,
    change: Vec<f64>,
    jump: Jump,
    error: f64,
}

/// Everything that a step's reactions depend on, as rapier left it.
pub(crate) struct Scene<'a> {
    pub rapier: &'a PhysicsWorld,
    pub ground: &'a Ground,
    pub robot: &'a Robot,
    pub assembly: &'a Assembly,
    pub settings: &'a Settings,
    /// How long the step is, in seconds.
    pub dt_s: f64,
    /// The robot when the step began.
    pub before: &'a State,
    /// Its poses in the middle of the step, with the rates of its beginning.
    pub middle: &'a State,
    /// And where these rates would take it by the end of the step.
    pub ahead: &'a State,
    /// Whether the step is short enough to see how rollers turn while they pass over the ground.
    pub sees_rollers_pass: bool,
    /// The rates of bodies when the step began, by degree of freedom.
    pub rates_before: &'a [f64],
    /// And at its end without any reaction.
    pub rates_free: &'a [f64],
    /// What the motors do.
    pub motors: &'a [MotorTorque],
    /// The torque of each wheel's motor that its gear takes a share of, in N m.
    pub geared_n_m: &'a [f64],
    /// What each wheel's motor and bearing lose of their impulse in the step per rate that it gains, in N m s per rad/s.
    pub held_n_m_s2: &'a [f64],
}

/// A roller that the ground touched in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TouchedRoller {
    pub wheel: usize,
    pub roller: usize,
    /// The mean of its rate about its axis over the step, in rad/s.
    pub mean_rad_s: f64,
    /// Its rate about its axis after the step, in rad/s.
    pub rate_rad_s: f64,
}

impl Reactions {
    /// Solves for the reactions of the step that rapier has just taken without any.
    pub fn react(&mut self, scene: &Scene<'_>) {
        self.clear();
        self.gather(scene);
        let multibody = &scene.rapier.multibody_joints[scene.assembly.multibody];
        let dofs = multibody.ndofs();
        let answer = |impulses: &mut [Real]| {
            let count = impulses.len() / dofs;
            let mut impulses = DMatrixViewMut::from_slice(impulses, dofs, count);
            multibody.inv_augmented_mass().solve_mut(&mut impulses);
        };
        self.solve(dofs, answer);
        self.jump.clear(self.rows.len(), dofs);
        if Jump::happens(&self.all) {
            self.find_jump(scene, dofs, answer);
        }
        self.count_work();
    }

    /// Tells the jump of rollers that came down apart from the rest of the step.
    fn find_jump(&mut self, scene: &Scene<'_>, dofs: usize, answer: impl FnOnce(&mut [Real])) {
        let wheels = scene.assembly.wheels.iter();
        self.wheel_dofs.clear();
        self.wheel_dofs.extend(wheels.map(|wheel| wheel.hub_dof));
        self.wheel_responses.clear();
        self.wheel_responses
            .resize(self.wheel_dofs.len() * dofs, 0.0);
        for (wheel, dof) in self.wheel_dofs.iter().enumerate() {
            self.wheel_responses[wheel * dofs + dof] = 1.0;
        }
        answer(&mut self.wheel_responses);
        self.row_axles.clear();
        self.row_axles.extend(self.rows.iter().map(|row| row.axle));
        self.freed_axles.clear();
        let axles = self.axles.iter();
        self.freed_axles
            .extend(axles.map(|axle| axle.free_response - axle.response.unwrap_or(0.0)));
        let responses = Responses {
            of_rows: &self.responses,
            of_wheels: &self.wheel_responses,
            wheel_dofs: &self.wheel_dofs,
            held_n_m_s2: scene.held_n_m_s2,
            axles: &self.row_axles,
            freed_axles: &self.freed_axles,
        };
        self.jump.find(&self.all, &self.problem, &responses);
        let over = 1.0 - self.jump.share();
        for (row, of) in self.rows.iter().enumerate() {
            if let Some((axle, c)) = of.axle {
                let axle = &mut self.axles[axle];
                axle.start_rad_s += over * self.jump.impulse(row) * c * axle.free_response;
            }
        }
    }

    /// Counts what each impulse took.
    fn count_work(&mut self) {
        let mut row = 0;
        for reaction in &mut self.all {
            for k in 0..reaction.rows() {
                let velocities = (reaction.velocity_before[k], reaction.velocity_after[k]);
                reaction.taken_j[k] = self.jump.taken_j(row, reaction.impulse[k], velocities);
                row += 1;
            }
        }
    }

    /// The jump of rollers that came down in the last step.
    pub fn jump(&self) -> &Jump {
        &self.jump
    }

    /// The reactions of the last step.
    pub fn all(&self) -> &[Reaction] {
        &self.all
    }

    /// By how much the reactions change each rate of the bodies.
    pub fn change(&self) -> &[f64] {
        &self.change
    }

    /// The rollers that the ground touched.
    pub fn touched(&self) -> impl Iterator<Item = TouchedRoller> {
        self.axles.iter().map(|axle| TouchedRoller {
            wheel: axle.wheel,
            roller: axle.roller,
            mean_rad_s: 0.5 * (axle.start_rad_s + axle.rate_rad_s),
            rate_rad_s: axle.rate_rad_s,
        })
    }

    /// By how much deeper than when it began the deepest contact would be in the ground at the end of the last step if the
    /// robot moved on with the mean of the rates, in metres.
    pub fn sinks_m(&self, dt_s: f64) -> f64 {
        let contacts = self.all.iter().filter(|reaction| reaction.rows() == 3);
        let sinks = contacts
            .zip(&self.gaps_m)
            .map(|(contact, (gap_m, before_m))| {
                let then_m = gap_m + 0.5 * dt_s * contact.velocity_after.x;
                before_m.min(0.0) - then_m
            });
        sinks.fold(0.0, f64::max)
    }

    /// Whether a roller is about to slide: its friction is near its limit, and it holds or has just begun to slide.
    pub fn about_to_slide(&self) -> bool {
        /// Near its limit, as a share of it.
        const NEAR_LIMIT: f64 = 0.5;
        /// A roller that slides faster has made up its mind, in m/s.
        const SLIDES_M_S: f64 = 0.03;
        self.all.iter().any(|reaction| {
            let limit = NEAR_LIMIT * reaction.friction * reaction.impulse.x;
            matches!(reaction.part, Part::Roller(..))
                && limit > 0.0
                && reaction.impulse.yz().norm() > limit
                && reaction.velocity_after.yz().norm() < SLIDES_M_S
        })
    }

    /// By how much the laws were broken in the last step, in m/s or rad/s.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Energy in the springs of the contacts, in J: F^2 / (2 k) each.
    pub fn spring_energy_j(&self, settings: &Settings, dt_s: f64) -> f64 {
        let force_n = |reaction: &Reaction| reaction.impulse.x / dt_s;
        let contacts = self.all.iter().filter(|reaction| reaction.rows() == 3);
        let squares: f64 = contacts.map(|reaction| force_n(reaction).powi(2)).sum();
        0.5 * squares / settings.contact_stiffness_n_m
    }

    fn clear(&mut self) {
        std::mem::swap(&mut self.all, &mut self.before);
        self.all.clear();
        self.rows.clear();
        self.axles.clear();
        self.problem.clear();
        self.nearby.clear();
        self.gaps_m.clear();
    }

    /// Collects all contacts and dry bearings.
    fn gather(&mut self, scene: &Scene<'_>) {
        scene.find_chassis(&mut self.found);
        self.nearby.append(&mut self.found);
        for wheel in 0..scene.robot.wheels.len() {
            scene.find_wheel(wheel, &mut self.workspace, &mut self.found);
            self.nearby.append(&mut self.found);
        }
        self.touch(scene);
        for (index, wheel) in scene.robot.wheels.iter().enumerate() {
            // A gear takes its share of the motor's torque, whichever of the two drives the other.
            let gear_n_m = (1.0 - wheel.drive.gear_efficiency) * scene.geared_n_m[index].abs();
            let friction_n_m = wheel.dry_friction_n_m() + gear_n_m;
            self.limit_motor(scene, index);
            if friction_n_m > 0.0 {
                let row = Row {
                    chassis: [0.0; 6],
                    hub: Some((scene.assembly.wheels[index].hub_dof, 1.0)),
                    axle: None,
                };
                self.hold_bearing(scene, Part::Hub(index), row, friction_n_m);
            }
        }
        for i in 0..self.axles.len() {
            let axle = self.axles[i];
            let body = &scene.assembly.wheels[axle.wheel];
            let friction_n_m = body.rollers[axle.roller].friction_n_m;
            if friction_n_m > 0.0 && axle.response.is_some() {
                // Its spin against the hub.
                let d = axle.axis;
                let along = d.dot(&scene.middle.hubs()[axle.wheel].axis());
                let row = Row {
                    chassis: [0.0, 0.0, 0.0, -d.x, -d.y, -d.z],
                    hub: Some((body.hub_dof, -along)),
                    axle: Some((i, 1.0)),
                };
                let part = Part::Axle(axle.wheel, axle.roller);
                self.hold_bearing(scene, part, row, friction_n_m);
            }
        }
    }

    /// Turns the places that are near the ground into contacts.
    fn touch(&mut self, scene: &Scene<'_>) {
        let settings = scene.settings;
        let relaxed_s = scene.dt_s + settings.contact_relaxation_s;
        let compliance = 1.0 / (settings.contact_stiffness_n_m * scene.dt_s * relaxed_s);
        let mut foreseen = std::mem::take(&mut self.foreseen);
        foreseen.clear();
        foreseen.extend(self.nearby.iter().map(|place| scene.foresee(place)));

        // What stops the one that comes in fastest may move the others by as much.
        let open_m_s =
            |contact: &Foreseen| contact.free.x + contact.gap_before_m.max(0.0) / scene.dt_s;
        let comes_m_s = foreseen.iter().map(open_m_s).fold(0.0, f64::min).abs();
        for contact in &foreseen {
            if open_m_s(contact) > OPEN_M_S + comes_m_s {
                continue;
            }
            let place = &contact.candidate;
            let before = self.impulse_before(place.part);
            let gap_m = contact.gap_before_m;
            let approach_m_s = if gap_m > 0.0 {
                gap_m / scene.dt_s
            } else {
                // No faster than what the spring was loaded with, and a little.
                let loaded_m_s = compliance * before.map_or(0.0, |impulse| impulse.x);
                (gap_m / relaxed_s).max(-loaded_m_s - PUSH_OUT_M_S)
            };
            let friction = scene.ground.friction_at(&place.place_m);
            let law = Law::Contact {
                friction,
                approach_m_s,
                compliance,
            };
            let rows = contact.rows.map(|row| Row {
                axle: contact
                    .axle
                    .and_then(|axle| Some((self.index_of(axle), row.axle?.1))),
                ..row
            });
            let reaction = Reaction {
                part: place.part,
                at_m: place.place_m,
                frame: contact.frame,
                friction,
                impulse: Vector3::zeros(),
                velocity_before: contact.before,
                velocity_after: Vector3::zeros(),
                taken_j: Vector3::zeros(),
                came_down: place.came_down,
                rolling_radius_m: rows[2].axle.map_or(0.0, |(_, radius_m)| radius_m),
            };
            self.push(law, reaction, &rows, contact.free.as_slice());
            self.gaps_m.push((place.gap_m, contact.gap_before_m));
        }
        self.foreseen = foreseen;
    }

    /// The place of a roller among those that may touch, where it is put if it is not there yet.
    fn index_of(&mut self, axle: Axle) -> usize {
        let of_this = |other: &Axle| (other.wheel, other.roller) == (axle.wheel, axle.roller);
        self.axles.iter().position(of_this).unwrap_or_else(|| {
            self.axles.push(axle);
            self.axles.len() - 1
        })
    }

    /// What acted in the last step on the part that a new reaction goes on from.
    fn impulse_before(&self, part: Part) -> Option<Vector3<f64>> {
        let place = self.all.iter().filter(|r| part.follows(r.part)).count();
        let mut before = self.before.iter().filter(|r| part.follows(r.part));
        before.nth(place).map(|reaction| reaction.impulse)
    }

    /// Adds a dry bearing.
    fn hold_bearing(&mut self, scene: &Scene<'_>, part: Part, row: Row, friction_n_m: f64) {
        let most_n_m_s = friction_n_m * scene.dt_s;
        let law = Law::Joint {
            least_n_m_s: -most_n_m_s,
            most_n_m_s,
        };
        self.hold_joint(scene, part, row, law, 0.0);
    }

    /// Keeps the motor of a wheel from driving it beyond its rate limit: of what it gives it takes back as much as that
    /// needs, and not more.
    fn limit_motor(&mut self, scene: &Scene<'_>, wheel: usize) {
        /// Below this share of its limit a wheel does not reach it within a step.
        const NEAR_LIMIT: f64 = 0.9;
        let (motor, dof) = (&scene.motors[wheel], scene.assembly.wheels[wheel].hub_dof);
        let (now_rad_s, free_rad_s) = (scene.rates_before[dof], scene.rates_free[dof]);
        let limit_rad_s = motor.rate_limit_rad_s.copysign(now_rad_s);
        if now_rad_s.abs().max(free_rad_s * limit_rad_s.signum())
            < NEAR_LIMIT * motor.rate_limit_rad_s
        {
            return;
        }
        let gives_n_m = motor.torque_n_m - motor.droop_n_m_s * (limit_rad_s - now_rad_s);
        let gives_n_m_s = gives_n_m * scene.dt_s;
        let law = Law::Joint {
            least_n_m_s: if limit_rad_s > 0.0 {
                -gives_n_m_s.max(0.0)
            } else {
                0.0
            },
            most_n_m_s: if limit_rad_s > 0.0 {
                0.0
            } else {
                -gives_n_m_s.min(0.0)
            },
        };
        let row = Row {
            chassis: [0.0; 6],
            hub: Some((dof, 1.0)),
            axle: None,
        };
        self.hold_joint(scene, Part::RateLimit(wheel), row, law, limit_rad_s);
    }

    /// Adds a joint whose rate is counted from another.
    fn hold_joint(&mut self, scene: &Scene<'_>, part: Part, row: Row, law: Law, from_rad_s: f64) {
        let rate = |rates: &[f64], of_axle: fn(&Axle) -> f64| {
            row.of_bodies(rates) + row.axle.map_or(0.0, |(i, c)| c * of_axle(&self.axles[i]))
        };
        let before = rate(scene.rates_before, |axle| axle.before_rad_s);
        let free = rate(scene.rates_free, |axle| axle.rate_rad_s);
        let reaction = Reaction {
            part,
            at_m: Vector3::zeros(),
            frame: [Vector3::zeros(); 3],
            friction: 0.0,
            impulse: Vector3::zeros(),
            velocity_before: Vector3::new(before - from_rad_s, 0.0, 0.0),
            velocity_after: Vector3::zeros(),
            taken_j: Vector3::zeros(),
            came_down: false,
            rolling_radius_m: 0.0,
        };
        self.push(law, reaction, &[row], &[free - from_rad_s]);
    }

    /// Adds a law and where it acts.
    fn push(&mut self, law: Law, reaction: Reaction, rows: &[Row], free: &[f64]) {
        self.problem.push(law, free);
        self.rows.extend_from_slice(rows);
        self.all.push(reaction);
    }

    /// Solves for the impulses, given how impulses answer: `solve` takes generalised impulses, one of `dofs` numbers
    /// after the other, to the rates that they give.
    fn solve(&mut self, dofs: usize, solve: impl FnOnce(&mut [Real])) {
        let rows = self.rows.len();
        self.responses.clear();
        self.responses.resize(rows * dofs, 0.0);
        for (row, impulse) in self.rows.iter().zip(self.responses.chunks_exact_mut(dofs)) {
            for (dof, c) in row.chassis.iter().enumerate() {
                impulse[dof] = *c as Real;
            }
            if let Some((dof, c)) = row.hub {
                impulse[dof] = c as Real;
            }
        }
        solve(&mut self.responses);
        let (rows, axles, responses) = (&self.rows, &self.axles, &self.responses);
        self.problem.set_response(|row, column| {
            let (at, by) = (&rows[row], &rows[column]);
            let response = &responses[column * dofs..][..dofs];
            let of_bodies = at.of_bodies_f32(response);
            match (at.axle, by.axle) {
                (Some((i, a)), Some((j, b))) if i == j => {
                    of_bodies + a * b * axles[i].response.unwrap_or(0.0)
                }
                _ => of_bodies,
            }
        });
        // What acted in the last step is most of what acts in this one.
        for law in 0..self.all.len() {
            let part = self.all[law].part;
            let place = self.all[..law]
                .iter()
                .filter(|other| part.follows(other.part))
                .count();
            let mut before = self.before.iter().filter(|other| part.follows(other.part));
            if let Some(before) = before.nth(place) {
                self.problem.suppose_within(law, before.impulse);
            }
        }
        self.error = self.problem.solve();
        self.take_solution(dofs);
    }

    /// Takes the impulses over, and what they do.
    fn take_solution(&mut self, dofs: usize) {
        self.change.clear();
        self.change.resize(dofs, 0.0);
        let mut row = 0;
        for reaction in &mut self.all {
            for k in 0..reaction.rows() {
                let impulse = self.problem.impulses()[row];
                reaction.impulse[k] = impulse;
                reaction.velocity_after[k] = self.problem.velocities()[row];
                let response = &self.responses[row * dofs..][..dofs];
                for (change, rate) in self.change.iter_mut().zip(response) {
                    *change += impulse * f64::from(*rate);
                }
                if let Some((axle, c)) = self.rows[row].axle {
                    let axle = &mut self.axles[axle];
                    axle.rate_rad_s += impulse * c * axle.response.unwrap_or(0.0);
                }
                row += 1;
            }
        }
    }
}

impl Scene<'_> {
    /// What a place near the ground would be as a contact.
    fn foresee(&self, place: &Candidate) -> Foreseen {
        let axle = self.axle(place.part);
        let in_the_middle = frame(place.normal, place.along);
        let row = |direction: Vector3<f64>| self.row(place, self.middle, place.place_m, direction);
        let (frame, rows) = match place.turning.came_down_at_m {
            Some(at_m) => {
                // A roller that came down: its tangents as they were then. Across the ground it is where it is now.
                let axes = frame(place.normal, self.axis_of(place.part, self.before));
                let tangent = |direction| self.row(place, self.before, at_m, direction);
                (axes, [row(axes[0]), tangent(axes[1]), tangent(axes[2])])
            }
            None => (in_the_middle, in_the_middle.map(row)),
        };
        let velocities = |rates: &[f64], axle_rad_s: Option<f64>| {
            let of = |row: &Row| {
                let of_axle = (row.axle.zip(axle_rad_s)).map_or(0.0, |((_, c), rate)| c * rate);
                row.of_bodies(rates) + of_axle
            };
            Vector3::new(of(&rows[0]), of(&rows[1]), of(&rows[2]))
        };
        let tangential = |v: &Vector3<f64>| Vector3::new(0.0, v.y, v.z);
        let turning = &place.turning;
        let now = velocities(self.rates_before, axle.map(|a| a.before_rad_s));
        let free = velocities(self.rates_free, axle.map(|a| a.rate_rad_s));
        Foreseen {
            candidate: *place,
            gap_before_m: place.gap_m - 0.5 * self.dt_s * now.x,
            frame,
            rows,
            before: now - tangential(&turning.until_m_s),
            free: free + tangential(&turning.from_m_s),
            axle,
        }
    }

    /// The axis of a part's roller in a state, in the floor's frame; any direction of what is none.
    fn axis_of(&self, part: Part, state: &State) -> Vector3<f64> {
        match part {
            Part::Roller(wheel, roller) => {
                let axis_in_hub = self.assembly.wheels[wheel].rollers[roller].axis_in_hub;
                state.hubs()[wheel].rotation * axis_in_hub
            }
            _ => Vector3::x(),
        }
    }

    /// The roller of a part, if it is one's, with the rate that it has without reactions.
    fn axle(&self, part: Part) -> Option<Axle> {
        let Part::Roller(wheel, roller) = part else {
            return None;
        };
        let state = &self.assembly.wheels[wheel].rollers[roller];
        let hub = &self.middle.hubs()[wheel];
        Some(Axle {
            wheel,
            roller,
            axis: hub.rotation * state.axis_in_hub,
            before_rad_s: state.axial_rate_rad_s,
            start_rad_s: state.axial_rate_rad_s,
            rate_rad_s: state.free_rate_rad_s(self.dt_s),
            response: (!state.seized).then_some(state.response(self.dt_s)),
            free_response: if state.seized {
                0.0
            } else {
                state.response(0.0)
            },
        })
    }

    /// How the velocity of a place along a direction follows from the robot's rates, in the pose that it has in a state.
    ///
    /// A roller moves with its hub but for its rate about its own axis d: with w that rate, W the hub's angular velocity
    /// and l the lever from the roller's middle, v = v_hub + (w - W . d) d x l.
    fn row(
        &self,
        place: &Candidate,
        state: &State,
        place_m: Vector3<f64>,
        direction: Vector3<f64>,
    ) -> Row {
        let mut turn = (place_m - state.center_m()).cross(&direction);
        let (mut hub_row, mut axle_row) = (None, None);
        if let Part::Roller(wheel, roller) = place.part {
            let hub = &state.hubs()[wheel];
            let mut of_hub = (place_m - hub.center_m).cross(&direction);
            let body = &self.assembly.wheels[wheel];
            let roller = &body.rollers[roller];
            if !roller.seized {
                let axis = hub.rotation * roller.axis_in_hub;
                let lever_m = place_m - roller.center_m(hub);
                let share = axis.dot(&lever_m.cross(&direction));
                turn -= share * axis;
                of_hub -= share * axis;
                axle_row = Some((0, share));
            }
            hub_row = Some((body.hub_dof, hub.axis().dot(&of_hub)));
        }
        Row {
            chassis: [
                direction.x,
                direction.y,
                direction.z,
                turn.x,
                turn.y,
                turn.z,
            ],
            hub: hub_row,
            axle: axle_row,
        }
    }
}
