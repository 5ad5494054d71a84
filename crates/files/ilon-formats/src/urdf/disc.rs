//! Interprets a link's geometry as a wheel: round about an axis, with a radius and a middle.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};
use urdf_rs::Geometry;

use super::body::RigidBody;
use super::geometry::{mesh_points, range};
use super::mesh::Meshes;
use super::mesh_rollers;
use super::tree::PlacedShape;
use crate::error::Fault;

/// Number of directions across the axis in which a mesh's reach is sampled.
const DIRECTIONS: usize = 16;
/// A mesh is round if its reaches differ by less than this share of the largest.
const ROUND: f64 = 0.08;
/// A round shape is centred on the axis if its middle is off it by less than this share of its
/// radius.
const CENTRED: f64 = 0.1;

/// A wheel's geometry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    /// Its radius, in metres.
    pub(super) radius_m: f64,
    /// Its middle along the axis, from the given origin, in metres.
    pub(super) middle_m: f64,
    /// Whether only visual shapes show it, because there are no collision shapes.
    pub(super) of_visuals: bool,
}

/// Why a body's geometry shows no wheel.
#[derive(Clone, Debug)]
pub(super) enum NoDisc {
    /// No geometry.
    Bare,
    /// An unreadable mesh.
    Unreadable(Fault),
    /// No shape is round about the axis; with a description.
    NotRound(String),
}

impl NoDisc {
    /// Returns a description for a message about a joint: "...".
    pub(super) fn words(&self) -> String {
        match self {
            Self::Bare => "it has no geometry".to_owned(),
            Self::Unreadable(fault) => fault.to_string(),
            Self::NotRound(why) => why.clone(),
        }
    }
}

/// Returns the wheel that a body shows about an axis, the z axis of the frame: the largest round
/// collision shape, or else visual shape.
pub(super) fn about(
    body: &RigidBody,
    body_from_frame: &Isometry3<f64>,
    meshes: &Meshes,
) -> Result<Disc, NoDisc> {
    let (shapes, of_visuals) = if body.shapes.is_empty() {
        (&body.visuals, true)
    } else {
        (&body.shapes, false)
    };
    let mut largest: Option<(f64, f64)> = None;
    let mut why_not = NoDisc::Bare;
    for shape in shapes {
        match of_shape(shape, body_from_frame, meshes) {
            Ok(found) if largest.is_none_or(|l| found.0 > l.0) => largest = Some(found),
            Ok(_) => {}
            // Other shapes may be a motor's mount: the unreadable one may be the wheel.
            Err(NoDisc::Unreadable(fault)) => return Err(NoDisc::Unreadable(fault)),
            Err(other) => why_not = other,
        }
    }
    match largest {
        Some((radius_m, middle_m)) => Ok(Disc {
            radius_m,
            middle_m,
            of_visuals,
        }),
        None => Err(why_not),
    }
}

/// Returns the width of the widest shape of a body that is round about an axis, the z axis of the
/// frame, in metres: collision shapes, or else visual shapes. `None` if only spheres are.
pub(super) fn width_m(
    body: &RigidBody,
    body_from_frame: &Isometry3<f64>,
    meshes: &Meshes,
) -> Option<f64> {
    let shapes = match &body.shapes[..] {
        [] => &body.visuals,
        _ => &body.shapes,
    };
    let width_m = |shape: &PlacedShape| {
        of_shape(shape, body_from_frame, meshes).ok()?;
        let from_shape = body_from_frame.inverse() * shape.body_from_shape;
        match &shape.geometry {
            Geometry::Cylinder { length, .. } | Geometry::Capsule { length, .. } => Some(*length),
            Geometry::Box { size } => (0..3)
                .find(|&i| (from_shape.rotation * Vector3::ith(i, 1.0)).z.abs() > 0.99)
                .map(|along| size[along]),
            Geometry::Sphere { .. } => None,
            Geometry::Mesh { filename, scale } => {
                let points = mesh_points(meshes, filename, *scale, &from_shape).ok()?;
                let along = || points.iter().map(|point| point.z);
                Some(
                    along().fold(f64::NEG_INFINITY, f64::max)
                        - along().fold(f64::INFINITY, f64::min),
                )
            }
        }
    };
    shapes.iter().filter_map(width_m).reduce(f64::max)
}

/// Returns the radii of all readable shapes of a body that are round about an axis, the z axis of
/// the frame, in metres.
pub(super) fn readable(
    body: &RigidBody,
    body_from_frame: &Isometry3<f64>,
    meshes: &Meshes,
) -> Vec<f64> {
    let shapes = body.shapes.iter().chain(&body.visuals);
    let discs = shapes.filter_map(|shape| of_shape(shape, body_from_frame, meshes).ok());
    discs.map(|(radius_m, _)| radius_m).collect()
}

/// Returns the radii of the cylinders of a body that are centred on an axis, the z axis of the
/// frame, but transverse to it, in metres: a wheel's wrongly rotated cylinder still shows its
/// radius.
pub(super) fn cylinders_across(body: &RigidBody, body_from_frame: &Isometry3<f64>) -> Vec<f64> {
    let shapes = body.shapes.iter().chain(&body.visuals);
    let across = shapes.filter_map(|shape| {
        let Geometry::Cylinder { radius, .. } = &shape.geometry else {
            return None;
        };
        let from_shape = body_from_frame.inverse() * shape.body_from_shape;
        let is_across = (from_shape * Vector3::z()).z.abs() < 0.1;
        let is_centred = from_shape.translation.vector.xy().norm() <= CENTRED * radius;
        (is_across && is_centred).then_some(*radius)
    });
    across.collect()
}

/// Returns the largest distance of a body's readable meshes from an axis, the z axis of the frame,
/// in metres.
pub(super) fn mesh_reach_m(
    body: &RigidBody,
    body_from_frame: &Isometry3<f64>,
    meshes: &Meshes,
) -> Option<f64> {
    let shapes = body.shapes.iter().chain(&body.visuals);
    let points = shapes.filter_map(|shape| match &shape.geometry {
        Geometry::Mesh { filename, scale } => {
            let place = body_from_frame.inverse() * shape.body_from_shape;
            mesh_points(meshes, filename, *scale, &place).ok()
        }
        _ => None,
    });
    points
        .flatten()
        .map(|point| point.xy().coords.norm())
        .reduce(f64::max)
}

/// Returns radius and middle of one shape.
fn of_shape(
    shape: &PlacedShape,
    body_from_frame: &Isometry3<f64>,
    meshes: &Meshes,
) -> Result<(f64, f64), NoDisc> {
    let from_shape = body_from_frame.inverse() * shape.body_from_shape;
    let center = from_shape.translation.vector;
    let aligned = (from_shape * Vector3::z()).z.abs() > 0.99;
    let off_m = center.xy().norm();
    let centred = |radius: f64| {
        if off_m <= CENTRED * radius {
            Ok((off_m + radius, center.z))
        } else {
            Err(NoDisc::NotRound(format!(
                "its geometry of radius {:.1} mm stands {:.1} mm off the axis",
                1e3 * radius,
                1e3 * off_m
            )))
        }
    };
    match &shape.geometry {
        Geometry::Sphere { radius } => centred(*radius),
        Geometry::Cylinder { radius, .. } | Geometry::Capsule { radius, .. } if aligned => {
            centred(*radius)
        }
        Geometry::Cylinder { .. } | Geometry::Capsule { .. } => Err(NoDisc::NotRound(
            "its cylinder does not lie along the axis".to_owned(),
        )),
        // A square box stands for the inscribed wheel.
        Geometry::Box { size } => match square_about(size, &from_shape) {
            Some(radius) => centred(radius),
            None => Err(NoDisc::NotRound(
                "its box is not square about the axis".to_owned(),
            )),
        },
        Geometry::Mesh { filename, scale } => {
            let points =
                mesh_points(meshes, filename, *scale, &from_shape).map_err(NoDisc::Unreadable)?;
            let (radius_m, middle_m) = square_of(&points).map_or_else(|| of_points(&points), Ok)?;
            // Corners of rollers' ends and of a rim reach further than the rolling surface, by an
            // amount that differs between mirrored wheels.
            let drawn = mesh_rollers::of_mesh(filename, *scale, &from_shape, meshes);
            let radius_m = drawn.map_or(radius_m, |drawn| drawn.wheel_radius_m);
            Ok((radius_m, middle_m))
        }
    }
}

/// Returns half of the side of a box that is square about z; `None` for others.
fn square_about(size: &[f64; 3], from_shape: &Isometry3<f64>) -> Option<f64> {
    let along = (0..3).find(|&i| (from_shape.rotation * Vector3::ith(i, 1.0)).z.abs() > 0.99)?;
    side(size[(along + 1) % 3], size[(along + 2) % 3])
}

/// Returns half of the side of a square with these sides; `None` if they differ.
fn side(p: f64, q: f64) -> Option<f64> {
    ((p - q).abs() <= 0.05 * p.max(q)).then_some(0.25 * (p + q))
}

/// Returns radius and middle of the wheel for which the corners of a box stand that is square about
/// z: a mesh that is a box counts as a box.
fn square_of(points: &[Point3<f64>]) -> Option<(f64, f64)> {
    /// Share of the half of a side by which a corner may be rounded.
    const ROUNDED: f64 = 0.01;
    let (low, high) = range(points);
    let (middle, size) = (0.5 * (low + high), high - low);
    let is_corner = |point: &Point3<f64>| {
        let off = (point.coords - middle).abs() - 0.5 * size;
        off.x.abs() <= ROUNDED * size.x && off.y.abs() <= ROUNDED * size.y
    };
    let radius_m = side(size.x, size.y)?;
    let off_m = middle.xy().norm();
    let is_box = off_m <= CENTRED * radius_m && points.iter().all(is_corner);
    is_box.then_some((off_m + radius_m, middle.z))
}

/// Returns radius and middle of points that are round about z.
fn of_points(points: &[Point3<f64>]) -> Result<(f64, f64), NoDisc> {
    let (mut radius, mut low, mut high) = (0.0f64, f64::INFINITY, f64::NEG_INFINITY);
    for v in points {
        radius = radius.max(v.xy().coords.norm());
        (low, high) = (low.min(v.z), high.max(v.z));
    }
    let least = least_reach(points);
    if least < (1.0 - ROUND) * radius {
        return Err(NoDisc::NotRound(format!(
            "its mesh reaches {:.1} mm from the axis one way and {:.1} mm another",
            1e3 * radius,
            1e3 * least
        )));
    }
    Ok((radius, 0.5 * (low + high)))
}

/// Returns the smallest reach across z over some directions.
fn least_reach(points: &[Point3<f64>]) -> f64 {
    (0..DIRECTIONS)
        .map(|k| {
            let (s, c) = libm::sincos(2.0 * PI * k as f64 / DIRECTIONS as f64);
            let reach = |v: &Point3<f64>| c * v.x + s * v.y;
            points.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
        })
        .fold(f64::INFINITY, f64::min)
}

/// Returns the level axis about which a body's geometry is round, with its middle point, for a
/// joint without a stated axis.
pub(super) fn level_axis(
    body: &RigidBody,
    meshes: &Meshes,
) -> Result<(Point3<f64>, Unit<Vector3<f64>>), NoDisc> {
    let shapes = if body.shapes.is_empty() {
        &body.visuals
    } else {
        &body.shapes
    };
    let mut best: Option<(f64, Point3<f64>, Unit<Vector3<f64>>)> = None;
    let mut why_not = NoDisc::Bare;
    for shape in shapes {
        let candidates = match axes_of(shape, meshes) {
            Ok(candidates) => candidates,
            Err(NoDisc::Unreadable(fault)) => return Err(NoDisc::Unreadable(fault)),
            Err(other) => {
                why_not = other;
                continue;
            }
        };
        for (radius_m, middle, axis) in candidates {
            if axis.z.abs() > 0.1 {
                why_not =
                    NoDisc::NotRound("it is round about an axis that is not level".to_owned());
            } else if best.as_ref().is_none_or(|b| radius_m > b.0) {
                // To the left, or forward if it points along x: wheels drive forward.
                let leftward = if axis.y.abs() > 1e-6 { axis.y } else { axis.x };
                best = Some((radius_m, middle, if leftward < 0.0 { -axis } else { axis }));
            }
        }
    }
    best.map(|(_, middle, axis)| (middle, axis)).ok_or(why_not)
}

/// The axes about which a shape is round, with radius and middle.
type Axes = Vec<(f64, Point3<f64>, Unit<Vector3<f64>>)>;

fn axes_of(shape: &PlacedShape, meshes: &Meshes) -> Result<Axes, NoDisc> {
    let place = &shape.body_from_shape;
    let middle = Point3::from(place.translation.vector);
    match &shape.geometry {
        Geometry::Cylinder { radius, .. } | Geometry::Capsule { radius, .. } => Ok(vec![(
            *radius,
            middle,
            Unit::new_normalize(place.rotation * Vector3::z()),
        )]),
        Geometry::Sphere { .. } => Err(NoDisc::NotRound(
            "a sphere is round about every axis".to_owned(),
        )),
        Geometry::Box { .. } => Err(NoDisc::NotRound("a box is not round".to_owned())),
        Geometry::Mesh { filename, scale } => {
            let points = mesh_points(meshes, filename, *scale, &Isometry3::identity())
                .map_err(NoDisc::Unreadable)?;
            let found: Axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()]
                .into_iter()
                .filter_map(|axis| {
                    let turn = UnitQuaternion::rotation_between(&axis, &Vector3::z())
                        .unwrap_or_else(UnitQuaternion::identity);
                    let turned: Vec<Point3<f64>> = points.iter().map(|p| turn * p).collect();
                    let center = box_middle(&turned);
                    let about: Vec<Point3<f64>> =
                        turned.iter().map(|p| Point3::from(p - center)).collect();
                    let (radius_m, _) = of_points(&about).ok()?;
                    let middle = place * (turn.inverse() * center);
                    Some((
                        radius_m,
                        middle,
                        Unit::new_normalize(place.rotation * *axis),
                    ))
                })
                .collect();
            match found.len() {
                1 => Ok(found),
                0 => Err(NoDisc::NotRound(
                    "its mesh is round about none of its axes".to_owned(),
                )),
                _ => Err(NoDisc::NotRound(
                    "its mesh is round about several axes".to_owned(),
                )),
            }
        }
    }
}

fn box_middle(points: &[Point3<f64>]) -> Point3<f64> {
    let (low, high) = range(points);
    Point3::from((low + high) * 0.5)
}
