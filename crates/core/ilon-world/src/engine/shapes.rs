//! Converts collision shapes of the robot's file to parry's.

use ilon_robot::{Collision, CollisionShape, ModelledRoller};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::engine::convert;

/// A shape and its pose in the frame of its body; `None` for a hull without volume.
pub(crate) fn shape_of(collision: &Collision) -> Option<(Isometry3<f64>, SharedShape)> {
    // URDF's cylinders are along z, parry's along y.
    let y_to_z = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    let as_it_is = UnitQuaternion::identity();
    let (shape, turn) = match &collision.shape {
        CollisionShape::Box { half_extents_m: h } => (SharedShape::cuboid(h.x, h.y, h.z), as_it_is),
        CollisionShape::Cylinder { radius_m, length_m } => {
            (SharedShape::cylinder(0.5 * *length_m, *radius_m), y_to_z)
        }
        CollisionShape::Capsule { radius_m, length_m } => {
            (SharedShape::capsule_z(0.5 * *length_m, *radius_m), as_it_is)
        }
        CollisionShape::Sphere { radius_m } => (SharedShape::ball(*radius_m), as_it_is),
        CollisionShape::ConvexHull { points_m } => {
            let points: Vec<Vector> = points_m
                .iter()
                .map(|p| convert::vector(&p.coords))
                .collect();
            (SharedShape::convex_hull(&points)?, as_it_is)
        }
    };
    Some((collision.body_from_shape * turn, shape))
}

/// The shapes of a roller in its file, as one in its own frame; `None` if a hull among them has no
/// volume.
pub(crate) fn shape_of_roller(modelled: &ModelledRoller) -> Option<SharedShape> {
    let parts: Option<Vec<_>> = modelled.shapes.iter().map(shape_of).collect();
    let parts = parts?
        .into_iter()
        .map(|(pose, shape)| (convert::pose(&pose), shape));
    Some(SharedShape::compound(parts.collect()))
}
