//! What is missing from the laws of a step: one equation for each row, F(p) = 0, in m/s or rad/s (Alart and Curnier 1991).
//!
//! With r the response of a row to its own impulse, q = p - u / r is what the row would carry if it had to stop the velocity that is left, and
//! F = r (p - prox(q)), with the law's proximal map (`kinds`): how far the impulse is from what the law allows, as a velocity. Where the law gives
//! the velocity, F is what that is off by; where it gives the impulse, r times what that is off by. F is continuous, and made of smooth pieces.

use super::kinds::{Allowed, Law};
use super::system::ImpulseProblem;

/// How the rows of a law are measured.
struct Measure {
    /// r, in m/s per N s. Two rows among which friction lies have one, so that its bound stays round.
    responses: [f64; 3],
    /// What a row of F has for each impulse: r, and of a contact's normal what the contact gives besides.
    scales: [f64; 3],
}

impl ImpulseProblem {
    /// Writes F down, and its derivative by the impulses, row by row, where that is asked for. Gives |F|^2.
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

    /// What a law of one row lets pass of its line p - u / r: 0 where it gives the impulse, 1 where it gives the velocity.
    pub(super) fn slope(&self, at: usize, law: Law) -> f64 {
        self.allowed(at, law, &self.measure(at, law)).slope[0][0]
    }

    /// F of a law of one row.
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

    /// Writes down how F of the k-th row of a law changes with all impulses: by scale (dp_k - sum of slope_j dq_j), with dq_j = dp_j - W_j dp / r_j.
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
