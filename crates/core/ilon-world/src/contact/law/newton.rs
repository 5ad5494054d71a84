//! Newton's method on the residual of the laws (`residual`), with a line search.
//!
//! The impulses may violate the laws' bounds on the way. Each step is halved until |F|^2 is less
//! than the largest of the last eight (Grippo, Lampariello and Lucidi 1986): a monotone search
//! would stop where the pieces of F meet.

use super::compliant::CompliantStep;
use super::system::{ImpulseProblem, Kept, TOLERANCE};
use crate::contact::linear::solve_in_place;

/// Redundant contacts can share a load in many ways: a compliance of this share of each row's own
/// response selects the shares that change least. It falls with the residual, by this much per m/s,
/// to the least that rounding still resolves, so that the last steps are pure Newton steps. Chosen.
const RIDGE: f64 = 1e-7;
const RIDGE_FALLS: f64 = 1e-3;
const LEAST_RIDGE: f64 = 1e-9;

/// In a line search, the laws are checked only if the residual is at most this, in m/s. Chosen.
const NEAR: f64 = 1e-4;

/// The most halvings of a step. If none descends, the last one is taken, which is rarely far and
/// often makes progress. Chosen.
const HALVINGS: usize = 14;

/// The share of the predicted decrease that a step must achieve. Chosen.
const FALL: f64 = 1e-3;

/// Newton's method with its work space.
#[derive(Clone, Debug, Default)]
pub(super) struct Newton {
    /// F.
    missing: Vec<f64>,
    compliant: CompliantStep,
    /// The effect of a whole step on the impulses, and on the velocities.
    step: Vec<f64>,
    step_m_s: Vec<f64>,
    /// The rows whose impulses depend on one another, the effect of a step on them, and the other
    /// rows.
    coupled: Vec<usize>,
    solution: Vec<f64>,
    given: Vec<usize>,
    /// The impulses at the start of a step.
    from: Kept,
    /// The impulses before they were projected back into the laws' bounds.
    beyond: Kept,
}

/// The end of a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// The violation of the laws, in m/s or rad/s.
    pub error: f64,
    /// The number of steps.
    pub steps: u32,
}

/// The length of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stride {
    /// Always whole: near the solution this converges soonest, even if F grows on the way.
    Whole,
    /// As much of it as descends.
    Searched,
}

impl Newton {
    /// Takes at most this many steps from the current impulses, until the laws hold, and projects
    /// the impulses into the laws' bounds. `matrix` is work space.
    pub fn search(
        &mut self,
        problem: &mut ImpulseProblem,
        matrix: &mut Vec<f64>,
        (most_steps, stride): (u32, Stride),
    ) -> Found {
        let rows = problem.rows();
        self.missing.resize(rows, 0.0);
        matrix.resize(rows * rows, 0.0);
        let is_compliant = CompliantStep::applies(problem);
        let mut sizes = [0.0_f64; 8];
        let mut steps = 0;
        while steps < most_steps {
            let size = problem.residual(&mut self.missing, (!is_compliant).then_some(&mut *matrix));
            sizes[steps as usize % 8] = size;
            let is_found = match is_compliant {
                true => (self.compliant).find(problem, &self.missing, &mut self.step),
                false => self.find_step(problem, matrix, size),
            };
            if !is_found {
                break;
            }
            steps += 1;
            let is_near = match stride {
                Stride::Whole => {
                    problem.add(&self.step);
                    true
                }
                Stride::Searched => {
                    let most = sizes.iter().copied().fold(0.0, f64::max);
                    self.take_step(problem, most) <= NEAR * NEAR
                }
            };
            if is_near {
                problem.keep(&mut self.beyond);
                let error = problem.settle();
                if error <= TOLERANCE {
                    return Found { error, steps };
                }
                problem.go_back(&self.beyond);
            }
        }
        let error = problem.settle();
        Found { error, steps }
    }

    /// Computes the step from F and its derivative, with |F|^2 = `size`. Returns whether there is
    /// one.
    fn find_step(&mut self, problem: &ImpulseProblem, matrix: &mut [f64], size: f64) -> bool {
        let ridge = (RIDGE_FALLS * size.sqrt()).clamp(LEAST_RIDGE, RIDGE);
        let rows = problem.rows();
        for row in 0..rows {
            matrix[row * rows + row] += ridge * problem.w(row, row);
        }
        self.step.clear();
        self.step
            .extend(self.missing.iter().map(|missing| -missing));
        self.take_out_given(matrix);
        let coupled = self.coupled.len();
        self.solution.clear();
        self.solution
            .extend(self.coupled.iter().map(|row| self.step[*row]));
        let is_found = solve_in_place(&mut matrix[..coupled * coupled], &mut self.solution);
        for (row, step) in self.coupled.iter().zip(&self.solution) {
            self.step[*row] = *step;
        }
        is_found && self.step.iter().all(|step| step.is_finite())
    }

    /// Removes from the system the rows whose impulse is fixed by a law whatever the others are,
    /// such as open contacts, the majority in a scene with many bodies. The others remain as
    /// `coupled`.
    fn take_out_given(&mut self, matrix: &mut [f64]) {
        let rows = self.step.len();
        let is_coupled = |row: &usize| {
            let line = matrix[row * rows..][..rows].iter().enumerate();
            line.into_iter()
                .any(|(other, entry)| other != *row && *entry != 0.0)
        };
        self.coupled.clear();
        self.coupled.extend((0..rows).filter(is_coupled));
        if self.coupled.len() == rows {
            return;
        }
        let mut coupled = self.coupled.iter().copied().peekable();
        self.given.clear();
        self.given
            .extend((0..rows).filter(|row| coupled.next_if_eq(row).is_none()));
        for row in &self.given {
            self.step[*row] /= matrix[row * rows + row];
        }
        for row in &self.coupled {
            let line = &matrix[row * rows..][..rows];
            let of_given = self
                .given
                .iter()
                .map(|given| line[*given] * self.step[*given]);
            self.step[*row] -= of_given.sum::<f64>();
        }
        let places = self.coupled.iter();
        let entries =
            places.flat_map(|row| self.coupled.iter().map(move |other| row * rows + other));
        for (to, from) in entries.enumerate() {
            matrix[to] = matrix[from];
        }
    }

    /// Takes as much of the step as descends below `most`, and returns |F|^2 there.
    fn take_step(&mut self, problem: &mut ImpulseProblem, most: f64) -> f64 {
        problem.keep(&mut self.from);
        problem.respond(&self.step, &mut self.step_m_s);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            problem.move_from(&self.from, share, (&self.step, &self.step_m_s));
            let size = problem.residual(&mut self.missing, None);
            if size <= (1.0 - FALL * share) * most {
                return size;
            }
            share *= 0.5;
        }
        problem.move_from(&self.from, share, (&self.step, &self.step_m_s));
        problem.residual(&mut self.missing, None)
    }
}
