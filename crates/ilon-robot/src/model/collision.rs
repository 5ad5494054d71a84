//! What can touch the world, but for rollers.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};

/// A collision shape and where it sits.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// Pose of the shape in the frame of the body that carries it.
    pub body_from_shape: Isometry3<f64>,
    /// The shape.
    pub shape: CollisionShape,
}

/// The collision shapes of URDF, all but the hull centred on their own frame.
#[derive(Clone, Debug, PartialEq)]
pub enum CollisionShape {
    /// A box with sides along the axes.
    Box {
        /// Half of each side, in metres.
        half_extents_m: Vector3<f64>,
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius in metres.
        radius_m: f64,
        /// Length along z, in metres.
        length_m: f64,
    },
    /// A capsule along z.
    Capsule {
        /// Radius in metres.
        radius_m: f64,
        /// Length of the cylindrical part along z, in metres.
        length_m: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius in metres.
        radius_m: f64,
    },
    /// The convex hull of a mesh's vertices.
    ConvexHull {
        /// The vertices, in metres.
        points_m: Arc<[Point3<f64>]>,
    },
}

impl Collision {
    /// How far the shape reaches from the origin of the body that carries it, in a unit direction of that body's frame, in
    /// metres.
    pub fn reach_m(&self, direction: &Vector3<f64>) -> f64 {
        let d = self.body_from_shape.rotation.inverse() * direction;
        let from_middle_m = match &self.shape {
            CollisionShape::Box { half_extents_m } => half_extents_m.dot(&d.abs()),
            CollisionShape::Cylinder { radius_m, length_m } => {
                radius_m * d.xy().norm() + 0.5 * length_m * d.z.abs()
            }
            CollisionShape::Capsule { radius_m, length_m } => radius_m + 0.5 * length_m * d.z.abs(),
            CollisionShape::Sphere { radius_m } => *radius_m,
            CollisionShape::ConvexHull { points_m } => points_m
                .iter()
                .map(|p| p.coords.dot(&d))
                .fold(f64::NEG_INFINITY, f64::max),
        };
        self.body_from_shape.translation.vector.dot(direction) + from_middle_m
    }
}
