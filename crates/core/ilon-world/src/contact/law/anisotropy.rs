//! Contacts with anisotropic friction, compliance or drag.
//!
//! **Friction.** The friction impulse of such a contact lies in an ellipse, |S^-1 p_t| <= mu p_n
//! with S symmetric and positive. When it slides, the velocity is along the ellipse's normal,
//! opposed to the impulse, so that friction dissipates the most that the ellipse allows (an
//! associated law). In p' = S^-1 p_t and u' = S u_t that is Coulomb's law with a disc: p_t . u_t =
//! p' . u', and u' against p' is u_t against S^-2 p_t, the normal of the ellipse. So the problem is
//! solved in these variables, with S W S for W, and the solution is transformed back.
//!
//! **Compliance.** A contact whose tangential compliance is a matrix has a coupling of its tangents
//! in addition to W.

use nalgebra::{Matrix2, Vector2};

/// The laws with anisotropic friction.
#[derive(Clone, Debug, Default)]
pub(super) struct Anisotropies(Vec<Anisotropy>);

/// A law with anisotropic friction.
#[derive(Clone, Copy, Debug)]
struct Anisotropy {
    /// The row of its first tangent.
    at: usize,
    /// S, and its inverse.
    by: Matrix2<f64>,
    back: Matrix2<f64>,
}

impl Anisotropies {
    pub fn clear(&mut self) {
        self.0.clear();
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Makes the friction of a law anisotropic; its first tangent has the row `at`. Along a unit
    /// vector among its tangents the friction is the law's, across it `ratio` times as much, > 0.
    /// Its velocities, which are the last, become u'.
    pub fn push(&mut self, at: usize, (along, ratio): (Vector2<f64>, f64), velocities: &mut [f64]) {
        let scaled = |ratio: f64| {
            let lies = along * along.transpose();
            lies + ratio * (Matrix2::identity() - lies)
        };
        let anisotropy = Anisotropy {
            at,
            by: scaled(ratio),
            back: scaled(1.0 / ratio),
        };
        let free = anisotropy.by * Vector2::new(velocities[at], velocities[at + 1]);
        velocities[at..].copy_from_slice(free.as_slice());
        self.0.push(anisotropy);
    }

    /// Transforms W with `rows` rows to S W S.
    pub fn apply(&self, delassus: &mut [f64], rows: usize) {
        for anisotropy in &self.0 {
            scale_response(delassus, rows, (anisotropy.at, anisotropy.by));
        }
    }

    /// Transforms impulses, velocities and W back.
    pub fn take_back(
        &self,
        (impulses, velocities): (&mut [f64], &mut [f64]),
        delassus: &mut [f64],
        rows: usize,
    ) {
        for &Anisotropy { at, by, back } in &self.0 {
            scale_response(delassus, rows, (at, back));
            for (of, by) in [(&mut *impulses, by), (&mut *velocities, back)] {
                let real = by * Vector2::new(of[at], of[at + 1]);
                of[at..at + 2].copy_from_slice(real.as_slice());
            }
        }
    }

    /// A friction impulse in two rows from `at` on, as its law sees it: S^-1 p_t.
    pub fn in_disc(&self, at: usize, tangents: Vector2<f64>) -> Vector2<f64> {
        let anisotropy = self.0.iter().find(|s| s.at == at);
        anisotropy.map_or(tangents, |anisotropy| anisotropy.back * tangents)
    }
}

/// Multiplies the rows of two tangents of W, and then their columns.
fn scale_response(delassus: &mut [f64], rows: usize, (at, by): (usize, Matrix2<f64>)) {
    let mut scale_pair = |[first, second]: [usize; 2]| {
        let scaled = by * Vector2::new(delassus[first], delassus[second]);
        delassus[first] = scaled.x;
        delassus[second] = scaled.y;
    };
    for other in 0..rows {
        scale_pair([at * rows + other, (at + 1) * rows + other]);
    }
    for other in 0..rows {
        scale_pair([other * rows + at, other * rows + at + 1]);
    }
}
