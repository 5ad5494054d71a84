//! Collision geometry: conversion to shapes of the model, and a roller's [`Profile`] about its
//! axis, with t counted from the point closest to the hub axis.

use nalgebra::{Isometry3, Point3, Unit, Vector3};
use urdf_rs::Geometry;

use super::mesh::Meshes;
use super::tree::PlacedShape;
use crate::error::Fault;
use crate::model::{CollisionShape, Profile, ProfilePart as Part};

/// Returns a URDF geometry as a shape, except meshes.
pub(super) fn primitive(geometry: &Geometry) -> Option<CollisionShape> {
    Some(match geometry {
        Geometry::Box { size } => CollisionShape::Box {
            half_extents_m: Vector3::from(**size) * 0.5,
        },
        Geometry::Cylinder { radius, length } => CollisionShape::Cylinder {
            radius_m: *radius,
            length_m: *length,
        },
        Geometry::Capsule { radius, length } => CollisionShape::Capsule {
            radius_m: *radius,
            length_m: *length,
        },
        Geometry::Sphere { radius } => CollisionShape::Sphere { radius_m: *radius },
        Geometry::Mesh { .. } => return None,
    })
}

/// Returns the largest distance of a shape from a point of the body frame, in metres; `None` for a
/// mesh.
pub(super) fn extent_m(shape: &PlacedShape, from: &Point3<f64>) -> Option<f64> {
    let own_m = match &shape.geometry {
        Geometry::Box { size } => 0.5 * Vector3::from(**size).norm(),
        Geometry::Cylinder { radius, length } => libm::hypot(*radius, 0.5 * length),
        Geometry::Capsule { radius, length } => radius + 0.5 * length,
        Geometry::Sphere { radius } => *radius,
        Geometry::Mesh { .. } => return None,
    };
    Some((Point3::from(shape.body_from_shape.translation.vector) - from).norm() + own_m)
}

/// Returns the vertices of a mesh in the frame that contains its shape.
pub(super) fn mesh_points(
    meshes: &Meshes,
    filename: &str,
    scale: Option<urdf_rs::Vec3>,
    place: &Isometry3<f64>,
) -> Result<Vec<Point3<f64>>, Fault> {
    let scale = scale.map_or(Vector3::repeat(1.0), |s| Vector3::from(*s));
    let vertices = meshes.vertices(filename)?;
    Ok(vertices
        .iter()
        .map(|v| place * Point3::from(v.coords.component_mul(&scale)))
        .collect())
}

/// The convex hull of a mesh, in the frame of its shape.
///
/// Of more than [`MOST_HULL_POINTS`] it takes the furthest vertices in that many directions, along
/// the axes and spread evenly where the mesh fills a cube: what looks for touches reads them all in
/// each step. Sharp corners stay; a smooth mesh lacks some 0.3 % of its half size at most, between
/// directions that are no further than 0.07 rad from any other.
pub(super) fn mesh_hull(
    meshes: &Meshes,
    filename: &str,
    scale: Option<urdf_rs::Vec3>,
) -> Result<CollisionShape, Fault> {
    let mut points_m = distinct(mesh_points(
        meshes,
        filename,
        scale,
        &Isometry3::identity(),
    )?);
    if points_m.len() > MOST_HULL_POINTS {
        points_m = distinct(furthest(points_m));
    }
    let points_m = points_m.into();
    Ok(CollisionShape::ConvexHull { points_m })
}

/// The furthest of many points in each of [`MOST_HULL_POINTS`] directions.
fn furthest(mut points: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
    /// Points that lie together, and cells along an axis in which they do. Chosen.
    const TOGETHER: usize = 256;
    const CELLS: f64 = 16.0;
    let (low, high) = range(&points);
    let half = 0.5 * (high - low).map(|side| side.max(1e-9));
    let cell = |p: &Point3<f64>| {
        let cell = (p.coords - low).component_div(&half) * (0.5 * CELLS);
        [cell.x, cell.y, cell.z].map(|x| x as u8)
    };
    points.sort_by_cached_key(cell);
    let groups: Vec<_> = points.chunks(TOGETHER).map(|of| (range(of), of)).collect();
    let furthest = |even: Vector3<f64>| {
        let u = even.component_div(&half);
        let (mut most, mut furthest) = (f64::NEG_INFINITY, points[0]);
        for ((low, high), group) in &groups {
            let reach = low.component_mul(&u).sup(&high.component_mul(&u)).sum();
            if reach <= most {
                continue;
            }
            for point in *group {
                let reach = point.coords.dot(&u);
                if reach > most {
                    (most, furthest) = (reach, *point);
                }
            }
        }
        furthest
    };
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let axes = axes.into_iter().flat_map(|axis| [axis, -axis]);
    let all = axes.chain(directions(MOST_HULL_POINTS - 6));
    all.map(furthest).collect()
}

/// The least and the largest coordinates of points.
pub(super) fn range(points: &[Point3<f64>]) -> (Vector3<f64>, Vector3<f64>) {
    let none = Vector3::repeat(f64::INFINITY);
    points.iter().fold((none, -none), |(low, high), p| {
        (low.inf(&p.coords), high.sup(&p.coords))
    })
}

/// Each point once.
fn distinct(mut points: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
    let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(f64::to_bits);
    points.sort_unstable_by_key(key);
    points.dedup_by_key(|p| key(p));
    points
}

/// The most points of a hull.
const MOST_HULL_POINTS: usize = 2000;

/// Unit directions spread evenly over the sphere, on a spiral.
fn directions(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (s, c) = libm::sincos(golden * i as f64);
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * c, r * s, z)
    })
}

/// Reads collision shapes, all in one frame with the axis, which passes through `foot`.
pub(super) fn profile(
    foot: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
    shapes: &[PlacedShape],
    meshes: &Meshes,
) -> Result<Profile, Fault> {
    let mut parts = Vec::new();
    for shape in shapes {
        read_shape(foot, axis, shape, meshes, &mut parts)?;
    }
    Profile::new(parts).ok_or(Fault::RollerWithoutShape)
}

fn read_shape(
    foot: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
    shape: &PlacedShape,
    meshes: &Meshes,
    parts: &mut Vec<Part>,
) -> Result<(), Fault> {
    let from_foot = Point3::from(shape.body_from_shape.translation.vector) - foot;
    let t_m = from_foot.dot(axis);
    let off_axis_m = (from_foot - axis.into_inner() * t_m).norm();
    // The cosine between the roller's axis and a shape's axis; within one degree they count as
    // equal.
    let aligned = |shape_axis: Vector3<f64>| {
        (shape.body_from_shape * shape_axis).dot(axis).abs() > libm::cos(1f64.to_radians())
    };
    let mut add = |t_m, ring_m, ball_m| {
        parts.push(Part {
            t_m,
            ring_m,
            ball_m,
        })
    };
    let radius_m = match &shape.geometry {
        Geometry::Sphere { radius } => {
            add(t_m, 0.0, *radius);
            *radius
        }
        Geometry::Capsule { radius, length } if aligned(Vector3::z()) => {
            add(t_m - 0.5 * length, 0.0, *radius);
            add(t_m + 0.5 * length, 0.0, *radius);
            *radius
        }
        Geometry::Cylinder { radius, length } if aligned(Vector3::z()) => {
            add(t_m - 0.5 * length, *radius, 0.0);
            add(t_m + 0.5 * length, *radius, 0.0);
            *radius
        }
        Geometry::Box { size } => {
            let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
            let along = (0..3)
                .find(|&i| aligned(axes[i]))
                .ok_or(Fault::RollerNotRound)?;
            let (p, q) = (size[(along + 1) % 3], size[(along + 2) % 3]);
            if (p - q).abs() > 0.05 * p.max(q) {
                return Err(Fault::RollerNotRound);
            }
            // A square box stands for the inscribed cylinder.
            let radius = 0.25 * (p + q);
            add(t_m - 0.5 * size[along], radius, 0.0);
            add(t_m + 0.5 * size[along], radius, 0.0);
            radius
        }
        Geometry::Mesh { filename, scale } => {
            let scale = scale.map_or(Vector3::repeat(1.0), |s| Vector3::from(*s));
            let vertices = meshes.vertices(filename)?;
            let from_foot = vertices.iter().map(|v| {
                shape.body_from_shape * Point3::from(v.coords.component_mul(&scale)) - foot
            });
            parts.extend(turned(axis, from_foot)?);
            return Ok(());
        }
        Geometry::Cylinder { .. } | Geometry::Capsule { .. } => return Err(Fault::RollerNotRound),
    };
    if off_axis_m > 0.05 * radius_m {
        return Err(Fault::RollerNotRound);
    }
    Ok(())
}

/// Returns the circles of the outermost points about the axis; rejects points that are not round
/// about it.
fn turned(
    axis: &Unit<Vector3<f64>>,
    points: impl Iterator<Item = Vector3<f64>>,
) -> Result<Vec<Part>, Fault> {
    // The extents in any two directions across the axis must be centred and equal.
    let least_aligned = if axis.x.abs() < 0.7 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let p = axis.cross(&least_aligned).normalize();
    let q = axis.cross(&p);
    let mut extent = [(f64::INFINITY, f64::NEG_INFINITY); 2];
    let mut circles: Vec<(f64, f64)> = Vec::new();
    for point in points {
        let (x, y) = (point.dot(&p), point.dot(&q));
        for (e, value) in extent.iter_mut().zip([x, y]) {
            *e = (e.0.min(value), e.1.max(value));
        }
        circles.push((point.dot(axis), libm::hypot(x, y)));
    }
    let radius_m = circles.iter().map(|c| c.1).fold(0.0, f64::max);
    let round = extent.iter().all(|(low, high)| {
        (low + radius_m).abs() < 0.1 * radius_m && (high - radius_m).abs() < 0.1 * radius_m
    });
    if !round {
        return Err(Fault::RollerNotRound);
    }
    // Only the upper convex hull of (t, radius) can support.
    circles.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut hull: Vec<(f64, f64)> = Vec::new();
    for c in circles {
        while let [.., a, b] = hull[..] {
            let turns_left = (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0) >= 0.0;
            if !turns_left {
                break;
            }
            hull.pop();
        }
        hull.push(c);
    }
    Ok(hull
        .into_iter()
        .map(|(t_m, ring_m)| Part {
            t_m,
            ring_m,
            ball_m: 0.0,
        })
        .collect())
}
