//! Better starts if Newton's method does not converge: alternates between each law by itself and
//! their coupling (Douglas and Rachford 1956, in the form of Gabay and Mercier 1976).
//!
//! Instead of W each row answers with a response R of its own:
//!
//! - (W + R) p = R q + u - u_free: the impulses p that match the given impulses q and velocities u;
//! - u grows by R (q - p), which makes it the velocities of p;
//! - q = prox(p - u / R): the impulse that each law allows there (`kinds`).
//!
//! If p = q, the problem is solved. With fixed friction bounds this converges from any start and
//! for any R > 0; the speed depends on R, which is balanced between the distance of p and q and the
//! change of q (He, Yang and Wang 2000). Bounds that follow a load which friction itself changes
//! may cycle with it; the start that is reached is still a better one.

use super::system::ImpulseProblem;
use crate::contact::linear::{factorise, solve_factorised};

/// R relative to the rows' own responses at the start, and its bounds. Chosen.
const SHARE: f64 = 1e-2;
const SHARES: [f64; 2] = [1e-7, 10.0];

/// Steps with the same R. Chosen.
const STEPS: usize = 20;

/// R changes by this factor if one of the two is this many times the other. Chosen.
const CHANGES: f64 = 2.5;
const APART: f64 = 4.0;

/// The state that continues from one call to the next: it follows from q and u, with any R.
#[derive(Clone, Debug, Default)]
pub(super) struct Splitting {
    /// q, in N s or N m s.
    allowed: Vec<f64>,
    /// u, in m/s or rad/s.
    velocities: Vec<f64>,
    /// R relative to the rows' own responses, and R itself, in m/s per N s.
    share: f64,
    responses: Vec<f64>,
    /// p.
    coupled: Vec<f64>,
}

impl Splitting {
    /// Starts from the current impulses.
    pub fn begin(&mut self, problem: &ImpulseProblem) {
        self.allowed.clone_from(&problem.impulses);
        self.velocities.clone_from(&problem.velocities);
        self.share = SHARE;
    }

    /// Takes `steps` steps, and gives the problem the impulses that the laws allow there. Returns
    /// their violation of the laws, in m/s or rad/s. `matrix` is work space.
    pub fn go(
        &mut self,
        problem: &mut ImpulseProblem,
        matrix: &mut Vec<f64>,
        mut steps: usize,
    ) -> f64 {
        let rows = problem.rows();
        while steps > 0 {
            self.take_responses(problem);
            matrix.clone_from(&problem.delassus);
            for (row, response) in self.responses.iter().enumerate() {
                matrix[row * rows + row] += response;
            }
            if !factorise(matrix, rows) {
                break;
            }
            let (mut apart, mut moved) = (0.0, 0.0);
            for _ in 0..STEPS.min(steps) {
                (apart, moved) = self.step(problem, matrix);
            }
            steps = steps.saturating_sub(STEPS);
            if apart > APART * moved {
                self.share *= CHANGES;
            } else if moved > APART * apart {
                self.share /= CHANGES;
            }
            self.share = self.share.clamp(SHARES[0], SHARES[1]);
        }
        problem.impulses.clone_from(&self.allowed);
        problem.follow_impulses();
        problem.settle()
    }

    /// Sets R to a share of each row's own response. Both rows of friction have the same R, so that
    /// its bound stays round.
    fn take_responses(&mut self, problem: &ImpulseProblem) {
        let own = |row: usize| self.share * problem.w(row, row);
        self.responses.clear();
        self.responses.extend((0..problem.rows()).map(own));
        for (at, law) in &problem.laws {
            if let Some(first) = law.first_tangent() {
                let tangents = &mut self.responses[at + first..][..2];
                tangents.fill((tangents[0] * tangents[1]).sqrt());
            }
        }
    }

    /// Takes a step. Returns the distance of p and q, and the change of q, as velocities.
    fn step(&mut self, problem: &ImpulseProblem, factors: &[f64]) -> (f64, f64) {
        let Self {
            allowed,
            velocities,
            responses,
            coupled,
            ..
        } = self;
        let free = problem.free();
        coupled.clear();
        coupled.extend(
            (0..free.len()).map(|row| responses[row] * allowed[row] + velocities[row] - free[row]),
        );
        solve_factorised(factors, coupled);
        let (mut apart, mut moved) = (0.0_f64, 0.0_f64);
        for &(at, law) in &problem.laws {
            let mut asked = [0.0; 3];
            for (k, asked) in asked[..law.rows()].iter_mut().enumerate() {
                let row = at + k;
                velocities[row] += responses[row] * (allowed[row] - coupled[row]);
                *asked = coupled[row] - velocities[row] / responses[row];
            }
            let allows = law.allows(&problem.curves, &asked, 1.0 / responses[at]);
            for (k, impulse) in allows.impulse[..law.rows()].iter().enumerate() {
                let row = at + k;
                apart = apart.max((impulse - coupled[row]).abs() * problem.w(row, row));
                moved = moved.max((impulse - allowed[row]).abs() * responses[row]);
                allowed[row] = *impulse;
            }
        }
        (apart, moved)
    }
}
