//! The exact roller against every kind of ground, held against a brute-force minimisation in f64.
//!
//! The reference knows nothing of the closed forms: it walks along the roller's axis in fine steps, asks for the
//! distance of each sphere of the barrel to the ground by elementary geometry, and keeps the least.

mod support;

use ilon_robot::Barrel;
use ilon_world::{RollerDispatcher, RollerShape};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use parry3d::math::{Pose, Real, Rotation, Vector};
use parry3d::query::{ContactManifold, PersistentQueryDispatcher};
use parry3d::shape::{HeightField, HeightFieldFlags, Shape, SharedShape, TriMeshFlags};
use parry3d::utils::Array2;
use proptest::prelude::*;

/// Prediction distance, generous so that contacts are found before they touch.
const PREDICTION_M: Real = 0.02;

fn barrel() -> Barrel {
    Barrel::handing_over(0.05, 0.012, std::f64::consts::FRAC_PI_4, 9)
}

/// The least signed distance of the barrel to a ground whose signed distance to a point is given.
fn brute_force(
    barrel: &Barrel,
    ground_from_roller: &Isometry3<f64>,
    signed_distance: impl Fn(&Vector3<f64>) -> f64,
) -> f64 {
    let axis = ground_from_roller.rotation * Vector3::z();
    let at = |t: f64| {
        let c = ground_from_roller.translation.vector + t * axis;
        signed_distance(&c) - barrel.sphere_radius_m(t)
    };
    // The distance is convex in t: 2000 steps, then 2000 more around the best; what is left is below 1e-12 m.
    let steps = 2000;
    let best = |from: f64, to: f64| {
        (0..=steps)
            .map(|i| from + (to - from) * f64::from(i) / f64::from(steps))
            .min_by(|a, b| at(*a).total_cmp(&at(*b)))
            .unwrap_or(from)
    };
    let half = barrel.half_length_m;
    let coarse = best(-half, half);
    let pitch = 2.0 * half / f64::from(steps);
    at(best(
        (coarse - pitch).max(-half),
        (coarse + pitch).min(half),
    ))
}

/// Signed distance of a point to a box, by elementary geometry.
fn to_box(half: Vector3<f64>, p: &Vector3<f64>) -> f64 {
    let q = p.abs() - half;
    q.sup(&Vector3::zeros()).norm() + q.max().min(0.0)
}

/// Distance of a point to a triangle: the least over its inside and its three sides.
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

/// The deepest contact that the dispatcher finds, whichever of the two shapes comes first.
fn deepest(ground: &dyn Shape, ground_from_roller: &Pose, roller_first: bool) -> Option<Real> {
    let roller = RollerShape::new(&barrel());
    let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
    let mut workspace = None;
    let found = if roller_first {
        RollerDispatcher.contact_manifolds(
            &ground_from_roller.inverse(),
            &roller,
            ground,
            PREDICTION_M,
            &mut manifolds,
            &mut workspace,
        )
    } else {
        RollerDispatcher.contact_manifolds(
            ground_from_roller,
            ground,
            &roller,
            PREDICTION_M,
            &mut manifolds,
            &mut workspace,
        )
    };
    found.expect("the dispatcher knows this ground");
    manifolds
        .iter()
        .flat_map(|m| m.points.iter().map(|p| p.dist))
        .min_by(Real::total_cmp)
}

fn to_f32(iso: &Isometry3<f64>) -> Pose {
    let (t, q) = (iso.translation.vector, iso.rotation);
    Pose::from_parts(
        Vector::new(t.x as Real, t.y as Real, t.z as Real),
        Rotation::from_xyzw(q.i as Real, q.j as Real, q.k as Real, q.w as Real).normalize(),
    )
}

/// Any rotation, and a place above a ground of 0.2 m such that the roller is near its surface.
fn poses() -> impl Strategy<Value = Isometry3<f64>> {
    (
        prop::array::uniform3(-1.0..1.0f64),
        0.0..std::f64::consts::PI,
        -0.15..0.15f64,
        -0.15..0.15f64,
        -0.005..0.025f64,
    )
        .prop_map(|(axis, angle, x, y, z)| {
            let axis =
                nalgebra::Unit::try_new(Vector3::from(axis), 1e-3).unwrap_or(Vector3::z_axis());
            Isometry3::from_parts(
                Translation3::new(x, y, z),
                UnitQuaternion::from_axis_angle(&axis, angle),
            )
        })
}

/// f32 carries coordinates below 0.25 m to 1.5e-8; a handful of products and roots of them stays within 1e-7 m.
const EXACT_M: f64 = 1e-7;
/// Where a search replaces the closed form (edges, corners), the distance is flat at its minimum, so the search's own
/// resolution does not count; the projection of a point on an edge loses some digits more.
const SEARCHED_M: f64 = 5e-7;

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, rng_seed: prop::test_runner::RngSeed::Fixed(1973), ..ProptestConfig::default() })]

    #[test]
    fn on_a_half_space_the_contact_is_the_nearest_sphere_of_the_barrel(pose in poses(), first in any::<bool>()) {
        let found = deepest(&*SharedShape::halfspace(Vector::Z), &to_f32(&pose), first);
        let expected = brute_force(&barrel(), &pose, |p| p.z);
        if expected < f64::from(PREDICTION_M) - EXACT_M {
            prop_assert!((f64::from(found.expect("within reach")) - expected).abs() < EXACT_M);
        }
    }

    #[test]
    fn on_a_box_the_contact_is_the_nearest_sphere_of_the_barrel(pose in poses(), first in any::<bool>()) {
        let half = Vector3::new(0.1, 0.08, 0.03);
        let pose = Translation3::new(0.0, 0.0, half.z) * pose;
        let axis = pose.rotation * Vector3::z();
        let buried = (-10..=10).any(|i| {
            let t = f64::from(i) / 10.0 * barrel().half_length_m;
            to_box(half, &(pose.translation.vector + t * axis)) < 0.0
        });
        // With its axis inside the box a roller is deeper than its own radius: no contact solver lets it come to that.
        prop_assume!(!buried);
        let ground = SharedShape::cuboid(half.x as Real, half.y as Real, half.z as Real);
        let found = deepest(&*ground, &to_f32(&pose), first);
        let expected = brute_force(&barrel(), &pose, |p| to_box(half, p));
        if expected < f64::from(PREDICTION_M) - SEARCHED_M {
            prop_assert!((f64::from(found.expect("within reach")) - expected).abs() < SEARCHED_M);
        }
    }

    #[test]
    fn on_a_triangle_the_contact_is_the_nearest_sphere_of_the_barrel(pose in poses(), first in any::<bool>()) {
        let v = [Vector3::new(-0.1, -0.1, 0.0), Vector3::new(0.12, -0.05, 0.01), Vector3::new(0.0, 0.11, -0.01)];
        let axis = pose.rotation * Vector3::z();
        let normal = (v[1] - v[0]).cross(&(v[2] - v[0])).normalize();
        let height = |t: f64| normal.dot(&(pose.translation.vector + t * axis - v[0]));
        let half = barrel().half_length_m;
        // A triangle has no inside: an axis that crosses its plane has no signed distance to hold it against.
        prop_assume!(height(half) * height(-half) > 0.0 && height(half).abs().min(height(-half).abs()) > 1e-4);
        let f = |p: &Vector3<f64>| Vector::new(p.x as Real, p.y as Real, p.z as Real);
        let ground = SharedShape::triangle(f(&v[0]), f(&v[1]), f(&v[2]));
        let found = deepest(&*ground, &to_f32(&pose), first);
        let expected = brute_force(&barrel(), &pose, |p| to_triangle(v, p));
        if expected < f64::from(PREDICTION_M) - SEARCHED_M {
            prop_assert!((f64::from(found.expect("within reach")) - expected).abs() < SEARCHED_M);
        }
    }
}

/// A turning wheel on each flat ground: the height at which its rollers just touch is rho, at every angle.
#[test]
fn the_outline_of_a_turning_wheel_is_round_on_every_flat_ground() {
    let wheel = support::wheel(
        Vector3::new(0.0, 0.0, 0.05),
        std::f64::consts::FRAC_PI_2,
        -std::f64::consts::FRAC_PI_4,
        9,
    );
    let flat = |n: usize| Array2::new(n, n, vec![0.0; n * n]);
    let square = [
        Vector::new(-0.5, -0.5, 0.0),
        Vector::new(0.5, -0.5, 0.0),
        Vector::new(0.5, 0.5, 0.0),
        Vector::new(-0.5, 0.5, 0.0),
    ];
    let mesh = SharedShape::trimesh_with_flags(
        square.to_vec(),
        vec![[0, 1, 2], [0, 2, 3]],
        TriMeshFlags::FIX_INTERNAL_EDGES,
    )
    .expect("two triangles make a mesh");
    let slab = SharedShape::cuboid(0.5, 0.5, 0.1);
    let below = |z: Real| Pose::from_parts(Vector::Z * z, Rotation::IDENTITY);
    // parry's height fields rise along y; a quarter turn about x brings y up to z.
    let upright = Pose::from_parts(
        Vector::ZERO,
        Rotation::from_rotation_x(std::f32::consts::FRAC_PI_2),
    );
    let grounds: Vec<(&str, SharedShape, Pose)> = vec![
        ("half-space", SharedShape::halfspace(Vector::Z), below(0.0)),
        ("box", slab.clone(), below(-0.1)),
        ("mesh", mesh, below(0.0)),
        (
            "compound",
            SharedShape::compound(vec![(below(-0.1), slab)]),
            below(0.0),
        ),
        (
            "height field",
            SharedShape::new(HeightField::with_flags(
                flat(9),
                Vector::new(1.0, 1.0, 1.0),
                HeightFieldFlags::FIX_INTERNAL_EDGES,
            )),
            upright,
        ),
    ];
    for (name, ground, world_from_ground) in grounds {
        let mut worst = 0.0f64;
        for step in 0..720 {
            let turned = Isometry3::rotation(Vector3::z() * f64::from(step).to_radians() * 0.5);
            let clearance = wheel
                .rollers
                .iter()
                .filter_map(|roller| {
                    let z = UnitQuaternion::rotation_between(&Vector3::z(), &roller.axis_in_hub)?;
                    let hub_from_roller = Isometry3::from_parts(roller.center_in_hub_m.into(), z);
                    let world_from_roller =
                        to_f32(&(wheel.body_from_hub * turned * hub_from_roller));
                    deepest(
                        &*ground,
                        &(world_from_ground.inverse() * world_from_roller),
                        false,
                    )
                })
                .min_by(Real::total_cmp)
                .expect("some roller is near");
            worst = worst.max(f64::from(clearance).abs());
        }
        println!("{name}: outline round to {worst:.1e} m");
        // f32 on coordinates of 0.05 m: ten roundings of 4e-9.
        assert!(worst < 1e-6, "{name}: the outline is off by {worst:.2e} m");
    }
}
