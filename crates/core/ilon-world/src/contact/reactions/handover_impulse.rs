//! The jump of a hand-over, separated from the rest of a step.
//!
//! A roller that comes down does not roll yet, and on a mecanum wheel its axis has another
//! direction than that of its predecessor: the robot's rates jump. Friction at its limit causes the
//! jump within a part s of the step; over the rest the contact sticks and its regular force does no
//! work. If the work of the whole impulse were computed with the mean of the velocities before and
//! after, the regular force would count as sliding over the whole step, and a hand-over would lose
//! energy in proportion to the step's length.
//!
//! So the impulses p of a step are separated. p_j brings the rollers to rolling, W p_j = -u_0 where
//! they come down and W p_j = 0 at all other sticking contacts, and p_r = p - p_j is the rest.
//! Motors and bearings do not react within the jump: W is here the response without their loss per
//! rate gained, which the step otherwise includes implicitly. With u_0+ = u_0 + W p_j, and the jump
//! over when friction has done its part, mu p_n s = -(p_j + s p_r) along the sliding:
//!
//! work of p_j = p_j . ((u_0 + u_0+) / 2 + s (u_1 - u_0+) / 2), work of p_r = p_r . (u_s + u_1) /
//! 2, u_s = u_0+ - s (u_0+ - u_0).
//!
//! All other forces that act over the step, and the robot's motion, use u_s too.

use std::ops::Range;

use nalgebra::Vector3;

use crate::contact::law::ImpulseProblem;
use crate::contact::linear::{solve_for_all, solve_in_place};
use crate::contact::reactions::reaction::Reaction;
use crate::contact::reactions::response::{Responses, of_axles};
use crate::contact::reactions::row::Row;
use crate::robot::articulated::Articulated;

/// A contact that approaches faster, in its robot's unit of speed, is an impact, which takes the
/// whole step. 1 cm/s for wheels of 50 mm. Chosen.
const HITS: f64 = 0.0143;

/// The jump of a step; zero if no roller came down.
#[derive(Clone, Debug, Default)]
pub(crate) struct HandoverImpulse {
    /// p_j, row by row.
    impulses: Vec<f64>,
    /// W p_j, row by row.
    velocities: Vec<f64>,
    /// Its change of the bodies' rates, by degree of freedom.
    change: Vec<f64>,
    /// s, the share of the step that it takes.
    share: f64,
    held: Vec<usize>,
    matrix: Vec<f64>,
    solution: Vec<f64>,
    /// Decouples the wheels from their motors: a square matrix with one row per wheel.
    freeing: Vec<f64>,
    /// Effect of the unit impulse of each row on each wheel, row by row; and the part from
    /// decoupling the wheels.
    at_joints: Vec<f64>,
    freed: Vec<f64>,
}

/// The response of the bodies to impulses, with the implicit damping of the step, and that damping.
pub(crate) struct BodyResponse<'a> {
    pub rows: &'a [Row],
    pub responses: &'a Responses,
    /// Loss of impulse per rate gained by the motor and bearing of each wheel, in N m s per rad/s.
    pub held_n_m_s2: &'a [f64],
    /// Additional response of each roller to an impulse about its axis without its bearing's
    /// damping, in rad/s per N m s.
    pub freed_axles: &'a [f64],
}

impl BodyResponse<'_> {
    /// Addition to W of two rows by rollers without bearing damping.
    fn of_freed_axle(&self, row: usize, column: usize) -> f64 {
        let rows = (&self.rows[row], &self.rows[column]);
        of_axles(rows, |axle| [self.freed_axles[axle], 0.0])
    }
}

impl HandoverImpulse {
    /// Whether rollers of bodies came down in a step without an impact.
    pub fn happens(reactions: &[Reaction], bodies: &[Articulated]) -> bool {
        let pressing = |r: &&Reaction| r.rows() == 3 && r.impulse.x > 0.0;
        let gently =
            |r: &Reaction| r.velocity_before.x > -HITS * bodies[r.a.body].scale.speed_m_s();
        reactions.iter().filter(pressing).all(gently) && reactions.iter().any(takes_up)
    }

    /// No jump.
    pub fn clear(&mut self, rows: usize, dofs: usize) {
        for (room, length) in [
            (&mut self.impulses, rows),
            (&mut self.velocities, rows),
            (&mut self.change, dofs),
        ] {
            room.clear();
            room.resize(length, 0.0);
        }
        self.share = 0.0;
    }

    /// Finds the jump of a step that has been solved.
    pub fn find(
        &mut self,
        reactions: &[Reaction],
        problem: &ImpulseProblem,
        held: &BodyResponse<'_>,
    ) {
        self.free_joints(held);
        self.find_at_joints(held);
        self.find_impulses(reactions, problem, held);
        self.find_effect(problem, held);
        self.share = share(reactions, &self.impulses);
    }

    /// Change of the bodies' rates from the beginning of the step to the start of the mean over it,
    /// for a range of the degrees of freedom of all bodies.
    pub fn start_change(&self, dofs: Range<usize>) -> impl Iterator<Item = f64> {
        let over = 1.0 - self.share;
        // There is none for a step whose contacts were not solved here.
        let change = self.change.get(dofs).unwrap_or(&[]);
        change.iter().map(move |change| over * change)
    }

    /// Half of its effect on the rates of the bodies after it is found, to be completed.
    pub fn change_mut(&mut self) -> &mut [f64] {
        &mut self.change
    }

    /// p_j of a row.
    pub fn impulse(&self, row: usize) -> f64 {
        self.impulses[row]
    }

    /// s, the share of the step that it takes.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Energy taken by the impulse of a row, in J, given its velocities before and after the step.
    pub fn taken_j(&self, row: usize, impulse: f64, (before, after): (f64, f64)) -> f64 {
        let (of_jump, jumped) = (self.impulses[row], before + self.velocities[row]);
        let in_jump = 0.5 * (before + jumped) + 0.5 * self.share * (after - jumped);
        let start = jumped - self.share * self.velocities[row];
        -(of_jump * in_jump + (impulse - of_jump) * 0.5 * (start + after))
    }

    /// Removes the wheels' motors from a response: with A the matrix that includes their damping, G
    /// the damping, E the wheels' columns and S = E^T A^-1 E, the inverse of A - E G E^T is A^-1 +
    /// A^-1 E (1 - G S)^-1 G E^T A^-1 (Woodbury).
    fn free_joints(&mut self, held: &BodyResponse<'_>) {
        let joints = held.responses.joints();
        self.freeing.clear();
        self.freeing.resize(joints * joints, 0.0);
        // 1 - G S, and beside it G.
        self.matrix.clear();
        for (row, lost) in held.held_n_m_s2.iter().enumerate() {
            let one = |k: usize| if row == k { 1.0 } else { 0.0 };
            self.matrix
                .extend((0..joints).map(|k| one(k) - lost * held.responses.between_joints(row, k)));
            self.matrix
                .extend((0..joints).map(|k| if row == k { *lost } else { 0.0 }));
        }
        if !solve_for_all(&mut self.matrix, joints) {
            return;
        }
        let solved = self.matrix.chunks_exact(2 * joints);
        for (freeing, row) in self.freeing.chunks_exact_mut(joints).zip(solved) {
            freeing.copy_from_slice(&row[joints..]);
        }
    }

    /// The effect of each row on the wheels, with damping, and the addition by decoupling.
    fn find_at_joints(&mut self, held: &BodyResponse<'_>) {
        let joints = held.responses.joints();
        self.at_joints.clear();
        self.freed.clear();
        for row in 0..self.impulses.len() {
            let of_row = (0..joints).map(|joint| held.responses.at_joint(row, joint));
            self.at_joints.extend(of_row);
            let at = &self.at_joints[row * joints..];
            let freeing = self.freeing.chunks_exact(joints);
            let freed = freeing.map(|of| of.iter().zip(at).map(|(f, at)| f * at).sum::<f64>());
            self.freed.extend(freed);
        }
    }

    /// W of two rows with the wheels free.
    fn response(
        &self,
        problem: &ImpulseProblem,
        held: &BodyResponse<'_>,
        (row, column): (usize, usize),
    ) -> f64 {
        let joints = held.responses.joints();
        let mut sum = problem.w(row, column) + held.of_freed_axle(row, column);
        let at = &self.at_joints[row * joints..][..joints];
        for (at, freed) in at.iter().zip(&self.freed[column * joints..]) {
            sum += at * freed;
        }
        sum
    }

    /// Solves W p_j = -u_0 where rollers come down and 0 where another contact or a bearing sticks.
    fn find_impulses(
        &mut self,
        reactions: &[Reaction],
        problem: &ImpulseProblem,
        held: &BodyResponse<'_>,
    ) {
        /// Redundant contacts can share a jump in many ways: a minimal compliance selects one.
        /// Chosen.
        const RIDGE: f64 = 1e-6;
        self.held.clear();
        self.solution.clear();
        let mut row = 0;
        for (law, reaction) in reactions.iter().enumerate() {
            let holds = problem.holds(law);
            for k in 0..reaction.rows() {
                let normal = k == 0 && reaction.rows() == 3 && reaction.impulse.x > 0.0;
                if normal || holds {
                    self.held.push(row);
                    let stops = takes_up(reaction) && k > 0;
                    self.solution.push(if stops {
                        -reaction.velocity_before[k]
                    } else {
                        0.0
                    });
                }
                row += 1;
            }
        }
        let still = std::mem::take(&mut self.held);
        self.matrix.clear();
        for &row in &still {
            for &column in &still {
                let w = self.response(problem, held, (row, column));
                let ridge = if row == column { RIDGE * w } else { 0.0 };
                self.matrix.push(w + ridge);
            }
        }
        if solve_in_place(&mut self.matrix, &mut self.solution) {
            for (&row, impulse) in still.iter().zip(&self.solution) {
                self.impulses[row] = *impulse;
            }
        }
        self.held = still;
    }

    /// The effect of the impulses on the rows, and half of that on the bodies.
    fn find_effect(&mut self, problem: &ImpulseProblem, held: &BodyResponse<'_>) {
        let joints = held.responses.joints();
        // The effect of the impulses on the wheels, with damping, and then the addition by
        // decoupling.
        self.matrix.clear();
        for joint in 0..joints {
            let of_rows = self.held.iter();
            let at = of_rows.map(|&row| self.impulses[row] * self.at_joints[row * joints + joint]);
            self.matrix.push(at.sum());
        }
        self.solution.clear();
        for of in self.freeing.chunks_exact(joints) {
            let freed = of.iter().zip(&self.matrix).map(|(f, at)| f * at);
            self.solution.push(freed.sum());
        }
        for row in 0..self.velocities.len() {
            let of_rows = self
                .held
                .iter()
                .map(|&by| (problem.w(row, by) + held.of_freed_axle(row, by)) * self.impulses[by]);
            let of_joints = self.solution.iter().enumerate();
            self.velocities[row] = of_rows.sum::<f64>()
                + of_joints
                    .map(|(a, y)| y * self.at_joints[row * joints + a])
                    .sum::<f64>();
        }
        for &row in &self.held {
            let impulse = self.impulses[row];
            held.responses.add_row(row, impulse, &mut self.change);
        }
        for (joint, impulse) in self.solution.iter().enumerate() {
            held.responses.add_joint(joint, *impulse, &mut self.change);
        }
    }
}

/// Whether a roller came down and took up some of the load.
fn takes_up(reaction: &Reaction) -> bool {
    reaction.came_down && reaction.impulse.x > 0.0
}

/// The share of the step for which friction is at its limit: the mean over the rollers that came
/// down, weighted by their losses.
fn share(reactions: &[Reaction], jump: &[f64]) -> f64 {
    let (mut shares, mut weights) = (0.0, 0.0);
    let mut row = 0;
    for reaction in reactions {
        let slides = reaction.velocity_before.yz();
        if takes_up(reaction) && slides.norm() > 0.0 {
            let of_jump = Vector3::from_column_slice(&jump[row..row + 3]);
            let along = slides.normalize();
            let needed = -of_jump.yz().dot(&along);
            let regular = reaction.impulse - of_jump;
            let stops = reaction.friction * reaction.impulse.x + regular.yz().dot(&along);
            let weight = (needed * slides.norm()).max(0.0);
            let share = if stops > 0.0 {
                (needed / stops).clamp(0.0, 1.0)
            } else {
                1.0
            };
            shares += weight * share;
            weights += weight;
        }
        row += reaction.rows();
    }
    if weights > 0.0 { shares / weights } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::reactions::reaction::{Member, Part, Partner};

    /// A roller that came down and slid along its first tangent.
    fn came_down(friction: f64, impulse: Vector3<f64>) -> Reaction {
        Reaction {
            a: Member {
                body: 0,
                part: Part::Roller(0, 0),
            },
            b: Partner::Ground,
            at_m: Vector3::zeros(),
            frame: [Vector3::z(), Vector3::x(), Vector3::y()],
            friction,
            nap: None,
            impulse,
            velocity_before: Vector3::new(0.0, 0.2, 0.0),
            velocity_after: Vector3::zeros(),
            taken_j: Vector3::zeros(),
            came_down: true,
            rolling_radius_m: 0.0,
            compliance: None,
        }
    }

    /// Friction at its limit gives mu p_n over a whole step. To stop the sliding it must give the
    /// jump and, for as long as that takes, the regular force: mu p_n s = -(p_j + s p_r) along the
    /// sliding.
    #[test]
    fn friction_stops_what_slides_in_the_part_of_a_step_in_which_it_can() {
        let (friction, normal_n_s) = (0.5, 0.04);
        for (jump_n_s, rest_n_s) in [(-0.004, 0.0), (-0.004, 0.006), (-0.004, -0.006)] {
            let whole = Vector3::new(normal_n_s, jump_n_s + rest_n_s, 0.0);
            let part = share(&[came_down(friction, whole)], &[0.0, jump_n_s, 0.0]);
            let left_n_s = friction * normal_n_s * part + (jump_n_s + part * rest_n_s);
            // A handful of roundings.
            assert!(left_n_s.abs() < 1e-17, "{rest_n_s}: {left_n_s:e}");
        }
        // If friction is too weak, it takes the whole step.
        let weak = came_down(0.05, Vector3::new(normal_n_s, -0.004, 0.0));
        assert_eq!(share(&[weak], &[0.0, -0.004, 0.0]), 1.0);
    }
}
