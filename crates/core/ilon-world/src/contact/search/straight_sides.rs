//! Finds places where the straight side of a cylinder is near a box or another cylinder, and where
//! one of its ends stands on a face of a box, in f64.
//!
//! parry finds such points by an iteration that leaves micrometres of a gap, which a stiff contact
//! turns into thousands of newtons. Here a side and a face, or two sides, that are nearly parallel
//! are near each other at both ends of their common length, each with its own gap; if they cross,
//! at one point. Places at the rim of an end are left to parry.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use crate::contact::search::ball_and_cylinder::SolidCylinder;
use crate::contact::search::nearest::SolidBox;

/// Straight lines whose directions differ by less than this, as a sine, are near each other along
/// their common length. Chosen.
const PARALLEL: f64 = 0.1;

/// Lines that cross by less than this, as a sine, have the same distance along their common length
/// as at the crossing, to a ten-millionth of it. Chosen.
const CROSSES: f64 = 1e-3;

/// Two points nearer than this carry a load as one, in metres. Chosen.
const ONE_PLACE_M: f64 = 1e-6;

/// Number of points on the rim of an end on a face: it tips over a side of that hexagon, 13 %
/// nearer to the middle than the rim. Chosen.
const RING: usize = 6;

/// A place where a cylinder is near another solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct SidePlace {
    pub on_cylinder_m: Vector3<f64>,
    pub on_other_m: Vector3<f64>,
    /// Unit vector out of the other one.
    pub normal: Vector3<f64>,
    pub gap_m: f64,
    /// Whether it is a fixed point of the cylinder while that rotates.
    pub is_corner: bool,
}

/// A straight line of a length, with a radius: a cylinder without ends.
#[derive(Clone, Copy)]
struct Rod {
    center_m: Vector3<f64>,
    along: Vector3<f64>,
    half_length_m: f64,
    radius_m: f64,
}

impl Rod {
    fn at(&self, t_m: f64) -> Vector3<f64> {
        self.center_m + t_m * self.along
    }

    /// The point of its surface beside a point of its axis that reaches furthest in a direction
    /// across it.
    fn side(&self, t_m: f64, towards: &Vector3<f64>) -> Option<Vector3<f64>> {
        let across = towards - self.along * self.along.dot(towards);
        let across = across.try_normalize(1e-6)?;
        Some(self.at(t_m) + self.radius_m * across)
    }

    /// The near place of its side and another's beside a point of each axis.
    fn place(&self, other: &Self, (own_m, other_m): (f64, f64)) -> Option<SidePlace> {
        let normal = (self.at(own_m) - other.at(other_m)).try_normalize(1e-9)?;
        let on_cylinder_m = self.side(own_m, &-normal)?;
        let on_other_m = other.side(other_m, &normal)?;
        Some(SidePlace {
            on_cylinder_m,
            on_other_m,
            normal,
            gap_m: normal.dot(&(on_cylinder_m - on_other_m)),
            is_corner: false,
        })
    }

    /// The cosine between it and another one, the projection of the other's middle on it, and that
    /// of its own middle on the other.
    fn beside(&self, other: &Self) -> (f64, f64, f64) {
        let off_m = other.center_m - self.center_m;
        let (own, others) = (self.along.dot(&off_m), -other.along.dot(&off_m));
        (self.along.dot(&other.along), own, others)
    }

    /// The points of both where they cross, regardless of their lengths; `None` if they are
    /// parallel.
    fn crossing(&self, other: &Self) -> Option<(f64, f64)> {
        let (cos, own_m, other_m) = self.beside(other);
        let sin2 = 1.0 - cos * cos;
        let at_m = (own_m + cos * other_m) / sin2;
        (sin2 > CROSSES * CROSSES).then_some((at_m, other_m + cos * at_m))
    }

    /// Places where it is near another one's side, in their common frame. Empty if only an end is
    /// near, such as that of a cylinder that stands on the other one with a micrometre of
    /// deflection: then the penetration across their sides exceeds that along them.
    fn near(&self, other: &Self) -> Vec<SidePlace> {
        let (cos, own_m, other_m) = self.beside(other);
        let is_on_both = |(own_m, other_m): &(f64, f64)| {
            own_m.abs() <= self.half_length_m && other_m.abs() <= other.half_length_m
        };
        let mut found = Vec::new();
        if let Some(at) = self.crossing(other).filter(is_on_both)
            && let Some(place) = self.place(other, at)
        {
            let to_end_m = (self.half_length_m - at.0.abs()).min(other.half_length_m - at.1.abs());
            if place.gap_m >= -to_end_m {
                found.push(place);
            }
        }
        if 1.0 - cos * cos >= PARALLEL * PARALLEL {
            return found;
        }
        // The common length ends where either ends.
        let own_ends = [-self.half_length_m, self.half_length_m];
        let other_ends = [-other.half_length_m, other.half_length_m];
        let of_own = own_ends.map(|at_m| (at_m, other_m + cos * at_m));
        let of_other = other_ends.map(|at_m| (own_m + cos * at_m, at_m));
        let mut places: Vec<(f64, f64)> = of_own.into_iter().chain(of_other).collect();
        places.retain(is_on_both);
        places.sort_by(|one, other| one.0.total_cmp(&other.0));
        places.dedup_by(|one, other| (one.0 - other.0).abs() < ONE_PLACE_M);
        let [first, .., last] = places[..] else {
            return found;
        };
        let ends: Vec<SidePlace> = [first, last]
            .into_iter()
            .filter_map(|at| self.place(other, at))
            .collect();
        if ends.iter().all(|place| place.gap_m >= first.0 - last.0) {
            found.extend(ends);
        }
        found
    }
}

/// The part of a range of t in which |from + by t| is at most `most`.
fn clip(from: f64, by: f64, most: f64, (low, high): (f64, f64)) -> (f64, f64) {
    if by == 0.0 {
        return if from.abs() <= most {
            (low, high)
        } else {
            (0.0, -1.0)
        };
    }
    let (one, other) = ((-most - from) / by, (most - from) / by);
    (low.max(one.min(other)), high.min(one.max(other)))
}

/// Both ends of a range, one for zero length, and none if it is empty.
fn ends((low, high): (f64, f64)) -> impl Iterator<Item = f64> {
    let second = (high - low > ONE_PLACE_M).then_some(high);
    (low <= high).then_some(low).into_iter().chain(second)
}

impl SolidCylinder {
    fn rod(&self, frame_from_floor: &Isometry3<f64>) -> Rod {
        let pose = frame_from_floor * self.floor_from_cylinder;
        Rod {
            center_m: pose.translation.vector,
            along: pose.rotation * Vector3::y(),
            half_length_m: self.half_length_m,
            radius_m: self.radius_m,
        }
    }

    /// Places where its side is near another cylinder's side; empty if only an end of one of them
    /// is.
    pub(super) fn near_cylinder(&self, other: &Self) -> Vec<SidePlace> {
        let frame = Isometry3::identity();
        self.rod(&frame).near(&other.rod(&frame))
    }

    /// Places where its side or one of its ends is near a box, and whether the rim of an end may be
    /// nearer; empty if that is left to parry.
    pub(super) fn near_box(&self, solid: &SolidBox) -> (Vec<SidePlace>, bool) {
        let rod = self.rod(&solid.floor_from_box.inverse());
        let half_sides_m = &solid.half_sides_m;
        let (mut found, is_cut) = match Facing::of(&rod, half_sides_m) {
            Some(facing) if rod.along[facing.axis].abs() < PARALLEL => {
                facing.side(&rod, half_sides_m)
            }
            Some(facing) => (facing.end(self, solid), false),
            None => return (Vec::new(), true),
        };
        let is_beside = found.is_empty();
        if is_beside {
            found = near_edges(&rod, half_sides_m);
        }
        for place in &mut found {
            let to_floor =
                |place_m: Vector3<f64>| (solid.floor_from_box * Point3::from(place_m)).coords;
            place.on_cylinder_m = to_floor(place.on_cylinder_m);
            place.on_other_m = to_floor(place.on_other_m);
            place.normal = solid.floor_from_box.rotation * place.normal;
        }
        (found, is_cut || is_beside)
    }
}

/// The face of a box that a cylinder faces most.
struct Facing {
    axis: usize,
    /// Which of the two faces across that axis.
    sign: f64,
}

impl Facing {
    /// `None` if the box faces an end of the cylinder more than the cylinder faces a face.
    fn of(rod: &Rod, half_sides_m: &Vector3<f64>) -> Option<Self> {
        let apart_m = |axis: usize| {
            let across = (1.0 - rod.along[axis].powi(2)).max(0.0).sqrt();
            let reach_m = rod.half_length_m * rod.along[axis].abs() + rod.radius_m * across;
            rod.center_m[axis].abs() - reach_m - half_sides_m[axis]
        };
        let axis = (0..3).max_by(|a, b| apart_m(*a).total_cmp(&apart_m(*b)))?;
        let before_end_m = rod.center_m.dot(&rod.along).abs()
            - rod.half_length_m
            - half_sides_m.dot(&rod.along.abs());
        // An end on a face is as far from it as the face is from the end, except for their tilt.
        let is_end = rod.along[axis].abs() >= PARALLEL;
        (is_end || before_end_m < apart_m(axis)).then(|| Self {
            axis,
            sign: 1.0_f64.copysign(rod.center_m[axis]),
        })
    }

    fn normal(&self) -> Vector3<f64> {
        Vector3::ith(self.axis, self.sign)
    }

    fn place(&self, on_cylinder_m: Vector3<f64>, half_m: f64, is_corner: bool) -> SidePlace {
        let mut on_other_m = on_cylinder_m;
        on_other_m[self.axis] = self.sign * half_m;
        SidePlace {
            on_cylinder_m,
            on_other_m,
            normal: self.normal(),
            gap_m: self.sign * on_cylinder_m[self.axis] - half_m,
            is_corner,
        }
    }

    /// Places where the nearest line of the side is over the face, and whether an edge cuts it off:
    /// beyond the edge it may be nearer, to edges and corners.
    fn side(&self, rod: &Rod, half_sides_m: &Vector3<f64>) -> (Vec<SidePlace>, bool) {
        let Some(middle_m) = rod.side(0.0, &-self.normal()) else {
            return (Vec::new(), true);
        };
        let whole = (-rod.half_length_m, rod.half_length_m);
        let mut common = whole;
        for axis in (0..3).filter(|axis| *axis != self.axis) {
            common = clip(middle_m[axis], rod.along[axis], half_sides_m[axis], common);
        }
        let at = |t_m: f64| self.place(middle_m + t_m * rod.along, half_sides_m[self.axis], false);
        let mut found: Vec<SidePlace> = ends(common).map(at).collect();
        /// The end of the face and its edge count as one place within this share of the radius: two
        /// so near would alternate in carrying the load. Chosen.
        const TOLD: f64 = 0.1;
        let is_cut = common != whole;
        if is_cut {
            let mut beyond = near_edges(rod, half_sides_m);
            let told = |one: &SidePlace, other: &SidePlace| {
                (one.on_other_m - other.on_other_m).norm() < TOLD * rod.radius_m
            };
            let nearer = |one: &SidePlace, other: &SidePlace| one.gap_m < other.gap_m;
            beyond.retain(|edge| !found.iter().any(|at| told(at, edge) && !nearer(edge, at)));
            found.retain(|at| !beyond.iter().any(|edge| told(at, edge)));
            found.extend(beyond);
            // In a fixed order, whichever of them are edges: a step's impulses start from those of
            // the last.
            let along_m = |place: &SidePlace| rod.along.dot(&place.on_cylinder_m);
            found.sort_by(|one, other| along_m(one).total_cmp(&along_m(other)));
        }
        (found, is_cut)
    }

    /// Places where an end stands on the face; empty if it reaches over an edge.
    fn end(&self, cylinder: &SolidCylinder, solid: &SolidBox) -> Vec<SidePlace> {
        let half_sides_m = &solid.half_sides_m;
        // The face as a plane z = 0.
        let up = UnitQuaternion::rotation_between(&self.normal(), &Vector3::z());
        let up = up.unwrap_or_else(|| {
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
        });
        let half_m = half_sides_m[self.axis];
        let standing = SolidCylinder {
            floor_from_cylinder: Isometry3::translation(0.0, 0.0, -half_m)
                * up
                * solid.floor_from_box.inverse()
                * cylinder.floor_from_cylinder,
            ..*cylinder
        };
        let mut found = Vec::new();
        let mut reaches_over = false;
        standing.offer_lowest(RING, |place_m, is_corner| {
            let in_box_m = up.inverse() * (place_m + Vector3::z() * half_m);
            let is_over =
                |axis: usize| axis == self.axis || in_box_m[axis].abs() <= half_sides_m[axis];
            reaches_over |= !(0..3).all(is_over);
            found.push(self.place(in_box_m, half_m, is_corner));
        });
        if reaches_over {
            found.clear();
        }
        found
    }
}

/// Places where a side is near edges and corners of a box: away from all of its faces.
fn near_edges(rod: &Rod, half_sides_m: &Vector3<f64>) -> Vec<SidePlace> {
    let mut found = Vec::new();
    for corner in 0..8 {
        let sign = Vector3::from_fn(|axis, _| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 });
        let corner_m = sign.component_mul(half_sides_m);
        // Along a face a normal has rounding of either sign.
        let is_away = |place: &SidePlace, axis: usize| place.normal[axis] * sign[axis] > 1e-9;
        let point = Rod {
            center_m: corner_m,
            along: Vector3::zeros(),
            half_length_m: 0.0,
            radius_m: 0.0,
        };
        let beside_m = rod.along.dot(&(corner_m - rod.center_m));
        let to_end_m = rod.half_length_m - beside_m.abs();
        let place = rod.place(&point, (beside_m, 0.0));
        found.extend(place.filter(|place| {
            to_end_m >= (-place.gap_m).max(0.0) && (0..3).all(|axis| is_away(place, axis))
        }));
        // Each edge from one of its two corners.
        for axis in (0..3).filter(|axis| sign[*axis] > 0.0) {
            let mut center_m = corner_m;
            center_m[axis] = 0.0;
            let edge = Rod {
                center_m,
                along: Vector3::ith(axis, 1.0),
                half_length_m: half_sides_m[axis],
                radius_m: 0.0,
            };
            let mut places = rod.near(&edge);
            places.retain(|place| (0..3).all(|of| of == axis || is_away(place, of)));
            found.extend(places);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::{Translation3, UnitQuaternion};

    use super::*;

    const SOLID: Vector3<f64> = Vector3::new(0.3, 0.2, 0.1);

    /// Frames of a pair: one without rounding, and a general one.
    fn frames() -> [Isometry3<f64>; 2] {
        let turned = UnitQuaternion::from_euler_angles(0.3, -0.7, 1.9);
        [
            Isometry3::identity(),
            Isometry3::from_parts(Translation3::new(2.0, -3.0, 0.4), turned),
        ]
    }

    /// A cylinder of radius 50 mm and length 0.3 m, upright before its rotation, beside a box of
    /// 0.6 x 0.4 x 0.2 m, in a frame.
    fn pair(
        frame: &Isometry3<f64>,
        place_m: [f64; 3],
        turned: UnitQuaternion<f64>,
    ) -> (SolidCylinder, SolidBox) {
        let upright = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
        let cylinder = SolidCylinder {
            floor_from_cylinder: frame
                * Isometry3::from_parts(Vector3::from(place_m).into(), turned * upright),
            radius_m: 0.05,
            half_length_m: 0.15,
        };
        let solid = SolidBox {
            floor_from_box: *frame,
            half_sides_m: SOLID,
        };
        (cylinder, solid)
    }

    /// The results in the box's own frame, ordered by height.
    fn found(
        frame: &Isometry3<f64>,
        place_m: [f64; 3],
        turned: UnitQuaternion<f64>,
    ) -> Vec<SidePlace> {
        let (cylinder, solid) = pair(frame, place_m, turned);
        let (mut found, _) = cylinder.near_box(&solid);
        for place in &mut found {
            let back = |m: Vector3<f64>| frame.inverse_transform_point(&Point3::from(m)).coords;
            place.on_cylinder_m = back(place.on_cylinder_m);
            place.on_other_m = back(place.on_other_m);
            place.normal = frame.rotation.inverse() * place.normal;
        }
        found.sort_by(|a, b| a.on_other_m.z.total_cmp(&b.on_other_m.z));
        found
    }

    /// Sums of a few metres in f64.
    const ROUNDED_M: f64 = 2e-15;

    /// 10 mm from the face at x = 0.3 m, from 0.05 m above its middle on: the common length reaches
    /// from the cylinder's lower end at z = -0.05 to the box's upper edge at 0.1.
    #[test]
    fn an_upright_side_is_near_a_face_where_their_heights_meet() {
        for frame in frames() {
            let [low, high] = found(&frame, [0.36, 0.07, 0.1], UnitQuaternion::identity())[..]
            else {
                panic!("two ends");
            };
            for (place, z_m) in [(low, -0.05), (high, 0.1)] {
                assert!((place.on_other_m - Vector3::new(0.3, 0.07, z_m)).norm() < ROUNDED_M);
                assert!((place.on_cylinder_m - Vector3::new(0.31, 0.07, z_m)).norm() < ROUNDED_M);
                assert!((place.normal - Vector3::x()).norm() < ROUNDED_M);
                assert!((place.gap_m - 0.01).abs() < ROUNDED_M, "{}", place.gap_m);
            }
        }
    }

    /// Tilted towards the face: its lowest rim comes nearer by the lever times the sine, and moves
    /// away by the radius times one minus the cosine. A billionth of a radian is resolved.
    #[test]
    fn a_side_that_leans_is_nearer_with_one_end() {
        for frame in frames() {
            for lean_rad in [0.0, 1e-9, 1e-4, 0.05] {
                let turned = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -lean_rad);
                let found = found(&frame, [0.36, 0.0, 0.0], turned);
                let [low, high] = found[..] else {
                    panic!("{found:?}");
                };
                // Clipped by the box's edges at 0.1 m above and below its middle.
                let side_m = 0.06 - 0.05 / lean_rad.cos();
                for (place, z_m) in [(low, -0.1), (high, 0.1)] {
                    // Beyond the edge it is nearer still, and near the edge across its side.
                    let is_near_edge = z_m > 0.0;
                    let across = if is_near_edge { lean_rad.cos() } else { 1.0 };
                    let gap_m = (side_m - z_m * lean_rad.tan()) * across;
                    assert!(
                        (place.gap_m - gap_m).abs() < 1e-14,
                        "{lean_rad}: {} {gap_m}",
                        place.gap_m
                    );
                }
            }
        }
    }

    /// Beside the upright edge at (0.3, 0.2) m, with offsets of 0.08 and 0.06 m: 0.1 m minus the
    /// radius, along the diagonal of a 3-4-5 triangle.
    #[test]
    fn an_upright_side_is_near_an_edge_beside_it() {
        for frame in frames() {
            let found = found(&frame, [0.38, 0.26, 0.0], UnitQuaternion::identity());
            let [low, high] = found[..] else {
                panic!("{found:?}");
            };
            for (place, z_m) in [(low, -0.1), (high, 0.1)] {
                assert!((place.on_other_m - Vector3::new(0.3, 0.2, z_m)).norm() < ROUNDED_M);
                assert!((place.normal - Vector3::new(0.8, 0.6, 0.0)).norm() < 2e-14);
                assert!((place.gap_m - 0.05).abs() < ROUNDED_M);
            }
        }
    }

    /// Across the upper edge along x, tilted by 45 degrees over it: near it at one point, in the
    /// middle of its length.
    #[test]
    fn a_side_that_crosses_an_edge_is_near_it_at_one_place() {
        for frame in frames() {
            let turned =
                UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_4);
            let far_m = 0.06 * std::f64::consts::FRAC_1_SQRT_2;
            let found = found(&frame, [0.1, 0.2 + far_m, 0.1 + far_m], turned);
            let [place] = found[..] else {
                panic!("{found:?}");
            };
            assert!((place.on_other_m - Vector3::new(0.1, 0.2, 0.1)).norm() < 1e-14);
            assert!((place.gap_m - 0.01).abs() < 1e-14);
        }
    }

    /// On top of the box it stands on points of its rim all around, at the same height; if its end
    /// reaches over an edge, or only an end is beside the box, it is left to parry.
    #[test]
    fn an_end_stands_on_a_face_with_its_ring() {
        for frame in frames() {
            let on_top = found(
                &frame,
                [0.1, 0.05, 0.1 + 0.15 + 0.001],
                UnitQuaternion::identity(),
            );
            let of_ring = on_top.iter().filter(|place| place.is_corner);
            assert_eq!(of_ring.count(), RING);
            for place in &on_top {
                assert!((place.gap_m - 0.001).abs() < ROUNDED_M);
                let out_m = (place.on_cylinder_m.xy() - nalgebra::Vector2::new(0.1, 0.05)).norm();
                assert!((out_m - 0.05).abs() < ROUNDED_M);
                assert!((place.normal - Vector3::z()).norm() < ROUNDED_M);
            }
            assert!(found(&frame, [0.28, 0.0, 0.251], UnitQuaternion::identity()).is_empty());
        }
    }

    /// A body that stands on another deflects by a micrometre: neither a can on a box, also over an
    /// edge or a corner, nor one on another is reported as deep across its side.
    #[test]
    fn what_stands_on_another_is_not_deep_in_it() {
        for frame in frames() {
            for x_m in [0.24, 0.27, 0.299, 0.3, 0.301, 0.33] {
                for y_m in [0.0, 0.17, 0.199, 0.2, 0.201, 0.22] {
                    for lean_rad in [0.0, 1e-9, 1e-6] {
                        let turned = UnitQuaternion::from_scaled_axis(
                            Vector3::new(0.6, 0.8, 0.3) * lean_rad,
                        );
                        for place in found(&frame, [x_m, y_m, 0.1 + 0.15 - 1e-6], turned) {
                            assert!(place.gap_m > -2e-6, "{x_m} {y_m}: {place:?}");
                        }
                    }
                }
            }
            let upright = UnitQuaternion::identity();
            let (own, _) = pair(&frame, [0.0, 0.0, 0.3 - 1e-6], upright);
            for x_m in [0.0, 1e-6, 0.02, 0.07] {
                let (below, _) = pair(&frame, [x_m, 0.0, 0.0], upright);
                assert!(own.near_cylinder(&below).is_empty(), "{x_m}");
            }
        }
    }

    /// Two upright cylinders, one 30 mm higher: along their common length, the distance of their
    /// axes minus both radii. Crossed at right angles they meet at one point.
    #[test]
    fn two_sides_are_near_along_what_they_have_in_common() {
        let upright = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
        let other_at = |place_m: Vector3<f64>, turned: UnitQuaternion<f64>| SolidCylinder {
            floor_from_cylinder: Isometry3::from_parts(place_m.into(), turned * upright),
            radius_m: 0.03,
            half_length_m: 0.1,
        };
        let (own, _) = pair(&Isometry3::identity(), [0.0; 3], UnitQuaternion::identity());
        let beside = own.near_cylinder(&other_at(
            Vector3::new(0.06, 0.08, 0.08),
            UnitQuaternion::identity(),
        ));
        let heights: Vec<f64> = beside.iter().map(|place| place.on_other_m.z).collect();
        assert!(
            (heights[0].min(heights[1]) + 0.02).abs() < ROUNDED_M,
            "{heights:?}"
        );
        assert!(
            (heights[0].max(heights[1]) - 0.15).abs() < ROUNDED_M,
            "{heights:?}"
        );
        for place in &beside {
            assert!((place.gap_m - 0.02).abs() < ROUNDED_M);
            assert!((place.normal + Vector3::new(0.6, 0.8, 0.0)).norm() < 1e-14);
        }
        let across = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
        let crossed = own.near_cylinder(&other_at(Vector3::new(0.1, 0.02, 0.07), across));
        assert_eq!(crossed.len(), 1);
        assert!((crossed[0].on_other_m - Vector3::new(0.07, 0.0, 0.07)).norm() < ROUNDED_M);
        assert!((crossed[0].gap_m - 0.02).abs() < ROUNDED_M);
    }
}
