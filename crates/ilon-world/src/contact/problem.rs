//! The impulses of a step: what the ground and dry bearings do to a robot, solved to the end.
//!
//! A sweep through a robot's degrees of freedom is dear and converges slowly, because a roller is light across its axis
//! (it spins) and heavy along it (it carries the robot). Here the problem is written down between the impulses alone,
//! where both a sweep and a direct solution cost next to nothing:
//!
//! u = u_free + W p, with u the velocities where the impulses p act and W the Delassus matrix, what a unit impulse at one
//! place does to the velocity at another, and a law for each of them:
//!
//! - *contact*, Signorini: p_n >= 0, u_n + b + c p_n >= 0, one of them 0 (b is the gap's, c the compliance of the
//!   contact);
//! - *contact*, Coulomb: |p_t| <= mu p_n; it sticks, or p_t is as large as it may be and opposes the sliding u_t;
//! - *joint*: least <= p <= most; it sticks, or p is as large as it may be and opposes the turning;
//! - *disc*: |p| <= most, over two rows; it sticks, or p is as large as it may be and opposes the motion;
//! - *slide*, between two stops: least <= u <= most, and p = 0 but at a stop, from which it pushes;
//! - *curve*: (u, p) lies on a curve of straight pieces along which velocity grows: a motor at its bounds with its gear.
//!
//! Newton's method takes all laws at once, differentiated where they stand (Alart and Curnier 1991). A robot that rolls needs one
//! step of it. Where some steps lead nowhere, block Gauss-Seidel sweeps, which solve one law exactly for the others as they are,
//! find out roughly what sticks and what slides, and it begins again from there. Rollers that slide along their axles or
//! that rolling costs something have another way to find that out: `split`.

mod curve;
mod newton;
mod one_contact;
mod split;
mod stretch;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, Vector2, Vector3};

pub(crate) use curve::Curve;
use curve::Curves;
use newton::Newton;
use one_contact::contact_impulse;
use split::Split;
use stretch::Stretch;

/// What holds between an impulse and the velocity where it acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Law {
    /// Three rows: the normal and two tangents.
    Contact {
        /// Coulomb friction coefficient mu.
        friction: f64,
        /// b: the contact may come nearer by at most this, in m/s; negative where it shall be pushed apart.
        approach_m_s: f64,
        /// c: compliance of the contact over the step, in m/s per N s: it gives by this much for what it carries.
        compliance: f64,
    },
    /// One row: the turning of a joint, held within bounds. Dry friction has bounds of equal size; what keeps a motor from
    /// driving beyond a rate has 0 as one of them, and its velocity is counted from that rate.
    Joint {
        /// The impulse while the joint turns forwards, in N m s, <= 0.
        least_n_m_s: f64,
        /// The impulse while it turns backwards, in N m s, >= 0.
        most_n_m_s: f64,
    },
    /// Two rows: a motion in a plane that is held by an impulse of bounded size, in whatever direction.
    Disc {
        /// The impulse while it moves, in N s, >= 0.
        most_n_s: f64,
    },
    /// One row: a roller along its axle, between two stops.
    Slide {
        /// The velocity that takes it to the stop behind within the step, in m/s, <= 0.
        least_m_s: f64,
        /// The velocity that takes it to the stop ahead, in m/s, >= 0.
        most_m_s: f64,
    },
    /// One row: velocity and impulse lie on a curve, which is added before: [`ImpulseProblem::add_curve`].
    Curve {
        /// Its place among the curves.
        place: usize,
    },
}

/// What holds of one row that slides between stops.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sliding {
    /// It is at a stop, to which this velocity takes it, in m/s.
    At(f64),
    /// It slides, without impulse.
    Free,
}

impl Law {
    fn rows(&self) -> usize {
        match self {
            Law::Contact { .. } => 3,
            Law::Disc { .. } => 2,
            Law::Joint { .. } | Law::Slide { .. } | Law::Curve { .. } => 1,
        }
    }

    /// Which of its rows is the first of two among which its friction lies.
    fn first_tangent(&self) -> Option<usize> {
        match self {
            Law::Contact { .. } => Some(1),
            Law::Disc { .. } => Some(0),
            Law::Joint { .. } | Law::Slide { .. } | Law::Curve { .. } => None,
        }
    }
}

impl Sliding {
    /// What holds of a row of a response `own` in 1/kg, on a `line` p - u / own: as the velocity falls from stop to stop, the
    /// impulse grows, so that each of these lines meets the law once.
    fn on_line(line: f64, own: f64, (least_m_s, most_m_s): (f64, f64)) -> Self {
        if line > -least_m_s / own {
            Self::At(least_m_s)
        } else if line < -most_m_s / own {
            Self::At(most_m_s)
        } else {
            Self::Free
        }
    }
}

/// The impulses of a step. It is cleared and filled again in every step and allocates only while it grows.
#[derive(Clone, Debug, Default)]
pub(crate) struct ImpulseProblem {
    /// With the first row of each.
    laws: Vec<(usize, Law)>,
    /// p, in N s or N m s.
    impulses: Vec<f64>,
    /// u, in m/s or rad/s.
    velocities: Vec<f64>,
    /// What stands on W's diagonal beside the robot's response, in m/s per N s: contacts that give across their normal.
    softness: Vec<f64>,
    /// W, row by row.
    delassus: Vec<f64>,
    /// Of contacts that grip otherwise by direction.
    stretches: Vec<Stretch>,
    /// Contacts that give otherwise by direction: the row of the first tangent, and what stands beside W's diagonal, in m/s per N s.
    coupled: Vec<(usize, f64)>,
    curves: Curves,
    newton: Newton,
    split: Split,
    /// The impulses that broke the laws least so far.
    best: Vec<f64>,
    /// Whether it holds free bodies.
    holds_heaps: bool,
}

/// Solved, when no law is broken by more than this, in m/s or rad/s: what f32 resolves of a slow robot's rates.
const TOLERANCE: f64 = 1e-8;

/// Rounds of Newton steps and sweeps at most. Nearly every step is done after one; where many contacts say nearly the same
/// (rough ground, a chassis that lies on its side) some need dozens, and a few never get to the last digits.
const ROUNDS: usize = 64;

/// The same where free bodies lie about: in a heap a load is shared in so many ways that few steps get to the last digits, and each round takes
/// long.
const ROUNDS_OF_HEAPS: usize = 8;

/// After so many rounds sweeps go half as far: contacts that press one another down would swing to and fro for ever.
const ROUNDS_A_SHARE: usize = 8;

/// Sweeps where Newton's method needs a better start.
const SWEEPS_A_ROUND: usize = 50;

/// The same where contacts give: their springs couple them less, and what is missing is mostly which of them slides. Where so few do
/// not lead anywhere in some rounds, more is missing.
const SOFT_SWEEPS_A_ROUND: usize = 2;

/// Rounds of so few sweeps.
const SOFT_ROUNDS: usize = 8;

impl ImpulseProblem {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.laws.clear();
        self.impulses.clear();
        self.velocities.clear();
        self.softness.clear();
        self.stretches.clear();
        self.coupled.clear();
        self.curves.clear();
    }

    /// Adds a law, with the velocity that there would be without any impulse: normal and two tangents of a contact, the
    /// rate of a joint.
    pub fn push(&mut self, law: Law, free_velocity: &[f64]) {
        debug_assert_eq!(free_velocity.len(), law.rows());
        self.laws.push((self.velocities.len(), law));
        self.velocities.extend_from_slice(free_velocity);
        self.impulses.resize(self.velocities.len(), 0.0);
        self.softness.resize(self.velocities.len(), 0.0);
    }

    /// Says whether it holds free bodies.
    pub fn hold_heaps(&mut self, holds: bool) {
        self.holds_heaps = holds;
    }

    /// Lets the contact that was added last give along its tangents, by so much in m/s per N s: what it holds and what slides is
    /// then the velocity where it acts, and what it gives on top.
    pub fn soften(&mut self, tangents: [f64; 2]) {
        let rows = self.rows();
        self.softness[rows - 2..].copy_from_slice(&tangents);
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.velocities.len()
    }

    /// Sets W once all laws are there. `fill` takes a row's place, and room for what it has on and before the diagonal.
    pub fn set_delassus(&mut self, fill: impl Fn(usize, &mut [f64])) {
        let rows = self.rows();
        self.delassus.clear();
        self.delassus.resize(rows * rows, 0.0);
        for row in 0..rows {
            let (above, below) = self.delassus.split_at_mut(row * rows);
            let own = &mut below[..=row];
            fill(row, own);
            own[row] += self.softness[row];
            for (other, w) in above.chunks_exact_mut(rows).zip(own) {
                other[row] = *w;
            }
        }
        for (at, coupled) in &self.coupled {
            self.delassus[at * rows + at + 1] += coupled;
            self.delassus[(at + 1) * rows + at] += coupled;
        }
        self.stretch_response();
    }

    /// Starts the solution of the law that was added at a place from an impulse: the nearest that the law allows. Of a
    /// law of fewer rows only the first numbers count.
    pub fn warm_start(&mut self, law: usize, mut asked: Vector3<f64>) {
        if let (at, Some(first)) = (self.laws[law].0, self.laws[law].1.first_tangent()) {
            let rubs = self.in_disc(at + first, asked.fixed_rows::<2>(first).into_owned());
            asked.fixed_rows_mut::<2>(first).copy_from(&rubs);
        }
        self.bring(law, asked);
    }

    /// Sets the impulse of a law to the nearest that it allows.
    fn bring(&mut self, law: usize, asked: Vector3<f64>) {
        let (at, law) = self.laws[law];
        match law {
            Law::Joint {
                least_n_m_s,
                most_n_m_s,
            } => self.set(at, asked.x.clamp(least_n_m_s, most_n_m_s)),
            Law::Slide { .. } | Law::Curve { .. } => self.set(at, asked.x),
            Law::Disc { most_n_s } => self.set_within(at, asked.xy(), most_n_s),
            Law::Contact { friction, .. } => {
                let normal = asked.x.max(0.0);
                self.set(at, normal);
                self.set_within(at + 1, asked.yz(), friction * normal);
            }
        }
    }

    /// Sets two impulses to the nearest in a disc.
    fn set_within(&mut self, at: usize, mut asked: Vector2<f64>, limit: f64) {
        let size = asked.norm();
        if size > limit {
            asked *= limit / size;
        }
        self.set(at, asked.x);
        self.set(at + 1, asked.y);
    }

    /// Sets an impulse, and the velocities that follow.
    fn set(&mut self, row: usize, impulse: f64) {
        let by = impulse - self.impulses[row];
        if by != 0.0 {
            self.impulses[row] = impulse;
            let rows = self.rows();
            // W is symmetric: its row is its column.
            let column = &self.delassus[row * rows..][..rows];
            for (velocity, w) in self.velocities.iter_mut().zip(column) {
                *velocity += w * by;
            }
        }
    }

    /// Whether friction holds a contact or a bearing, as the impulses are now: within its limit.
    pub fn holds(&self, law: usize) -> bool {
        let (at, law) = self.laws[law];
        match law {
            Law::Joint {
                least_n_m_s,
                most_n_m_s,
            } => {
                let p = self.impulses[at];
                least_n_m_s * (1.0 - 1e-9) < p && p < most_n_m_s * (1.0 - 1e-9)
            }
            Law::Slide { .. } => matches!(self.sliding((at, law)), Some(Sliding::At(_))),
            Law::Curve { place } => self.on_curve(at, place).is_upright(),
            Law::Disc { most_n_s } => {
                self.in_disc(at, pair(&self.impulses, at)).norm() < most_n_s * (1.0 - 1e-9)
            }
            Law::Contact { friction, .. } => {
                let p = self.contact_impulse(at);
                self.in_disc(at + 1, p.yz()).norm() < friction * p.x * (1.0 - 1e-9)
            }
        }
    }

    /// The impulses as they are now, row by row, in N s or N m s.
    pub fn impulses(&self) -> &[f64] {
        &self.impulses
    }

    /// The velocities where they act, row by row, in m/s or rad/s; of contacts that give, with what they give.
    pub fn velocities(&self) -> &[f64] {
        &self.velocities
    }

    /// Solves for the impulses, from those that are supposed. Gives back by how much the laws are broken in the end, in
    /// m/s or rad/s.
    pub fn solve(&mut self) -> f64 {
        let error = self.solve_in_discs();
        if !self.stretches.is_empty() {
            self.take_back();
        }
        error
    }

    fn solve_in_discs(&mut self) -> f64 {
        let in_turn = self.has_rollers_of_several_laws();
        let gives = self.softness.iter().any(|softness| *softness > 0.0);
        let mut error = self.error();
        if error <= TOLERANCE {
            return error;
        }
        let mut least = f64::INFINITY;
        let rounds = if self.holds_heaps {
            ROUNDS_OF_HEAPS
        } else {
            ROUNDS
        };
        for round in 0..rounds {
            let share = 0.5_f64.powi((round / ROUNDS_A_SHARE) as i32);
            error = self.newton_steps(error);
            if error <= TOLERANCE {
                return error;
            }
            if error < least {
                least = error;
                self.best.clear();
                self.best.extend_from_slice(&self.impulses);
            }
            let sweeps = if gives && round < SOFT_ROUNDS {
                SOFT_SWEEPS_A_ROUND
            } else {
                SWEEPS_A_ROUND
            };
            if in_turn {
                self.split_steps(round);
            } else {
                self.sweep(sweeps, share);
            }
            error = self.error();
        }
        if error < least {
            return error;
        }
        for row in 0..self.rows() {
            self.set(row, self.best[row]);
        }
        least
    }

    /// Exchanges the room in which Newton's method writes its matrix: whoever solves something else afterwards may use it, so that
    /// the robots of a fleet do not each keep another.
    pub fn swap_room(&mut self, room: &mut Vec<f64>) {
        self.newton.swap_matrix(room);
    }

    /// W of two rows.
    pub fn w(&self, row: usize, column: usize) -> f64 {
        self.delassus[row * self.rows() + column]
    }

    fn contact_impulse(&self, at: usize) -> Vector3<f64> {
        Vector3::from_row_slice(&self.impulses[at..at + 3])
    }

    fn contact_velocity(&self, at: usize) -> Vector3<f64> {
        Vector3::from_row_slice(&self.velocities[at..at + 3])
    }

    /// What holds of a row that slides between stops, as things stand; `None` of other laws.
    fn sliding(&self, (at, law): (usize, Law)) -> Option<Sliding> {
        let Law::Slide {
            least_m_s,
            most_m_s,
        } = law
        else {
            return None;
        };
        let own = self.w(at, at);
        let line = self.impulses[at] - self.velocities[at] / own;
        Some(Sliding::on_line(line, own, (least_m_s, most_m_s)))
    }

    /// Goes a share of the way to where each law is solved for the others as they are, one after the other, over and over.
    fn sweep(&mut self, sweeps: usize, share: f64) {
        for _ in 0..sweeps {
            for law in 0..self.laws.len() {
                self.solve_one(law, share);
            }
        }
    }

    /// Goes a share of the way to where one law is solved for the others as they are.
    fn solve_one(&mut self, index: usize, share: f64) {
        let (at, law) = self.laws[index];
        match law {
            Law::Joint { .. } => {
                let impulse = self.impulses[at] - share * self.velocities[at] / self.w(at, at);
                self.bring(index, Vector3::new(impulse, 0.0, 0.0));
            }
            Law::Curve { place } => {
                let by = self.on_curve(at, place).impulse - self.impulses[at];
                self.set(at, self.impulses[at] + share * by);
            }
            // Beside these no sweeps are gone: `split`.
            Law::Slide { .. } | Law::Disc { .. } => {}
            Law::Contact {
                friction,
                approach_m_s,
                compliance,
            } => {
                let own = Matrix3::from_fn(|i, j| self.w(at + i, at + j));
                let free = self.contact_velocity(at) - own * self.contact_impulse(at);
                let give = (approach_m_s, compliance);
                let impulse = contact_impulse(&own, &free, friction, give);
                for k in 0..3 {
                    let now = self.impulses[at + k];
                    self.set(at + k, now + share * (impulse[k] - now));
                }
            }
        }
    }

    /// By how much the laws are broken, in m/s or rad/s: the most of all. An impulse beyond what friction can do counts by
    /// the velocity that the excess makes where it acts.
    fn error(&self) -> f64 {
        let of = |&(at, law): &(usize, Law)| match law {
            Law::Joint {
                least_n_m_s,
                most_n_m_s,
            } => {
                let (p, u) = (self.impulses[at], self.velocities[at]);
                let excess = (least_n_m_s - p).max(p - most_n_m_s).max(0.0) * self.w(at, at);
                let opposes = if u > 0.0 {
                    p <= least_n_m_s * (1.0 - 1e-9)
                } else {
                    p >= most_n_m_s * (1.0 - 1e-9)
                };
                excess.max(if opposes { 0.0 } else { u.abs() })
            }
            // How far the nearest point of the law on the row's line is: in velocity as in what the impulse makes of one.
            Law::Slide { .. } => match self.sliding((at, law)) {
                Some(Sliding::At(stop_m_s)) => (self.velocities[at] - stop_m_s).abs(),
                Some(Sliding::Free) => self.impulses[at].abs() * self.w(at, at),
                None => 0.0,
            },
            Law::Contact {
                friction,
                approach_m_s,
                compliance,
            } => {
                let (p, u) = (self.contact_impulse(at), self.contact_velocity(at));
                let gap = u.x + approach_m_s + compliance * p.x;
                let normal = if p.x > 0.0 {
                    gap.abs()
                } else {
                    (-gap).max(-p.x * self.w(at, at))
                };
                normal.max(self.error_in_disc(at + 1, friction * p.x.max(0.0)))
            }
            Law::Disc { most_n_s } => self.error_in_disc(at, most_n_s),
            Law::Curve { place } => (self.on_curve(at, place).velocity - self.velocities[at]).abs(),
        };
        self.laws.iter().map(of).fold(0.0, f64::max)
    }

    /// The same of two rows whose impulse is held in a disc of this size.
    fn error_in_disc(&self, at: usize, limit: f64) -> f64 {
        let (p, u) = (pair(&self.impulses, at), pair(&self.velocities, at));
        let rubbed = p.norm();
        let own = 0.5 * (self.w(at, at) + self.w(at + 1, at + 1));
        let excess = (rubbed - limit).max(0.0) * own;
        let slides = if limit <= 0.0 {
            0.0
        } else if rubbed < limit * (1.0 - 1e-9) {
            u.norm()
        } else {
            // It may only move against what holds it.
            let pull = p / rubbed;
            (u - pull * u.dot(&pull).min(0.0)).norm()
        };
        slides.max(excess)
    }
}

/// The two numbers of a list from a place on.
fn pair(of: &[f64], at: usize) -> Vector2<f64> {
    Vector2::new(of[at], of[at + 1])
}
