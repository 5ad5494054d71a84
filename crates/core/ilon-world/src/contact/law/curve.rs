//! Rows whose velocity and impulse lie on a curve of straight pieces.
//!
//! Along the curve the velocity u grows or stays, and the impulse p rises by less than what would move the row so far by itself: by less
//! than du / w, with w the row's own response. So each line p = line + u / w of what the row does as the others are meets it once.

/// A curve of straight pieces, from its least velocity on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Curve {
    /// Where its pieces meet: velocity in m/s or rad/s, and impulse in N s or N m s. At least one.
    pub points: Vec<[f64; 2]>,
    /// How velocity and impulse change along its first and its last piece, which have no other end.
    pub ends: [[f64; 2]; 2],
}

/// The curves of a problem.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    points: Vec<[f64; 2]>,
    /// Of each curve the first of its points and the first that is none of them, and its ends.
    all: Vec<(usize, usize, [[f64; 2]; 2])>,
}

/// Where a row meets its curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    pub velocity: f64,
    pub impulse: f64,
    /// How velocity and impulse change along the piece that is met.
    along: [f64; 2],
}

impl Meeting {
    /// By how much the impulse of the meeting grows with the line p - u / own that is met: 0 where the impulse is the same all along the piece, 1 where
    /// the velocity is.
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

    /// Adds a curve, and gives its place.
    pub fn push(&mut self, curve: &Curve) -> usize {
        let first = self.points.len();
        self.points.extend_from_slice(&curve.points);
        let end = self.points.len();
        self.all.push((first, end, curve.ends));
        self.all.len() - 1
    }

    /// Where the line p - u / own = `line` meets the curve at a place.
    pub fn meet(&self, place: usize, line: f64, own: f64) -> Meeting {
        let (first, end, ends) = self.all[place];
        let points = &self.points[first..end];
        // By how much a point lies above the line; it falls along the curve.
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
                // From the nearer end: pieces may be much longer than what is counted in them.
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

    /// Every line p - u / own = constant meets the curve once, on the piece that lies there: its first and its last have no other end.
    #[test]
    fn a_line_meets_the_curve_where_both_have_one_velocity_and_one_impulse() {
        let curve = Curve {
            points: vec![[0.0, 0.0], [1.0, 0.2], [1.0, -0.3], [4.0, -0.6]],
            ends: [[1.0, 0.4], [1.0, -0.2]],
        };
        let mut curves = Curves::default();
        // Another before it, so that the places differ.
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
            // On an upright piece the velocity is given, and the impulse follows the line.
            let slope = met.slope(own);
            assert_eq!(slope == 1.0, along[0] == 0.0);
            // Over the rise of the line along the piece.
            let expected = along[1] / (along[1] - along[0] / own);
            assert!((slope - expected).abs() < 1e-12, "{slope} {expected}");
        }
    }

    /// Pieces may be a billion times as long as what is counted in them, as those of a torque that hardly falls with the rate: a
    /// meeting near either end of one is as exact as the numbers that are met, not as the length of the piece.
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
        // From [1, -1] on, impulse falls by (0.1 far - 1) / (far - 1) for each unit of velocity.
        let falls = (0.1 * far - 1.0) / (far - 1.0);
        for (velocity, impulse) in [(-0.5, 0.05), (1.5, -1.0 - 0.5 * falls)] {
            let met = curves.meet(place, impulse - velocity / own, own);
            // Sums of numbers of about one; from the far end they would be off by some of 1e9, 1e-7.
            assert!((met.velocity - velocity).abs() < 1e-12, "{met:?}");
            assert!((met.impulse - impulse).abs() < 1e-12, "{met:?}");
        }
    }
}
