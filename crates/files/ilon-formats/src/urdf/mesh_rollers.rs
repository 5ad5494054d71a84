//! Finds rollers in the mesh of a whole wheel: equal pieces, evenly spread around its axis, that
//! reach as far out as the wheel.
//!
//! CAD programs export a wheel as one mesh, in which each roller is a separate piece. Such a mesh
//! shows what the file does not state: the number of rollers, their angle and their thickness.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};
use urdf_rs::Geometry;

use super::body::RigidBody;
use super::mesh::Meshes;
use super::roller_dimensions::skew;
use super::visual_meshes::mesh_triangles;

/// Largest mesh that is analysed: published wheels have up to 80,000 triangles.
const MOST_TRIANGLES: usize = 500_000;
/// Smallest number of pieces accepted as rollers.
const LEAST: usize = 5;
/// Largest relative difference in size of the rollers of a wheel, due to rounding in exporters.
const ALIKE: f64 = 0.02;
/// Largest difference in gamma, in radians.
const SAME_ANGLE_RAD: f64 = 0.02;
/// Largest gamma of a roller: bolts and spokes lie along the hub's axis, in radians.
const MOST_GAMMA_RAD: f64 = 80.0 * PI / 180.0;
/// Positions around the wheel are even within this share of their spacing.
const EVEN: f64 = 0.1;
/// Smallest reach of rollers, as a share of the wheel's radius: nothing else touches the ground.
/// Meshes may be some percent off their joints.
const REACHES: f64 = 0.95;
/// Largest relative difference of the extents across the axis of an undistorted roller, due to
/// unevenly spread vertices.
const MADE_ROUND: f64 = 0.06;
/// Largest relative difference of the rings of a wheel's rollers, for the same reason.
const OFF_AXIS: f64 = 0.05;

/// The rollers of a wheel shown by its mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeshRollers {
    pub(super) count: usize,
    /// The paper's gamma, signed, in the hub's frame.
    pub(super) gamma_rad: f64,
    /// A roller's largest radius, in metres.
    pub(super) roller_radius_m: f64,
    /// The wheel's radius, in metres, at its rollers' middles, on which barrels roll; the ends of
    /// thick drawn rollers reach further. For a stretched mesh, the rollers' reach.
    pub(super) wheel_radius_m: f64,
    /// Whether the rollers are round: those of a stretched mesh are not, and have another angle.
    pub(super) are_round: bool,
}

impl MeshRollers {
    /// Whether two wheels are equal, except for their handedness.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.count == other.count
            && (self.gamma_rad.abs() - other.gamma_rad.abs()).abs() < SAME_ANGLE_RAD
            && are_alike(self.roller_radius_m, other.roller_radius_m)
            && are_alike(self.wheel_radius_m, other.wheel_radius_m)
    }

    /// Whether barrels of that radius can hand over to each other.
    pub(super) fn hands_over(&self) -> bool {
        self.roller_radius_m > self.wheel_radius_m * (1.0 - libm::cos(PI / self.count as f64))
    }
}

/// Returns the rollers shown by a mesh of a wheel, whose hub axis is z of the frame; `None` if no
/// mesh shows any.
pub(super) fn of_wheel(
    body: &RigidBody,
    body_from_hub: &Isometry3<f64>,
    meshes: &Meshes,
) -> Option<MeshRollers> {
    let mut shapes = body.visuals.iter().chain(&body.shapes);
    shapes.find_map(|shape| {
        let Geometry::Mesh { filename, scale } = &shape.geometry else {
            return None;
        };
        let hub_from_shape = body_from_hub.inverse() * shape.body_from_shape;
        of_mesh(filename, *scale, &hub_from_shape, meshes)
    })
}

/// The same for one mesh.
pub(super) fn of_mesh(
    filename: &str,
    scale: Option<urdf_rs::Vec3>,
    hub_from_shape: &Isometry3<f64>,
    meshes: &Meshes,
) -> Option<MeshRollers> {
    let path = meshes.find(filename).ok()?;
    let triangles = mesh_triangles(&path, meshes.files()).ok()?;
    if triangles.len() > MOST_TRIANGLES {
        return None;
    }
    let scale = scale.map_or(Vector3::repeat(1.0), |s| Vector3::from(*s));
    let place = |[x, y, z]: [f32; 3]| {
        let v = Vector3::new(x, y, z).cast::<f64>().component_mul(&scale);
        hub_from_shape * Point3::from(v)
    };
    of_pieces(&pieces(&triangles, place))
}

/// Returns the vertices of a mesh by connected pieces.
fn pieces(
    triangles: &[[[f32; 3]; 3]],
    place: impl Fn([f32; 3]) -> Point3<f64>,
) -> Vec<Vec<Point3<f64>>> {
    // Neighbours have bitwise equal vertices.
    let mut known: HashMap<[u32; 3], usize> = HashMap::new();
    let mut corners: Vec<[f32; 3]> = Vec::new();
    let mut leader: Vec<usize> = Vec::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| {
            // -0 is 0.
            let key = corner.map(|x| (x + 0.0).to_bits());
            *known.entry(key).or_insert_with(|| {
                corners.push(corner);
                leader.push(leader.len());
                leader.len() - 1
            })
        });
        join(&mut leader, a, b);
        join(&mut leader, b, c);
    }
    let mut pieces: HashMap<usize, usize> = HashMap::new();
    let mut found: Vec<Vec<Point3<f64>>> = Vec::new();
    for (i, corner) in corners.into_iter().enumerate() {
        let piece = *pieces.entry(led_by(&mut leader, i)).or_insert_with(|| {
            found.push(Vec::new());
            found.len() - 1
        });
        found[piece].push(place(corner));
    }
    found
}

fn join(leader: &mut [usize], a: usize, b: usize) {
    let (a, b) = (led_by(leader, a), led_by(leader, b));
    leader[a.max(b)] = a.min(b);
}

fn led_by(leader: &mut [usize], mut of: usize) -> usize {
    while leader[of] != of {
        leader[of] = leader[leader[of]];
        of = leader[of];
    }
    of
}

/// A piece interpreted as a roller.
#[derive(Clone, Copy, Debug)]
struct RollerPiece {
    radius_m: f64,
    half_length_m: f64,
    ring_radius_m: f64,
    gamma_rad: f64,
    /// Its angle around the hub, in rad.
    place_rad: f64,
    /// Its largest distance from the hub axis, in metres.
    reach_m: f64,
    /// Relative difference of its extents across its axis.
    out_of_round: f64,
}

impl RollerPiece {
    fn is_like(&self, other: &Self) -> bool {
        are_alike(self.radius_m, other.radius_m)
            && are_alike(self.half_length_m, other.half_length_m)
            && are_within(OFF_AXIS, self.ring_radius_m, other.ring_radius_m)
            && (self.gamma_rad - other.gamma_rad).abs() < SAME_ANGLE_RAD
    }
}

fn are_alike(p: f64, q: f64) -> bool {
    are_within(ALIKE, p, q)
}

fn are_within(share: f64, p: f64, q: f64) -> bool {
    (p - q).abs() <= share * p.max(q)
}

/// Returns the rollers among the pieces of a wheel, in its hub's frame.
fn of_pieces(pieces: &[Vec<Point3<f64>>]) -> Option<MeshRollers> {
    let farthest_m = pieces
        .iter()
        .map(|piece| reach_m(piece))
        .fold(0.0, f64::max);
    let mut kinds: Vec<Vec<RollerPiece>> = Vec::new();
    for form in pieces.iter().filter_map(|piece| form(piece)) {
        if form.reach_m < REACHES * farthest_m {
            continue;
        }
        match kinds.iter_mut().find(|kind| kind[0].is_like(&form)) {
            Some(kind) => kind.push(form),
            None => kinds.push(vec![form]),
        }
    }
    // Pins and caps are as evenly spread as their rollers, and reach less far.
    let farthest =
        |kind: &Vec<RollerPiece>| kind.iter().map(|form| form.reach_m).fold(0.0, f64::max);
    let rings = kinds.into_iter().filter(|kind| kind.len() >= LEAST);
    let rollers = rings.max_by(|p, q| farthest(p).total_cmp(&farthest(q)))?;
    let count = rollers.len();
    let mean = |of: fn(&RollerPiece) -> f64| rollers.iter().map(of).sum::<f64>() / count as f64;
    let are_round = rollers.iter().all(|form| form.out_of_round < MADE_ROUND);
    let roller_radius_m = mean(|form| form.radius_m);
    are_even(&rollers).then(|| MeshRollers {
        count,
        gamma_rad: mean(|form| form.gamma_rad),
        roller_radius_m,
        wheel_radius_m: match are_round {
            true => mean(|form| form.ring_radius_m) + roller_radius_m,
            false => mean(|form| form.reach_m),
        },
        are_round,
    })
}

/// Whether rollers are evenly spread around the wheel.
fn are_even(rollers: &[RollerPiece]) -> bool {
    let mut places_rad: Vec<f64> = rollers.iter().map(|form| form.place_rad).collect();
    places_rad.sort_by(f64::total_cmp);
    let apart_rad = TAU / places_rad.len() as f64;
    let first = places_rad[0] + TAU;
    let next = places_rad.iter().skip(1).chain(std::iter::once(&first));
    let mut gaps_rad = places_rad.iter().zip(next).map(|(p, q)| q - p);
    gaps_rad.all(|gap_rad| (gap_rad - apart_rad).abs() < EVEN * apart_rad)
}

fn reach_m(piece: &[Point3<f64>]) -> f64 {
    let reaches = piece.iter().map(|point| point.xy().coords.norm());
    reaches.fold(0.0, f64::max)
}

/// Returns a piece as a roller, if it is round about its own axis and neither spoke nor bolt.
fn form(piece: &[Point3<f64>]) -> Option<RollerPiece> {
    /// Smallest number of vertices of a round piece.
    const LEAST_CORNERS: usize = 12;
    /// Largest relative difference of the extents across a round piece's axis.
    const ROUND: f64 = 0.1;
    if piece.len() < LEAST_CORNERS {
        return None;
    }
    let count = piece.len() as f64;
    let middle = Point3::from(piece.iter().map(|p| p.coords).sum::<Vector3<f64>>() / count);
    let spread = |p: &Point3<f64>| (p - middle) * (p - middle).transpose();
    let spread: Matrix3<f64> = piece.iter().map(spread).sum::<Matrix3<f64>>() / count;
    let eigen = spread.symmetric_eigen();
    let mut by_size = [0, 1, 2];
    by_size.sort_by(|&p, &q| eigen.eigenvalues[p].total_cmp(&eigen.eigenvalues[q]));
    let [least, between, most] = by_size.map(|i| eigen.eigenvalues[i]);
    // The distinct one of the three extents is along the axis.
    let (along, low, high) = match most - between > between - least {
        true => (by_size[2], least, between),
        false => (by_size[0], between, most),
    };
    if high - low > ROUND * high {
        return None;
    }
    let axis = Unit::new_normalize(eigen.eigenvectors.column(along).into_owned());
    // The middle of its extent: the mean of its vertices is off if they are denser on one side.
    let span = |i: usize| {
        let direction = eigen.eigenvectors.column(i).into_owned();
        let places = piece.iter().map(|p| (p - middle).dot(&direction));
        let (from, to) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), t| {
            (t.min(from), t.max(to))
        });
        (direction * (0.5 * (from + to)), 0.5 * (to - from))
    };
    let spans = [span(0), span(1), span(2)];
    let middle = middle + spans.iter().map(|(off, _)| off).sum::<Vector3<f64>>();
    let skew = skew(&middle, &axis)?;
    if skew.gamma_rad.abs() > MOST_GAMMA_RAD {
        return None;
    }
    let from_axis_m = |p: &Point3<f64>| (p - middle).cross(&axis).norm();
    let radius_m = piece.iter().map(from_axis_m).fold(0.0, f64::max);
    Some(RollerPiece {
        radius_m,
        half_length_m: spans[along].1,
        ring_radius_m: skew.ring_radius_m,
        gamma_rad: skew.gamma_rad,
        place_rad: libm::atan2(skew.foot.y, skew.foot.x),
        reach_m: reach_m(piece),
        out_of_round: (high - low) / high,
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    type Triangle = [[f32; 3]; 3];

    /// A spindle about z: radii at positions along it, in facets around.
    fn spindle(outline: &[(f64, f64)]) -> Vec<[Point3<f64>; 3]> {
        const AROUND: usize = 16;
        let point = |(z, r): (f64, f64), i: usize| {
            let angle = TAU * (i % AROUND) as f64 / AROUND as f64;
            Point3::new(r * libm::cos(angle), r * libm::sin(angle), z)
        };
        let strips = outline.windows(2).flat_map(|pair| {
            (0..AROUND).flat_map(|i| {
                let [a, b] = [point(pair[0], i), point(pair[0], i + 1)];
                let [c, d] = [point(pair[1], i), point(pair[1], i + 1)];
                [[a, b, c], [b, d, c]]
            })
        });
        strips.collect()
    }

    fn as_read(triangle: [Point3<f64>; 3]) -> Triangle {
        triangle.map(|p| [p.x as f32, p.y as f32, p.z as f32])
    }

    /// A wheel of radius 50 mm about z: rollers of radius 10 mm on a ring of 40 mm, at given turns,
    /// with axes by gamma as in `roller_dimensions`, on pins that reach nearly as far; and a hub of
    /// given radius, with bolts.
    fn wheel(gamma_deg: f64, places: &[f64], hub_m: f64) -> Vec<Triangle> {
        const LENGTH_M: f64 = 0.04;
        let outline: Vec<(f64, f64)> = (0..=8)
            .map(|i| {
                let t = 2.0 * f64::from(i) / 8.0 - 1.0;
                (0.5 * LENGTH_M * t, 0.01 - 0.004 * t * t)
            })
            .collect();
        let gamma = gamma_deg.to_radians();
        let down_axis = Vector3::new(0.0, libm::cos(gamma), -libm::sin(gamma));
        let lay = Rotation3::rotation_between(&Vector3::z(), &down_axis).expect("not opposite");
        let mut triangles = Vec::new();
        for place in places {
            let around = Rotation3::from_axis_angle(&Vector3::z_axis(), TAU * place);
            let there = |p: Point3<f64>| around * (lay * p + Vector3::new(0.04, 0.0, 0.0));
            triangles.extend(spindle(&outline).into_iter().map(|t| t.map(there)));
            let pin = spindle(&[(-0.024, 0.002), (0.0, 0.002), (0.024, 0.002)]);
            triangles.extend(pin.into_iter().map(|t| t.map(there)));
        }
        triangles.extend(spindle(&[(-0.02, hub_m), (0.0, hub_m), (0.02, hub_m)]));
        for i in 0..6 {
            let around = Rotation3::from_axis_angle(&Vector3::z_axis(), TAU * f64::from(i) / 6.0);
            let bolt = spindle(&[(-0.021, 0.002), (0.0, 0.002), (0.021, 0.002)]);
            let there = |p: Point3<f64>| around * (p + Vector3::new(0.02, 0.0, 0.0));
            triangles.extend(bolt.into_iter().map(|t| t.map(there)));
        }
        triangles.into_iter().map(as_read).collect()
    }

    fn drawn(triangles: &[Triangle]) -> Option<MeshRollers> {
        of_pieces(&pieces(triangles, |[x, y, z]| {
            Point3::new(x, y, z).cast::<f64>()
        }))
    }

    fn evenly(count: usize) -> Vec<f64> {
        (0..count).map(|i| 0.3 + i as f64 / count as f64).collect()
    }

    #[test]
    fn a_mesh_shows_how_many_rollers_at_which_angle_and_how_thick() {
        for (gamma_deg, count) in [(45.0, 9), (-45.0, 9), (30.0, 12), (0.0, 7), (-60.0, 8)] {
            let found = drawn(&wheel(gamma_deg, &evenly(count), 0.03)).expect("rollers");
            assert_eq!(found.count, count);
            assert!(
                (found.gamma_rad.to_degrees() - gamma_deg).abs() < 1e-3,
                "{found:?}"
            );
            // To f32 precision; the wheel's radius within the error of 22.5 degree facets on the
            // roller's.
            assert!((found.roller_radius_m - 0.01).abs() < 1e-7, "{found:?}");
            let facet_m = 0.01 * (1.0 - libm::cos(PI / 16.0));
            assert!(
                (found.wheel_radius_m - 0.05).abs() < facet_m + 1e-7,
                "{found:?}"
            );
            assert!(found.hands_over());
            assert!(found.are_round);
        }
    }

    #[test]
    fn rollers_of_a_stretched_mesh_are_not_round() {
        let narrow: Vec<Triangle> = wheel(45.0, &evenly(9), 0.03)
            .into_iter()
            .map(|triangle| triangle.map(|[x, y, z]| [x, y, 0.93 * z]))
            .collect();
        let found = drawn(&narrow).expect("rollers");
        // A narrower shape has a smaller angle, like a point of the axis: tan(gamma) = 0.93 at
        // most.
        let most_deg = 0.93_f64.atan().to_degrees();
        let gamma_deg = found.gamma_rad.to_degrees();
        assert!((38.0..most_deg).contains(&gamma_deg), "{found:?}");
        assert!(!found.are_round, "{found:?}");
    }

    #[test]
    fn a_mesh_that_stands_off_its_joint_shows_them_all_the_same() {
        let off: Vec<Triangle> = wheel(45.0, &evenly(9), 0.03)
            .into_iter()
            .map(|triangle| triangle.map(|[x, y, z]| [x + 0.0008, y, z]))
            .collect();
        let found = drawn(&off).expect("rollers");
        assert_eq!(found.count, 9);
        // A shift by 0.8 mm on a ring of 40 mm turns the axes by at most 0.02 rad, to both sides
        // alike.
        assert!(
            (found.gamma_rad.to_degrees() - 45.0).abs() < 0.1,
            "{found:?}"
        );
        assert!((found.wheel_radius_m - 0.05).abs() < 3e-4, "{found:?}");
    }

    #[test]
    fn what_is_no_ring_of_rollers_is_not_taken_for_one() {
        // A tyre around them; a missing roller; too few; none.
        assert_eq!(drawn(&wheel(45.0, &evenly(9), 0.06)), None);
        assert_eq!(drawn(&wheel(45.0, &evenly(9)[1..], 0.03)), None);
        assert_eq!(drawn(&wheel(45.0, &evenly(4), 0.03)), None);
        assert_eq!(drawn(&wheel(45.0, &[], 0.03)), None);
    }
}
