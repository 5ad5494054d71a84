//! One contact of a roller: the exact barrel against each kind of ground.

use divan::{Bencher, black_box};
use ilon_robot::Barrel;
use ilon_world::{RollerDispatcher, RollerShape};
use parry3d::math::{Pose, Rotation, Vector};
use parry3d::query::{ContactManifold, PersistentQueryDispatcher};
use parry3d::shape::{Cuboid, HalfSpace, HeightField, Shape, TriMesh};
use parry3d::utils::Array2;

fn main() {
    divan::main();
}

#[divan::bench]
fn half_space(bencher: Bencher) {
    bench(bencher, &HalfSpace::new(Vector::Z));
}

#[divan::bench]
fn cuboid(bencher: Bencher) {
    bench(bencher, &Cuboid::new(Vector::new(0.5, 0.5, 0.012)));
}

#[divan::bench]
fn height_field(bencher: Bencher) {
    // parry's height fields stand along y; a flat one will do, its cells are searched all the same.
    let heights = Array2::zeros(41, 41);
    bench(
        bencher,
        &HeightField::new(heights, Vector::new(1.0, 1.0, 1.0)),
    );
}

#[divan::bench]
fn triangle_mesh(bencher: Bencher) {
    let corner = |x: f32, y: f32| Vector::new(x, y, 0.0);
    let corners = vec![
        corner(-0.5, -0.5),
        corner(0.5, -0.5),
        corner(0.5, 0.5),
        corner(-0.5, 0.5),
    ];
    let mesh = TriMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).expect("two triangles are a mesh");
    bench(bencher, &mesh);
}

/// A roller of `mecanum4` lying on the ground, tilted by 10 degrees, a micrometre deep.
fn bench(bencher: Bencher, ground: &dyn Shape) {
    let barrel = Barrel::handing_over(0.05, 0.012, std::f64::consts::FRAC_PI_4, 9);
    let roller = RollerShape::new(&barrel);
    let lying = Rotation::from_rotation_y(80.0f32.to_radians());
    let pose = Pose::from_parts(Vector::new(0.1, 0.05, 0.012 - 1e-6), lying);
    let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
    let mut workspace = None;
    bencher.bench_local(|| {
        RollerDispatcher
            .contact_manifolds(
                black_box(&pose),
                ground,
                &roller,
                1e-3,
                &mut manifolds,
                &mut workspace,
            )
            .expect("the dispatcher knows this ground");
        manifolds.len()
    });
}
