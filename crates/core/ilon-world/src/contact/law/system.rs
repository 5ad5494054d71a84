//! The laws of a step, the current impulses and the velocities that follow.

use nalgebra::{Vector2, Vector3};

use super::anisotropy::Anisotropies;
use super::curve::{Curve, Curves};
use super::kinds::{LEAST_BOUND_N_S, Law};

/// The impulses of a step. It is cleared and filled again in every step, and allocates only while
/// it grows.
#[derive(Clone, Debug, Default)]
pub(crate) struct ImpulseProblem {
    /// Each with its first row.
    pub(super) laws: Vec<(usize, Law)>,
    /// p, in N s or N m s.
    pub(super) impulses: Vec<f64>,
    /// u, in m/s or rad/s.
    pub(super) velocities: Vec<f64>,
    /// u_free, the velocities without any impulse.
    free: Vec<f64>,
    /// Addition to W's diagonal, in m/s per N s: contacts with tangential compliance.
    pub(super) softness: Vec<f64>,
    /// The half solution of each row, by degree of freedom of the bodies, one after the other;
    /// empty if W has more to it than their products.
    pub(super) halves: Vec<f64>,
    /// W, row by row.
    pub(super) delassus: Vec<f64>,
    /// For contacts with anisotropic friction.
    pub(super) anisotropies: Anisotropies,
    /// Contacts with anisotropic compliance: the row of the first tangent, and the addition beside
    /// W's diagonal, in m/s per N s.
    coupled: Vec<(usize, f64)>,
    pub(super) curves: Curves,
}

/// Solved if no law is violated by more than this, in m/s or rad/s: the resolution of a slow
/// robot's rates in f32.
pub(super) const TOLERANCE: f64 = 1e-8;

/// Beyond this velocity, in m/s or rad/s, rounding exceeds the tolerance: an f64 of that size has a
/// resolution of 1.2e-10, and sums of dozens have less.
const FARTHEST: f64 = 1e6;

/// A saved state of impulses and velocities.
#[derive(Clone, Debug, Default)]
pub(super) struct Kept {
    impulses: Vec<f64>,
    velocities: Vec<f64>,
}

impl ImpulseProblem {
    /// Removes everything.
    pub fn clear(&mut self) {
        self.laws.clear();
        self.impulses.clear();
        self.velocities.clear();
        self.softness.clear();
        self.halves.clear();
        self.anisotropies.clear();
        self.coupled.clear();
        self.curves.clear();
    }

    /// Adds a law, with the velocity without any impulse: normal and two tangents of a contact, or
    /// the rate of a joint.
    pub fn push(&mut self, law: Law, free_velocity: &[f64]) {
        debug_assert_eq!(free_velocity.len(), law.rows());
        self.laws.push((self.velocities.len(), law));
        self.velocities.extend_from_slice(free_velocity);
        self.impulses.resize(self.velocities.len(), 0.0);
        self.softness.resize(self.velocities.len(), 0.0);
    }

    /// Makes the last contact compliant along its tangents, in m/s per N s: its friction law then
    /// holds for the velocity at its place plus that of its deflection.
    pub fn soften(&mut self, tangents: [f64; 2]) {
        let rows = self.rows();
        self.softness[rows - 2..].copy_from_slice(&tangents);
    }

    /// Couples the two tangents of the last contact: the compliance of the velocity along each by
    /// the impulse along the other, in m/s per N s.
    pub fn couple(&mut self, tangents: f64) {
        self.coupled.push((self.rows() - 2, tangents));
    }

    /// Makes the last contact or disc anisotropic: along a unit vector among its tangents its law
    /// holds, across it with `ratio` times the limit, > 0.
    pub fn make_anisotropic(&mut self, along: Vector2<f64>, ratio: f64) {
        let at = self.rows() - 2;
        self.anisotropies
            .push(at, (along, ratio), &mut self.velocities);
    }

    /// Adds a curve, and returns its index.
    pub fn add_curve(&mut self, curve: &Curve) -> usize {
        self.curves.push(curve)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.velocities.len()
    }

    /// Sets W once all laws have been added. `fill` gets a row's index, and the slice of its
    /// entries up to the diagonal.
    pub fn set_delassus(&mut self, fill: impl Fn(usize, &mut [f64])) {
        let rows = self.rows();
        self.free.clone_from(&self.velocities);
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
        self.anisotropies.apply(&mut self.delassus, rows);
    }

    /// Sets the half solutions of all rows, one degree of freedom of the bodies after the other: W
    /// is their products, but for the laws' compliance. Not for rollers, which add their own, and
    /// for contacts whose tangents are coupled or anisotropic.
    pub fn set_halves(&mut self, halves: &[f64]) {
        self.halves.clear();
        if self.coupled.is_empty() && self.anisotropies.is_empty() {
            self.halves.extend_from_slice(halves);
        }
    }

    /// Starts the solution of a law, given by its index, from the nearest impulse that the law
    /// allows. For laws with fewer rows only the first numbers count.
    pub fn warm_start(&mut self, law: usize, mut asked: Vector3<f64>) {
        if let (at, Some(first)) = (self.laws[law].0, self.laws[law].1.first_tangent()) {
            let rubs = self
                .anisotropies
                .in_disc(at + first, asked.fixed_rows::<2>(first).into_owned());
            asked.fixed_rows_mut::<2>(first).copy_from(&rubs);
        }
        self.bring(law, asked);
    }

    /// Sets the impulse of a law to the nearest that it allows, and updates the velocities.
    fn bring(&mut self, law: usize, asked: Vector3<f64>) {
        let (at, law) = self.laws[law];
        let allowed = law.allows(&self.curves, asked.as_slice(), 0.0);
        for k in 0..law.rows() {
            self.set(at + k, allowed.impulse[k]);
        }
    }

    /// Projects all impulses into the bounds of their laws, updates the velocities, and returns the
    /// violation of the laws like [`Self::error`].
    pub(super) fn settle(&mut self) -> f64 {
        let mut is_within = true;
        for (at, law) in &self.laws {
            let impulses = &mut self.impulses[*at..][..law.rows()];
            let allowed = law.allows(&self.curves, impulses, 0.0);
            let allowed = &allowed.impulse[..law.rows()];
            if impulses != allowed {
                is_within = false;
                impulses.copy_from_slice(allowed);
            }
        }
        if !is_within {
            self.follow_impulses();
        }
        self.error()
    }

    /// Sets an impulse, and updates the velocities.
    pub(super) fn set(&mut self, row: usize, impulse: f64) {
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

    /// Saves the current impulses.
    pub(super) fn keep(&self, kept: &mut Kept) {
        kept.impulses.clone_from(&self.impulses);
        kept.velocities.clone_from(&self.velocities);
    }

    /// Recomputes the velocities from the impulses, u = u_free + W p, without accumulated rounding.
    pub(super) fn follow_impulses(&mut self) {
        self.velocities.clone_from(&self.free);
        add_response(&self.delassus, &self.impulses, &mut self.velocities);
    }

    /// Adds to the impulses, and updates the velocities.
    pub(super) fn add(&mut self, step: &[f64]) {
        add_response(&self.delassus, step, &mut self.velocities);
        for (impulse, by) in self.impulses.iter_mut().zip(step) {
            *impulse += by;
        }
    }

    /// Moves a share of a step away from saved impulses, with the effect of the step on the
    /// velocities.
    pub(super) fn move_from(
        &mut self,
        from: &Kept,
        share: f64,
        (step, step_m_s): (&[f64], &[f64]),
    ) {
        let add = |to: &mut [f64], from: &[f64], by: &[f64]| {
            for (to, (from, by)) in to.iter_mut().zip(from.iter().zip(by)) {
                *to = from + share * by;
            }
        };
        add(&mut self.impulses, &from.impulses, step);
        add(&mut self.velocities, &from.velocities, step_m_s);
    }

    /// W times impulses.
    pub(super) fn respond(&self, impulses: &[f64], velocities: &mut Vec<f64>) {
        velocities.clear();
        velocities.resize(impulses.len(), 0.0);
        add_response(&self.delassus, impulses, velocities);
    }

    /// Restores saved impulses to the bit; [`Self::set`] would leave accumulated rounding in the
    /// velocities.
    pub(super) fn go_back(&mut self, kept: &Kept) {
        self.impulses.clone_from(&kept.impulses);
        self.velocities.clone_from(&kept.velocities);
    }

    /// Whether friction holds a contact or a bearing at the current impulses: within its limit.
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
            // Where the velocity is given.
            Law::Slide { .. } | Law::Curve { .. } => self.slope(at, law) == 1.0,
            Law::Disc { most_n_s } => {
                self.anisotropies
                    .in_disc(at, pair(&self.impulses, at))
                    .norm()
                    < most_n_s * (1.0 - 1e-9)
            }
            Law::Contact { friction, .. } => {
                let p = self.contact_impulse(at);
                self.anisotropies.in_disc(at + 1, p.yz()).norm() < friction * p.x * (1.0 - 1e-9)
            }
        }
    }

    /// The current impulses, row by row, in N s or N m s.
    pub fn impulses(&self) -> &[f64] {
        &self.impulses
    }

    /// The velocities at their places, row by row, in m/s or rad/s; for compliant contacts
    /// including the deflection.
    pub fn velocities(&self) -> &[f64] {
        &self.velocities
    }

    /// W of two rows.
    pub fn w(&self, row: usize, column: usize) -> f64 {
        self.delassus[row * self.rows() + column]
    }

    pub(super) fn contact_impulse(&self, at: usize) -> Vector3<f64> {
        Vector3::from_row_slice(&self.impulses[at..at + 3])
    }

    pub(super) fn contact_velocity(&self, at: usize) -> Vector3<f64> {
        Vector3::from_row_slice(&self.velocities[at..at + 3])
    }

    /// Transforms impulses, velocities and W back from anisotropic variables.
    pub(super) fn take_back(&mut self) {
        let rows = self.rows();
        let (impulses, velocities) = (&mut self.impulses, &mut self.velocities);
        self.anisotropies
            .take_back((impulses, velocities), &mut self.delassus, rows);
    }

    /// u_free.
    pub(super) fn free(&self) -> &[f64] {
        &self.free
    }

    /// The largest violation of all laws, in m/s or rad/s. An impulse beyond friction's limit
    /// counts by the velocity that the excess causes at its place. Infinite if the velocities are
    /// NaN, or so large that rounding dominates.
    pub(super) fn error(&self) -> f64 {
        // NaN is not below it either.
        if !self.velocities.iter().all(|u| u.abs() < FARTHEST) {
            return f64::INFINITY;
        }
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
                normal.max(self.error_in_disc(at + 1, friction * p.x.max(0.0)))
            }
            Law::Disc { most_n_s } => self.error_in_disc(at, most_n_s),
            Law::Slide { .. } | Law::Curve { .. } => self.missing(at, law).abs(),
        };
        self.laws.iter().map(of).fold(0.0, f64::max)
    }

    /// The violation of two rows with an impulse in a disc of this radius.
    fn error_in_disc(&self, at: usize, limit: f64) -> f64 {
        let (p, u) = (pair(&self.impulses, at), pair(&self.velocities, at));
        let rubbed = p.norm();
        let own = 0.5 * (self.w(at, at) + self.w(at + 1, at + 1));
        let excess = (rubbed - limit).max(0.0) * own;
        let slides = if limit < LEAST_BOUND_N_S {
            0.0
        } else if rubbed < limit * (1.0 - 1e-9) {
            u.norm()
        } else {
            // It may move only against the impulse.
            let pull = p / rubbed;
            (u - pull * u.dot(&pull).min(0.0)).norm()
        };
        slides.max(excess)
    }
}

/// Adds W times impulses to velocities.
fn add_response(delassus: &[f64], impulses: &[f64], velocities: &mut [f64]) {
    // W is symmetric: its rows are its columns, which allow adding several numbers at a time.
    let columns = delassus.chunks_exact(impulses.len().max(1));
    for (column, impulse) in columns.zip(impulses).filter(|(_, p)| **p != 0.0) {
        for (velocity, w) in velocities.iter_mut().zip(column) {
            *velocity += w * impulse;
        }
    }
}

/// Two numbers of a list from an index on.
pub(super) fn pair(of: &[f64], at: usize) -> Vector2<f64> {
    Vector2::new(of[at], of[at + 1])
}
