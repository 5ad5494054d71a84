//! Ellipsoids, as balls whose envelope they are.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::writer::ShapeOf;

/// Balls that stand for an ellipsoid.
const BALLS: usize = 15;

/// Shapes, placed in a frame.
pub(super) type Placed = Vec<(Isometry3<f64>, ShapeOf)>;

/// Balls whose envelope an ellipsoid of revolution is, if it is one that is longer than it is thick.
///
/// Of an ellipsoid with the half axes a across and c > a along, the ball at t along the axis that touches it from inside has the
/// radius a sqrt(1 - t^2 / (c^2 - a^2)), as long as it touches at all: |t| <= c - a^2 / c.
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
