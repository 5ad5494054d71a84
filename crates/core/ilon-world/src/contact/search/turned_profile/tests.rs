//! Nearest points of turned rollers, against a search over the whole body.

use ilon_robot::SolidOfRevolution;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::PlacedProfile;
use crate::contact::search::nearest::{Nearest, Piece, SolidBox, Triangle};

/// The minimum of a convex function over an interval, by thirds.
fn least(low: f64, high: f64, of: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (low, high);
    for _ in 0..60 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if of(a) < of(b) { high = b } else { low = a }
    }
    of(0.5 * (low + high))
}

/// The smallest distance of a piece from the points of the body: thirds along the axis and, for
/// each of its points, over its disc.
fn brute_force(placed: &PlacedProfile<'_>, piece: &Piece) -> f64 {
    let x = placed.axis.cross(&Vector3::new(0.3, 0.5, 0.8)).normalize();
    let y = placed.axis.cross(&x);
    let (first_m, last_m) = placed.turned.span_m();
    least(first_m, last_m, |t| {
        let r = placed.turned.surface_radius_m(t);
        least(-r, r, |u| {
            let half = (r * r - u * u).max(0.0).sqrt();
            least(-half, half, |v| {
                let place_m = placed.center_m + t * placed.axis + u * x + v * y;
                piece.foot(&place_m).distance_m
            })
        })
    })
}

fn bodies() -> [SolidOfRevolution; 3] {
    let of = |points: &[[f64; 2]], edge| SolidOfRevolution::new(points, edge).unwrap();
    [
        of(&[[-0.02, 0.01], [0.02, 0.01]], 0.002),
        of(&[[-0.02, 0.01], [0.02, 0.01]], 0.0),
        of(
            &[[-0.02, 0.006], [-0.006, 0.01], [0.006, 0.01], [0.02, 0.007]],
            0.001,
        ),
    ]
}

fn nearest_of(placed: &PlacedProfile<'_>, piece: &Piece) -> Nearest {
    let mut best: Option<Nearest> = None;
    placed.places_on(piece, f64::INFINITY, |nearest| {
        if best.is_none_or(|best| nearest.gap_m < best.gap_m) {
            best = Some(nearest);
        }
    });
    best.expect("a place")
}

#[test]
fn nearest_places_are_those_of_a_search_over_the_whole_body() {
    let solid = Piece::Box(SolidBox {
        floor_from_box: Isometry3::from_parts(
            Translation3::new(0.03, -0.01, 0.02),
            UnitQuaternion::from_euler_angles(0.2, -0.1, 0.7),
        ),
        half_sides_m: Vector3::new(0.05, 0.03, 0.01),
    });
    let corners_m = [
        Vector3::new(0.0, 0.0, 0.01),
        Vector3::new(0.05, 0.01, 0.0),
        Vector3::new(0.01, 0.04, -0.01),
    ];
    let triangle = Piece::Triangle(Triangle::new(corners_m, &Vector3::z()).unwrap());
    for body in bodies() {
        for i in 0..6 {
            let s = f64::from(i);
            let axis =
                Vector3::new((1.3 * s).cos(), (1.3 * s).sin(), 0.6 * (0.7 * s).sin()).normalize();
            let center_m = Vector3::new(0.06 * (2.1 * s).cos(), 0.05 * (1.7 * s).sin(), 0.06);
            let placed = PlacedProfile {
                turned: &body,
                center_m,
                axis,
            };
            for piece in [&Piece::Plane, &solid, &triangle] {
                let nearest = nearest_of(&placed, piece);
                let exact_m = brute_force(&placed, piece);
                // Sixty thirds leave a share of 3e-11 of an interval of centimetres; its places'
                // flat surroundings less.
                assert!(
                    (nearest.gap_m - exact_m).abs() < 1e-9,
                    "{i} {:e} {exact_m:e}",
                    nearest.gap_m
                );
                // The point is on the ground, and the roller is its gap away along the normal.
                assert!(piece.foot(&nearest.place_m).distance_m.abs() < 1e-12);
                let reach = placed.support(&nearest.normal, nearest.corner);
                let across_m = (reach - nearest.place_m).dot(&nearest.normal);
                assert!((across_m - nearest.gap_m).abs() < 1e-9, "{i}");
            }
        }
    }
}

/// The box around a body contains it, and reaches as far as its further end along each axis: the
/// third of these is thicker at one end by up to 1 mm.
#[test]
fn the_box_around_a_roller_holds_it_and_touches_it_along_each_axis() {
    for body in bodies() {
        for i in 0..6 {
            let s = f64::from(i);
            let axis = Vector3::new((1.3 * s).cos(), (1.3 * s).sin(), 0.6 * (0.7 * s).sin());
            let placed = PlacedProfile {
                turned: &body,
                center_m: Vector3::new(0.06 * s, -0.05 * s, 0.03),
                axis: axis.normalize(),
            };
            let bounds = placed.bounds();
            for side in 0..3 {
                let towards = Vector3::ith(side, 1.0);
                let over_m = bounds.most_m[side] - placed.support(&-towards, None)[side];
                let under_m = placed.support(&towards, None)[side] - bounds.least_m[side];
                // The box is as wide both ways as the further of the two; a handful of roundings of
                // decimetres.
                assert!(over_m.min(under_m).abs() < 1e-15, "{i} {side}");
                assert!(over_m.max(under_m) < 2e-3, "{i} {side}");
            }
        }
    }
}

#[test]
fn a_roller_that_reaches_into_an_edge_is_pushed_out_over_it() {
    // A cylinder along y with its side over the straight edge of a box along x = 0, at 45 degrees
    // to both faces.
    let piece = Piece::Box(SolidBox {
        floor_from_box: Isometry3::translation(-0.1, 0.0, -0.1),
        half_sides_m: Vector3::new(0.1, 0.2, 0.1),
    });
    let body = &bodies()[0];
    for gap_m in [1e-3, 1e-6, -1e-6, -1e-4] {
        let off_m = (0.01 + gap_m) * std::f64::consts::FRAC_1_SQRT_2;
        let placed = PlacedProfile {
            turned: body,
            center_m: Vector3::new(off_m, 0.0, off_m),
            axis: Vector3::y(),
        };
        let nearest = nearest_of(&placed, &piece);
        // A handful of roundings of centimetres.
        assert!(
            (nearest.gap_m - gap_m).abs() < 1e-15,
            "{gap_m}: {:e}",
            nearest.gap_m
        );
        let diagonal = Vector3::new(1.0, 0.0, 1.0).normalize();
        assert!((nearest.normal - diagonal).norm() < 1e-12);
    }
}

#[test]
fn a_roller_beside_a_raised_triangle_and_below_its_plane_does_not_touch_it() {
    // A slope up to the edge at x = 0; the roller is behind the edge, lower than the extension of
    // the slope's plane, and clear of it.
    let corners_m = [
        Vector3::new(0.0, -0.05, 0.0),
        Vector3::new(0.0, 0.05, 0.0),
        Vector3::new(-0.05, 0.0, -0.03),
    ];
    let piece = Piece::Triangle(Triangle::new(corners_m, &Vector3::z()).unwrap());
    for body in bodies() {
        let placed = PlacedProfile {
            turned: &body,
            center_m: Vector3::new(0.04, 0.0, -0.002),
            axis: Vector3::y(),
        };
        // 40 mm across and 2 mm down to its axis, its side is 30 mm from the edge: the ground near
        // it is the next triangle.
        let mut gaps_m: Vec<f64> = Vec::new();
        placed.places_on(&piece, 0.02, |nearest| gaps_m.push(nearest.gap_m));
        assert!(gaps_m.is_empty(), "{gaps_m:?}");
    }
}

#[test]
fn a_cylinder_that_lies_on_the_ground_touches_with_both_of_its_edges() {
    let [body, ..] = bodies();
    let placed = PlacedProfile {
        turned: &body,
        center_m: Vector3::new(0.0, 0.0, 0.01),
        axis: Vector3::x(),
    };
    let mut places = Vec::new();
    placed.places_on(&Piece::Plane, 1e-3, |nearest| places.push(nearest));
    assert_eq!(places.len(), 2);
    for (nearest, x_m) in places.iter().zip([-0.018, 0.018]) {
        assert!(nearest.gap_m.abs() < 1e-17 && (nearest.place_m.x - x_m).abs() < 1e-17);
    }
    // Upright it stands on the middle of its face.
    let upright = PlacedProfile {
        axis: Vector3::z(),
        center_m: Vector3::new(0.0, 0.0, 0.021),
        ..placed
    };
    assert!((upright.gap_m(&Piece::Plane, f64::INFINITY) - 0.001).abs() < 1e-17);
}

#[test]
fn radii_of_curvature_are_those_of_the_outline_in_the_mean() {
    // An arc of radius 60 mm as lines that turn by 8 mrad each; around its axis the roller has its
    // local thickness.
    let (arc_m, thick_m) = (0.06, 0.012);
    let points: Vec<[f64; 2]> = (-20..=20)
        .map(|i| {
            let (sin, cos) = (8e-3 * f64::from(i)).sin_cos();
            [arc_m * sin, thick_m - arc_m * (1.0 - cos)]
        })
        .collect();
    let turned = SolidOfRevolution::new(&points, 0.0).unwrap();
    let placed = PlacedProfile {
        turned: &turned,
        center_m: Vector3::new(0.3, 0.2, 0.1),
        axis: Vector3::x(),
    };
    let [along_m, around_m] = placed.radii_m(&Vector3::z());
    // Over 40 mrad lie five of its lines, give or take one at an end.
    assert!((along_m / arc_m - 1.0).abs() < 0.2, "{along_m}");
    assert!((around_m - thick_m).abs() < 1e-4, "{around_m}");
    // A level cylinder: over the tilt its whole length; beyond that its edge.
    let cylinder = SolidOfRevolution::new(&[[-0.02, 0.01], [0.02, 0.01]], 0.002).unwrap();
    let mut placed = PlacedProfile {
        turned: &cylinder,
        center_m: Vector3::zeros(),
        axis: Vector3::x(),
    };
    let [along_m, around_m] = placed.radii_m(&Vector3::z());
    let straight_m = 0.04 - 2.0 * 0.002;
    let expected_m = straight_m / (2.0 * super::MEAN_TILT.sin()) + 0.002;
    assert!(
        (along_m - expected_m).abs() < 1e-4,
        "{along_m} {expected_m}"
    );
    assert!((around_m - 0.01).abs() < 1e-12);
    placed.axis = Vector3::new(0.1_f64.cos(), 0.0, 0.1_f64.sin());
    let [along_m, around_m] = placed.radii_m(&Vector3::z());
    assert!((along_m - 0.002).abs() < 1e-12, "{along_m}");
    // The circle of its edge, 8 mm, is seen at 0.1 rad.
    assert!((around_m - (0.008 / 0.1_f64.cos() + 0.002)).abs() < 1e-12);
}

/// In any pose of a spindle, its lowest corner is the one whose own support point reaches furthest.
#[test]
fn the_lowest_corner_is_the_one_that_reaches_furthest() {
    let points_m = [
        [-0.04, 0.004],
        [-0.02, 0.011],
        [0.0, 0.015],
        [0.02, 0.012],
        [0.04, 0.005],
    ];
    let turned = SolidOfRevolution::new(&points_m, 0.001).unwrap();
    let up = Vector3::z();
    for step in 0..=180 {
        // From standing on one end over lying to standing on the other.
        let tilt_rad = f64::to_radians(f64::from(step));
        let placed = PlacedProfile {
            turned: &turned,
            center_m: Vector3::zeros(),
            axis: Vector3::new(tilt_rad.sin(), 0.0, tilt_rad.cos()),
        };
        let found_m = placed.support(&up, None).z;
        for corner in 0..turned.corners().len() {
            let other_m = placed.support(&up, Some(corner)).z;
            assert!(found_m <= other_m + 1e-15, "{step} deg, corner {corner}");
        }
    }
}

/// Each place on a face names the corner above it: that corner, not the lowest of all, is its gap
/// away along the normal. It is computed by the same few sums of centimetres.
#[test]
fn each_place_on_a_face_lies_beneath_its_own_corner() {
    let corners_m = [
        Vector3::new(-1.0, -1.0, 0.0),
        Vector3::new(1.0, -1.0, 0.0),
        Vector3::new(0.0, 1.0, 0.0),
    ];
    let triangle = Piece::Triangle(Triangle::new(corners_m, &Vector3::z()).unwrap());
    for body in bodies() {
        for tilt_rad in [-0.1_f64, 0.0, 0.01] {
            let placed = PlacedProfile {
                turned: &body,
                center_m: Vector3::new(0.0, 0.0, 0.03),
                axis: Vector3::new(tilt_rad.cos(), 0.0, tilt_rad.sin()),
            };
            for piece in [&Piece::Plane, &triangle] {
                let mut beneath_m = Vec::new();
                placed.places_on(piece, 0.1, |nearest| {
                    let reach_m = placed.support(&nearest.normal, nearest.corner);
                    let off_m = reach_m - nearest.place_m - nearest.gap_m * nearest.normal;
                    assert!(off_m.norm() < 1e-15, "{tilt_rad}: {off_m}");
                    beneath_m.push(nearest.place_m.x);
                });
                let is_apart = |pair: &[f64]| (pair[1] - pair[0]).abs() > 0.01;
                assert!(beneath_m.windows(2).any(is_apart), "{beneath_m:?}");
            }
        }
    }
}
