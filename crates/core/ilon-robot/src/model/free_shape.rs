//! Boxes, cylinders and spheres that belong to no robot.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::CollisionShape;

/// The shape of a free body, around its centre, which is its centre of mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FreeShape {
    /// A box.
    Box {
        /// Its sides along its own axes, in metres.
        size_m: [f64; 3],
    },
    /// A cylinder along its own z axis.
    Cylinder {
        /// Its radius, in metres.
        radius_m: f64,
        /// Its length, in metres.
        length_m: f64,
    },
    /// A sphere.
    Sphere {
        /// Its radius, in metres.
        radius_m: f64,
    },
}

impl FreeShape {
    /// Its surface.
    pub fn collision(&self) -> CollisionShape {
        match *self {
            Self::Box { size_m } => CollisionShape::Box {
                half_extents_m: 0.5 * Vector3::from(size_m),
            },
            Self::Cylinder { radius_m, length_m } => {
                CollisionShape::Cylinder { radius_m, length_m }
            }
            Self::Sphere { radius_m } => CollisionShape::Sphere { radius_m },
        }
    }

    /// Each of its sizes with its name, in metres.
    pub fn sizes_m(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Box { size_m } => size_m.iter().map(|side| ("size_m", *side)).collect(),
            Self::Cylinder { radius_m, length_m } => {
                vec![("radius_m", radius_m), ("length_m", length_m)]
            }
            Self::Sphere { radius_m } => vec![("radius_m", radius_m)],
        }
    }

    /// Its volume, in m^3.
    pub fn volume_m3(&self) -> f64 {
        match *self {
            Self::Box { size_m } => Vector3::from(size_m).product(),
            Self::Cylinder { radius_m, length_m } => PI * radius_m * radius_m * length_m,
            Self::Sphere { radius_m } => 4.0 / 3.0 * PI * radius_m * radius_m * radius_m,
        }
    }

    /// Its inertia about its centre of a uniform density, over its mass, in m^2.
    pub fn inertia_m2(&self) -> Matrix3<f64> {
        let along = match *self {
            Self::Box { size_m } => {
                let size_m = Vector3::from(size_m);
                let squares = size_m.component_mul(&size_m) / 12.0;
                Vector3::repeat(squares.sum()) - squares
            }
            Self::Cylinder { radius_m, length_m } => {
                let across = radius_m * radius_m / 4.0 + length_m * length_m / 12.0;
                Vector3::new(across, across, 0.5 * radius_m * radius_m)
            }
            Self::Sphere { radius_m } => Vector3::repeat(0.4 * radius_m * radius_m),
        };
        Matrix3::from_diagonal(&along)
    }
}
