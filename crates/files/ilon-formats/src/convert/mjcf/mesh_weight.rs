//! What a mesh weighs, as MuJoCo works it out: its triangles make tetrahedra with one point within.

use mjcf_rs::assets::MeshInertia;
use nalgebra::{Matrix3, Point3, Vector3};
use parry3d::math::Vector;
use parry3d::transformation::try_convex_hull;

use crate::model::MassProperties;

/// A triangle by its corners.
pub(super) type Triangle = [Point3<f64>; 3];

/// Volume, centre and inertia of a mesh for the density of 1 kg/m^3, in the mesh's frame; `None` of
/// one that encloses nothing.
///
/// MuJoCo's default, `legacy`, counts each tetrahedron as a positive volume: of a mesh that is not
/// convex the whole then hangs on the inner point, which is the middle of the surface for the
/// centre, and the centre for mass and inertia. With `exact`, tetrahedra that face inwards are
/// taken away. `shell` is the surface alone, for 1 kg/m^2.
pub(super) fn solid(triangles: &[Triangle], kind: MeshInertia) -> Option<MassProperties> {
    let volume_of = |tetrahedron: &[Vector3<f64>; 3]| {
        let [a, b, c] = tetrahedron;
        let volume_m3 = a.dot(&b.cross(c)) / 6.0;
        match kind {
            MeshInertia::Exact => volume_m3,
            _ => volume_m3.abs(),
        }
    };
    let is_shell = kind == MeshInertia::Shell;
    let inner = middle(triangles)?;
    let mut volume_m3 = 0.0;
    let mut moment = Vector3::zeros();
    for triangle in triangles {
        let corners = triangle.map(|corner| corner - inner);
        let of = volume_of(&corners);
        volume_m3 += of;
        // The fourth corner is the inner point.
        moment += corners.iter().sum::<Vector3<f64>>() * (0.25 * of);
    }
    if !(is_shell || volume_m3 > 0.0 && volume_m3.is_finite()) {
        return None;
    }
    // The integral of x x^T over a tetrahedron with a corner at the origin is V / 20 (s s^T + sum
    // of c c^T), s the sum of its other corners c; over a triangle it is A / 12 of that.
    let (center, share) = match is_shell {
        true => (inner, 12.0),
        false => (inner + moment / volume_m3, 20.0),
    };
    let weight_of = |[a, b, c]: &[Vector3<f64>; 3]| match is_shell {
        true => 0.5 * (b - a).cross(&(c - a)).norm(),
        false => volume_of(&[*a, *b, *c]),
    };
    let (mut mass_kg, mut second) = (0.0, Matrix3::zeros());
    for triangle in triangles {
        let corners = triangle.map(|corner| corner - center);
        mass_kg += weight_of(&corners);
        let sum = corners.iter().sum::<Vector3<f64>>();
        let squares = corners.iter().map(|c| c * c.transpose());
        let spread = squares.fold(sum * sum.transpose(), |all, one| all + one);
        second += spread * (weight_of(&corners) / share);
    }
    Some(MassProperties {
        mass_kg,
        center_of_mass_m: center.coords,
        inertia_kg_m2: Matrix3::identity() * second.trace() - second,
    })
}

/// The triangles of the convex hull of some points, which MuJoCo takes where a file gives points
/// without faces; `None` of points that have none.
pub(super) fn hull(points: &[Point3<f64>]) -> Option<Vec<Triangle>> {
    let points: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let (corners, sides) = try_convex_hull(&points).ok()?;
    let corner = |at: u32| {
        let p = corners[at as usize];
        Point3::new(p.x, p.y, p.z)
    };
    Some(sides.into_iter().map(|side| side.map(corner)).collect())
}

/// The mean of the triangles' middles by their areas.
fn middle(triangles: &[Triangle]) -> Option<Point3<f64>> {
    let (mut area, mut sum) = (0.0, Vector3::zeros());
    for [a, b, c] in triangles {
        let of = (b - a).cross(&(c - a)).norm();
        area += of;
        sum += (a.coords + b.coords + c.coords) * (of / 3.0);
    }
    (area > 0.0).then(|| Point3::from(sum / area))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The twelve triangles of a box, wound outwards.
    fn cuboid(half: Vector3<f64>, at: Vector3<f64>) -> Vec<Triangle> {
        let corner = |i: usize| {
            let sign = |bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
            Point3::from(at + half.component_mul(&Vector3::new(sign(1), sign(2), sign(4))))
        };
        let sides = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let halves = sides
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        halves.map(|side| side.map(corner)).collect()
    }

    #[test]
    fn a_box_of_triangles_weighs_what_a_box_does() {
        let half = Vector3::new(0.1, 0.2, 0.3);
        let at = Vector3::new(1.0, -2.0, 0.5);
        for kind in [MeshInertia::Convex, MeshInertia::Exact] {
            let found = solid(&cuboid(half, at), kind).expect("a volume");
            let mass_kg = 8.0 * half.product();
            assert!((found.mass_kg - mass_kg).abs() < 1e-12 * mass_kg);
            assert!((found.center_of_mass_m - at).norm() < 1e-12);
            let moment = |p: f64, q: f64| mass_kg * (p * p + q * q) / 3.0;
            let expected = Matrix3::from_diagonal(&Vector3::new(
                moment(half.y, half.z),
                moment(half.x, half.z),
                moment(half.x, half.y),
            ));
            assert!((found.inertia_kg_m2 - expected).norm() < 1e-12 * expected.norm());
        }
    }

    #[test]
    fn points_without_faces_weigh_what_their_hull_does() {
        let half = Vector3::new(0.1, 0.2, 0.3);
        let sides = cuboid(half, Vector3::zeros());
        let mut points: Vec<Point3<f64>> = sides.concat();
        // The middle of a side and of the whole are no corners.
        points.extend([Point3::new(0.1, 0.0, 0.0), Point3::origin()]);
        let hull = hull(&points).expect("few points");
        let found = solid(&hull, MeshInertia::Exact).expect("a volume, wound outwards");
        let expected = solid(&sides, MeshInertia::Exact).expect("a volume");
        assert!((found.mass_kg - expected.mass_kg).abs() < 1e-12);
        assert!((found.inertia_kg_m2 - expected.inertia_kg_m2).norm() < 1e-12);
        assert_eq!(super::hull(&[Point3::origin(); 2]), None);
        // Eight points, of which one lies within: MuJoCo's mass, centre and principal moments.
        let points = [
            [0.0, 0.0, 0.0],
            [3.0, 0.5, 0.0],
            [2.5, 2.0, 0.2],
            [-0.5, 1.5, -0.3],
            [0.2, 0.1, 1.8],
            [2.0, 0.4, 1.1],
            [1.0, 1.7, 1.4],
            [1.0, 0.8, 0.6],
        ];
        let hull = super::hull(&points.map(Point3::from)).expect("few points");
        let found = solid(&hull, MeshInertia::Exact).expect("a volume");
        assert!(
            (found.mass_kg - 4.877_666_69).abs() < 1e-5,
            "{}",
            found.mass_kg
        );
        let center_m = Vector3::new(1.058_679_02, 0.924_827_45, 0.548_611_01);
        assert!(
            (found.center_of_mass_m - center_m).norm() < 1e-5,
            "{}",
            found.center_of_mass_m
        );
        let moments = found.principal_moments_kg_m2();
        for (is, should) in moments
            .iter()
            .zip([1.740_965_56, 3.155_459_25, 3.441_733_36])
        {
            assert!((is - should).abs() < 1e-5, "{moments:?}");
        }
    }

    /// The caps of a turned cylinder whose corners are written with few decimals are not quite flat.
    #[test]
    fn rounded_points_weigh_what_the_exact_ones_do() {
        let (radius_m, length_m, sides) = (0.05_f64, 0.04, 24);
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, 0.7, -1.1);
        let exact: Vec<Point3<f64>> = (0..2 * sides)
            .map(|i| {
                let (sin, cos) = libm::sincos(f64::from(i / 2) * std::f64::consts::TAU / 24.0);
                let z = if i % 2 == 0 { 0.0 } else { length_m };
                turn * Point3::new(radius_m * cos, radius_m * sin, z)
            })
            .collect();
        let area_m2 = 12.0 * radius_m * radius_m * libm::sin(std::f64::consts::TAU / 24.0);
        for decimals in 6..13 {
            let unit = 10f64.powi(-decimals);
            let points: Vec<_> = exact
                .iter()
                .map(|p| p.map(|x| unit * (x / unit).round()))
                .collect();
            let hull = hull(&points).expect("points in space");
            let found = solid(&hull, MeshInertia::Exact).expect("a volume");
            // Corners that are off by half a unit, over a radius of 0.05 m.
            let off = found.mass_kg / (area_m2 * length_m) - 1.0;
            assert!(off.abs() < 40.0 * unit + 1e-12, "{decimals}: {off}");
        }
    }

    #[test]
    fn what_is_not_convex_weighs_what_mujoco_says() {
        let outline = [[0.0, 0.0], [2.0, 1.0], [0.0, 0.4], [-2.0, 1.0]];
        let corner = |i: usize| {
            let [x, y] = outline[i % 4];
            Point3::new(x, y, if i < 4 { -0.3 } else { 0.3 })
        };
        let mut faces = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
        for i in 0..4 {
            let j = (i + 1) % 4;
            faces.extend([[i, j, 4 + j], [i, 4 + j, 4 + i]]);
        }
        let triangles: Vec<Triangle> = faces.iter().map(|face| face.map(corner)).collect();
        // MuJoCo of this mesh, which it reads in f32: mass, y of the centre, principal moments.
        for (kind, [mass_kg, y_m, least, middle, most]) in [
            (
                MeshInertia::Convex,
                [0.70054, 0.537837, 0.048517, 0.514802, 0.526579],
            ),
            (
                MeshInertia::Exact,
                [0.48, 0.466667, 0.034667, 0.3344, 0.340267],
            ),
            (
                MeshInertia::Shell,
                [6.788955, 0.565960, 0.738469, 8.284942, 8.424074],
            ),
        ] {
            let found = solid(&triangles, kind).expect("a volume");
            let moments = found.principal_moments_kg_m2();
            let pairs = [
                (found.mass_kg, mass_kg),
                (found.center_of_mass_m.y, y_m),
                (moments[0], least),
                (moments[1], middle),
                (moments[2], most),
            ];
            for (is, should) in pairs {
                assert!((is - should).abs() < 2e-6 * mass_kg, "{is} {should}");
            }
        }
    }

    #[test]
    fn what_encloses_nothing_has_no_weight() {
        assert_eq!(solid(&[], MeshInertia::Exact), None);
        let flat = [
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
        ];
        assert_eq!(solid(&[flat], MeshInertia::Exact), None);
    }
}
