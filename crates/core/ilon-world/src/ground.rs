//! The ground: a plane or uneven ground, obstacles, and friction by place.

mod floor;
mod height_field;
mod in_rapier;
mod surface;

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use rapier3d::prelude::*;

use crate::contact::search::bounds::Bounds;
use crate::contact::search::nearest::{Piece, SolidBox};
use crate::contact::search::solid::{Near, Solid as ContactSolid};

pub use floor::{Floor, GroundBox, Patch, Relief};
pub(crate) use height_field::HeightField;
pub(crate) use in_rapier::{Grip, insert_into};
pub use surface::{ContactSurface, FloorSurface, Nap, Stribeck};

/// The ground of a running world: a body that never moves.
#[derive(Clone)]
pub(crate) struct Ground {
    has_plane: bool,
    /// Its surface outside patches, for all materials that `materials` does not name.
    built: ContactSurface,
    /// A friction set later, which replaces the original one outside patches.
    set_friction: Option<f64>,
    /// Materials of rollers, and the surface for each of them outside patches.
    materials: Vec<String>,
    footings: Vec<ContactSurface>,
    patches: Vec<Patch>,
    solids: Vec<Solid>,
    /// The relief among them.
    relief: Option<Arc<HeightField>>,
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

impl Solid {
    /// As the search for contacts uses it.
    fn placed(&self) -> ContactSolid<'_> {
        ContactSolid {
            shape: &self.shape,
            floor_from_shape: self.floor_from_solid,
        }
    }
}

impl Ground {
    /// The ground of a floor.
    pub fn of(floor: &Floor) -> Self {
        let solids = floor.solids().into_iter();
        let boxes = floor.boxes.iter().map(|solid| SolidBox {
            floor_from_box: solid.floor_from_box(),
            half_sides_m: solid.half_sides_m,
        });
        Self {
            boxes: boxes.collect(),
            relief: floor
                .relief
                .as_ref()
                .map(|relief| Arc::new(HeightField::of(relief))),
            solids: solids
                .map(|(floor_from_solid, shape)| Solid {
                    floor_from_solid,
                    shape,
                })
                .collect(),
            has_plane: floor.relief.is_none(),
            built: ContactSurface {
                friction: floor.friction,
                surface: floor.surface,
            },
            set_friction: None,
            materials: floor.materials.clone(),
            footings: floor.footings.clone(),
            patches: floor.patches.clone(),
            down: floor.down(),
        }
    }

    /// Fills `pieces` with the pieces of ground that may be nearer to a point than `within_m`.
    pub fn pieces_near(&self, place_m: &Vector3<f64>, within_m: f64, pieces: &mut Vec<Piece>) {
        self.solids_near(place_m, within_m, pieces);
        if let Some(relief) = self.relief() {
            let around = Bounds::of_ball(place_m, within_m);
            relief.triangles_in(&around, |triangle| {
                let piece = Piece::Triangle(triangle);
                if piece.foot(place_m).distance_m < within_m {
                    pieces.push(piece);
                }
            });
        }
    }

    /// The same without the triangles of uneven ground.
    pub fn solids_near(&self, place_m: &Vector3<f64>, within_m: f64, pieces: &mut Vec<Piece>) {
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
    }

    /// The uneven ground instead of the plane, if there is any.
    pub fn relief(&self) -> Option<&HeightField> {
        self.relief.as_deref()
    }

    /// Whether the ground extends to any depth, as below a plane and the boxes on it; uneven ground
    /// has nothing beneath it.
    pub fn is_solid_below(&self) -> bool {
        self.has_plane
    }

    /// The parts of the ground that are not the plane.
    pub fn solids(&self) -> impl Iterator<Item = ContactSolid<'_>> {
        self.solids.iter().map(Solid::placed)
    }

    /// Whether there is more than a plane.
    pub fn has_solids(&self) -> bool {
        !self.solids.is_empty()
    }

    /// Passes the places where a solid within a box is nearer to the ground than this to `show`.
    pub fn near(
        &self,
        (solid, bounds): (&ContactSolid<'_>, &Bounds),
        within_m: f64,
        mut show: impl FnMut(Near),
    ) {
        let around = bounds.grown(within_m);
        if self.has_plane && around.least_m.z <= 0.0 {
            solid.near_plane(within_m, &mut show);
        }
        for ground in &self.solids {
            let reaches = match self.relief() {
                Some(relief) if ground.shape.as_heightfield().is_some() => relief.reaches(&around),
                _ => ground.placed().bounds().meets(&around),
            };
            if reaches {
                solid.near(&ground.placed(), within_m, &mut show);
            }
        }
    }

    /// The distance of a solid from the ground, in metres, negative inside; further away from
    /// uneven ground a lower bound.
    pub fn gap_m(&self, solid: &ContactSolid<'_>) -> f64 {
        let of_plane_m = match self.has_plane {
            true => solid.lowest_m(),
            false => f64::INFINITY,
        };
        self.solids()
            .map(|ground| solid.gap_m(&ground))
            .fold(of_plane_m, f64::min)
    }

    /// The acceleration of gravity in the floor's frame, in m/s^2, from its magnitude; tilted on a
    /// slope.
    pub fn gravity_in_floor(&self, gravity_m_s2: f64) -> Vector3<f64> {
        self.down * gravity_m_s2
    }

    /// Changes the direction of gravity from now on, a unit vector.
    pub fn lean(&mut self, down: Vector3<f64>) {
        self.down = down;
    }

    /// Changes the patches from now on, and the friction elsewhere; `None` restores the original
    /// one.
    pub fn set_friction(&mut self, friction: Option<f64>, patches: &[Patch]) {
        self.set_friction = friction;
        self.patches = patches.to_vec();
    }

    /// The surface at a point in the floor's frame, for rollers of a material.
    pub fn footing_at(&self, in_floor_m: &Vector3<f64>, material: Option<&str>) -> ContactSurface {
        // Nearly all floors are the same for all rollers.
        let index = if self.materials.is_empty() {
            None
        } else {
            material.and_then(|name| self.materials.iter().position(|known| known == name))
        };
        let of_material = |footings: &[ContactSurface]| footings.get(index?).copied();
        let mut footing = match self.patch_at(in_floor_m) {
            Some(patch) => of_material(&patch.footings).unwrap_or(ContactSurface {
                friction: patch.friction,
                surface: patch.surface,
            }),
            None => {
                let built = of_material(&self.footings).unwrap_or(self.built);
                ContactSurface {
                    friction: self.set_friction.unwrap_or(built.friction),
                    ..built
                }
            }
        };
        footing.friction = footing.friction.max(0.0);
        footing
    }

    /// The last patch that contains a point in the floor's frame.
    fn patch_at(&self, in_floor_m: &Vector3<f64>) -> Option<&Patch> {
        let inside = |p: &&Patch| {
            let off = in_floor_m.xy() - p.center_m;
            off.x.abs() <= p.half_sides_m.x && off.y.abs() <= p.half_sides_m.y
        };
        self.patches.iter().rev().find(inside)
    }
}
