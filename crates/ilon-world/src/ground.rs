//! The ground: a plane or a rough surface, what stands on it, and how slippery it is where.

mod anchor;
mod floor;

use nalgebra::{Isometry3, Point3, Vector3};
use parry3d::bounding_volume::Aabb;
use rapier3d::prelude::*;

use crate::contact::nearest::{Piece, SolidBox, Triangle};
use crate::engine::convert;

pub(crate) use anchor::{Anchor, Grip};
pub use floor::{Floor, FloorSurface, GroundBox, Patch, Relief, Stribeck};

/// What a running world needs to know of its ground: a body that never moves.
#[derive(Clone)]
pub(crate) struct Ground {
    has_plane: bool,
    friction: f64,
    surface: FloorSurface,
    patches: Vec<Patch>,
    solids: Vec<Solid>,
    /// The boxes among them.
    boxes: Vec<SolidBox>,
    /// The direction of gravity.
    down: Vector3<f64>,
}

/// A part of the ground that is not the plane.
#[derive(Clone)]
struct Solid {
    floor_from_solid: Isometry3<f64>,
    shape: SharedShape,
}

impl Ground {
    /// Fills `pieces` with those of the ground that may be nearer to a place than `within_m`.
    pub fn pieces_near(&self, place_m: &Vector3<f64>, within_m: f64, pieces: &mut Vec<Piece>) {
        pieces.clear();
        let mut offer = |piece: Piece| {
            if piece.foot(place_m).distance_m < within_m {
                pieces.push(piece);
            }
        };
        if self.has_plane {
            offer(Piece::Plane);
        }
        self.boxes
            .iter()
            .for_each(|solid| offer(Piece::Box(*solid)));
        for solid in &self.solids {
            let Some(field) = solid.shape.as_heightfield() else {
                continue;
            };
            let center = solid.floor_from_solid.inverse() * Point3::from(*place_m);
            let half = Vector3::repeat(within_m);
            let around = Aabb::new(
                convert::vector(&(center.coords - half)),
                convert::vector(&(center.coords + half)),
            );
            field.map_elements_in_local_aabb(&around, &mut |_, triangle| {
                let corner = |corner: Vector| {
                    (solid.floor_from_solid * Point3::from(convert::to_f64(corner))).coords
                };
                let corners_m = [triangle.a, triangle.b, triangle.c].map(corner);
                if let Some(triangle) = Triangle::new(corners_m, &Vector3::z()) {
                    offer(Piece::Triangle(triangle));
                }
            });
        }
    }

    /// Whether everything below a point of the ground is ground too, as below a plane and the boxes on it; below a relief nothing is.
    pub fn is_solid_below(&self) -> bool {
        self.has_plane
    }

    /// Whether there is more than a plane.
    pub fn has_solids(&self) -> bool {
        !self.solids.is_empty()
    }

    /// How far a shape of a robot is from the ground, in metres; not above 0 where they touch, and f64's infinity where
    /// parry cannot tell. f32 counts from the robot's anchor.
    pub fn distance_m(
        &self,
        anchor: &Anchor,
        floor_from_shape: &Isometry3<f64>,
        shape: &SharedShape,
    ) -> f64 {
        let rapier_from_floor = anchor.rapier_from_floor();
        let in_rapier = convert::pose(&(rapier_from_floor * floor_from_shape));
        let plane = self.has_plane.then(|| SharedShape::halfspace(Vector::Z));
        let plane = plane.iter().map(|plane| (Pose::IDENTITY, plane));
        let solids = self.solids.iter().map(|solid| {
            let pose = convert::pose(&(rapier_from_floor * solid.floor_from_solid));
            (pose, &solid.shape)
        });
        let distances = plane.chain(solids).map(|(pose, ground)| {
            parry3d::query::distance(&pose, &**ground, &in_rapier, &**shape)
                .map_or(f64::INFINITY, |found| f64::from(found.distance))
        });
        distances.fold(f64::INFINITY, f64::min)
    }

    /// The acceleration of gravity in the floor's frame, in m/s^2, from its magnitude: on a slope it leans.
    pub fn gravity_in_floor(&self, gravity_m_s2: f64) -> Vector3<f64> {
        self.down * gravity_m_s2
    }

    /// Changes the friction from now on.
    pub fn set_friction(&mut self, friction: f64, patches: &[Patch]) {
        self.friction = friction;
        self.patches = patches.to_vec();
    }

    /// The friction coefficient at a place in the floor's frame.
    pub fn friction_at(&self, in_floor_m: &Vector3<f64>) -> f64 {
        let patch = self.patch_at(in_floor_m);
        patch.map_or(self.friction, |p| p.friction).max(0.0)
    }

    /// What the ground is made of at a place in the floor's frame.
    pub fn surface_at(&self, in_floor_m: &Vector3<f64>) -> FloorSurface {
        self.patch_at(in_floor_m)
            .map_or(self.surface, |p| p.surface)
    }

    /// The patch that a place in the floor's frame lies on, of several the last.
    fn patch_at(&self, in_floor_m: &Vector3<f64>) -> Option<&Patch> {
        let inside = |p: &&Patch| {
            let off = in_floor_m.xy() - p.center_m;
            off.x.abs() <= p.half_sides_m.x && off.y.abs() <= p.half_sides_m.y
        };
        self.patches.iter().rev().find(inside)
    }
}
