//! The violation of the laws of a step: one equation per row, F(p) = 0, in m/s or rad/s (Alart and
//! Curnier 1991).
//!
//! With r the response of a row to its own impulse, q = p - u / r is the impulse that would stop
//! the remaining velocity, and F = r (p - prox(q)), with the law's proximal map (`kinds`): the
//! distance of the impulse from the allowed one, as a velocity. If the law gives the velocity, F is
//! the velocity's error; if it gives the impulse, r times the impulse's error. F is continuous and
//! piecewise smooth.

use nalgebra::Matrix3;

use super::kinds::{Allowed, Law};
use super::system::ImpulseProblem;

/// The units in which the rows of a law are measured.
struct Measure {
    /// r, in m/s per N s. Both rows of friction have the same r, so that its bound stays round.
    responses: [f64; 3],
    /// The derivative of a row of F by its impulse: r, plus the compliance for a contact's normal.
    scales: [f64; 3],
}

impl ImpulseProblem {
    /// Writes F and, if requested, its derivative by the impulses, row by row. Returns |F|^2.
    pub(super) fn residual(&self, missing: &mut [f64], mut derivative: Option<&mut [f64]>) -> f64 {
        for &(at, law) in &self.laws {
            let measure = self.measure(at, law);
            let allowed = self.allowed(at, law, &measure);
            for k in 0..law.rows() {
                let row = at + k;
                missing[row] = measure.scales[k] * (self.impulses[row] - allowed.impulse[k]);
                if let Some(derivative) = &mut derivative {
                    let line = &mut derivative[row * self.rows()..][..self.rows()];
                    self.differentiate((at, law), k, (&measure, &allowed.slope[k]), line);
                }
            }
        }
        missing.iter().map(|missing| missing * missing).sum()
    }

    /// The derivative of F of a contact, in three rows: by its own impulses with the velocities
    /// that the bodies have, including its tangential compliance, and by these velocities.
    pub(super) fn blocks(&self, at: usize, law: Law) -> (Matrix3<f64>, Matrix3<f64>) {
        let measure = self.measure(at, law);
        let slope = self.allowed(at, law, &measure).slope;
        let [mut own, mut coupled] = [Matrix3::zeros(); 2];
        for (k, j) in (0..9).map(|entry| (entry / 3, entry % 3)) {
            let share = measure.scales[k] * slope[k][j];
            coupled[(k, j)] = share / measure.responses[j];
            own[(k, j)] = coupled[(k, j)] * self.softness[at + j] - share;
        }
        for k in 0..3 {
            own[(k, k)] += measure.scales[k];
        }
        (own, coupled)
    }

    /// The derivative of a one-row law by its line p - u / r: 0 if it gives the impulse, 1 if it
    /// gives the velocity.
    pub(super) fn slope(&self, at: usize, law: Law) -> f64 {
        self.allowed(at, law, &self.measure(at, law)).slope[0][0]
    }

    /// F of a law with one row.
    pub(super) fn missing(&self, at: usize, law: Law) -> f64 {
        let measure = self.measure(at, law);
        measure.scales[0] * (self.impulses[at] - self.allowed(at, law, &measure).impulse[0])
    }

    #[inline(always)]
    fn measure(&self, at: usize, law: Law) -> Measure {
        let own = self.w(at, at);
        let pair = |first: usize| self.w(first, first) + self.w(first + 1, first + 1);
        let (responses, more) = match law {
            Law::Joint { .. } | Law::Slide { .. } | Law::Curve { .. } => ([own, 0.0, 0.0], 0.0),
            Law::Disc { .. } => ([pair(at), pair(at), 0.0], 0.0),
            Law::Contact { compliance, .. } => ([own, pair(at + 1), pair(at + 1)], compliance),
        };
        let mut scales = responses;
        scales[0] += more;
        Measure { responses, scales }
    }

    #[inline(always)]
    fn allowed(&self, at: usize, law: Law, measure: &Measure) -> Allowed {
        let mut asked = [0.0; 3];
        let (impulses, velocities) = (&self.impulses[at..], &self.velocities[at..]);
        for (k, asked) in asked.iter_mut().enumerate().take(law.rows()) {
            *asked = impulses[k] - velocities[k] / measure.responses[k];
        }
        law.allows(&self.curves, &asked, 1.0 / measure.responses[0])
    }

    /// Writes the derivative of F in the k-th row of a law by all impulses: scale (dp_k - sum of
    /// slope_j dq_j), with dq_j = dp_j - W_j dp / r_j.
    #[inline(always)]
    fn differentiate(
        &self,
        (at, law): (usize, Law),
        k: usize,
        (measure, slope): (&Measure, &[f64; 3]),
        line: &mut [f64],
    ) {
        line.fill(0.0);
        line[at + k] = measure.scales[k];
        for j in (0..law.rows()).filter(|j| slope[*j] != 0.0) {
            let share = measure.scales[k] * slope[j];
            let of_velocity = share / measure.responses[j];
            let row = at + j;
            let response = &self.delassus[row * line.len()..][..line.len()];
            for (entry, w) in line.iter_mut().zip(response) {
                *entry += of_velocity * w;
            }
            line[row] -= share;
        }
    }
}
