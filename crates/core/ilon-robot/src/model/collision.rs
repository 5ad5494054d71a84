//! Collision geometry other than rollers.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};

/// A collision shape and its pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// Pose of the shape in the frame of the body that carries it.
    pub body_from_shape: Isometry3<f64>,
    /// The shape.
    pub shape: CollisionShape,
    /// Its friction on the ground, such as 0 of a ball caster; `None` for that of the ground.
    pub friction: Option<f64>,
}

/// The collision shapes of URDF; all except the hull are centred on their own frame.
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
    /// Returns the furthest point of the shape in a direction of the frame of the body that carries
    /// it, in metres; the middle of the furthest edge or face for shapes other than hulls.
    pub fn farthest(&self, direction: &Vector3<f64>) -> Point3<f64> {
        let d = self.body_from_shape.rotation.inverse() * direction;
        // Along a side at right angles to the direction the middle is as far as any point.
        let towards = |x: f64, most: f64| {
            if x.abs() < 1e-9 {
                0.0
            } else {
                most.copysign(x)
            }
        };
        let in_shape = match &self.shape {
            CollisionShape::Box { half_extents_m } => d.zip_map(half_extents_m, towards),
            CollisionShape::Cylinder { radius_m, length_m } => {
                let level = d.xy().try_normalize(1e-9).unwrap_or_default() * *radius_m;
                Vector3::new(level.x, level.y, towards(d.z, 0.5 * length_m))
            }
            CollisionShape::Capsule { radius_m, length_m } => {
                let end = Vector3::new(0.0, 0.0, towards(d.z, 0.5 * length_m));
                end + d.normalize() * *radius_m
            }
            CollisionShape::Sphere { radius_m } => d.normalize() * *radius_m,
            CollisionShape::ConvexHull { points_m } => {
                let points = points_m.iter().map(|point| point.coords);
                let farthest = points.max_by(|a, b| a.dot(&d).total_cmp(&b.dot(&d)));
                farthest.unwrap_or_default()
            }
        };
        self.body_from_shape * Point3::from(in_shape)
    }

    /// Returns how far the shape reaches from the origin of the body that carries it, in a unit
    /// direction of that body's frame, in metres.
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

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, vector};

    use super::*;

    /// In every direction the furthest point is as far as the shape reaches.
    #[test]
    fn the_farthest_point_is_as_far_as_the_shape_reaches() {
        let points = [[0.1, 0.0, 0.2], [-0.3, 0.1, 0.0], [0.0, -0.2, -0.1]];
        let shapes = [
            CollisionShape::Box {
                half_extents_m: vector![0.1, 0.2, 0.3],
            },
            CollisionShape::Cylinder {
                radius_m: 0.1,
                length_m: 0.4,
            },
            CollisionShape::Capsule {
                radius_m: 0.1,
                length_m: 0.4,
            },
            CollisionShape::Sphere { radius_m: 0.2 },
            CollisionShape::ConvexHull {
                points_m: points.map(Point3::from).into(),
            },
        ];
        let turned = UnitQuaternion::from_euler_angles(0.3, -0.7, 1.1);
        for shape in shapes {
            let body_from_shape = Isometry3::from_parts(vector![0.5, -0.4, 0.3].into(), turned);
            let collision = Collision {
                friction: None,
                body_from_shape,
                shape,
            };
            for direction in [
                vector![0.0, 0.0, -1.0],
                vector![1.0, 0.0, 0.0],
                vector![0.6, 0.0, 0.8],
                vector![-0.48, 0.6, 0.64],
            ] {
                let farthest_m = collision.farthest(&direction).coords.dot(&direction);
                let reach_m = collision.reach_m(&direction);
                assert!(
                    (farthest_m - reach_m).abs() < 1e-12,
                    "{collision:?} in {direction}"
                );
            }
        }
    }

    /// If a face or an edge is at right angles to the direction, its middle is returned.
    #[test]
    fn of_a_face_the_middle_is_meant() {
        let down = vector![0.0, 0.0, -1.0];
        let at = |shape| {
            let body_from_shape = Isometry3::translation(0.1, 0.2, 0.3);
            Collision {
                friction: None,
                body_from_shape,
                shape,
            }
            .farthest(&down)
        };
        let boxed = at(CollisionShape::Box {
            half_extents_m: vector![0.1, 0.2, 0.3],
        });
        assert_eq!(boxed, Point3::new(0.1, 0.2, 0.0));
        let disc = at(CollisionShape::Cylinder {
            radius_m: 0.1,
            length_m: 0.4,
        });
        assert!((disc - Point3::new(0.1, 0.2, 0.1)).norm() < 1e-15);
    }
}
