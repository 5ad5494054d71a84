//! The impulses of a step: what the ground and dry bearings do to a robot, solved to the end.
//!
//! A sweep through a robot's degrees of freedom is dear and converges slowly, because a roller is light across its axis
//! (it spins) and heavy along it (it carries the robot). Here the problem is written down between the impulses alone,
//! where both a sweep and a direct solution cost next to nothing:
//!
//! u = u_free + W p, with u the velocities where the impulses p act and W what a unit impulse at one place does to the
//! velocity at another (Delassus' operator), and a law for each of them:
//!
//! - *contact*, Signorini: p_n >= 0, u_n + b + c p_n >= 0, one of them 0 (b is the gap's, c the compliance of the
//!   contact);
//! - *contact*, Coulomb: |p_t| <= mu p_n; it sticks, or p_t is as large as it may be and opposes the sliding u_t;
//! - *joint*: least <= p <= most; it sticks, or p is as large as it may be and opposes the turning.
//!
//! Block Gauss-Seidel sweeps solve one law exactly for the others as they are; between them Newton's method takes all
//! laws at once, differentiated where they stand (Alart and Curnier 1991). A robot that rolls needs one Newton step.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

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
}

impl Law {
    fn rows(&self) -> usize {
        match self {
            Law::Contact { .. } => 3,
            Law::Joint { .. } => 1,
        }
    }
}

/// What a law does as things stand.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// A contact that carries nothing.
    Open,
    /// It presses, or holds, and nothing slides.
    Sticks,
    /// A contact that slides.
    Slides {
        /// Where friction pulls, among the tangents.
        along: Vector2<f64>,
        /// The largest friction impulse over the one that would stop the sliding, roughly.
        share: f64,
        /// Impulse per velocity, in N s per m/s.
        scale: f64,
    },
    /// A joint that turns against this impulse, in N m s.
    Turns(f64),
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
    /// W, row by row.
    response: Vec<f64>,
    newton: Newton,
}

/// Room for Newton's method.
#[derive(Clone, Debug, Default)]
struct Newton {
    matrix: Vec<f64>,
    step: Vec<f64>,
    kept: Vec<f64>,
}

/// Solved, when no law is broken by more than this, in m/s or rad/s: what f32 resolves of a slow robot's rates.
const TOLERANCE: f64 = 1e-8;

/// Rounds of Newton steps and sweeps at most. Nearly every step is done after one; where many contacts say nearly the same
/// (rough ground, a chassis that lies on its side) some need dozens, and a few never get to the last digits.
const ROUNDS: usize = 64;

/// After so many rounds sweeps go half as far: contacts that press one another down would swing to and fro for ever.
const ROUNDS_A_SHARE: usize = 8;

/// Sweeps where Newton's method needs a better start.
const SWEEPS_A_ROUND: usize = 50;

/// Newton steps in a row at most, while each brings the error down by a factor of ten.
const NEWTON_STEPS: usize = 4;

impl ImpulseProblem {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.laws.clear();
        self.impulses.clear();
        self.velocities.clear();
    }

    /// Adds a law, with the velocity that there would be without any impulse: normal and two tangents of a contact, the
    /// rate of a joint.
    pub fn push(&mut self, law: Law, free_velocity: &[f64]) {
        debug_assert_eq!(free_velocity.len(), law.rows());
        self.laws.push((self.velocities.len(), law));
        self.velocities.extend_from_slice(free_velocity);
        self.impulses.resize(self.velocities.len(), 0.0);
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.velocities.len()
    }

    /// Sets W from its entries, of which those on and below its diagonal are asked for, once all laws are there.
    pub fn set_response(&mut self, entry: impl Fn(usize, usize) -> f64) {
        let rows = self.rows();
        self.response.clear();
        self.response.resize(rows * rows, 0.0);
        for row in 0..rows {
            for column in 0..=row {
                let w = entry(row, column);
                self.response[row * rows + column] = w;
                self.response[column * rows + row] = w;
            }
        }
    }

    /// Starts the solution of the law that was added at a place from an impulse: the nearest that the law allows. Of a
    /// bearing only the first number counts.
    pub fn suppose_within(&mut self, law: usize, asked: Vector3<f64>) {
        let (at, law) = self.laws[law];
        match law {
            Law::Joint {
                least_n_m_s,
                most_n_m_s,
            } => self.set(at, asked.x.clamp(least_n_m_s, most_n_m_s)),
            Law::Contact { friction, .. } => {
                let normal = asked.x.max(0.0);
                let mut rubbed = asked.yz();
                let (size, limit) = (rubbed.norm(), friction * normal);
                if size > limit {
                    rubbed *= limit / size;
                }
                self.set(at, normal);
                self.set(at + 1, rubbed.x);
                self.set(at + 2, rubbed.y);
            }
        }
    }

    /// Sets an impulse, and the velocities that follow.
    fn set(&mut self, row: usize, impulse: f64) {
        let by = impulse - self.impulses[row];
        if by != 0.0 {
            self.impulses[row] = impulse;
            let rows = self.rows();
            // W is symmetric: its row is its column.
            let column = &self.response[row * rows..][..rows];
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
            Law::Contact { friction, .. } => {
                let p = self.contact_impulse(at);
                p.yz().norm() < friction * p.x * (1.0 - 1e-9)
            }
        }
    }

    /// The impulses as they are now, row by row, in N s or N m s.
    pub fn impulses(&self) -> &[f64] {
        &self.impulses
    }

    /// The velocities where they act, row by row, in m/s or rad/s.
    pub fn velocities(&self) -> &[f64] {
        &self.velocities
    }

    /// Solves for the impulses, from those that are supposed. Gives back by how much the laws are broken in the end, in
    /// m/s or rad/s.
    pub fn solve(&mut self) -> f64 {
        let mut error = self.error();
        for round in 0..ROUNDS {
            let share = 0.5_f64.powi((round / ROUNDS_A_SHARE) as i32);
            for _ in 0..NEWTON_STEPS {
                if error <= TOLERANCE {
                    return error;
                }
                let before = error;
                error = self.newton_step(error);
                if error > 0.1 * before {
                    break;
                }
            }
            if error <= TOLERANCE {
                return error;
            }
            for _ in 0..SWEEPS_A_ROUND {
                for law in 0..self.laws.len() {
                    self.solve_one(law, share);
                }
            }
            error = self.error();
        }
        error
    }

    /// W of two rows.
    pub fn w(&self, row: usize, column: usize) -> f64 {
        self.response[row * self.rows() + column]
    }

    fn contact_impulse(&self, at: usize) -> Vector3<f64> {
        Vector3::from_row_slice(&self.impulses[at..at + 3])
    }

    fn contact_velocity(&self, at: usize) -> Vector3<f64> {
        Vector3::from_row_slice(&self.velocities[at..at + 3])
    }

    /// Goes a share of the way to where one law is solved for the others as they are.
    fn solve_one(&mut self, index: usize, share: f64) {
        let (at, law) = self.laws[index];
        match law {
            Law::Joint { .. } => {
                let impulse = self.impulses[at] - share * self.velocities[at] / self.w(at, at);
                self.suppose_within(index, Vector3::new(impulse, 0.0, 0.0));
            }
            Law::Contact {
                friction,
                approach_m_s,
                compliance,
            } => {
                let own = Matrix3::from_fn(|i, j| self.w(at + i, at + j));
                let free = self.contact_velocity(at) - own * self.contact_impulse(at);
                let impulse = contact_impulse(&own, &free, friction, (approach_m_s, compliance));
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
                let (limit, rubbed) = (friction * p.x.max(0.0), p.yz().norm());
                let own = 0.5 * (self.w(at + 1, at + 1) + self.w(at + 2, at + 2));
                let excess = (rubbed - limit).max(0.0) * own;
                let tangential = if limit <= 0.0 {
                    0.0
                } else if rubbed < limit * (1.0 - 1e-9) {
                    u.yz().norm()
                } else {
                    // Sliding may only go against friction.
                    let pull = p.yz() / rubbed;
                    (u.yz() - pull * u.yz().dot(&pull).min(0.0)).norm()
                };
                normal.max(tangential).max(excess)
            }
        };
        self.laws.iter().map(of).fold(0.0, f64::max)
    }

    /// What a law does as things stand: which part of it holds for the impulse less the velocity, the two brought to one
    /// scale by the law's own response.
    fn state(&self, (at, law): (usize, Law)) -> State {
        let own = self.w(at, at);
        match law {
            Law::Joint {
                least_n_m_s,
                most_n_m_s,
            } => {
                let holding = self.impulses[at] - self.velocities[at] / own;
                let within = holding.clamp(least_n_m_s, most_n_m_s);
                if holding == within {
                    State::Sticks
                } else {
                    State::Turns(within)
                }
            }
            Law::Contact {
                friction,
                approach_m_s,
                compliance,
            } => {
                let (p, u) = (self.contact_impulse(at), self.contact_velocity(at));
                if p.x - (u.x + approach_m_s + compliance * p.x) / own <= 0.0 {
                    return State::Open;
                }
                let scale = 1.0 / (self.w(at + 1, at + 1) + self.w(at + 2, at + 2));
                let pull = p.yz() - scale * u.yz();
                let (limit, size) = (friction * p.x, pull.norm());
                if size > limit {
                    State::Slides {
                        along: pull / size,
                        share: limit / size,
                        scale,
                    }
                } else {
                    State::Sticks
                }
            }
        }
    }

    /// One step of Newton's method, put back into the laws' bounds. It is taken only where it lowers the error, which is
    /// given and given back.
    fn newton_step(&mut self, error: f64) -> f64 {
        self.linearise();
        let rows = self.rows();
        let Newton { matrix, step, kept } = &mut self.newton;
        if !solve_in_place(matrix, step) {
            return error;
        }
        kept.clear();
        kept.extend_from_slice(&self.impulses);
        for law in 0..self.laws.len() {
            let at = self.laws[law].0;
            let there = |k: usize| self.newton.kept[at + k] + self.newton.step[at + k];
            let asked = match self.laws[law].1 {
                Law::Joint { .. } => Vector3::new(there(0), 0.0, 0.0),
                Law::Contact { .. } => Vector3::new(there(0), there(1), there(2)),
            };
            self.suppose_within(law, asked);
        }
        let reached = self.error();
        if reached < error {
            return reached;
        }
        for row in 0..rows {
            self.set(row, self.newton.kept[row]);
        }
        error
    }

    /// Writes down the laws' derivatives where they stand, and what is missing from them.
    fn linearise(&mut self) {
        let rows = self.rows();
        let mut newton = std::mem::take(&mut self.newton);
        newton.clear(rows);
        for &(at, law) in &self.laws {
            match (self.state((at, law)), law) {
                (State::Open, _) => {
                    (at..at + 3).for_each(|row| newton.fix(row, -self.impulses[row]))
                }
                (State::Turns(impulse), _) => newton.fix(at, impulse - self.impulses[at]),
                (_, Law::Joint { .. }) => newton.stop(at, self),
                (
                    state,
                    Law::Contact {
                        friction,
                        approach_m_s,
                        compliance,
                    },
                ) => {
                    (at..at + 3).for_each(|row| newton.stop(row, self));
                    newton.matrix[at * rows + at] += compliance;
                    newton.step[at] -= approach_m_s + compliance * self.impulses[at];
                    if let State::Slides {
                        along,
                        share,
                        scale,
                    } = state
                    {
                        self.linearise_sliding(&mut newton, (at, friction), (along, share, scale));
                    }
                }
            }
        }
        self.newton = newton;
    }

    /// The tangents of a contact that slides: p_t = mu p_n q/|q| with q = p_t - scale u_t, differentiated.
    fn linearise_sliding(
        &self,
        newton: &mut Newton,
        (at, friction): (usize, f64),
        (along, share, scale): (Vector2<f64>, f64, f64),
    ) {
        let rows = self.rows();
        let tangents = [at + 1, at + 2];
        for (i, row) in tangents.into_iter().enumerate() {
            newton.matrix[row * rows..][..rows].fill(0.0);
            let by = friction * self.impulses[at] * along[i] - self.impulses[row];
            newton.fix(row, by);
            let line = &mut newton.matrix[row * rows..][..rows];
            line[at] -= friction * along[i];
            for (j, other) in tangents.into_iter().enumerate() {
                let across = if i == j { 1.0 } else { 0.0 } - along[i] * along[j];
                line[other] -= share * across;
                let of_velocity = &self.response[other * rows..][..rows];
                for (entry, w) in line.iter_mut().zip(of_velocity) {
                    *entry += share * across * scale * w;
                }
            }
        }
    }
}

impl Newton {
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

    /// A row whose velocity shall vanish: W dp = -u.
    fn stop(&mut self, row: usize, problem: &ImpulseProblem) {
        // Redundant contacts can share a load in many ways: the least softness picks one.
        const RIDGE: f64 = 1e-6;
        let rows = self.step.len();
        let line = &mut self.matrix[row * rows..][..rows];
        line.copy_from_slice(&problem.response[row * rows..][..rows]);
        line[row] *= 1.0 + RIDGE;
        self.step[row] = -problem.velocities[row];
    }
}

/// The impulse of one contact that is alone, with the response W and the velocity `free` that it would have without: normal and
/// two tangents, for its law with an approach and a compliance.
///
/// With the friction that belongs to it, the normal velocity is a continuous function of the normal impulse: below 0 without
/// any, or there is no contact, and in the end growing, because a contact that is pressed hard enough sticks. Between the two it is
/// 0, however strongly friction presses the contact down or lifts it: solving for the one with the other as it was would swing to
/// and fro for ever where mu |W_nt| > W_nn.
fn contact_impulse(
    w: &Matrix3<f64>,
    free: &Vector3<f64>,
    friction: f64,
    (approach_m_s, compliance): (f64, f64),
) -> Vector3<f64> {
    /// Halvings of the bracket, at the least.
    const ROUNDS: usize = 100;
    let tangents = w.fixed_view::<2, 2>(1, 1).into_owned();
    let coupling = Vector2::new(w[(1, 0)], w[(2, 0)]);
    let rubbed = |normal: f64| {
        friction_impulse(
            &tangents,
            &(free.yz() + coupling * normal),
            friction * normal,
        )
    };
    let excess = |normal: f64| {
        let rubs = coupling.dot(&rubbed(normal));
        free.x + approach_m_s + (w[(0, 0)] + compliance) * normal + rubs
    };
    let mut low = (0.0, excess(0.0));
    if low.1 >= 0.0 {
        return Vector3::zeros();
    }
    let mut high_n_s = -low.1 / (w[(0, 0)] + compliance);
    let mut high = (high_n_s, excess(high_n_s));
    for _ in 0..ROUNDS {
        if high.1 >= 0.0 {
            break;
        }
        low = high;
        high_n_s *= 2.0;
        high = (high_n_s, excess(high_n_s));
    }
    // The secant, with the end that stays behind halved (Illinois, Dowell and Jarratt 1971).
    let mut normal = high.0;
    for _ in 0..ROUNDS {
        if high.1 - low.1 <= 0.0 || high.0 - low.0 <= 1e-15 * high.0 {
            break;
        }
        normal = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let here = excess(normal);
        if here.abs() < 1e-2 * TOLERANCE {
            break;
        }
        if here > 0.0 {
            high = (normal, here);
            low.1 *= 0.5;
        } else {
            low = (normal, here);
            high.1 *= 0.5;
        }
    }
    let rubbed = rubbed(normal);
    Vector3::new(normal, rubbed.x, rubbed.y)
}

/// The friction impulse of one contact: W p + free = 0 where |p| may be that large, and else the p of size `most` that
/// opposes the sliding W p + free, which is (W + a 1) p = -free for the a > 0 that makes it that large.
///
/// 1/|p| is nearly straight in a, so that Newton's method on it converges from the left in a few steps (More and
/// Sorensen 1983).
fn friction_impulse(w: &Matrix2<f64>, free: &Vector2<f64>, most: f64) -> Vector2<f64> {
    if most <= 0.0 {
        return Vector2::zeros();
    }
    let mut a = 0.0;
    let mut impulse = Vector2::zeros();
    for _ in 0..30 {
        let (xx, xy, yy) = (w[(0, 0)] + a, w[(0, 1)], w[(1, 1)] + a);
        let determinant = (xx * yy - xy * xy).max(f64::MIN_POSITIVE);
        let solve =
            |f: &Vector2<f64>| Vector2::new(yy * f.x - xy * f.y, xx * f.y - xy * f.x) / determinant;
        impulse = -solve(free);
        let size = impulse.norm();
        if size <= most * (1.0 + 1e-12) {
            break;
        }
        a += (size / most - 1.0) * size * size / impulse.dot(&solve(&impulse));
    }
    // What is left of the iteration's error may not leave the friction disc.
    let size = impulse.norm();
    if size > most {
        impulse * (most / size)
    } else {
        impulse
    }
}

/// Solves a linear system, given row by row, in place by elimination with row pivots. Says whether it is regular.
pub(crate) fn solve_in_place(matrix: &mut [f64], x: &mut [f64]) -> bool {
    let n = x.len();
    for column in 0..n {
        let size = |row: &usize| matrix[row * n + column].abs();
        let Some(pivot) = (column..n).max_by(|a, b| size(a).total_cmp(&size(b))) else {
            return false;
        };
        if matrix[pivot * n + column] == 0.0 {
            return false;
        }
        if pivot != column {
            for k in column..n {
                matrix.swap(pivot * n + k, column * n + k);
            }
            x.swap(pivot, column);
        }
        let (above, below) = matrix.split_at_mut((column + 1) * n);
        let leading = &above[column * n..];
        for (offset, row) in below.chunks_exact_mut(n).enumerate() {
            let share = row[column] / leading[column];
            if share != 0.0 {
                for k in column + 1..n {
                    row[k] -= share * leading[k];
                }
                x[column + 1 + offset] -= share * x[column];
            }
        }
    }
    for row in (0..n).rev() {
        for k in row + 1..n {
            x[row] -= matrix[row * n + k] * x[k];
        }
        x[row] /= matrix[row * n + row];
    }
    x.iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between -1 and 1, the same in every run.
    struct Draw(u64);

    impl Draw {
        fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        /// A symmetric matrix A^T A + ridge, row by row: positive definite, and of lower rank without the ridge where A
        /// has fewer rows than columns.
        fn response(&mut self, rows: usize, rank: usize, ridge: f64) -> Vec<f64> {
            let a: Vec<f64> = (0..rank * rows).map(|_| self.next()).collect();
            let entry = |i: usize, j: usize| {
                let sum: f64 = (0..rank).map(|k| a[k * rows + i] * a[k * rows + j]).sum();
                sum + if i == j { ridge } else { 0.0 }
            };
            (0..rows * rows)
                .map(|i| entry(i / rows, i % rows))
                .collect()
        }
    }

    fn bearing(most_n_m_s: f64) -> Law {
        Law::Joint {
            least_n_m_s: -most_n_m_s,
            most_n_m_s,
        }
    }

    fn contact(friction: f64) -> Law {
        Law::Contact {
            friction,
            approach_m_s: 0.0,
            compliance: 0.0,
        }
    }

    fn problem(laws: &[Law], free: &[f64], response: &[f64]) -> ImpulseProblem {
        let mut problem = ImpulseProblem::default();
        let mut rest = free;
        for law in laws {
            let (own, others) = rest.split_at(law.rows());
            problem.push(*law, own);
            rest = others;
        }
        problem.set_response(|row, column| response[row * free.len() + column]);
        problem
    }

    /// A block of mass m that falls by v on a floor of friction mu while it slides by s: the floor stops the fall with
    /// m v, and the sliding loses mu v, no more than it has. On paper: p_n = m v, |p_t| = min(mu m v, m s).
    #[test]
    fn a_block_loses_as_much_sliding_as_coulomb_says() {
        let (mass_kg, fall, slide) = (2.5, 0.4, Vector2::new(-0.3, 0.4));
        let response: Vec<f64> = (0..9)
            .map(|i| if i % 4 == 0 { 1.0 / mass_kg } else { 0.0 })
            .collect();
        for mu in [0.0, 0.2, 0.9, 1.25, 3.0] {
            let mut block = problem(&[contact(mu)], &[-fall, slide.x, slide.y], &response);
            assert!(block.solve() <= TOLERANCE);
            let p = block.contact_impulse(0);
            let rubbed = mass_kg * slide.norm().min(mu * fall);
            // Solved to 1e-8 m/s: 2.5e-8 N s.
            assert!((p.x - mass_kg * fall).abs() < 1e-7, "mu {mu}: {p}");
            assert!(
                (p.yz() + slide.normalize() * rubbed).norm() < 1e-7,
                "mu {mu}: {p}"
            );
        }
    }

    /// A contact that opens by itself, or may come nearer than it does, carries nothing; one that is in too deep is pushed
    /// out at the rate asked for.
    #[test]
    fn contacts_push_only_and_only_as_far_as_asked() {
        let response = [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0];
        for (free, approach, impulse, left) in [
            (0.1, 0.0, 0.0, 0.1),
            (-0.1, 0.2, 0.0, -0.1),
            (-0.3, 0.2, 0.05, -0.2),
            (0.1, -0.5, 0.2, 0.5),
        ] {
            let law = Law::Contact {
                friction: 0.5,
                approach_m_s: approach,
                compliance: 0.0,
            };
            let mut one = problem(&[law], &[free, 0.0, 0.0], &response);
            one.solve();
            assert!((one.impulses[0] - impulse).abs() < 1e-8);
            assert!((one.velocities[0] - left).abs() < 2e-8);
        }
    }

    /// A soft contact gives by c p: the spring's share.
    #[test]
    fn a_soft_contact_gives_in_proportion_to_what_it_carries() {
        let law = Law::Contact {
            friction: 0.0,
            approach_m_s: 0.0,
            compliance: 0.5,
        };
        let response = [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0];
        let mut soft = problem(&[law], &[-1.0, 0.0, 0.0], &response);
        soft.solve();
        // -1 + 2 p + 0.5 p = 0.
        assert!((soft.impulses[0] - 0.4).abs() < 1e-8);
    }

    /// Where a contact is light one way and heavy the other, as a roller is, friction at its limit still opposes the
    /// sliding that is left, whatever the two directions' masses are.
    #[test]
    fn friction_at_its_limit_opposes_the_sliding_of_light_and_heavy_directions() {
        let mut draw = Draw(1);
        for _ in 0..500 {
            let (light, heavy) = (10.0 + 90.0 * draw.next().abs(), 0.1 + draw.next().abs());
            let turn = Vector2::new(draw.next(), draw.next()).normalize();
            let across = Vector2::new(-turn.y, turn.x);
            let w = light * turn * turn.transpose() + heavy * across * across.transpose();
            let free = Vector2::new(draw.next(), draw.next());
            let most = 0.5 * draw.next().abs();
            let p = friction_impulse(&w, &free, most);
            let sliding = w * p + free;
            assert!(p.norm() <= most * (1.0 + 1e-12));
            if p.norm() < most * (1.0 - 1e-9) {
                assert!(sliding.norm() < 1e-12);
            } else {
                // The sliding points against p: no part beside it. Rounding of sums of about 1.
                let beside = sliding.perp(&p) / p.norm();
                assert!(
                    beside.abs() < 1e-9 && sliding.dot(&p) <= 1e-12,
                    "{sliding} {p}"
                );
            }
        }
    }

    /// A dry bearing holds what it can and opposes what it cannot: p = -clamp(free / w, +-most).
    /// A roller's end on a tilted robot: friction turns it so that it presses itself down, mu |W_nt| > W_nn, and whoever solves
    /// for the normal with the friction as it was swings between an impulse and none.
    #[test]
    fn a_contact_that_its_friction_presses_down_or_lifts_is_solved() {
        for (coupling, sliding) in [(-1.061, 0.32), (-1.061, -0.32), (1.061, 0.32)] {
            let response = [
                0.54, coupling, 0.695, //
                coupling, 4.65, -2.4, //
                0.695, -2.4, 49.0,
            ];
            let free = [-0.0206, sliding, -0.0177];
            let mut problem = problem(&[contact(0.6)], &free, &response);
            assert!(problem.solve() < 1e-8, "{coupling}, {sliding}");
            assert!(problem.impulses()[0] > 0.0);
            assert!(problem.velocities()[0].abs() < 1e-8);
        }
    }

    #[test]
    fn a_dry_bearing_holds_what_it_can() {
        for (free, most, impulse) in [(0.5, 0.2, -0.2), (0.5, 0.1, -0.1), (-0.5, 0.1, 0.1)] {
            let mut bearing = problem(&[bearing(most)], &[free], &[2.5]);
            assert!(bearing.solve() <= TOLERANCE);
            assert!((bearing.impulses[0] - impulse).abs() < 1e-8);
        }
    }

    /// The solution may start from what acted in the step before, on a floor that has turned slippery since: an impulse
    /// that friction cannot make any more is none, however still it holds the contact. On paper: a block of mass m on a
    /// slope, held by p_t = m g sin dt, of which mu m g cos dt is left.
    #[test]
    fn a_start_beyond_the_cone_is_no_solution() {
        let (mass_kg, dt_s, slope) = (2.5, 2e-3, 0.3_f64);
        let response: Vec<f64> = (0..9)
            .map(|i| if i % 4 == 0 { 1.0 / mass_kg } else { 0.0 })
            .collect();
        let pulls = 9.81 * dt_s * slope.sin();
        let presses = 9.81 * dt_s * slope.cos();
        for mu in [0.1, 0.0] {
            let mut block = problem(&[contact(mu)], &[-presses, pulls, 0.0], &response);
            let held = Vector3::new(mass_kg * presses, -mass_kg * pulls, 0.0);
            // Set as it is, without being brought back into the cone: the residual must show it.
            held.iter()
                .enumerate()
                .for_each(|(row, p)| block.set(row, *p));
            let excess_m_s = pulls - mu * presses;
            assert!((block.error() - excess_m_s).abs() < 1e-12);
            assert!(block.solve() <= TOLERANCE);
            let rubbed = block.contact_impulse(0).yz().norm();
            assert!((rubbed - mu * mass_kg * presses).abs() < 1e-7, "{rubbed}");

            block.suppose_within(0, held);
            assert!(block.contact_impulse(0).yz().norm() <= mu * held.x);
        }
    }

    /// As for a bearing whose friction has fallen.
    #[test]
    fn a_start_beyond_a_bearings_friction_is_no_solution() {
        let mut bearing = problem(&[bearing(0.1)], &[0.5], &[2.5]);
        bearing.set(0, -0.2);
        assert!((bearing.error() - 0.25).abs() < 1e-12);
        assert!(bearing.solve() <= TOLERANCE);
        assert!((bearing.impulses[0] + 0.1).abs() < 1e-8);
    }

    /// What keeps a motor from driving beyond a rate takes as much of its impulse as that needs, and no more than it gives:
    /// a wheel of response w that would be u too fast loses min(u / w, given); one that is too slow loses nothing.
    #[test]
    fn a_one_sided_joint_holds_one_way_only() {
        for (free, given, impulse) in [(0.5, 1.0, -0.2), (0.5, 0.1, -0.1), (-0.5, 1.0, 0.0)] {
            let limit = Law::Joint {
                least_n_m_s: -given,
                most_n_m_s: 0.0,
            };
            let mut limit = problem(&[limit], &[free], &[2.5]);
            assert!(limit.solve() <= TOLERANCE);
            assert!((limit.impulses[0] - impulse).abs() < 1e-8);
        }
    }

    /// Four legs under one table, of which three would do: they carry it together, whatever their shares.
    #[test]
    fn redundant_contacts_carry_the_load_together() {
        let legs = [[0.15, 0.16], [0.15, -0.16], [-0.15, 0.16], [-0.15, -0.16]];
        let (mass_kg, inertia) = (11.0, 0.2);
        let w = |i: usize, j: usize| {
            if !(i.is_multiple_of(3) && j.is_multiple_of(3)) {
                return if i == j { 1.0 / mass_kg } else { 0.0 };
            }
            let (a, b) = (legs[i / 3], legs[j / 3]);
            1.0 / mass_kg + (a[0] * b[0] + a[1] * b[1]) / inertia
        };
        let response: Vec<f64> = (0..144).map(|i| w(i / 12, i % 12)).collect();
        let fall: Vec<f64> = (0..12)
            .map(|i| if i % 3 == 0 { -0.02 } else { 0.0 })
            .collect();
        let mut table = problem(&[contact(0.6); 4], &fall, &response);
        assert!(table.solve() <= TOLERANCE);
        let carried: f64 = (0..4).map(|leg| table.impulses[3 * leg]).sum();
        assert!((carried - 0.02 * mass_kg).abs() < 1e-6);
    }

    /// Contacts and bearings drawn at random, sticking, sliding, open and redundant: every law holds afterwards, and
    /// u = u_free + W p does. Fifteen rows on a robot of ten degrees of freedom.
    #[test]
    fn random_problems_are_solved_to_the_end() {
        let mut draw = Draw(2);
        let mut unsolved = 0;
        for _ in 0..500 {
            let mu = draw.next().abs();
            let mut laws = vec![contact(mu); 4];
            laws.extend([bearing(0.3 * draw.next().abs()); 3]);
            let free: Vec<f64> = (0..15).map(|_| draw.next()).collect();
            let response = draw.response(15, 10, 1e-3);
            let mut random = problem(&laws, &free, &response);
            let error = random.solve();
            unsolved += usize::from(error > TOLERANCE);
            for row in 0..15 {
                let of_impulses: f64 = (0..15)
                    .map(|k| response[row * 15 + k] * random.impulses[k])
                    .sum();
                let apart = random.velocities[row] - free[row] - of_impulses;
                // Sums of some hundred terms of about 1e2.
                assert!(apart.abs() < 1e-10, "{apart:e}");
            }
            for at in [0, 3, 6, 9] {
                let (p, u) = (random.contact_impulse(at), random.contact_velocity(at));
                assert!(p.x >= 0.0 && p.yz().norm() <= mu * p.x * (1.0 + 1e-9));
                assert!(u.x >= -error - 1e-12 && p.x.min(u.x) <= error + 1e-12);
            }
        }
        // A random matrix is no robot: some have no solution at all with friction, and some need more rounds.
        assert!(unsolved <= 25, "{unsolved} of 500");
    }
}
