//! The description of a floor: its surface, obstacles, and friction by place.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector2, Vector3};
use parry3d::shape::{HeightField, HeightFieldFlags};
use parry3d::utils::Array2;
use rapier3d::prelude::*;
use smart_default::SmartDefault;

use super::{ContactSurface, FloorSurface};
use crate::WorldError;
use crate::error::{FINITE, POSITIVE, check_numbers};

/// The ground a robot drives on.
///
/// Its frame is that of the world: the origin is in its plane, and z is its normal. On a slope
/// gravity is tilted.
#[derive(Clone, Debug, SmartDefault, PartialEq)]
pub struct Floor {
    /// Coulomb friction coefficient between roller and ground, >= 0.
    #[default = 0.6]
    pub friction: f64,
    /// Slope: the angle by which the ground falls towards +x, in radians; 0 is level. All
    /// coordinates are in the sloping plane, and heights along its normal.
    pub slope_rad: f64,
    /// Patches with another friction; later ones cover earlier ones.
    pub patches: Vec<Patch>,
    /// Boxes on the ground: kerbs, thresholds, walls.
    pub boxes: Vec<GroundBox>,
    /// Uneven ground instead of the plane.
    pub relief: Option<Relief>,
    /// Its surface outside patches.
    pub surface: FloorSurface,
    /// Materials of rollers ([`ilon_robot::Wheel::material`]) for which `footings`, here and on
    /// each patch, define the surface; `friction` and `surface` apply to all others.
    pub materials: Vec<String>,
    /// The surface for rollers of each of `materials`, outside patches.
    pub footings: Vec<ContactSurface>,
}

/// A rectangle of ground along the world's axes with its own friction.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Its middle in the world, in metres.
    pub center_m: Vector2<f64>,
    /// Half of its sides along x and y, in metres.
    pub half_sides_m: Vector2<f64>,
    /// Coulomb friction coefficient there, >= 0.
    pub friction: f64,
    /// Its surface.
    pub surface: FloorSurface,
    /// The surface for rollers of each of the floor's [`Floor::materials`].
    pub footings: Vec<ContactSurface>,
}

/// A box in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundBox {
    /// Its middle in the world, in metres.
    pub center_m: Vector3<f64>,
    /// Half of its sides along its own axes, in metres.
    pub half_sides_m: Vector3<f64>,
    /// Its heading in the world, in radians.
    pub heading_rad: f64,
    /// The angle by which the end along its own x axis is lowered, about its middle, in radians;
    /// negative for a ramp that leads up.
    pub pitch_rad: f64,
}

/// Uneven ground: heights on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// Distance between neighbouring heights, in metres, > 0.
    pub cell_m: f64,
    /// The middle of the grid in the world, in metres.
    pub center_m: Vector2<f64>,
    /// Heights above the plane in metres: row by row from -y to +y, in each row from -x to +x. Rows
    /// of one length, at least 2 x 2.
    pub heights_m: Vec<Vec<f64>>,
}

impl Floor {
    /// The direction of gravity in the floor's frame, whose z is the floor's normal.
    pub(super) fn down(&self) -> Vector3<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -self.slope_rad) * -Vector3::z()
    }

    /// The highest point of uneven ground and boxes within a circle around a point in the floor's
    /// plane, in metres; 0 if there are none.
    pub(crate) fn highest_m(&self, center_m: Vector2<f64>, radius_m: f64) -> f64 {
        let on_boxes = self.boxes.iter().filter_map(|solid| {
            let within_m = radius_m + solid.half_sides_m.norm();
            let top_m = solid.center_m.z + solid.half_height_m();
            ((solid.center_m.xy() - center_m).norm() <= within_m).then_some(top_m)
        });
        let on_relief = self
            .relief
            .iter()
            .filter_map(|relief| relief.highest_m(center_m, radius_m));
        let ground_m = if self.relief.is_some() {
            f64::NEG_INFINITY
        } else {
            0.0
        };
        let highest_m = on_boxes.chain(on_relief).fold(ground_m, f64::max);
        if highest_m.is_finite() {
            highest_m
        } else {
            0.0
        }
    }

    /// Refuses invalid floors.
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        let setting = |name, value, range| Err(WorldError::Setting { name, value, range });
        for footing in self.all_footings() {
            footing.check()?;
        }
        let of_patches = self.patches.iter().map(|patch| patch.footings.len());
        let mut counts = of_patches.chain([self.footings.len()]);
        if let Some(count) = counts.find(|count| *count != self.materials.len()) {
            let range = "one of each of the floor's materials";
            return setting("footings", count as f64, range);
        }
        let upright = std::f64::consts::FRAC_PI_2;
        if !(-upright..=upright).contains(&self.slope_rad) {
            return setting("slope_rad", self.slope_rad, "between -pi/2 and pi/2");
        }
        let sides = self.boxes.iter().flat_map(|of| of.half_sides_m.iter());
        check_numbers(sides.map(|side_m| ("half_sides_m", *side_m, POSITIVE)))?;
        let mut pitches = self.boxes.iter().map(|solid| solid.pitch_rad);
        if let Some(bad) = pitches.find(|pitch| !(-upright..=upright).contains(pitch)) {
            return setting("pitch_rad", bad, "between -pi/2 and pi/2");
        }
        if let Some(relief) = &self.relief {
            check_numbers([("cell_m", relief.cell_m, POSITIVE)])?;
            let [columns, rows] = relief.points();
            let is_grid = relief.heights_m.iter().all(|row| row.len() == columns);
            if rows < 2 || columns < 2 || !is_grid {
                let range = "a grid of at least 2 x 2 heights";
                return setting("heights_m", rows as f64, range);
            }
            let middle = relief.center_m.iter();
            let heights = relief.heights_m.iter().flatten();
            check_numbers(middle.map(|at_m| ("center_m", *at_m, FINITE)))?;
            check_numbers(heights.map(|height_m| ("heights_m", *height_m, "finite everywhere")))?;
        }
        Ok(())
    }

    /// All surfaces of the floor, for all rollers.
    pub(crate) fn all_footings(&self) -> impl Iterator<Item = ContactSurface> {
        let plain = |friction, surface| ContactSurface { friction, surface };
        let floor = std::iter::once(plain(self.friction, self.surface));
        let patches = self.patches.iter().flat_map(move |patch| {
            let own = std::iter::once(plain(patch.friction, patch.surface));
            own.chain(patch.footings.iter().copied())
        });
        floor.chain(self.footings.iter().copied()).chain(patches)
    }

    /// Everything but the plane: its pose in the floor's frame and its shape.
    pub(super) fn solids(&self) -> Vec<(Isometry3<f64>, SharedShape)> {
        // parry's height fields rise along y over x and z: a quarter turn about x brings y up to z
        // and -z to y.
        let upright =
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        let relief = self.relief.iter().map(|relief| {
            let at_m = relief.center_m.push(0.0);
            (
                Isometry3::from_parts(Translation3::from(at_m), upright),
                relief.shape(),
            )
        });
        let boxes = self.boxes.iter().map(|solid| {
            let h = solid.half_sides_m;
            let shape = SharedShape::cuboid(h.x, h.y, h.z);
            (solid.floor_from_box(), shape)
        });
        relief.chain(boxes).collect()
    }
}

impl GroundBox {
    pub(super) fn floor_from_box(&self) -> Isometry3<f64> {
        let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.heading_rad);
        let pitch = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), self.pitch_rad);
        Isometry3::from_parts(self.center_m.into(), heading * pitch)
    }

    /// From its centre up to its highest corner, in metres.
    fn half_height_m(&self) -> f64 {
        let (sin, cos) = libm::sincos(self.pitch_rad);
        cos.abs() * self.half_sides_m.z + sin.abs() * self.half_sides_m.x
    }
}

impl Relief {
    /// The number of heights along x and along y.
    pub(super) fn points(&self) -> [usize; 2] {
        [
            self.heights_m.first().map_or(0, Vec::len),
            self.heights_m.len(),
        ]
    }

    /// Its lengths along x and y, in metres.
    fn sides_m(&self) -> Vector2<f64> {
        let sides = self.points().map(|points| (points - 1) as f64);
        self.cell_m * Vector2::from(sides)
    }

    /// Its corner at the smallest x and y, in metres.
    pub(super) fn corner_m(&self) -> Vector2<f64> {
        self.center_m - 0.5 * self.sides_m()
    }

    /// The highest point within a circle around a point, in metres; `None` if the circle misses the
    /// grid.
    fn highest_m(&self, center_m: Vector2<f64>, radius_m: f64) -> Option<f64> {
        let corner_m = self.corner_m();
        let is_near = |row: usize, column: usize| {
            let at = corner_m + Vector2::new(column as f64, row as f64) * self.cell_m;
            (at - center_m).norm() <= radius_m + self.cell_m
        };
        let rows = self.heights_m.iter().enumerate();
        let heights = rows.flat_map(|(row, heights)| {
            let cells = heights.iter().enumerate();
            cells.filter(move |(column, _)| is_near(row, *column))
        });
        heights.map(|(_, height_m)| *height_m).reduce(f64::max)
    }

    fn shape(&self) -> SharedShape {
        let [columns, rows] = self.points();
        // parry's rows are along its z, which is our -y.
        let heights = Array2::new(
            rows,
            columns,
            (0..rows * columns)
                .map(|i| self.heights_m[rows - 1 - i % rows][i / rows])
                .collect(),
        );
        let sides = self.sides_m();
        SharedShape::new(HeightField::with_flags(
            heights,
            Vector::new(sides.x, 1.0, sides.y),
            HeightFieldFlags::FIX_INTERNAL_EDGES,
        ))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    /// A box reaches as high as the highest of its corners, for any heading and pitch.
    #[test]
    fn a_box_is_as_high_as_its_highest_corner() {
        let half_sides_m = Vector3::new(0.4, 0.2, 0.1);
        for (heading_rad, pitch_rad) in [(0.0, 0.0), (0.7, 0.3), (-2.0, -0.5), (1.0, 2.5)] {
            let solid = GroundBox {
                center_m: Vector3::new(2.0, -1.0, 0.5),
                half_sides_m,
                heading_rad,
                pitch_rad,
            };
            let corners = (0..8).map(|corner| {
                let side = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
                let signs = Vector3::new(side(0), side(1), side(2));
                let place =
                    solid.floor_from_box() * Point3::from(half_sides_m.component_mul(&signs));
                place.z
            });
            let highest_m = corners.fold(f64::NEG_INFINITY, f64::max);
            let floor = Floor {
                boxes: vec![solid],
                ..Floor::default()
            };
            let found_m = floor.highest_m(solid.center_m.xy(), 0.1);
            assert!((found_m - highest_m).abs() < 1e-15, "{found_m} {highest_m}");
            // A circle beside it that a corner may reach into, and one out of its reach.
            let reach_m = half_sides_m.norm();
            for (off_m, expected_m) in [(reach_m + 0.09, highest_m), (reach_m + 0.11, 0.0)] {
                let beside_m = solid.center_m.xy() + off_m * Vector2::new(0.6, 0.8);
                let found_m = floor.highest_m(beside_m, 0.1);
                assert!(
                    (found_m - expected_m).abs() < 1e-15,
                    "{off_m} m off: {found_m}"
                );
            }
        }
    }

    /// The height around a point is the highest of the grid points in the circle and a cell around
    /// it. The corner is at (0, -2): the point in the second row, the seventh along x, is at (3,
    /// -1.5).
    #[test]
    fn a_relief_is_as_high_as_its_highest_point_around_a_place() {
        let mut heights_m = vec![vec![0.0; 9]; 5];
        heights_m[1][6] = 0.3;
        let floor = Floor {
            relief: Some(Relief {
                center_m: Vector2::new(2.0, -1.0),
                cell_m: 0.5,
                heights_m,
            }),
            ..Floor::default()
        };
        let place_m = Vector2::new(3.0, -1.5);
        for (off_m, expected_m) in [(0.0, 0.3), (0.89, 0.3), (0.91, 0.0)] {
            for way in [
                Vector2::x(),
                -Vector2::x(),
                Vector2::y(),
                Vector2::new(0.6, -0.8),
            ] {
                let found_m = floor.highest_m(place_m + off_m * way, 0.4);
                assert_eq!(found_m, expected_m, "{off_m} m off along {way}");
            }
        }
    }
}
