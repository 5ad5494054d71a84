//! Finds places where two solids are near each other, and where one is near the floor's plane.
//!
//! Box, sphere and cylinder against the plane, a sphere against all three, and the side of a
//! cylinder against boxes and sides are computed in closed form. For all other pairs parry finds
//! the near faces, edges and corners.

use nalgebra::{Isometry3, Point3, Vector3};
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d::shape::Shape;
use rapier3d::prelude::*;

use crate::contact::search::ball_and_cylinder::{SolidBall, SolidCylinder};
use crate::contact::search::bounds::Bounds;
use crate::contact::search::nearest::{Piece, SolidBox};
use crate::contact::search::straight_sides::SidePlace;
use crate::engine::convert;

/// A shape in its pose in the floor's frame.
#[derive(Clone, Copy)]
pub(crate) struct Solid<'a> {
    pub shape: &'a SharedShape,
    pub floor_from_shape: Isometry3<f64>,
}

/// A place where a solid is near another, or near the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    /// Point on the other one, in metres.
    pub place_m: Vector3<f64>,
    /// Unit vector out of the other one.
    pub normal: Vector3<f64>,
    /// Distance in metres, negative in penetration.
    pub gap_m: f64,
    /// Whether it is a fixed point of the solid while that rotates.
    pub is_corner: bool,
}

impl Solid<'_> {
    /// A box around it.
    pub fn bounds(&self) -> Bounds {
        let around = self
            .shape
            .compute_aabb(&convert::pose(&self.floor_from_shape));
        Bounds {
            least_m: convert::to_vector(around.mins),
            most_m: convert::to_vector(around.maxs),
        }
    }

    /// The piece that a roller may be near to; `None` for other shapes.
    pub fn piece(&self) -> Option<Piece> {
        let pose = self.floor_from_shape;
        if let Some(cuboid) = self.shape.as_cuboid() {
            return Some(Piece::Box(SolidBox {
                floor_from_box: pose,
                half_sides_m: convert::to_vector(cuboid.half_extents),
            }));
        }
        if let Some(ball) = self.shape.as_ball() {
            return Some(Piece::Ball(SolidBall {
                center_m: pose.translation.vector,
                radius_m: ball.radius,
            }));
        }
        let cylinder = self.shape.as_cylinder()?;
        Some(Piece::Cylinder(SolidCylinder {
            floor_from_cylinder: pose,
            radius_m: cylinder.radius,
            half_length_m: cylinder.half_height,
        }))
    }

    fn ball(&self) -> Option<SolidBall> {
        match self.piece() {
            Some(Piece::Ball(ball)) => Some(ball),
            _ => None,
        }
    }

    /// Its distance from another one, in metres; 0 if they touch, and infinity if parry cannot
    /// compute it.
    pub fn distance_m(&self, other: &Self) -> f64 {
        let from_other = convert::pose(&self.floor_from_shape.inv_mul(&other.floor_from_shape));
        let found =
            parry3d::query::distance(&Pose::IDENTITY, &**self.shape, &from_other, &**other.shape);
        found.map_or(f64::INFINITY, |found| found.distance)
    }

    /// Its distance from another one, in metres, negative inside; in f64 if they are near. For
    /// uneven ground parry knows only what is near: further away the result is a lower bound.
    pub fn gap_m(&self, other: &Self) -> f64 {
        /// Below this distance parry's is not exact, in metres. Chosen.
        const NEAR_M: f64 = 1e-4;
        /// The distance within which uneven ground is searched, in metres. Chosen.
        const LOOKS_M: f64 = 0.02;
        let apart_m = self.distance_m(other);
        if apart_m.is_finite() && apart_m > NEAR_M {
            return apart_m;
        }
        let (within_m, else_m) = if apart_m.is_finite() {
            (2.0 * NEAR_M, apart_m)
        } else {
            (LOOKS_M, LOOKS_M)
        };
        let mut gap_m = f64::INFINITY;
        self.near(other, within_m, |near| gap_m = gap_m.min(near.gap_m));
        if gap_m.is_finite() { gap_m } else { else_m }
    }

    /// The height of its lowest point, in metres.
    pub fn lowest_m(&self) -> f64 {
        let lowest_m = |shape: &dyn Shape, pose: &Pose| shape.compute_aabb(pose).mins.z;
        let pose = convert::pose(&self.floor_from_shape);
        // The box around a compound is not the least one.
        match self.shape.as_compound() {
            Some(compound) => {
                let parts = compound.shapes().iter();
                let lowest = parts.map(|(at, part)| lowest_m(&**part, &(pose * *at)));
                lowest.fold(f64::INFINITY, f64::min)
            }
            None => lowest_m(&**self.shape, &pose),
        }
    }

    /// Passes the places nearer to the floor's plane than this to `show`.
    pub fn near_plane(&self, within_m: f64, mut show: impl FnMut(Near)) {
        let mut offer = |place_m: Vector3<f64>, is_corner: bool| {
            if place_m.z < within_m {
                show(Near {
                    place_m: Vector3::new(place_m.x, place_m.y, 0.0),
                    normal: Vector3::z(),
                    gap_m: place_m.z,
                    is_corner,
                });
            }
        };
        match self.piece() {
            Some(Piece::Box(solid)) => {
                for corner in 0..8 {
                    let sign = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
                    let at = Vector3::new(sign(0), sign(1), sign(2));
                    let at = at.component_mul(&solid.half_sides_m);
                    offer((solid.floor_from_box * Point3::from(at)).coords, true);
                }
            }
            Some(Piece::Ball(ball)) => offer(ball.center_m - Vector3::z() * ball.radius_m, false),
            Some(Piece::Cylinder(cylinder)) => cylinder.offer_lowest(RING, offer),
            _ => {
                let plane = Solid {
                    shape: &SharedShape::halfspace(Vector::Z),
                    floor_from_shape: Isometry3::identity(),
                };
                self.near_by_features(&plane, within_m, show);
            }
        }
    }

    /// Passes the places nearer to another solid than this to `show`.
    pub fn near(&self, other: &Solid<'_>, within_m: f64, mut show: impl FnMut(Near)) {
        let mut offer = |place_m, normal, gap_m| {
            if gap_m < within_m {
                show(Near {
                    place_m,
                    normal,
                    gap_m,
                    is_corner: false,
                });
            }
        };
        if let (Some(ball), Some(piece)) = (self.ball(), other.piece()) {
            let foot = piece.foot(&ball.center_m);
            offer(foot.place_m, foot.normal, foot.distance_m - ball.radius_m);
        } else if let (Some(piece), Some(ball)) = (self.piece(), other.ball()) {
            let foot = piece.foot(&ball.center_m);
            let place_m = ball.center_m - ball.radius_m * foot.normal;
            offer(place_m, -foot.normal, foot.distance_m - ball.radius_m);
        } else if let (Some(Piece::Cylinder(own)), Some(piece)) = (self.piece(), other.piece()) {
            let found = match piece {
                Piece::Box(solid) => own.near_box(&solid),
                Piece::Cylinder(cylinder) => (own.near_cylinder(&cylinder), false),
                _ => (Vec::new(), true),
            };
            self.show_sides(other, (within_m, own.radius_m), (found, false), show);
        } else if let (Some(Piece::Box(solid)), Some(Piece::Cylinder(cylinder))) =
            (self.piece(), other.piece())
        {
            let found = cylinder.near_box(&solid);
            self.show_sides(other, (within_m, cylinder.radius_m), (found, true), show);
        } else {
            self.near_by_features(other, within_m, show);
        }
    }

    /// Passes the places where a cylinder's side is near to `show`; the cylinder is the other solid
    /// if so stated. Without any, or if the rim of an end is nearer, parry's results.
    fn show_sides(
        &self,
        other: &Solid<'_>,
        (within_m, radius_m): (f64, f64),
        ((found, may_miss), is_others): ((Vec<SidePlace>, bool), bool),
        mut show: impl FnMut(Near),
    ) {
        /// Possible error of parry, relative to the radius. Chosen.
        const ROUNDED: f64 = 0.01;
        if found.is_empty() {
            return self.near_by_features(other, within_m, show);
        }
        if may_miss {
            let gaps_m = found.iter().map(|place| place.gap_m);
            let least_m = gaps_m.fold(f64::INFINITY, f64::min);
            let mut by_parry = Vec::new();
            self.near_by_features(other, within_m, |near| by_parry.push(near));
            if by_parry
                .iter()
                .any(|near| near.gap_m < least_m - ROUNDED * radius_m)
            {
                return by_parry.into_iter().for_each(show);
            }
        }
        for place in found.iter().filter(|place| place.gap_m < within_m) {
            let (place_m, normal) = if is_others {
                (place.on_cylinder_m, -place.normal)
            } else {
                (place.on_other_m, place.normal)
            };
            show(Near {
                place_m,
                normal,
                gap_m: place.gap_m,
                is_corner: place.is_corner,
            });
        }
    }

    fn near_by_features(&self, other: &Solid<'_>, within_m: f64, mut show: impl FnMut(Near)) {
        let from_other = self.floor_from_shape.inv_mul(&other.floor_from_shape);
        let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
        // If parry does not support a pair of shapes it says so at any pose: then they do not
        // touch.
        let _ = DefaultQueryDispatcher.contact_manifolds(
            &convert::pose(&from_other),
            &**self.shape,
            &**other.shape,
            within_m,
            &mut manifolds,
            &mut None,
        );
        let own_turn = self.floor_from_shape.rotation;
        for manifold in &manifolds {
            let poses = manifold.subshape_poses.as_deref();
            let piece = |pose: Option<Pose>| pose.unwrap_or(Pose::IDENTITY);
            let own_piece = piece(poses.and_then(|poses| poses.pos1));
            let other_piece = piece(poses.and_then(|poses| poses.pos2));
            // parry's normals point out of either shape.
            let out = convert::to_vector(own_piece.rotation * manifold.local_n1);
            let normal = -(own_turn * out).normalize();
            let is_corner = !is_round(&**self.shape) && !is_round(&**other.shape);
            for point in &manifold.points {
                let on_other = convert::to_vector(other_piece * point.local_p2);
                let place_m = (other.floor_from_shape * Point3::from(on_other)).coords;
                let gap_m = point.dist;
                if gap_m < within_m {
                    show(Near {
                        place_m,
                        normal,
                        gap_m,
                        is_corner,
                    });
                }
            }
        }
    }
}

/// Number of points on the rim of an end on the ground: it tips over a side of that polygon, 4 %
/// nearer to the middle than the rim. Chosen.
const RING: usize = 12;

impl SolidCylinder {
    /// Passes its lowest point at each end to `offer` and, for an end nearly parallel to the plane,
    /// a ring of fixed ones.
    pub(super) fn offer_lowest(&self, ring: usize, mut offer: impl FnMut(Vector3<f64>, bool)) {
        /// A cylinder more upright than this, as the cosine of its tilt, stands on an end. Chosen.
        const STANDS: f64 = 0.9;
        let pose = &self.floor_from_cylinder;
        let axis = pose.rotation * Vector3::y();
        let down = -Vector3::z() + axis.z * axis;
        let end_m = |sign: f64| pose.translation.vector + sign * self.half_length_m * axis;
        // Without tilt there is no lowest point on its rim.
        if let Some(down) = down.try_normalize(1e-9) {
            for sign in [-1.0, 1.0] {
                offer(end_m(sign) + self.radius_m * down, false);
            }
        }
        if axis.z.abs() < STANDS {
            return;
        }
        let lower_m = end_m(-1.0_f64.copysign(axis.z));
        for index in 0..ring {
            let angle = std::f64::consts::TAU * index as f64 / ring as f64;
            let (sin, cos) = libm::sincos(angle);
            let out = pose.rotation * Vector3::new(cos, 0.0, sin);
            offer(lower_m + self.radius_m * out, true);
        }
    }
}

fn is_round(shape: &dyn Shape) -> bool {
    shape.as_ball().is_some() || shape.as_cylinder().is_some()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use nalgebra::{Translation3, UnitQuaternion};

    use super::*;

    fn only(one: &Solid<'_>, other: &Solid<'_>) -> Near {
        let mut found = Vec::new();
        one.near(other, 0.1, |near| found.push(near));
        assert_eq!(found.len(), 1, "{found:?}");
        found[0]
    }

    /// A box of 0.25 m and a sphere of radius 62.5 mm beside its face, 12.5 mm away and 31.25 mm
    /// off its middle: from either side the same two points are nearest, anywhere in the world.
    #[test]
    fn a_sphere_beside_a_box_is_seen_from_both_alike() {
        let (cube, ball) = (
            SharedShape::cuboid(0.125, 0.125, 0.125),
            SharedShape::ball(0.0625),
        );
        let turned = UnitQuaternion::from_euler_angles(0.3, -0.7, 1.9);
        for floor_from_pair in [
            Isometry3::identity(),
            Isometry3::from_parts(Translation3::new(2.0, -3.0, 0.4), turned),
        ] {
            let cube = Solid {
                shape: &cube,
                floor_from_shape: floor_from_pair,
            };
            let ball = Solid {
                shape: &ball,
                floor_from_shape: floor_from_pair * Translation3::new(0.2, 0.03125, 0.0),
            };
            let at_m = |x_m: f64| (floor_from_pair * Point3::new(x_m, 0.03125, 0.0)).coords;
            let out = floor_from_pair.rotation * Vector3::x();
            let (from_ball, from_cube) = (only(&ball, &cube), only(&cube, &ball));
            for (seen, place_m, normal) in [
                (from_ball, at_m(0.125), out),
                (from_cube, at_m(0.1375), -out),
            ] {
                // Sums of a few metres in f64.
                assert!((seen.gap_m - 0.0125).abs() < 1e-14, "{seen:?}");
                assert!((seen.place_m - place_m).norm() < 1e-14, "{seen:?}");
                assert!((seen.normal - normal).norm() < 1e-13, "{seen:?}");
            }
        }
    }

    /// A cube of half side h that stands on a corner reaches sqrt(3) h beneath its middle, on each
    /// of its eight corners.
    #[test]
    fn a_box_stands_on_any_of_its_corners() {
        let (half_m, middle_m) = (0.125, 0.5);
        let cube = SharedShape::cuboid(half_m, half_m, half_m);
        for corner in 0..8 {
            let sign = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let to_corner = Vector3::new(sign(0), sign(1), sign(2));
            let down = -Vector3::z();
            let turn = UnitQuaternion::rotation_between(&to_corner, &down).expect("not opposite");
            let cube = Solid {
                shape: &cube,
                floor_from_shape: Isometry3::from_parts(
                    Translation3::new(3.0, -2.0, middle_m),
                    turn,
                ),
            };
            let lowest_m = middle_m - half_m * f64::sqrt(3.0);
            let mut found = Vec::new();
            cube.near_plane(lowest_m + 1e-3, |near| found.push(near));
            assert_eq!(found.len(), 1, "corner {corner}");
            // Sums of a few metres.
            assert!((found[0].gap_m - lowest_m).abs() < 1e-15, "corner {corner}");
            let beneath_m = Vector3::new(3.0, -2.0, 0.0);
            assert!(
                (found[0].place_m - beneath_m).norm() < 1e-14,
                "corner {corner}"
            );
        }
    }

    /// A can of radius r and length 2 h, tilted from upright, its middle at c: its lowest point is
    /// h |cos| + r sin beneath that. If it nearly stands, a ring of its lower end is found as well,
    /// within r sin of the end's middle, h |cos| beneath c.
    #[test]
    fn a_can_that_leans_is_lowest_at_its_lower_rim_and_stands_on_its_lower_end() {
        let (radius_m, half_m, middle_m) = (0.03125, 0.125, 0.5);
        let can = SharedShape::cylinder(half_m, radius_m);
        for lean_rad in [0.0, 0.1, 0.4, 0.8, FRAC_PI_2, 2.2, PI - 0.1, PI] {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2 - lean_rad);
            let can = Solid {
                shape: &can,
                floor_from_shape: Isometry3::from_parts(
                    Translation3::new(3.0, -2.0, middle_m),
                    turn,
                ),
            };
            let (mut lowest_m, mut ring) = (f64::INFINITY, Vec::new());
            can.near_plane(1.0, |near| {
                lowest_m = lowest_m.min(near.gap_m);
                if near.is_corner {
                    ring.push(near.gap_m);
                }
            });
            let end_m = middle_m - half_m * lean_rad.cos().abs();
            let rim_m = radius_m * lean_rad.sin();
            // Sums of half a metre.
            assert!((lowest_m - (end_m - rim_m)).abs() < 1e-15, "{lean_rad}");
            assert_eq!(ring.is_empty(), lean_rad.cos().abs() < 0.9, "{lean_rad}");
            let off = ring
                .iter()
                .find(|gap_m| (*gap_m - end_m).abs() > rim_m + 1e-15);
            assert_eq!(off, None, "{lean_rad}");
        }
    }

    /// Numbers from -1 to 1, by a multiplicative generator (Lehmer 1951).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0 * 48_271 % 0x7fff_ffff;
            2.0 * self.0 as f64 / f64::from(0x7fff_ffff) - 1.0
        }

        fn vector(&mut self) -> Vector3<f64> {
            Vector3::new(self.next(), self.next(), self.next())
        }
    }

    /// Cylinders next to a box and to each other, tilted by a microradian up to half a turn: the
    /// distance of the nearest point found equals that by another method, alternating projections
    /// (von Neumann 1933). If the rim of an end is nearest, no found point is nearer.
    #[test]
    fn the_side_of_a_cylinder_is_as_near_as_the_solids_are() {
        let mut numbers = Numbers(7);
        let others = [
            SharedShape::cuboid(0.3, 0.2, 0.1),
            SharedShape::cylinder(0.15, 0.06),
        ];
        let can = SharedShape::cylinder(0.15, 0.05);
        let mut compared = 0;
        for draw in 0..100_000 {
            let lean_rad = PI * 10_f64.powf(-6.0 * numbers.next().abs());
            let mut quarters = || (4.0 * numbers.next()).round() * FRAC_PI_2;
            let square = UnitQuaternion::from_euler_angles(quarters(), quarters(), quarters());
            let turned = UnitQuaternion::from_scaled_axis(lean_rad * numbers.vector()) * square;
            let at_m = Translation3::from(0.5 * numbers.vector());
            let other = Solid {
                shape: &others[draw % 2],
                floor_from_shape: Isometry3::identity(),
            };
            let own = Solid {
                shape: &can,
                floor_from_shape: Isometry3::from_parts(at_m, turned),
            };
            if !(1e-3..0.03).contains(&own.distance_m(&other)) {
                continue;
            }
            let (Some(Piece::Cylinder(cylinder)), Some(piece)) = (own.piece(), other.piece())
            else {
                panic!("shapes that are known");
            };
            let found = match &piece {
                Piece::Box(solid) => cylinder.near_box(solid).0,
                Piece::Cylinder(other) => cylinder.near_cylinder(other),
                _ => panic!("no such shape"),
            };
            let gaps_m = found.iter().map(|place| place.gap_m);
            let least_m = gaps_m.fold(f64::INFINITY, f64::min);
            let Some((nearest_m, apart_m)) = by_projections(&own, &other) else {
                continue;
            };
            if found.is_empty() {
                continue;
            }
            let in_own = own
                .floor_from_shape
                .inverse_transform_point(&Point3::from(nearest_m));
            let is_on_rim = in_own.y.abs() > 0.15 - 1e-6;
            // The common length of two sides tilted by 0.1 ends where the connection is not exactly
            // perpendicular to both: by 0.1^4 of some centimetres.
            const ROUNDED_M: f64 = 1e-6;
            assert!(least_m > apart_m - ROUNDED_M, "{draw}: {least_m} {apart_m}");
            assert!(
                is_on_rim || least_m < apart_m + ROUNDED_M,
                "{draw}: {least_m} {apart_m}"
            );
            // From the other one the distance is the same.
            let mut seen_m = f64::INFINITY;
            other.near(&own, 0.1, |near| seen_m = seen_m.min(near.gap_m));
            assert!(
                (seen_m - least_m).abs() < 1e-14,
                "{draw}: {seen_m} {least_m}"
            );
            compared += 1;
        }
        assert!(compared > 1000, "{compared}");
    }

    /// The point of the first that is nearest to the second, and their distance, in metres; `None`
    /// if they are so nearly parallel that projections do not converge.
    fn by_projections(own: &Solid<'_>, other: &Solid<'_>) -> Option<(Vector3<f64>, f64)> {
        let (own, other) = (own.piece()?, other.piece()?);
        let mut place_m = own.foot(&Vector3::new(3.0, 2.0, 1.0)).place_m;
        for _ in 0..5_000 {
            let foot = own.foot(&other.foot(&place_m).place_m);
            let moved_m = (foot.place_m - place_m).norm();
            place_m = foot.place_m;
            if moved_m < 1e-13 {
                return Some((place_m, foot.distance_m));
            }
        }
        None
    }
}
