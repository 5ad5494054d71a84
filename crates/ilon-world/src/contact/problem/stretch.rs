//! Contacts that grip, or give, or are dragged at, otherwise in one direction than in another.
//!
//! **Grip.** The friction impulse of such a contact lies in an ellipse, |S^-1 p_t| <= mu p_n with S symmetric and positive, and where
//! it slides the velocity is along the ellipse's normal against it, so that friction takes the most that the ellipse lets it (an associated
//! law). In p' = S^-1 p_t and u' = S u_t that is Coulomb's law with a disc: p_t . u_t = p' . u', and u' against p' is u_t against
//! S^-2 p_t, the normal of the ellipse. So the problem is solved in these, with S W S for W, and what was found is taken back.
//!
//! **Giving.** A contact that gives by a matrix across its normal has what couples its tangents beside W's diagonal.

use nalgebra::{Matrix2, Vector2};

use super::ImpulseProblem;

/// A law whose friction is otherwise by direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// The row of its first tangent.
    at: usize,
    /// S, and its inverse.
    by: Matrix2<f64>,
    back: Matrix2<f64>,
}

impl ImpulseProblem {
    /// Lets the velocity along each tangent of the contact that was added last give for the impulse along the other too, by so much
    /// in m/s per N s.
    pub fn couple(&mut self, tangents: f64) {
        self.coupled.push((self.rows() - 2, tangents));
    }

    /// Lets the contact or disc that was added last hold otherwise by direction: along a unit vector among its tangents as its law says,
    /// across it `ratio` times as much, > 0.
    pub fn stretch(&mut self, along: Vector2<f64>, ratio: f64) {
        let scaled = |ratio: f64| {
            let lies = along * along.transpose();
            lies + ratio * (Matrix2::identity() - lies)
        };
        let at = self.rows() - 2;
        let stretch = Stretch {
            at,
            by: scaled(ratio),
            back: scaled(1.0 / ratio),
        };
        let free = stretch.by * Vector2::new(self.velocities[at], self.velocities[at + 1]);
        self.velocities[at..].copy_from_slice(free.as_slice());
        self.stretches.push(stretch);
    }

    /// Takes W to S W S.
    pub(super) fn stretch_response(&mut self) {
        for index in 0..self.stretches.len() {
            let Stretch { at, by, .. } = self.stretches[index];
            self.scale_response(at, by);
        }
    }

    /// Takes impulses, velocities and W back to what they are without S.
    pub(super) fn take_back(&mut self) {
        for index in 0..self.stretches.len() {
            let Stretch { at, by, back } = self.stretches[index];
            self.scale_response(at, back);
            for (of, by) in [(&mut self.impulses, by), (&mut self.velocities, back)] {
                let real = by * Vector2::new(of[at], of[at + 1]);
                of[at..at + 2].copy_from_slice(real.as_slice());
            }
        }
    }

    /// A friction impulse whose two rows begin here as its law counts it: S^-1 p_t.
    pub(super) fn in_disc(&self, at: usize, tangents: Vector2<f64>) -> Vector2<f64> {
        let stretch = self.stretches.iter().find(|s| s.at == at);
        stretch.map_or(tangents, |stretch| stretch.back * tangents)
    }

    /// Multiplies the rows of two tangents of W, and then their columns.
    fn scale_response(&mut self, at: usize, by: Matrix2<f64>) {
        let rows = self.rows();
        for other in 0..rows {
            self.scale_pair([at * rows + other, (at + 1) * rows + other], by);
        }
        for other in 0..rows {
            self.scale_pair([other * rows + at, other * rows + at + 1], by);
        }
    }

    fn scale_pair(&mut self, [first, second]: [usize; 2], by: Matrix2<f64>) {
        let scaled = by * Vector2::new(self.delassus[first], self.delassus[second]);
        self.delassus[first] = scaled.x;
        self.delassus[second] = scaled.y;
    }
}
