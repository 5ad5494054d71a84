//! Better starts where Newton's method leads nowhere: every law by itself, and what couples them, in turn (Douglas and Rachford 1956, in the form of
//! Gabay and Mercier 1976).
//!
//! In place of W each row answers by itself with a response R of its own:
//!
//! - (W + R) p = R q + u - u_free: what the impulses q, given so far, and the velocities u ask for;
//! - u grows by R (q - p), which makes it the velocities of p;
//! - q = prox(p - u / R): what each law allows there (`kinds`).
//!
//! Where p = q, all is solved. With fixed bounds of friction that comes nearer from any start and with any R > 0; how soon follows from R, which is
//! balanced between how far p and q are apart and how far q moves (He, Yang and Wang 2000). Bounds that follow a load which friction itself changes may
//! go round with it: then the start that is reached is a better one all the same.

use super::system::ImpulseProblem;
use crate::contact::linear::{factorise, solve_factorised};

/// R over the rows' own responses at first, and its bounds.
const SHARE: f64 = 1e-2;
const SHARES: [f64; 2] = [1e-7, 10.0];

/// Steps with one R.
const STEPS: usize = 20;

/// R changes by this factor where one of the two is so many times the other.
const CHANGES: f64 = 2.5;
const APART: f64 = 4.0;

/// What goes on from one call to the next: it follows from q and u, with any R.
#[derive(Clone, Debug, Default)]
pub(super) struct Splitting {
    /// q, in N s or N m s.
    allowed: Vec<f64>,
    /// u, in m/s or rad/s.
    velocities: Vec<f64>,
    /// R over the rows' own responses, and R itself, in m/s per N s.
    share: f64,
    responses: Vec<f64>,
    /// p.
    coupled: Vec<f64>,
}

impl Splitting {
    /// Begins from the impulses as they are.
    pub fn begin(&mut self, problem: &ImpulseProblem) {
        self.allowed.clone_from(&problem.impulses);
        self.velocities.clone_from(&problem.velocities);
        self.share = SHARE;
    }

    /// Takes so many steps, and gives the problem the impulses that the laws allow there. Gives by how much these break the laws, in m/s or rad/s. `matrix`
    /// is room.
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

    /// Takes R as a share of each row's own response. Friction has one for its two rows, so that its bound stays round.
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

    /// Takes a step. Gives how far p and q are apart, and how far q moves, as velocities.
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
