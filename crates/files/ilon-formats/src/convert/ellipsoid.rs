//! Ellipsoids, as balls whose envelope they are.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::writer::ShapeOf;

/// Balls that stand for an ellipsoid. A wheel of mecanum rollers then rolls on a radius that is too
/// small by less than 1e-4 of it.
const BALLS: usize = 31;

/// Shapes, placed in a frame.
pub(super) type Placed = Vec<(Isometry3<f64>, ShapeOf)>;

/// Balls whose envelope an ellipsoid of revolution is, if it is one that is longer than it is
/// thick.
///
/// Of an ellipsoid with the half axes a across and c > a along, the ball at t along the axis that
/// touches it from inside has the radius a sqrt(1 - t^2 / (c^2 - a^2)), as long as it touches at
/// all: |t| <= c - a^2 / c.
pub(super) fn ellipsoid(halves: [f64; 3]) -> Option<Placed> {
    let along = (0..3).find(|&i| {
        let (p, q) = (halves[(i + 1) % 3], halves[(i + 2) % 3]);
        (p - q).abs() < 1e-6 * p.max(q) && halves[i] >= p * (1.0 - 1e-6)
    })?;
    let (a, c) = (halves[(along + 1) % 3], halves[along]);
    if c <= a * (1.0 + 1e-6) {
        return Some(vec![(Isometry3::identity(), ShapeOf::Sphere(a))]);
    }
    let farthest = c - a * a / c;
    let balls = (0..BALLS).map(|i| {
        let t = farthest * (2.0 * i as f64 / (BALLS - 1) as f64 - 1.0);
        let radius = a * (1.0 - t * t / (c * c - a * a)).sqrt();
        let place = Translation3::from(Vector3::ith(along, t));
        (Isometry3::from(place), ShapeOf::Sphere(radius))
    });
    Some(balls.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At a tilt of sine w an ellipsoid reaches h = sqrt(a^2 + (c^2 - a^2) w^2), and the ball at t
    /// = h' touches it there. Of balls that are s apart two neighbours touch at most s / h'' apart,
    /// and between them the reach is less by at most (s / h'')^2 h'' / 8, h'' = (c^2 - a^2) a^2 /
    /// h^3.
    #[test]
    fn the_balls_reach_as_far_as_the_ellipsoid() {
        let (a, c): (f64, f64) = (0.012, 0.03);
        let balls = ellipsoid([a, a, c]).expect("it is longer than it is thick");
        let apart_m = 2.0 * (c - a * a / c) / (balls.len() - 1) as f64;
        let reach_m = |w: f64| (a * a + (c * c - a * a) * w * w).sqrt();
        let second = |w: f64| (c * c - a * a) * a * a / reach_m(w).powi(3);
        for step in -250..=250 {
            let w = 1e-3 * f64::from(step);
            // It falls with |w|.
            const NEAR: f64 = 0.05;
            let (least, most) = (second(w.abs() + NEAR), second((w.abs() - NEAR).max(0.0)));
            assert!(apart_m / least < NEAR);
            let most_m = (apart_m / least).powi(2) * most / 8.0;
            assert!(most_m < 1.5e-5, "{most_m}");
            let of_ball = |(place, shape): &(Isometry3<f64>, ShapeOf)| match shape {
                ShapeOf::Sphere(radius_m) => place.translation.z * w + radius_m,
                _ => panic!("a ball"),
            };
            let of_balls_m = balls.iter().map(of_ball).fold(0.0, f64::max);
            let missing_m = reach_m(w) - of_balls_m;
            assert!((-1e-15..most_m).contains(&missing_m), "{w}: {missing_m}");
        }
    }
}
