//! Where rollers slide along their axles or rolling costs something: the laws and what couples them, solved in turn (Douglas and Rachford 1956, in the form of
//! Gabay and Mercier 1976).
//!
//! The contact, the drag and the play of a roller all move the same few grams, and whether it lies at a stop changes what the others move by
//! a factor of hundreds. Taken one after the other they undo one another, and Newton's method goes round between stop and slide. Here
//! every law is asked for on its own, for one and the same response R of each row instead of W, and all couplings at once:
//!
//! - (W + R) p = R q + u - u_free: what the impulses q, given so far, and the velocities u ask for;
//! - u grows by R (q - p), which makes it the velocities of p;
//! - q is what each law allows next to p - u / R, as if R were all that answers.
//!
//! Where p = q, all is solved. With fixed bounds of friction that comes nearer from any start and with any R > 0; how soon follows
//! from R, and which R is best from what slides in the end. So each round takes another. Bounds that follow a load which friction itself
//! changes may go round with it; where that has not settled, they follow more slowly.

use nalgebra::{Vector2, Vector3};

use super::kinds::{Law, Sliding};
use super::system::ImpulseProblem;
use crate::contact::linear::{factorise, solve_factorised};

/// Steps with one R: at first, and where so few have settled nothing in [`AT_ONCE`] rounds.
const STEPS: [usize; 2] = [100, 1000];

/// R over the rows' own responses, one round after the other.
const SHARES: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];

/// Rounds in which the bounds of friction follow the load at once.
const AT_ONCE: usize = 2 * SHARES.len();

/// How much of the way to the load they follow in a step afterwards.
const FOLLOWS: f64 = 0.1;

/// What is kept from round to round. What follows from q and u follows with any R.
#[derive(Clone, Debug, Default)]
pub(super) struct Split {
    /// q, in N s or N m s.
    allowed: Vec<f64>,
    /// u, in m/s or rad/s.
    velocities: Vec<f64>,
    /// u_free.
    free: Vec<f64>,
    /// R, in m/s per N s.
    responses: Vec<f64>,
    /// p.
    coupled: Vec<f64>,
    /// The loads that friction follows, at the rows of contacts' normals.
    loads: Vec<f64>,
}

impl Split {
    /// Goes steps of a round, and to what the laws allow then; the first from the impulses as they are. `matrix` is room.
    pub fn steps(&mut self, problem: &mut ImpulseProblem, matrix: &mut Vec<f64>, round: usize) {
        if round == 0 {
            self.begin(problem);
        }
        self.take_responses(problem, SHARES[round % SHARES.len()]);
        let rows = problem.rows();
        matrix.clear();
        matrix.extend_from_slice(&problem.delassus);
        for (row, response) in self.responses.iter().enumerate() {
            matrix[row * rows + row] += response;
        }
        if !factorise(matrix, rows) {
            return;
        }
        let (steps, follows) = if round < AT_ONCE {
            (STEPS[0], 1.0)
        } else {
            (STEPS[1], FOLLOWS)
        };
        for _ in 0..steps {
            self.step(problem, matrix, follows);
        }
        for law in 0..problem.laws.len() {
            let asked = &self.allowed[problem.laws[law].0..];
            problem.bring(
                law,
                Vector3::from_fn(|k, _| asked.get(k).copied().unwrap_or(0.0)),
            );
        }
    }

    fn begin(&mut self, problem: &ImpulseProblem) {
        self.allowed.clone_from(&problem.impulses);
        self.loads.clone_from(&problem.impulses);
        self.velocities.clone_from(&problem.velocities);
        self.free.clone_from(&problem.velocities);
        let rows = problem.rows();
        for (free, w) in self
            .free
            .iter_mut()
            .zip(problem.delassus.chunks_exact(rows))
        {
            let of_impulses = w.iter().zip(&problem.impulses).map(|(w, p)| w * p);
            *free -= of_impulses.sum::<f64>();
        }
    }

    /// Takes R as a share of each row's own response. Friction has one for its two rows, so that its bound stays round.
    fn take_responses(&mut self, problem: &ImpulseProblem, share: f64) {
        let own = |row: usize| share * problem.w(row, row);
        self.responses.clear();
        self.responses.extend((0..problem.rows()).map(own));
        for (at, law) in &problem.laws {
            if let Some(first) = law.first_tangent() {
                let tangents = &mut self.responses[at + first..][..2];
                tangents.fill((tangents[0] * tangents[1]).sqrt());
            }
        }
    }

    fn step(&mut self, problem: &ImpulseProblem, factors: &[f64], follows: f64) {
        let Self {
            allowed,
            velocities,
            free,
            responses,
            coupled,
            loads,
        } = self;
        coupled.clear();
        coupled.extend(
            (0..free.len()).map(|row| responses[row] * allowed[row] + velocities[row] - free[row]),
        );
        solve_factorised(factors, coupled);
        for row in 0..coupled.len() {
            velocities[row] += responses[row] * (allowed[row] - coupled[row]);
            allowed[row] = coupled[row] - velocities[row] / responses[row];
        }
        for &(at, law) in &problem.laws {
            if let Law::Curve { place } = law {
                let meeting = problem.curves.meet(place, allowed[at], responses[at]);
                allowed[at] = meeting.impulse;
                continue;
            }
            law.allow(&mut allowed[at..], responses[at], (&mut loads[at], follows));
        }
    }
}

impl Law {
    /// Takes impulses to the nearest that the law allows if they answer with this response, in 1/kg, and what friction follows a part of
    /// the way with the load.
    fn allow(&self, asked: &mut [f64], response: f64, (load, follows): (&mut f64, f64)) {
        match *self {
            Law::Joint {
                least_n_m_s,
                most_n_m_s,
            } => asked[0] = asked[0].clamp(least_n_m_s, most_n_m_s),
            Law::Slide {
                least_m_s,
                most_m_s,
            } => match Sliding::on_line(asked[0], response, (least_m_s, most_m_s)) {
                Sliding::At(stop_m_s) => asked[0] += stop_m_s / response,
                Sliding::Free => asked[0] = 0.0,
            },
            Law::Disc { most_n_s } => bound(&mut asked[..2], most_n_s),
            // It is not a law's alone what a curve allows: `Curves::meet`.
            Law::Curve { .. } => {}
            Law::Contact {
                friction,
                approach_m_s,
                compliance,
            } => {
                let normal = (response * asked[0] - approach_m_s) / (response + compliance);
                asked[0] = normal.max(0.0);
                *load += follows * (asked[0] - *load);
                bound(&mut asked[1..3], friction * *load);
            }
        }
    }
}

/// Takes two impulses to the nearest in a disc.
fn bound(asked: &mut [f64], limit: f64) {
    let size = Vector2::new(asked[0], asked[1]).norm();
    if size > limit {
        asked.iter_mut().for_each(|p| *p *= limit / size);
    }
}
