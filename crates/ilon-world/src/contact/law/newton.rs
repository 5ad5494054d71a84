//! Newton's method on all laws of a step at once, differentiated where they stand (Alart and Curnier 1991).

use nalgebra::{Vector2, Vector3};

use super::curve::Meeting;
use super::kinds::{Law, Sliding};
use super::system::{ImpulseProblem, Kept, TOLERANCE, pair};
use crate::contact::linear::solve_in_place;

/// Redundant contacts can share a load in many ways: the least softness picks one, and the same one whichever way it is found, or loads at rest would leap.
pub(super) const RIDGE: f64 = 1e-6;

/// What a law does as things stand.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Regime {
    /// A contact that carries nothing.
    Open,
    /// It presses, or holds, and nothing slides.
    Sticks,
    /// A contact that slides, or what is held in a disc and moves.
    Slides {
        /// Where friction pulls, among the tangents.
        along: Vector2<f64>,
        /// The largest friction impulse over the one that would stop the sliding, roughly.
        share: f64,
        /// Impulse per velocity, in N s per m/s.
        scale: f64,
    },
    /// A joint that turns against this impulse, in N m s; 0 of a roller that slides along its axle.
    Turns(f64),
    /// A roller that moves along its axle at this velocity, in m/s: to a stop.
    Moves(f64),
    /// A row on a piece of its curve.
    Along(Meeting),
}

/// Room for Newton's method.
#[derive(Clone, Debug, Default)]
pub(super) struct Newton {
    matrix: Vec<f64>,
    step: Vec<f64>,
    kept: Kept,
}

impl Regime {
    /// What a law does as things stand: which part of it holds for the impulse less the velocity, the two brought to one
    /// scale by the law's own response.
    fn of(problem: &ImpulseProblem, (at, law): (usize, Law)) -> Self {
        let own = problem.w(at, at);
        match law {
            Law::Joint {
                least_n_m_s,
                most_n_m_s,
            } => {
                let holding = problem.impulses[at] - problem.velocities[at] / own;
                let within = holding.clamp(least_n_m_s, most_n_m_s);
                if holding == within {
                    Self::Sticks
                } else {
                    Self::Turns(within)
                }
            }
            Law::Slide { .. } => match problem.sliding((at, law)) {
                Some(Sliding::At(stop_m_s)) => Self::Moves(stop_m_s),
                Some(Sliding::Free) => Self::Turns(0.0),
                None => Self::Sticks,
            },
            Law::Contact {
                friction,
                approach_m_s,
                compliance,
            } => {
                let (p, u) = (problem.contact_impulse(at), problem.contact_velocity(at));
                if p.x - (u.x + approach_m_s + compliance * p.x) / own <= 0.0 {
                    return Self::Open;
                }
                Self::in_disc(problem, at + 1, friction * p.x)
            }
            Law::Disc { most_n_s } => Self::in_disc(problem, at, most_n_s),
            Law::Curve { place } => Self::Along(problem.on_curve(at, place)),
        }
    }

    /// What two rows do whose impulse is held in a disc of this size.
    fn in_disc(problem: &ImpulseProblem, at: usize, limit: f64) -> Self {
        let scale = 1.0 / (problem.w(at, at) + problem.w(at + 1, at + 1));
        let pull = pair(&problem.impulses, at) - scale * pair(&problem.velocities, at);
        let size = pull.norm();
        if size > limit {
            Self::Slides {
                along: pull / size,
                share: limit / size,
                scale,
            }
        } else {
            Self::Sticks
        }
    }
}

impl Newton {
    /// Goes steps of Newton's method from an error, as far as the one that comes nearest to the solution; stays where none comes
    /// nearer. Gives the error that is left.
    ///
    /// Whole steps may go round between two sets of contacts that stick, slide and are open, where motors reach their rate limits too. With `halves`
    /// it goes on from the nearest then with half steps, which lead out of two in five of such steps where wheels spin.
    ///
    /// What a step does to the error does not say whether it is right. Contacts on a stiff floor share a load in ways that hardly
    /// change any velocity: an error of 1e-6 m/s may stand for a hundredth of a load. A step goes all the way there, what slides
    /// turns meanwhile by the square of it, and the next step repairs that.
    pub fn steps(&mut self, problem: &mut ImpulseProblem, error: f64, halves: bool) -> f64 {
        /// From where they lead anywhere the error falls by squares.
        const WHOLE: [f64; 8] = [1.0; 8];
        const HALVES: [f64; 6] = [0.5, 0.5, 0.5, 0.5, 1.0, 1.0];
        problem.keep(&mut self.kept);
        let best = self.go_steps(problem, error, &WHOLE);
        if halves && best > TOLERANCE {
            return self.go_steps(problem, best, &HALVES);
        }
        best
    }

    /// Goes steps, of each a share, and back to the nearest of all so far, whose error is given. Gives the error that is left.
    fn go_steps(&mut self, problem: &mut ImpulseProblem, error: f64, shares: &[f64]) -> f64 {
        let mut best = error;
        for share in shares {
            if !self.go_a_step(problem, *share) {
                break;
            }
            let reached = problem.error();
            // From nowhere no step leads back.
            if reached == f64::INFINITY {
                break;
            }
            if reached < best {
                best = reached;
                if best <= TOLERANCE {
                    return best;
                }
                problem.keep(&mut self.kept);
            }
        }
        problem.go_back(&self.kept);
        best
    }

    /// Goes a share of one step of Newton's method, put back into the laws' bounds. Says whether there is one.
    fn go_a_step(&mut self, problem: &mut ImpulseProblem, share: f64) -> bool {
        self.linearise(problem);
        if !solve_in_place(&mut self.matrix, &mut self.step) {
            return false;
        }
        for law in 0..problem.laws.len() {
            let (at, kind) = problem.laws[law];
            // No other law's step changes its impulses.
            let there = |k: usize| problem.impulses[at + k] + share * self.step[at + k];
            let asked = match kind {
                Law::Joint { .. } | Law::Slide { .. } | Law::Curve { .. } => {
                    Vector3::new(there(0), 0.0, 0.0)
                }
                Law::Disc { .. } => Vector3::new(there(0), there(1), 0.0),
                Law::Contact { .. } => Vector3::new(there(0), there(1), there(2)),
            };
            problem.bring(law, asked);
        }
        true
    }

    /// Writes down the laws' derivatives where they stand, and what is missing from them.
    fn linearise(&mut self, problem: &ImpulseProblem) {
        let rows = problem.rows();
        self.clear(rows);
        for &(at, law) in &problem.laws {
            match (Regime::of(problem, (at, law)), law) {
                (Regime::Open, _) => {
                    (at..at + 3).for_each(|row| self.fix(row, -problem.impulses[row]))
                }
                (Regime::Turns(impulse), _) => self.fix(at, impulse - problem.impulses[at]),
                (Regime::Moves(stop_m_s), _) => {
                    self.stop(at, problem);
                    self.step[at] += stop_m_s;
                }
                (Regime::Along(meeting), _) => self.follow(at, &meeting, problem),
                (_, Law::Joint { .. } | Law::Slide { .. } | Law::Curve { .. }) => {
                    self.stop(at, problem);
                }
                (regime, Law::Disc { most_n_s }) => {
                    (at..at + 2).for_each(|row| self.stop(row, problem));
                    if let Regime::Slides {
                        along,
                        share,
                        scale,
                    } = regime
                    {
                        let disc = (most_n_s, None);
                        self.linearise_sliding(problem, (at, disc), (along, share, scale));
                    }
                }
                (
                    regime,
                    Law::Contact {
                        friction,
                        approach_m_s,
                        compliance,
                    },
                ) => {
                    (at..at + 3).for_each(|row| self.stop(row, problem));
                    self.matrix[at * rows + at] += compliance;
                    self.step[at] -= approach_m_s + compliance * problem.impulses[at];
                    if let Regime::Slides {
                        along,
                        share,
                        scale,
                    } = regime
                    {
                        let disc = (friction * problem.impulses[at], Some((at, friction)));
                        self.linearise_sliding(problem, (at + 1, disc), (along, share, scale));
                    }
                }
            }
        }
    }

    /// Two rows that move against a disc of a size: p = size q/|q| with q = p - scale u, differentiated. The size may grow with the impulse
    /// of another row.
    fn linearise_sliding(
        &mut self,
        problem: &ImpulseProblem,
        (at, (limit, grows)): (usize, (f64, Option<(usize, f64)>)),
        (along, share, scale): (Vector2<f64>, f64, f64),
    ) {
        let rows = problem.rows();
        let tangents = [at, at + 1];
        for (i, row) in tangents.into_iter().enumerate() {
            self.matrix[row * rows..][..rows].fill(0.0);
            self.fix(row, limit * along[i] - problem.impulses[row]);
            let line = &mut self.matrix[row * rows..][..rows];
            if let Some((with, by)) = grows {
                line[with] -= by * along[i];
            }
            for (j, other) in tangents.into_iter().enumerate() {
                let across = if i == j { 1.0 } else { 0.0 } - along[i] * along[j];
                line[other] -= share * across;
                let of_velocity = &problem.delassus[other * rows..][..rows];
                for (entry, w) in line.iter_mut().zip(of_velocity) {
                    *entry += share * across * scale * w;
                }
            }
        }
    }

    /// Where the matrix is written; what stands there counts for nothing between two calls.
    pub fn room(&mut self) -> &mut Vec<f64> {
        &mut self.matrix
    }

    fn clear(&mut self, rows: usize) {
        self.matrix.clear();
        self.matrix.resize(rows * rows, 0.0);
        self.step.clear();
        self.step.resize(rows, 0.0);
    }

    /// A row whose impulse changes by so much.
    fn fix(&mut self, row: usize, by: f64) {
        self.matrix[row * self.step.len() + row] = 1.0;
        self.step[row] = by;
    }

    /// A row that shall come to the straight line on which it meets its curve: across the line, velocity and impulse change by what is
    /// missing.
    fn follow(&mut self, row: usize, meeting: &Meeting, problem: &ImpulseProblem) {
        let [of_velocity, of_impulse] = meeting.across(problem.w(row, row));
        let missing_velocity = meeting.velocity - problem.velocities[row];
        let missing_impulse = meeting.impulse - problem.impulses[row];
        self.stop(row, problem);
        let rows = self.step.len();
        let line = &mut self.matrix[row * rows..][..rows];
        line.iter_mut().for_each(|w| *w *= of_velocity);
        line[row] += of_impulse;
        self.step[row] = of_velocity * missing_velocity + of_impulse * missing_impulse;
    }

    /// A row whose velocity shall vanish: W dp = -u.
    fn stop(&mut self, row: usize, problem: &ImpulseProblem) {
        let rows = self.step.len();
        let line = &mut self.matrix[row * rows..][..rows];
        line.copy_from_slice(&problem.delassus[row * rows..][..rows]);
        line[row] *= 1.0 + RIDGE;
        self.step[row] = -problem.velocities[row];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dry bearings on one axle, each at its torque, and one that holds, all from impulses that are no solution.
    fn bearings(most_n_m_s: [f64; 2], response: [f64; 4], start: [f64; 2]) -> ImpulseProblem {
        let mut problem = ImpulseProblem::default();
        for most_n_m_s in most_n_m_s {
            let least_n_m_s = -most_n_m_s;
            let law = Law::Joint {
                least_n_m_s,
                most_n_m_s,
            };
            problem.push(law, &[0.5]);
        }
        problem.set_delassus(|row, w| w.copy_from_slice(&response[2 * row..][..=row]));
        problem.set(0, start[0]);
        problem.set(1, start[1]);
        problem
    }

    /// Laws that stay as they are linear, and one step of Newton's method solves them from anywhere: a dry bearing that turns takes its friction,
    /// p_0 = -0.1, and one that holds leaves nothing, 0.5 + 0.5 p_0 + 2 p_1 = 0.
    #[test]
    fn one_step_reaches_what_bearings_do_that_turn_or_hold_already() {
        for start in [[0.0, 0.0], [0.06, -0.3], [-0.1, 0.4]] {
            let mut axle = bearings([0.1, 9.0], [2.5, 0.5, 0.5, 2.0], start);
            assert!(Newton::default().go_a_step(&mut axle, 1.0));
            let [turns, holds] = [axle.impulses[0], axle.impulses[1]];
            assert!((turns + 0.1).abs() < 1e-15, "{turns}");
            // The least softness takes a millionth of what the step adds.
            assert!((holds + 0.225).abs() < 1e-6, "{holds}");
        }
    }

    /// Two bearings of one axle that both hold it share what it takes, half each, though any other shares would do: they give by the same softness,
    /// and the axle turns on a little, as it did, by a share of 1e-6 w / (2 w).
    #[test]
    fn what_can_be_shared_in_any_way_is_shared_by_a_softness() {
        let mut axle = bearings([9.0; 2], [2.0; 4], [0.0; 2]);
        assert!(Newton::default().go_a_step(&mut axle, 1.0));
        let [first, second] = [axle.impulses[0], axle.impulses[1]];
        // What rounding leaves of W, 1e-16, over the softness.
        assert!((first + 0.125).abs() < 1e-6 && (first - second).abs() < 1e-9);
        let share = axle.velocities[0] / 0.5;
        assert!((share - 0.5e-6).abs() < 1e-9, "{share:e}");
    }

    /// Near the solution of a contact that slides a step leaves the square of what is missing: a thousandth of an impulse becomes millionths. With any other
    /// derivative a part of the thousandth would stay.
    #[test]
    fn a_step_of_what_slides_leaves_the_square_of_what_is_missing() {
        let response = [1.0, 0.2, -0.1, 0.2, 2.0, 0.3, -0.1, 0.3, 5.0];
        let mut sliding = ImpulseProblem::default();
        let law = Law::Contact {
            friction: 0.5,
            approach_m_s: 0.0,
            compliance: 0.0,
        };
        sliding.push(law, &[-1.0, 30.0, 20.0]);
        sliding.set_delassus(|row, w| w.copy_from_slice(&response[3 * row..][..=row]));
        let mut newton = Newton::default();
        for _ in 0..20 {
            newton.go_a_step(&mut sliding, 1.0);
        }
        assert!(sliding.error() <= TOLERANCE, "{}", sliding.error());
        let solution = sliding.contact_impulse(0);
        assert!((solution.yz().norm() / solution.x - 0.5).abs() < 1e-9);
        // Along the disc's edge, and the load.
        let across = Vector2::new(-solution.z, solution.y).normalize();
        let off = Vector3::new(1.0, across.x, across.y) * 1e-3 * solution.x;
        for row in 0..3 {
            sliding.set(row, solution[row] + off[row]);
        }
        newton.go_a_step(&mut sliding, 1.0);
        let left = (sliding.contact_impulse(0) - solution).norm() / solution.x;
        assert!(left < 1e-5, "{left:e}");
    }
}
