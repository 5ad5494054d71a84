//! The nearest point of a roller against a brute-force minimisation.
//!
//! The reference does not use the closed forms: it walks along the roller's axis in fine steps,
//! computes the distance of each sphere of the barrel to the ground by elementary geometry, and
//! keeps the minimum.

use ilon_robot::Barrel;
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::{Bracket, Nearest, Piece, PlacedBarrel, SolidBox, Triangle, keep_nearest_of_surface};

/// A digit of a sum of lengths up to 0.2 m in f64 is 3e-17 m. The search ends where its bracket is
/// 1e-12 m wide, and the distance is flat there.
const EXACT_M: f64 = 1e-11;

fn barrel() -> Barrel {
    Barrel::handing_over(0.05, 0.012, std::f64::consts::FRAC_PI_4, 9)
}

fn placed<'a>(barrel: &'a Barrel, pose: &Isometry3<f64>) -> PlacedBarrel<'a> {
    PlacedBarrel {
        barrel,
        center_m: pose.translation.vector,
        axis: pose.rotation * Vector3::z(),
    }
}

/// The smallest signed distance of the barrel to a ground with a given signed distance function.
fn brute_force(placed: &PlacedBarrel<'_>, signed_distance: impl Fn(&Vector3<f64>) -> f64) -> f64 {
    let at = |t: f64| {
        let sphere_m = placed.center_m + t * placed.axis;
        signed_distance(&sphere_m) - placed.barrel.sphere_radius_m(t)
    };
    // Each pass is a thousand times finer than the one before; the last leaves less than 1e-13 m.
    // The distance to a surface of several faces has several minima: each is wider than the first
    // steps.
    let steps = 2000;
    let mut middle = 0.0;
    let mut reach = placed.barrel.half_length_m;
    for _ in 0..4 {
        let half = placed.barrel.half_length_m;
        let (from, to) = ((middle - reach).max(-half), (middle + reach).min(half));
        middle = (0..=steps)
            .map(|i| from + (to - from) * f64::from(i) / f64::from(steps))
            .min_by(|a, b| at(*a).total_cmp(&at(*b)))
            .unwrap_or(from);
        reach *= 1e-3;
    }
    at(middle)
}

/// Signed distance of a point to a box, by elementary geometry.
fn to_box(half: Vector3<f64>, p: &Vector3<f64>) -> f64 {
    let q = p.abs() - half;
    q.sup(&Vector3::zeros()).norm() + q.max().min(0.0)
}

/// Distance of a point to a triangle: the minimum over its interior and its three sides.
fn to_triangle(v: [Vector3<f64>; 3], p: &Vector3<f64>) -> f64 {
    let n = (v[1] - v[0]).cross(&(v[2] - v[0])).normalize();
    let foot = p - n * n.dot(&(p - v[0]));
    let inside = (0..3).all(|i| (v[(i + 1) % 3] - v[i]).cross(&(foot - v[i])).dot(&n) >= 0.0);
    if inside {
        return (p - foot).norm();
    }
    (0..3)
        .map(|i| {
            let (a, b) = (v[i], v[(i + 1) % 3]);
            let s = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            (p - (a + s * (b - a))).norm()
        })
        .fold(f64::INFINITY, f64::min)
}

/// Any rotation, and a place near a ground with its surface at z = 0.
fn poses() -> impl Strategy<Value = Isometry3<f64>> {
    (
        prop::array::uniform3(-1.0..1.0f64),
        0.0..std::f64::consts::PI,
        -0.15..0.15f64,
        -0.15..0.15f64,
        -0.005..0.025f64,
    )
        .prop_map(|(axis, angle, x, y, z)| {
            let axis = Unit::try_new(Vector3::from(axis), 1e-3).unwrap_or(Vector3::z_axis());
            Isometry3::from_parts(
                Translation3::new(x, y, z),
                UnitQuaternion::from_axis_angle(&axis, angle),
            )
        })
}

/// Four triangles around a peak of 3 mm, 0.2 m wide.
fn peak() -> Vec<[Vector3<f64>; 3]> {
    let ring = [[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]];
    let corner = |i: usize| Vector3::new(ring[i % 4][0], ring[i % 4][1], 0.0);
    let top = Vector3::new(0.01, -0.02, 0.003);
    (0..4).map(|i| [corner(i), corner(i + 1), top]).collect()
}

fn triangles(corners: &[[Vector3<f64>; 3]]) -> Vec<Piece> {
    let pieces = corners.iter().map(|corners_m| {
        Piece::Triangle(Triangle::new(*corners_m, &Vector3::z()).expect("a triangle with an area"))
    });
    pieces.collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, max_global_rejects: 4096, rng_seed: prop::test_runner::RngSeed::Fixed(1973), ..ProptestConfig::default() })]

    #[test]
    fn on_a_plane_it_is_the_lowest_sphere_of_the_barrel(pose in poses()) {
        let barrel = barrel();
        let placed = placed(&barrel, &pose);
        let expected = brute_force(&placed, |p| p.z);
        prop_assert!((placed.nearest_to(&Piece::Plane).gap_m - expected).abs() < EXACT_M);
    }

    #[test]
    fn on_a_box_it_is_the_nearest_sphere_of_the_barrel(pose in poses()) {
        let barrel = barrel();
        let half = Vector3::new(0.1, 0.08, 0.03);
        let pose = Translation3::new(0.0, 0.0, half.z) * pose;
        let placed = placed(&barrel, &pose);
        let buried = (-10..=10).any(|i| {
            let t = f64::from(i) / 10.0 * barrel.half_length_m;
            to_box(half, &(placed.center_m + t * placed.axis)) < 0.0
        });
        // With its axis inside the box a roller is deeper than its own radius, which no contact
        // allows.
        prop_assume!(!buried);
        let piece = Piece::Box(SolidBox { floor_from_box: Isometry3::identity(), half_sides_m: half });
        let expected = brute_force(&placed, |p| to_box(half, p));
        let found = placed.nearest_to(&piece).gap_m;
        prop_assert!((found - expected).abs() < EXACT_M, "{found} for {expected}");
    }

    #[test]
    fn on_a_triangle_it_is_the_nearest_sphere_of_the_barrel(pose in poses()) {
        let barrel = barrel();
        let v = [Vector3::new(-0.1, -0.1, 0.0), Vector3::new(0.12, -0.05, 0.01), Vector3::new(0.0, 0.11, -0.01)];
        let placed = placed(&barrel, &pose);
        let normal = (v[1] - v[0]).cross(&(v[2] - v[0])).normalize();
        let height = |t: f64| normal.dot(&(placed.center_m + t * placed.axis - v[0]));
        let half = barrel.half_length_m;
        // Beneath its plane a triangle's ground has no distance.
        prop_assume!(height(half).min(height(-half)) > 1e-4);
        let expected = brute_force(&placed, |p| to_triangle(v, p));
        prop_assert!((placed.nearest_to(&triangles(&[v])[0]).gap_m - expected).abs() < EXACT_M);
    }

    /// A roller that is clear of every triangle is not reported inside the ground by any of them,
    /// and the nearest kept point is that of the whole surface.
    #[test]
    fn over_the_seams_of_a_surface_the_places_kept_have_its_true_distance(pose in poses()) {
        let barrel = barrel();
        let corners = peak();
        let pose = Translation3::new(0.0, 0.0, 0.008) * pose;
        let placed = placed(&barrel, &pose);
        let above = corners.iter().all(|v| {
            let normal = (v[1] - v[0]).cross(&(v[2] - v[0])).normalize();
            (-10..=10).all(|i| {
                let t = f64::from(i) / 10.0 * barrel.half_length_m;
                normal.dot(&(placed.center_m + t * placed.axis - v[0])) > 1e-4
            })
        });
        prop_assume!(above);
        let pieces = triangles(&corners);
        let mut places: Vec<(usize, Nearest)> =
            pieces.iter().enumerate().map(|(at, piece)| (at, placed.nearest_to(piece))).collect();
        keep_nearest_of_surface(&mut places, &pieces);
        let expected = brute_force(&placed, |p| {
            corners.iter().map(|v| to_triangle(*v, p)).fold(f64::INFINITY, f64::min)
        });
        let found = places.iter().map(|(_, place)| place.gap_m).fold(f64::INFINITY, f64::min);
        prop_assert!((found - expected).abs() < EXACT_M, "{found} for {expected}");
    }
}

/// A turning wheel on each flat ground: the height at which its rollers just touch is rho, at every
/// angle.
#[test]
fn the_outline_of_a_turning_wheel_is_round_on_every_flat_ground() {
    let count = 9;
    let (rho, r_max) = (0.05, 0.012);
    let gamma = std::f64::consts::FRAC_PI_4;
    let barrel = Barrel::handing_over(rho, r_max, gamma, count);
    let square =
        [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| Vector3::new(x, y, 0.0));
    let seam = triangles(&[
        [square[0], square[1], square[2]],
        [square[0], square[2], square[3]],
    ]);
    let slab = Piece::Box(SolidBox {
        floor_from_box: Isometry3::translation(0.0, 0.0, -0.1),
        half_sides_m: Vector3::new(0.5, 0.5, 0.1),
    });
    for pieces in [vec![Piece::Plane], vec![slab], seam] {
        for step in 0..720 {
            let turned_rad = f64::from(step) * 0.5_f64.to_radians();
            let gaps = (0..count).map(|roller| {
                let psi = turned_rad + std::f64::consts::TAU * roller as f64 / count as f64;
                // A hub along y, its rollers around it.
                let out = Vector3::new(psi.cos(), 0.0, psi.sin());
                let along = Vector3::new(-psi.sin(), 0.0, psi.cos());
                let placed = PlacedBarrel {
                    barrel: &barrel,
                    center_m: Vector3::new(0.0, 0.0, rho) + (rho - r_max) * out,
                    axis: gamma.cos() * along + gamma.sin() * Vector3::y(),
                };
                let gaps = pieces.iter().map(|piece| placed.nearest_to(piece).gap_m);
                gaps.fold(f64::INFINITY, f64::min)
            });
            let gap_m = gaps.fold(f64::INFINITY, f64::min);
            assert!(gap_m.abs() < EXACT_M, "{gap_m:.1e} m at step {step}");
        }
    }
}

/// A plane of small triangles is a plane: a barrel across their seams touches once, where it
/// touches the plane.
#[test]
fn across_seams_in_one_plane_a_roller_touches_once() {
    let barrel = barrel();
    let mut pieces = Vec::new();
    for row in -8..8 {
        for column in -8..8 {
            let corner = |i: i32, j: i32| {
                0.01 * Vector3::new(f64::from(column + i), f64::from(row + j), 0.0)
            };
            for corners_m in [
                [corner(0, 0), corner(1, 0), corner(1, 1)],
                [corner(0, 0), corner(1, 1), corner(0, 1)],
            ] {
                pieces.push(Piece::Triangle(
                    Triangle::new(corners_m, &Vector3::z()).unwrap(),
                ));
            }
        }
    }
    for index in 0..400 {
        let turned = f64::from(index);
        // Anywhere, and slightly beside a seam: from 1e-14 m to a tenth of a millimetre.
        let x_m = match index % 2 {
            0 => 3e-3 * turned.sin(),
            _ => 10.0_f64.powi(-4 - index % 11) * turned.sin(),
        };
        let at = Translation3::new(x_m, 7e-3 * (2.3 * turned).cos(), 0.0119);
        let lies = UnitQuaternion::from_euler_angles(
            std::f64::consts::FRAC_PI_2 + 0.02 * (1.7 * turned).sin(),
            0.0,
            turned,
        );
        let placed = placed(&barrel, &Isometry3::from_parts(at, lies));
        let on_plane = placed.nearest_to(&Piece::Plane);
        let mut places: Vec<(usize, Nearest)> = pieces
            .iter()
            .enumerate()
            .map(|(number, piece)| (number, placed.nearest_to(piece)))
            .filter(|(_, nearest)| nearest.gap_m < 1e-3)
            .collect();
        assert!(places.len() > 1);
        keep_nearest_of_surface(&mut places, &pieces);
        assert_eq!(places.len(), 1, "{index}: {places:?}");
        let found = places[0].1;
        assert!((found.gap_m - on_plane.gap_m).abs() < EXACT_M);
        assert!((found.place_m - on_plane.place_m).norm() < 1e-7, "{index}");
    }
}

/// Illinois's rule has an order of convergence of 1.44, while halving takes 41 evaluations from 2 m
/// to 1e-12 m, and the plain secant, one of whose ends stays, as many on curved slopes. It begins
/// with both ends, and three of the last four evaluations come from one side.
#[test]
fn the_search_along_a_roller_ends_after_a_dozen_looks() {
    let slopes: [fn(f64) -> f64; 4] = [
        |t| t.powi(3) + t - 0.5,
        |t| (4.0 * t).exp() - 2.0,
        |t| 0.3 + t / t.hypot(0.3),
        |t| (t + 1.0).powi(4) - 0.7,
    ];
    for (number, slope) in slopes.into_iter().enumerate() {
        let mut bracket = Bracket {
            ends_m: [-1.0, 1.0],
            slopes: [None; 2],
            last: 0,
        };
        let (mut t_m, mut looks) = (0.0, 0);
        while bracket.ends_m[1] - bracket.ends_m[0] >= 1e-12 && slope(t_m) != 0.0 {
            bracket.look(t_m, slope(t_m));
            t_m = bracket.next_m(looks);
            looks += 1;
            assert!(looks <= 16, "slope {number}");
        }
    }
}
