//! Newton's method with a search along each step: for contacts that jam, where neither whole steps nor sweeps lead anywhere.
//!
//! The laws are one equation for each row, F(p) = 0, in m/s or rad/s (Alart and Curnier 1991). With w a row's own response, q = p - u / w is what the
//! row would carry if it had to stop the velocity that is left: a contact presses where q_n > 0, and then F = u_n + b + c p_n, else w p_n; friction holds
//! where |q_t| <= mu q_n, and then F = u_t, else F = w (p_t - mu q_n q_t / |q_t|). F is continuous, and the impulses may leave the laws' bounds on
//! the way. Each step is halved until |F|^2 is less than the most of the last eight times (Grippo, Lampariello and Lucidi 1986): a fall in each step
//! would stop where the pieces of F meet.

use nalgebra::Matrix2;

use super::kinds::Law;
use super::newton::RIDGE;
use super::system::{ImpulseProblem, TOLERANCE, pair};
use crate::contact::linear::solve_in_place;

/// Steps at most.
const STEPS: usize = 60;

/// Halvings of a step at most: where none of its parts leads down, the last is gone, which seldom leads far and often on.
const HALVINGS: usize = 14;

/// Of the fall that a step promises, so much is asked for.
const FALL: f64 = 1e-3;

/// Room for the search.
#[derive(Clone, Debug, Default)]
pub(super) struct Descent {
    /// F.
    missing: Vec<f64>,
    step: Vec<f64>,
    from: Vec<f64>,
}

/// Where F is written down, and its derivative by the impulses, row by row, where that is asked for.
struct Equations<'a> {
    problem: &'a ImpulseProblem,
    missing: &'a mut [f64],
    matrix: Option<&'a mut [f64]>,
}

impl Descent {
    /// Goes on from the impulses as they are until the laws hold, or no further. `matrix` is room. Gives the error that is left once the impulses are
    /// put back into the laws' bounds.
    pub fn steps(&mut self, problem: &mut ImpulseProblem, matrix: &mut Vec<f64>) -> f64 {
        let rows = problem.rows();
        self.missing.resize(rows, 0.0);
        let mut sizes = [0.0_f64; 8];
        for number in 0..STEPS {
            matrix.clear();
            matrix.resize(rows * rows, 0.0);
            let size = self.write_down(problem, Some(matrix));
            if problem.error() <= TOLERANCE {
                break;
            }
            sizes[number % 8] = size;
            let most = sizes.iter().copied().fold(0.0, f64::max);
            self.step.clear();
            self.step
                .extend(self.missing.iter().map(|missing| -missing));
            if !solve_in_place(matrix, &mut self.step) {
                break;
            }
            self.go(problem, most);
        }
        for law in 0..problem.laws.len() {
            problem.bring_back(law);
        }
        problem.follow_impulses();
        problem.error()
    }

    /// Goes as much of the step as leads below `most`.
    fn go(&mut self, problem: &mut ImpulseProblem, most: f64) {
        self.from.clone_from(&problem.impulses);
        let mut share = 1.0;
        for _ in 0..=HALVINGS {
            let moved = self.from.iter().zip(&self.step);
            for (impulse, (from, step)) in problem.impulses.iter_mut().zip(moved) {
                *impulse = from + share * step;
            }
            problem.follow_impulses();
            if self.write_down(problem, None) <= (1.0 - FALL * share) * most {
                return;
            }
            share *= 0.5;
        }
    }

    /// Writes down F, and its derivative into a matrix of zeros, and gives |F|^2.
    fn write_down(&mut self, problem: &ImpulseProblem, matrix: Option<&mut Vec<f64>>) -> f64 {
        let mut equations = Equations {
            problem,
            missing: &mut self.missing,
            matrix: matrix.map(|matrix| &mut matrix[..]),
        };
        for &(at, law) in &problem.laws {
            equations.write(at, law);
        }
        self.missing.iter().map(|missing| missing * missing).sum()
    }
}

impl Equations<'_> {
    fn write(&mut self, at: usize, law: Law) {
        let problem = self.problem;
        let (own, u, p) = (
            problem.w(at, at),
            problem.velocities[at],
            problem.impulses[at],
        );
        match law {
            Law::Joint {
                least_n_m_s,
                most_n_m_s,
            } => {
                let asked = p - u / own;
                let within = asked.clamp(least_n_m_s, most_n_m_s);
                if asked == within {
                    self.ask(at, u, 1.0, 0.0);
                } else {
                    self.ask(at, own * (p - within), 0.0, own);
                }
            }
            Law::Curve { place } => {
                let meeting = problem.on_curve(at, place);
                let [of_velocity, of_impulse] = meeting.across(own);
                let missing =
                    of_velocity * (u - meeting.velocity) + of_impulse * (p - meeting.impulse);
                self.ask(at, missing, of_velocity, of_impulse);
            }
            Law::Contact {
                friction,
                approach_m_s,
                compliance,
            } => {
                let closing = u + approach_m_s + compliance * p;
                let asked = p - closing / own;
                if asked > 0.0 {
                    self.ask(at, closing, 1.0, compliance);
                } else {
                    self.ask(at, own * p, 0.0, own);
                }
                // How what the normal would carry changes: by W's row and by its own impulse.
                let grows = (at, -1.0 / own, 1.0 - compliance / own);
                self.ask_disc(at + 1, friction * asked.max(0.0), (friction, grows));
            }
            Law::Disc { most_n_s } => self.ask_disc(at, most_n_s, (0.0, (at, 0.0, 0.0))),
            // Where these are, another way is gone: `split`.
            Law::Slide { .. } => self.ask(at, u, 1.0, 0.0),
        }
    }

    /// Of a row: its F, and how that changes with its velocity and with its impulse.
    fn ask(&mut self, row: usize, missing: f64, of_velocity: f64, of_impulse: f64) {
        self.missing[row] = missing;
        self.add(row, (row, of_velocity, of_impulse));
        let ridge = RIDGE * self.problem.w(row, row);
        self.add(row, (row, 0.0, ridge));
    }

    /// Adds to how the F of a row changes: with the velocity of another, and with its impulse.
    fn add(&mut self, row: usize, (other, of_velocity, of_impulse): (usize, f64, f64)) {
        let Some(matrix) = &mut self.matrix else {
            return;
        };
        let rows = self.missing.len();
        let line = &mut matrix[row * rows..][..rows];
        if of_velocity != 0.0 {
            let w = &self.problem.delassus[other * rows..][..rows];
            for (entry, w) in line.iter_mut().zip(w) {
                *entry += of_velocity * w;
            }
        }
        line[other] += of_impulse;
    }

    /// Of two rows whose impulse is held in a disc, whose size grows by so much with what a row would carry.
    fn ask_disc(&mut self, at: usize, limit: f64, (by, grows): (f64, (usize, f64, f64))) {
        let problem = self.problem;
        let own = problem.w(at, at) + problem.w(at + 1, at + 1);
        let (p, u) = (pair(&problem.impulses, at), pair(&problem.velocities, at));
        let asked = p - u / own;
        let size = asked.norm();
        if size <= limit {
            self.ask(at, u.x, 1.0, 0.0);
            self.ask(at + 1, u.y, 1.0, 0.0);
            return;
        }
        let along = asked / size;
        let missing = own * (p - limit * along);
        // How limit q / |q| changes with q.
        let turns = (Matrix2::identity() - along * along.transpose()) * (limit / size);
        let (other, of_velocity, of_impulse) = grows;
        for (i, row) in [at, at + 1].into_iter().enumerate() {
            self.ask(row, missing[i], 0.0, own);
            for (j, tangent) in [at, at + 1].into_iter().enumerate() {
                self.add(row, (tangent, turns[(i, j)], -own * turns[(i, j)]));
            }
            if limit > 0.0 {
                let share = -own * by * along[i];
                self.add(row, (other, share * of_velocity, share * of_impulse));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::Curve;
    use super::*;

    /// Two contacts, a dry joint, a disc and a curve, of which each moves all others.
    fn problem(friction: f64, free: &[f64]) -> ImpulseProblem {
        let mut problem = ImpulseProblem::default();
        let contact = Law::Contact {
            friction,
            approach_m_s: 0.01,
            compliance: 0.2,
        };
        problem.push(contact, &free[..3]);
        problem.push(contact, &free[3..6]);
        let joint = Law::Joint {
            least_n_m_s: -0.3,
            most_n_m_s: 0.2,
        };
        problem.push(joint, &free[6..7]);
        problem.push(Law::Disc { most_n_s: 0.4 }, &free[7..9]);
        let place = problem.add_curve(&Curve {
            points: vec![[0.0, 0.0], [1.0, -0.3]],
            ends: [[1.0, 0.1], [1.0, -0.2]],
        });
        problem.push(Law::Curve { place }, &free[9..10]);
        problem.set_delassus(|row, w| {
            for (column, w) in w.iter_mut().enumerate() {
                let apart = (row - column) as f64;
                *w = if row == column {
                    2.0 + 0.1 * apart
                } else {
                    0.3 / (1.0 + apart)
                };
            }
        });
        problem
    }

    /// The derivative of F is that of differences over 2e-6 N s, wherever F has one: F is made of pieces that bend by less than 1e3 per N s, so that these
    /// are right to 1e-5, and a place that falls on a seam within 1e-6 is none of so few.
    #[test]
    fn the_derivative_is_that_of_differences() {
        let mut descent = Descent::default();
        for case in 0..40 {
            let number = |of: usize| (1.7 * (case * 31 + of) as f64).sin();
            let free: Vec<f64> = (0..10).map(number).collect();
            let mut problem = problem(0.3 + 0.02 * case as f64, &free);
            let rows = problem.rows();
            let at: Vec<f64> = (0..rows).map(|row| 0.5 * number(row + 77)).collect();
            let mut missing = |impulses: &[f64], matrix: Option<&mut Vec<f64>>| {
                problem.impulses.copy_from_slice(impulses);
                problem.follow_impulses();
                descent.missing.resize(rows, 0.0);
                descent.write_down(&problem, matrix);
                descent.missing.clone()
            };
            let mut matrix = vec![0.0; rows * rows];
            missing(&at, Some(&mut matrix));
            for column in 0..rows {
                const BY: f64 = 1e-6;
                let [before, after] = [-BY, BY].map(|by| {
                    let mut there = at.clone();
                    there[column] += by;
                    missing(&there, None)
                });
                for row in 0..rows {
                    let expected = (after[row] - before[row]) / (2.0 * BY);
                    let got = matrix[row * rows + column];
                    assert!(
                        (got - expected).abs() < 1e-5,
                        "case {case}, row {row}, column {column}: {got} {expected}"
                    );
                }
            }
        }
    }

    /// Friction from 1 to 3, which couples what presses and what slides as it does in jams: of forty draws no more than two are left, and no impulse pulls.
    #[test]
    fn from_no_impulse_the_search_ends_where_all_laws_hold() {
        let mut solved = 0;
        for case in 0..40 {
            let number = |of: usize| (2.3 * (case * 17 + of) as f64).sin();
            let free: Vec<f64> = (0..10).map(number).collect();
            let mut problem = problem(1.0 + 0.05 * case as f64, &free);
            let mut room = Vec::new();
            let error = Descent::default().steps(&mut problem, &mut room);
            if error <= TOLERANCE {
                solved += 1;
                for at in [0, 3] {
                    let p = Vector3::from_row_slice(&problem.impulses[at..at + 3]);
                    assert!(p.x >= 0.0);
                }
            }
        }
        assert!(solved >= 38, "{solved} of 40");
    }
}
