//! A roller's size and place from its joint and its collision geometry.
//!
//! Symbols as in [`crate::barrel`]: a the distance between hub axis and roller axis, k = sin delta = cos gamma, t a place
//! along the roller's axis from the point nearest to the hub axis.

use nalgebra::{Point3, Unit, Vector3};
use urdf_rs::Geometry;

use super::tree::PlacedShape;

/// The common perpendicular of hub axis and roller axis, in the hub frame.
pub(super) struct Skew {
    /// The point of the roller's axis nearest to the hub axis.
    pub(super) foot: Point3<f64>,
    /// Distance a between the axes, in metres.
    pub(super) ring_radius_m: f64,
    /// The paper's gamma of this roller, signed, in [-pi/2, pi/2].
    pub(super) gamma_rad: f64,
}

/// How a roller's axis lies to the hub axis, which is z of the hub frame. `None` where they are parallel or meet.
pub(super) fn skew(through: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> Option<Skew> {
    let across_squared = axis.xy().norm_squared();
    if across_squared < 1e-12 {
        return None;
    }
    // Seen along the hub axis the roller's axis is a line; its point nearest to the origin is the foot.
    let t = -through.xy().coords.dot(&axis.xy()) / across_squared;
    let foot = through + axis.into_inner() * t;
    let ring_radius_m = foot.xy().coords.norm();
    if ring_radius_m < 1e-9 {
        return None;
    }
    // Turned with the wheel until it points down, the foot is on x of the hub frame (down) and the tangent
    // z x x = y is -u. With u_gamma = n cos gamma + (k x n) sin gamma, the roller's axis k x u_gamma is
    // cos gamma y - sin gamma z; its sense is chosen so that its y component is positive.
    let outward = Vector3::new(foot.x, foot.y, 0.0) / ring_radius_m;
    let tangent = Vector3::z().cross(&outward);
    let along_tangent = axis.dot(&tangent);
    let sense = 1f64.copysign(along_tangent);
    let gamma_rad = (-sense * axis.z).atan2(sense * along_tangent);
    Some(Skew {
        foot,
        ring_radius_m,
        gamma_rad,
    })
}

/// What the collision geometry says of a roller's outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Outline {
    /// The wheel's radius rho that this roller makes, in metres.
    pub(super) wheel_radius_m: f64,
    /// Half of the length L between the outermost spheres of its barrel, in metres; `None` for a lone sphere, which
    /// says nothing of it.
    pub(super) half_length_m: Option<f64>,
    /// Where its middle is along the axis, from the foot, in metres.
    pub(super) middle_m: f64,
    /// How far the geometry leaves the circle of the wheel, in metres.
    pub(super) error_m: f64,
}

/// Why a roller's geometry cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unreadable {
    /// There is none.
    Missing,
    /// It is not round about the roller's axis, or not centred on it.
    NotRound,
    /// It is a mesh.
    Mesh,
}

/// Reads a roller's outline. `shapes` are in the hub frame.
pub(super) fn outline(
    skew: &Skew,
    axis: &Unit<Vector3<f64>>,
    shapes: &[PlacedShape],
) -> Result<Outline, Unreadable> {
    match shapes {
        [] => Err(Unreadable::Missing),
        [one] => one_shape(skew, axis, one),
        stack => sphere_stack(skew, axis, stack),
    }
}

fn one_shape(
    skew: &Skew,
    axis: &Unit<Vector3<f64>>,
    shape: &PlacedShape,
) -> Result<Outline, Unreadable> {
    let a = skew.ring_radius_m;
    let k = skew.gamma_rad.cos();
    let (middle_m, off_axis_m) = along_and_off(skew, axis, shape);
    // The cosine between the roller's axis and an axis of the shape; within one degree they are taken as one.
    let aligned = |shape_axis: Vector3<f64>| {
        (shape.body_from_shape * shape_axis).dot(axis).abs() > 1f64.to_radians().cos()
    };
    let (radius_m, half_length_m) = match shape.geometry {
        Geometry::Sphere { radius } => (radius, None),
        Geometry::Capsule { radius, length } if aligned(Vector3::z()) => {
            (radius, Some(0.5 * length))
        }
        Geometry::Cylinder { radius, length } if aligned(Vector3::z()) => (
            radius,
            Some(barrel_half_length_m(a, k, a + radius, 0.5 * length)),
        ),
        Geometry::Box { size } => {
            let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
            let along = (0..3)
                .find(|&i| aligned(axes[i]))
                .ok_or(Unreadable::NotRound)?;
            let (p, q) = (size[(along + 1) % 3], size[(along + 2) % 3]);
            if (p - q).abs() > 0.05 * p.max(q) {
                return Err(Unreadable::NotRound);
            }
            let radius = 0.25 * (p + q);
            (
                radius,
                Some(barrel_half_length_m(a, k, a + radius, 0.5 * size[along])),
            )
        }
        Geometry::Mesh { .. } => return Err(Unreadable::Mesh),
        Geometry::Cylinder { .. } | Geometry::Capsule { .. } => return Err(Unreadable::NotRound),
    };
    if off_axis_m > 0.05 * radius_m {
        return Err(Unreadable::NotRound);
    }
    Ok(Outline {
        wheel_radius_m: a + radius_m,
        half_length_m,
        middle_m,
        error_m: 0.0,
    })
}

/// A stack of spheres along the axis: each reaches sqrt(a^2 + t^2 k^2) + r from the hub axis, and the barrel that they
/// stand for reaches rho everywhere.
fn sphere_stack(
    skew: &Skew,
    axis: &Unit<Vector3<f64>>,
    stack: &[PlacedShape],
) -> Result<Outline, Unreadable> {
    let k = skew.gamma_rad.cos();
    let mut reaches = Vec::with_capacity(stack.len());
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for shape in stack {
        let Geometry::Sphere { radius } = shape.geometry else {
            return Err(match shape.geometry {
                Geometry::Mesh { .. } => Unreadable::Mesh,
                _ => Unreadable::NotRound,
            });
        };
        let (t, off_axis_m) = along_and_off(skew, axis, shape);
        if off_axis_m > 0.05 * radius {
            return Err(Unreadable::NotRound);
        }
        reaches.push(skew.ring_radius_m.hypot(t * k) + radius);
        (first, last) = (first.min(t), last.max(t));
    }
    let wheel_radius_m = reaches.iter().sum::<f64>() / reaches.len() as f64;
    let error_m = reaches
        .iter()
        .map(|reach| (reach - wheel_radius_m).abs())
        .fold(0.0, f64::max);
    Ok(Outline {
        wheel_radius_m,
        half_length_m: Some(0.5 * (last - first)),
        middle_m: 0.5 * (first + last),
        error_m,
    })
}

/// Place of a shape's centre along the roller's axis from the foot, and its distance from the axis.
fn along_and_off(skew: &Skew, axis: &Unit<Vector3<f64>>, shape: &PlacedShape) -> (f64, f64) {
    let from_foot = Point3::from(shape.body_from_shape.translation.vector) - skew.foot;
    let t = from_foot.dot(axis);
    (t, (from_foot - axis.into_inner() * t).norm())
}

/// Half of L for a roller that is cut flat `half_extent_m` from its middle: the barrel's outermost sphere is the one that
/// touches the ground at the cut.
///
/// At wheel angle phi the sphere at t = a tan(phi) / k touches, at t + s k sin(phi) along the axis; the function grows
/// with phi, so that halving the interval finds the cut.
pub(super) fn barrel_half_length_m(a: f64, k: f64, rho: f64, half_extent_m: f64) -> f64 {
    let touching_place_m = |phi: f64| a * phi.tan() / k + (rho - a / phi.cos()) * k * phi.sin();
    // The barrel tapers to nothing where a / cos(phi) = rho.
    let (mut low, mut high) = (0.0, (a / rho).clamp(-1.0, 1.0).acos());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if touching_place_m(middle) < half_extent_m {
            low = middle;
        } else {
            high = middle;
        }
    }
    a * low.tan() / k
}
