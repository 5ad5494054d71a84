//! How the laws of a step are solved all at once.
//!
//! Newton's method takes all laws at once, differentiated where they stand (Alart and Curnier 1991). A robot that rolls needs one
//! step of it. Where some steps lead nowhere, half steps may do; and where these do not, block Gauss-Seidel sweeps, which solve one law exactly for
//! the others as they are, find out roughly what sticks and what slides, and it begins again from there. Where that leads nowhere either (once in
//! some ten thousand steps on bumps, and in jams), `descent` searches along each step. Rollers that slide along their axles or
//! that rolling costs something have another way to find that out: `split`.

use nalgebra::{Matrix3, Vector3};

use super::descent::Descent;
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
    descent: Descent,
    /// The impulses that broke the laws least so far.
    best: Kept,
    /// Those that the solution was begun from.
    begun: Kept,
}

/// How long is tried.
struct Patience {
    /// Rounds of Newton steps and sweeps, before steps are searched along.
    rounds: usize,
    /// Rounds at most of what `split` solves.
    split_rounds: usize,
    /// Whether half of Newton's steps are tried where whole ones go round.
    halves: bool,
    /// Sweeps in the first round.
    first_sweeps: usize,
    /// Jams of more rows than this are not searched along.
    largest_jam: usize,
}

impl Patience {
    /// Of robots alone. Nearly every step is done after one round. Where wheels spin in long steps, a few sweeps do.
    const OF_ROBOTS: Self = Self {
        rounds: 2,
        split_rounds: 64,
        halves: true,
        first_sweeps: 4,
        largest_jam: usize::MAX,
    };

    /// Where free bodies lie about: in a heap a load is shared in so many ways that half steps rarely help, and each round takes long. Over one of fifty
    /// contacts a search would take half a second.
    const OF_HEAPS: Self = Self {
        rounds: 8,
        split_rounds: 8,
        halves: false,
        first_sweeps: SWEEPS_A_ROUND,
        largest_jam: 150,
    };
}

/// By which contacts what no round has solved is solved, each from where the one before ended, and the first from no impulse: how many times
/// the friction, and how many times as soft. Powers of two, which take back themselves to the bit.
const WAYS: [&[(f64, f64)]; 3] = [
    &[(1.0, 1.0)],
    &[(1.0 / 1048576.0, 1.0), (0.5, 1.0), (1.0, 1.0)],
    &[(1.0, 64.0), (1.0, 8.0), (1.0, 1.0)],
];

/// Sweeps where Newton's method needs a better start.
const SWEEPS_A_ROUND: usize = 50;

/// The same where contacts give: their springs couple them less, and what is missing is mostly which of them slides.
const SOFT_SWEEPS_A_ROUND: usize = 2;

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
        problem.keep(&mut self.begun);
        let rounds = if in_turn {
            patience.split_rounds
        } else {
            patience.rounds
        };
        for round in 0..rounds {
            error = self.newton.steps(problem, error, patience.halves);
            if error <= TOLERANCE {
                return error;
            }
            if error < least {
                least = error;
                problem.keep(&mut self.best);
            }
            let sweeps = if is_compliant {
                SOFT_SWEEPS_A_ROUND
            } else if round == 0 {
                patience.first_sweeps
            } else {
                SWEEPS_A_ROUND
            };
            if in_turn {
                self.split.steps(problem, self.newton.room(), round);
            } else {
                sweep(problem, sweeps);
            }
            error = self.error_in_reach(problem);
        }
        if error >= least {
            problem.go_back(&self.best);
            error = least;
        }
        if in_turn || problem.rows() > patience.largest_jam {
            return error;
        }
        self.solve_jam(problem, error)
    }

    /// Solves what no round has solved, contacts that jam: from the impulses that were supposed, from none, and by way of easier contacts. Leaves the
    /// impulses as they were where none of these breaks the laws less.
    fn solve_jam(&mut self, problem: &mut ImpulseProblem, mut error: f64) -> f64 {
        problem.keep(&mut self.best);
        problem.go_back(&self.begun);
        if self.descend(problem, &mut error) {
            return error;
        }
        for way in WAYS {
            problem.forget_impulses();
            for &(friction, softness) in way {
                problem.scale_friction(friction);
                problem.scale_compliance(softness);
                if (friction, softness) == (1.0, 1.0) {
                    if self.descend(problem, &mut error) {
                        return error;
                    }
                } else {
                    self.descent.steps(problem, self.newton.room());
                }
                problem.scale_friction(1.0 / friction);
                problem.scale_compliance(1.0 / softness);
            }
        }
        problem.go_back(&self.best);
        error
    }

    /// Searches on from the impulses as they are, and keeps where that leads where it breaks the laws less than so far. Says whether that is the
    /// solution.
    fn descend(&mut self, problem: &mut ImpulseProblem, least: &mut f64) -> bool {
        let near = self.descent.steps(problem, self.newton.room());
        let left = self.newton.steps(problem, near, false);
        if left < *least {
            *least = left;
            problem.keep(&mut self.best);
        }
        left <= TOLERANCE
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

/// Solves each law for the others as they are, one after the other, over and over.
fn sweep(problem: &mut ImpulseProblem, sweeps: usize) {
    for _ in 0..sweeps {
        for law in 0..problem.laws.len() {
            solve_one(problem, law);
        }
    }
}

/// Solves one law for the others as they are.
fn solve_one(problem: &mut ImpulseProblem, index: usize) {
    let (at, law) = problem.laws[index];
    match law {
        Law::Joint { .. } => {
            let impulse = problem.impulses[at] - problem.velocities[at] / problem.w(at, at);
            problem.bring(index, Vector3::new(impulse, 0.0, 0.0));
        }
        Law::Curve { place } => {
            let impulse = problem.on_curve(at, place).impulse;
            problem.set(at, impulse);
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
                problem.set(at + k, impulse[k]);
            }
        }
    }
}
