//! Rows whose velocity and impulse lie on a piecewise linear curve.
//!
//! Along the curve the velocity u does not fall, and the impulse p rises by less than du / w, with
//! w the row's own response. So each line p = line + u / w, the row's behaviour for given other
//! impulses, intersects the curve exactly once.

/// A piecewise linear curve, from its smallest velocity on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Curve {
    /// The points between its pieces: velocity in m/s or rad/s, and impulse in N s or N m s. At
    /// least one.
    pub points: Vec<[f64; 2]>,
    /// Direction, as velocity and impulse, of its first and its last piece, which are unbounded.
    pub ends: [[f64; 2]; 2],
}

/// The curves of a problem.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    points: Vec<[f64; 2]>,
    /// For each curve the range of its points, and its ends.
    all: Vec<(usize, usize, [[f64; 2]; 2])>,
}

/// The intersection of a row with its curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    pub velocity: f64,
    pub impulse: f64,
    /// Direction, as velocity and impulse, of the intersected piece.
    along: [f64; 2],
}

impl Meeting {
    /// The derivative of the intersection's impulse by the line p - u / own: 0 if the impulse is
    /// constant along the piece, 1 if the velocity is.
    pub fn slope(&self, own: f64) -> f64 {
        let [velocity, impulse] = self.along;
        impulse / (impulse - velocity / own)
    }
}

impl Curves {
    pub fn clear(&mut self) {
        self.points.clear();
        self.all.clear();
    }

    /// Adds a curve, and returns its index.
    pub fn push(&mut self, curve: &Curve) -> usize {
        let first = self.points.len();
        self.points.extend_from_slice(&curve.points);
        let end = self.points.len();
        self.all.push((first, end, curve.ends));
        self.all.len() - 1
    }

    /// The intersection of the line p - u / own = `line` with the curve at an index.
    pub fn meet(&self, place: usize, line: f64, own: f64) -> Meeting {
        let (first, end, ends) = self.all[place];
        let points = &self.points[first..end];
        // The height of a point above the line; it falls along the curve.
        let above = |[velocity, impulse]: [f64; 2]| impulse - velocity / own - line;
        let at = |from: [f64; 2], along: [f64; 2], share: f64| Meeting {
            velocity: from[0] + share * along[0],
            impulse: from[1] + share * along[1],
            along,
        };
        let rise = |along: [f64; 2]| along[1] - along[0] / own;
        let below = points.iter().position(|point| above(*point) <= 0.0);
        match below {
            Some(0) => at(points[0], ends[0], -above(points[0]) / rise(ends[0])),
            Some(next) => {
                let (from, to) = (points[next - 1], points[next]);
                let along = [to[0] - from[0], to[1] - from[1]];
                let (before, after) = (above(from), above(to));
                // From the nearer end, because pieces may be much longer than the distances on
                // them.
                if before < -after {
                    at(from, along, before / (before - after))
                } else {
                    at(to, along, after / (before - after))
                }
            }
            None => {
                let last = points[points.len() - 1];
                at(last, ends[1], -above(last) / rise(ends[1]))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every line p - u / own = constant intersects the curve once, on the expected piece: its
    /// first and its last are unbounded.
    #[test]
    fn a_line_meets_the_curve_where_both_have_one_velocity_and_one_impulse() {
        let curve = Curve {
            points: vec![[0.0, 0.0], [1.0, 0.2], [1.0, -0.3], [4.0, -0.6]],
            ends: [[1.0, 0.4], [1.0, -0.2]],
        };
        let mut curves = Curves::default();
        // Another curve first, so that the indices differ.
        curves.push(&Curve {
            points: vec![[7.0, 7.0]],
            ends: [[0.0, -1.0]; 2],
        });
        let place = curves.push(&curve);
        let own = 2.0;
        // The point on each piece, the piece, and whether it is upright.
        for (velocity, impulse, along) in [
            (-2.0, -0.8, [1.0, 0.4]),
            (0.25, 0.05, [1.0, 0.2]),
            (0.75, 0.15, [1.0, 0.2]),
            (1.0, 0.1, [0.0, -0.5]),
            (2.5, -0.45, [3.0, -0.3]),
            (9.0, -1.6, [1.0, -0.2]),
        ] {
            let met = curves.meet(place, impulse - velocity / own, own);
            assert!(
                (met.velocity - velocity).abs() < 1e-12,
                "{met:?} {velocity}"
            );
            assert!((met.impulse - impulse).abs() < 1e-12, "{met:?} {impulse}");
            let off = [met.along[0] - along[0], met.along[1] - along[1]];
            assert!(off.iter().all(|off| off.abs() < 1e-12), "{met:?} {along:?}");
            // On a vertical piece the velocity is given, and the impulse follows the line.
            let slope = met.slope(own);
            assert_eq!(slope == 1.0, along[0] == 0.0);
            // Relative to the rise of the line along the piece.
            let expected = along[1] / (along[1] - along[0] / own);
            assert!((slope - expected).abs() < 1e-12, "{slope} {expected}");
        }
    }

    /// Pieces may be a billion times as long as the distances on them, such as those of a torque
    /// that hardly falls with the rate: an intersection near either end is as accurate as its
    /// numbers, not as the length of the piece.
    #[test]
    fn near_either_end_of_a_very_long_piece_the_meeting_is_exact() {
        let far = 1e9;
        let curve = Curve {
            points: vec![
                [-far, 0.1 * far],
                [0.0, 0.0],
                [1.0, -1.0],
                [far, -0.1 * far],
            ],
            ends: [[1.0, -0.1]; 2],
        };
        let mut curves = Curves::default();
        let place = curves.push(&curve);
        let own = 2.0;
        // From [1, -1] on, the impulse falls by (0.1 far - 1) / (far - 1) per unit of velocity.
        let falls = (0.1 * far - 1.0) / (far - 1.0);
        for (velocity, impulse) in [(-0.5, 0.05), (1.5, -1.0 - 0.5 * falls)] {
            let met = curves.meet(place, impulse - velocity / own, own);
            // Sums of numbers of about one; computed from the far end they would have errors of 1e9
            // roundings, 1e-7.
            assert!((met.velocity - velocity).abs() < 1e-12, "{met:?}");
            assert!((met.impulse - impulse).abs() < 1e-12, "{met:?}");
        }
    }
}
