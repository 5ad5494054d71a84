//! Solves the laws of a step all at once: by Newton's method with a line search (`newton`) on one
//! residual (`residual`).
//!
//! It starts from the impulses of the last step. A rolling robot needs one Newton step, nearly all
//! others a few whole ones, although F may grow on the way (the watchdog rule of Chamberlain et al.
//! 1982). If these do not converge, in jams, it starts again with a line search along each step;
//! and if that does not converge either, `splitting` finds better and better starts.

use super::newton::{Newton, Stride};
use super::splitting::Splitting;
use super::system::{ImpulseProblem, Kept, TOLERANCE};

/// Solver of the laws of a step. It allocates only while it grows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solver {
    newton: Newton,
    splitting: Splitting,
    matrix: Vec<f64>,
    /// The start of the solution, and the impulses with the smallest violation so far.
    begun: Kept,
    best: Kept,
    effort: SolverEffort,
}

/// The cost of solving the laws of contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SolverEffort {
    /// Steps of Newton's method.
    pub newton_steps: u32,
    /// Number of times that Newton's method needed another start.
    pub restarts: u32,
}

/// The most steps of Newton's method: from the first start, from there again with a line search,
/// and from each other start. Chosen.
const WHOLE: (u32, Stride) = (8, Stride::Whole);
const FIRST: (u32, Stride) = (20, Stride::Searched);
const OTHERS: (u32, Stride) = (60, Stride::Searched);

/// Steps of `splitting` before each other start. Chosen.
const BETWEEN: [usize; 8] = [25, 25, 50, 100, 200, 400, 800, 1600];

impl Solver {
    /// Solves for the impulses from the assumed ones. Returns by how much the laws are broken in
    /// the end, in m/s or rad/s.
    pub fn solve(&mut self, problem: &mut ImpulseProblem) -> f64 {
        let error = self.solve_in_discs(problem);
        problem.take_back();
        error
    }

    /// The cost since the last call.
    pub fn take_effort(&mut self) -> SolverEffort {
        std::mem::take(&mut self.effort)
    }

    fn solve_in_discs(&mut self, problem: &mut ImpulseProblem) -> f64 {
        let mut least = problem.error();
        if least <= TOLERANCE {
            return least;
        }
        problem.keep(&mut self.begun);
        problem.keep(&mut self.best);
        if self.search(problem, &mut least, WHOLE) {
            return least;
        }
        problem.go_back(&self.begun);
        if self.search(problem, &mut least, FIRST) {
            return least;
        }
        problem.go_back(&self.begun);
        self.splitting.begin(problem);
        for steps in BETWEEN {
            self.effort.restarts += 1;
            let error = self.splitting.go(problem, &mut self.matrix, steps);
            if self.keep_if_better(problem, &mut least, error)
                || self.search(problem, &mut least, OTHERS)
            {
                return least;
            }
        }
        problem.go_back(&self.best);
        least
    }

    /// Continues the search from the current impulses. Returns whether it has reached the solution.
    fn search(
        &mut self,
        problem: &mut ImpulseProblem,
        least: &mut f64,
        steps: (u32, Stride),
    ) -> bool {
        let found = self.newton.search(problem, &mut self.matrix, steps);
        self.effort.newton_steps += found.steps;
        self.keep_if_better(problem, least, found.error)
    }

    /// Keeps the impulses if they violate the laws less than all before. Returns whether they are
    /// the solution.
    fn keep_if_better(&mut self, problem: &ImpulseProblem, least: &mut f64, error: f64) -> bool {
        if error < *least {
            *least = error;
            problem.keep(&mut self.best);
        }
        error <= TOLERANCE
    }
}
