//! How the laws of a step are solved all at once.
//!
//! Newton's method takes all laws at once, differentiated where they stand (Alart and Curnier 1991). A robot that rolls needs one
//! step of it. Where some steps lead nowhere, half steps may do; and where these do not, block Gauss-Seidel sweeps, which solve one law exactly for
//! the others as they are, find out roughly what sticks and what slides, and it begins again from there. Where that leads nowhere either (once in
//! some ten thousand steps on bumps), it goes by way of softer contacts. Rollers that slide along their axles or
//! that rolling costs something have another way to find that out: `split`.

use nalgebra::{Matrix3, Vector3};

use super::kinds::Law;
use super::newton::Newton;
use super::one_contact::contact_impulse;
use super::split::Split;
use super::system::{ImpulseProblem, Kept, TOLERANCE};

/// What solves the laws of a step. It allocates only while it grows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solver {
    newton: Newton,
    split: Split,
    /// The impulses that broke the laws least so far.
    best: Kept,
}

/// How long is tried.
struct Patience {
    /// Rounds of Newton steps and sweeps at most.
    rounds: usize,
    /// Whether half of Newton's steps are tried where whole ones go round.
    halves: bool,
    /// Sweeps in the first round.
    first_sweeps: usize,
    /// Whether what no round solves is solved by way of softer contacts.
    softens: bool,
}

impl Patience {
    /// Of robots alone. Nearly every step is done after one round; where many contacts say nearly the same (rough ground, a chassis that lies on
    /// its side) some need dozens, and a few never get to the last digits. Where wheels spin in long steps, a few sweeps do.
    const OF_ROBOTS: Self = Self {
        rounds: 64,
        halves: true,
        first_sweeps: 4,
        softens: true,
    };

    /// Where free bodies lie about: in a heap a load is shared in so many ways that few steps get to the last digits, and each round takes long.
    const OF_HEAPS: Self = Self {
        rounds: 8,
        halves: false,
        first_sweeps: SWEEPS_A_ROUND,
        softens: false,
    };
}

/// After so many rounds sweeps go half as far: contacts that press one another down would swing to and fro for ever.
const ROUNDS_A_SHARE: usize = 8;

/// Contacts that no round has solved are softened 2^12 times, and then half as much each time: powers of two, which take back themselves to the bit.
const SOFTENINGS: i32 = 12;

/// Sweeps where Newton's method needs a better start.
const SWEEPS_A_ROUND: usize = 50;

/// The same where contacts give: their springs couple them less, and what is missing is mostly which of them slides. Where so few do
/// not lead anywhere in some rounds, more is missing.
const SOFT_SWEEPS_A_ROUND: usize = 2;

/// Rounds of so few sweeps.
const SOFT_ROUNDS: usize = 8;

impl Solver {
    /// Solves for the impulses, from those that are supposed; `with_free_bodies` where free bodies lie about. Gives back by how much the laws
    /// are broken in the end, in m/s or rad/s.
    pub fn solve(&mut self, problem: &mut ImpulseProblem, with_free_bodies: bool) -> f64 {
        let patience = if with_free_bodies {
            Patience::OF_HEAPS
        } else {
            Patience::OF_ROBOTS
        };
        let error = self.solve_in_discs(problem, &patience);
        problem.take_back();
        error
    }

    /// Where matrices are written; what stands there counts for nothing between two calls: whoever solves something else afterwards may use
    /// it, so that the robots of a fleet do not each keep another.
    pub fn room(&mut self) -> &mut Vec<f64> {
        self.newton.room()
    }

    fn solve_in_discs(&mut self, problem: &mut ImpulseProblem, patience: &Patience) -> f64 {
        let in_turn = problem.has_rollers_of_several_laws();
        let is_compliant = problem.is_compliant();
        let mut error = problem.error();
        if error <= TOLERANCE {
            return error;
        }
        let mut least = error;
        problem.keep(&mut self.best);
        for round in 0..patience.rounds {
            let share = 0.5_f64.powi((round / ROUNDS_A_SHARE) as i32);
            error = self.newton.steps(problem, error, patience.halves);
            if error <= TOLERANCE {
                return error;
            }
            if error < least {
                least = error;
                problem.keep(&mut self.best);
            }
            let sweeps = if is_compliant && round < SOFT_ROUNDS {
                SOFT_SWEEPS_A_ROUND
            } else if round == 0 {
                patience.first_sweeps
            } else {
                SWEEPS_A_ROUND
            };
            if in_turn {
                self.split.steps(problem, self.newton.room(), round);
            } else {
                sweep(problem, sweeps, share);
            }
            error = self.error_in_reach(problem);
        }
        if error >= least {
            problem.go_back(&self.best);
            error = least;
        }
        if in_turn || !patience.softens {
            return error;
        }
        self.solve_from_softer(problem, error)
    }

    /// Solves what no round has solved by way of softer contacts, which share a load in one way only: from much softer ones on to those that are
    /// meant, each from where the one before ended. Leaves the impulses as they were where that breaks the laws no less.
    fn solve_from_softer(&mut self, problem: &mut ImpulseProblem, error: f64) -> f64 {
        problem.keep(&mut self.best);
        for halvings in (0..=SOFTENINGS).rev() {
            let times = 2.0_f64.powi(halvings);
            problem.scale_compliance(times);
            for _ in 0..ROUNDS_A_SHARE {
                sweep(problem, SWEEPS_A_ROUND, 1.0);
                let left = self.error_in_reach(problem);
                if self.newton.steps(problem, left, false) <= TOLERANCE {
                    break;
                }
            }
            problem.scale_compliance(1.0 / times);
        }
        let found = problem.error();
        if found < error {
            return found;
        }
        problem.go_back(&self.best);
        error
    }

    /// By how much the laws are broken after sweeps; where these have led beyond all bounds, by the impulses that broke them least so far, to which it
    /// goes back.
    fn error_in_reach(&self, problem: &mut ImpulseProblem) -> f64 {
        problem.follow_impulses();
        let error = problem.error();
        if error < f64::INFINITY {
            return error;
        }
        problem.go_back(&self.best);
        problem.error()
    }
}

/// Goes a share of the way to where each law is solved for the others as they are, one after the other, over and over.
fn sweep(problem: &mut ImpulseProblem, sweeps: usize, share: f64) {
    for _ in 0..sweeps {
        for law in 0..problem.laws.len() {
            solve_one(problem, law, share);
        }
    }
}

/// Goes a share of the way to where one law is solved for the others as they are.
fn solve_one(problem: &mut ImpulseProblem, index: usize, share: f64) {
    let (at, law) = problem.laws[index];
    match law {
        Law::Joint { .. } => {
            let impulse = problem.impulses[at] - share * problem.velocities[at] / problem.w(at, at);
            problem.bring(index, Vector3::new(impulse, 0.0, 0.0));
        }
        Law::Curve { place } => {
            let by = problem.on_curve(at, place).impulse - problem.impulses[at];
            problem.set(at, problem.impulses[at] + share * by);
        }
        // Beside these no sweeps are gone: `split`.
        Law::Slide { .. } | Law::Disc { .. } => {}
        Law::Contact {
            friction,
            approach_m_s,
            compliance,
        } => {
            let own = Matrix3::from_fn(|i, j| problem.w(at + i, at + j));
            let free = problem.contact_velocity(at) - own * problem.contact_impulse(at);
            let give = (approach_m_s, compliance);
            let impulse = contact_impulse(&own, &free, friction, give);
            for k in 0..3 {
                let now = problem.impulses[at + k];
                problem.set(at + k, now + share * (impulse[k] - now));
            }
        }
    }
}
