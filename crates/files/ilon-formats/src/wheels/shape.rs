//! The shapes that stand for rollers and tyres.

use std::f64::consts::PI;

use nalgebra::Isometry3;

use crate::model::{Collision, CollisionShape, Profile, ProfilePart};

/// A roller's shape in another simulator, along z of the roller frame, about its middle.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RollerShape {
    /// Equal ellipsoids of revolution about the roller's axis.
    Ellipsoids {
        /// Half axis across the roller's axis, in metres.
        radius_m: f64,
        /// Half axis along it, in metres.
        half_length_m: f64,
        /// Where they stand along it, in metres.
        at_m: Vec<f64>,
    },
    /// Solids: one capsule or cylinder, some spheres, or the collision shapes of its file.
    Solids(Vec<Collision>),
}

/// A solid at a place along the roller's axis.
pub(super) fn at(t_m: f64, shape: CollisionShape) -> Collision {
    Collision {
        friction: None,
        body_from_shape: Isometry3::translation(0.0, 0.0, t_m),
        shape,
    }
}

impl RollerShape {
    /// One solid about the middle.
    pub(super) fn of(solid: CollisionShape) -> Self {
        Self::Solids(vec![at(0.0, solid)])
    }

    /// What it is called.
    pub fn name(&self) -> String {
        match self {
            Self::Ellipsoids { at_m, .. } if at_m.len() == 1 => "an ellipsoid".to_owned(),
            Self::Ellipsoids { at_m, .. } => format!("{} ellipsoids", at_m.len()),
            Self::Solids(solids) => match &solids[..] {
                [one] => match one.shape {
                    CollisionShape::Capsule { .. } => "a capsule".to_owned(),
                    CollisionShape::Cylinder { .. } => "a cylinder".to_owned(),
                    CollisionShape::Sphere { .. } => "a sphere".to_owned(),
                    _ => "a solid".to_owned(),
                },
                solids => format!("{} solids", solids.len()),
            },
        }
    }

    /// Its outline about the roller's axis; `None` of the shapes of a file, which have theirs.
    pub(super) fn profile(&self) -> Option<Profile> {
        /// Circles for an ellipsoid: chords of its outline are off by less than 5e-5 of its length.
        const CIRCLES: u32 = 160;
        let part = |[t_m, ring_m]: [f64; 2], ball_m| ProfilePart {
            t_m,
            ring_m,
            ball_m,
        };
        let of_solid = |solid: &Collision| {
            let (half_m, ring_m, ball_m) = match solid.shape {
                CollisionShape::Sphere { radius_m } => (0.0, 0.0, radius_m),
                CollisionShape::Capsule { radius_m, length_m } => (0.5 * length_m, 0.0, radius_m),
                CollisionShape::Cylinder { radius_m, length_m } => (0.5 * length_m, radius_m, 0.0),
                _ => return None,
            };
            let t_m = solid.body_from_shape.translation.z;
            Some([-half_m, half_m].map(|end| part([t_m + end, ring_m], ball_m)))
        };
        let parts = match self {
            Self::Ellipsoids {
                radius_m,
                half_length_m,
                ..
            } => {
                let circle = |i| {
                    let (sin, cos) = libm::sincos(PI * (f64::from(i) / f64::from(CIRCLES) - 0.5));
                    part([half_length_m * sin, radius_m * cos], 0.0)
                };
                (0..=CIRCLES).map(circle).collect()
            }
            Self::Solids(solids) => {
                let ends: Vec<_> = solids.iter().map(of_solid).collect::<Option<_>>()?;
                ends.concat()
            }
        };
        Profile::new(parts)
    }
}
