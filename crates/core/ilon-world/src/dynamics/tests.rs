//! Trees against a dense reference, closed forms, and conservation laws.

use ilon_robot::MassProperties;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use super::*;

/// Random numbers between -1 and 1, the same in every run.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next())
    }

    fn pose(&mut self) -> Isometry3<f64> {
        let rotation = UnitQuaternion::new(2.0 * self.vector());
        Isometry3::from_parts((0.3 * self.vector()).into(), rotation)
    }

    fn mass(&mut self, at_its_center: bool) -> MassProperties {
        // Four points give a valid inertia on all axes.
        let parts: Vec<_> = (0..4)
            .map(|_| MassProperties::point(0.3 + 0.2 * self.next(), 0.2 * self.vector()))
            .collect();
        let mass = MassProperties::merged(&parts).expect("it weighs something");
        if at_its_center {
            MassProperties {
                center_of_mass_m: Vector3::zeros(),
                ..mass
            }
        } else {
            mass
        }
    }
}

/// A tree of two branches, with joints of both kinds and a chain of four.
fn branched(draw: &mut Draw) -> Tree {
    let parents = [None, Some(0), Some(1), Some(2), None, Some(4), Some(0)];
    let joints = parents
        .into_iter()
        .enumerate()
        .map(|(index, parent)| Joint {
            parent,
            motion: if index % 3 == 1 {
                Motion::Slides
            } else {
                Motion::Turns
            },
            parent_from_link: draw.pose(),
            mass: draw.mass(false),
            armature: 0.01 * (1.0 + draw.next()),
        });
    let joints = joints.collect();
    Tree::new(draw.mass(true), joints)
}

/// A tree with its pose and rates.
#[derive(Clone)]
struct Thrown {
    tree: Tree,
    floor_from_root: Isometry3<f64>,
    moved: Vec<f64>,
    rates: Vec<f64>,
}

impl Thrown {
    fn drawn(tree: Tree, draw: &mut Draw) -> Self {
        Self {
            floor_from_root: draw.pose(),
            moved: tree.joints().iter().map(|_| draw.next()).collect(),
            rates: (0..tree.dofs()).map(|_| draw.next()).collect(),
            tree,
        }
    }

    fn root(&self) -> LinkPose {
        LinkPose {
            center_m: self.floor_from_root.translation.vector,
            rotation: self
                .floor_from_root
                .rotation
                .to_rotation_matrix()
                .into_inner(),
        }
    }

    fn links(&self) -> Vec<LinkPose> {
        let mut links = vec![self.root(); self.moved.len()];
        self.tree.place(&self.root(), &self.moved, &mut links);
        links
    }

    /// Moves on with rates.
    fn moved_on(&self, rates: &[f64], dt_s: f64) -> Self {
        let mut next = self.clone();
        let at = &mut next.floor_from_root;
        at.translation.vector += dt_s * Vector3::from_column_slice(&rates[..3]);
        let turn = UnitQuaternion::new(dt_s * Vector3::from_column_slice(&rates[3..6]));
        at.rotation = turn * at.rotation;
        for (moved, rate) in next.moved.iter_mut().zip(&rates[6..]) {
            *moved += dt_s * rate;
        }
        next
    }

    /// All bodies, the root first, each with its pose and its mass.
    fn bodies(&self) -> Vec<(LinkPose, MassProperties)> {
        let links = self.links().into_iter().zip(self.tree.joints());
        let links = links.map(|(pose, joint)| (pose, joint.mass.clone()));
        [(self.root(), self.tree.root.clone())]
            .into_iter()
            .chain(links)
            .collect()
    }

    /// Centre of mass and rotation of each body.
    fn frames(&self) -> Vec<(Vector3<f64>, Matrix3<f64>)> {
        let bodies = self.bodies();
        let frame = |(pose, mass): &(LinkPose, MassProperties)| {
            (pose.place_m(&mass.center_of_mass_m), pose.rotation)
        };
        bodies.iter().map(frame).collect()
    }

    /// The velocity and the angular velocity of each body for given rates, by central differences
    /// of the poses.
    fn velocities(&self, rates: &[f64]) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        const H: f64 = 1e-5;
        let (ahead, behind) = (self.moved_on(rates, H), self.moved_on(rates, -H));
        let frames = ahead.frames().into_iter().zip(behind.frames());
        let of = |((a, ra), (b, rb)): ((_, Matrix3<f64>), (_, Matrix3<f64>))| {
            let turned = ra * rb.transpose();
            let skew = (turned - turned.transpose()) / 2.0;
            let angular = Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]) / (2.0 * H);
            let moved: Vector3<f64> = a - b;
            (moved / (2.0 * H), angular)
        };
        frames.map(of).collect()
    }

    /// Linear momentum and angular momentum about the floor's origin, and the kinetic energy.
    fn momenta(&self) -> (Vector3<f64>, Vector3<f64>, f64) {
        let mut sums = (Vector3::zeros(), Vector3::zeros(), 0.0);
        let velocities = self.velocities(&self.rates);
        for ((pose, mass), (v, w)) in self.bodies().into_iter().zip(velocities) {
            let at_m = pose.place_m(&mass.center_of_mass_m);
            let spin = pose.rotation * mass.inertia_kg_m2 * pose.rotation.transpose() * w;
            sums.0 += mass.mass_kg * v;
            sums.1 += mass.mass_kg * at_m.cross(&v) + spin;
            sums.2 += 0.5 * (mass.mass_kg * v.norm_squared() + w.dot(&spin));
        }
        for (joint, rate) in self.tree.joints().iter().zip(&self.rates[6..]) {
            sums.2 += 0.5 * joint.armature * rate * rate;
        }
        sums
    }

    /// The mass matrix, column by column from the bodies' velocities.
    fn dense(&self) -> DMatrix<f64> {
        let n = self.tree.dofs();
        let unit = |dof: usize| {
            (0..n)
                .map(|k| f64::from(u8::from(k == dof)))
                .collect::<Vec<_>>()
        };
        let columns: Vec<_> = (0..n).map(|dof| self.velocities(&unit(dof))).collect();
        DMatrix::from_fn(n, n, |i, j| {
            let bodies = self
                .bodies()
                .into_iter()
                .zip(columns[i].iter().zip(&columns[j]));
            let sum: f64 = bodies
                .map(|((pose, mass), ((vi, wi), (vj, wj)))| {
                    let inertia = pose.rotation * mass.inertia_kg_m2 * pose.rotation.transpose();
                    mass.mass_kg * vi.dot(vj) + wi.dot(&(inertia * wj))
                })
                .sum();
            let armature = if i == j && i >= 6 {
                self.tree.joints()[i - 6].armature
            } else {
                0.0
            };
            sum + armature
        })
    }

    fn mechanics(&self, held: &[f64]) -> Mechanics {
        let mut mechanics = Mechanics::of(&self.tree);
        mechanics.stand(&self.tree, &self.root(), &self.links(), held);
        mechanics
    }

    /// Accelerations with these rates where it stands.
    fn accelerations(&self, rates: &[f64], loads: &Loads, gravity: &Vector3<f64>) -> Vec<f64> {
        let mut mechanics = self.mechanics(&vec![0.0; self.moved.len()]);
        let mut forces = vec![0.0; self.tree.dofs()];
        mechanics.forces(&self.tree, rates, (loads, gravity), &mut forces);
        mechanics.factors().solve(&self.tree, &mut forces);
        forces
    }

    /// Takes a step like a world does in the air.
    fn step(&mut self, dt_s: f64, gravity: &Vector3<f64>) {
        let middle = self.moved_on(&self.rates.clone(), 0.5 * dt_s);
        let loads = Loads::none(&self.tree);
        let mut turning = self.rates.clone();
        for _ in 0..2 {
            let gains = middle.accelerations(&turning, &loads, gravity);
            for (mean, (before, gains)) in turning.iter_mut().zip(self.rates.iter().zip(&gains)) {
                *mean = before + 0.5 * dt_s * gains;
            }
        }
        let mut next = self.moved_on(&turning, dt_s);
        for (rate, mean) in next.rates.iter_mut().zip(&turning) {
            *rate = 2.0 * mean - *rate;
        }
        *self = next;
    }
}

/// The factors solve the mass matrix of the bodies, whose columns come from moving the tree
/// numerically.
#[test]
fn the_factors_are_those_of_the_bodies_mass_matrix() {
    let mut draw = Draw(1);
    for _ in 0..5 {
        let thrown = Thrown::drawn(branched(&mut draw), &mut draw);
        let n = thrown.tree.dofs();
        let held: Vec<f64> = (6..n).map(|_| 0.1 * (1.0 + draw.next())).collect();
        let mut dense = thrown.dense();
        for (joint, held) in held.iter().enumerate() {
            dense[(6 + joint, 6 + joint)] += held;
        }
        let mechanics = thrown.mechanics(&held);
        let b: Vec<f64> = (0..n).map(|_| draw.next()).collect();
        let mut x = b.clone();
        mechanics.factors().solve(&thrown.tree, &mut x);
        let back = &dense * DVector::from_column_slice(&x);
        for (found, b) in back.iter().zip(&b) {
            // Central differences of 1e-5 are right to 1e-10, times the solution, which is some 10.
            assert!((found - b).abs() < 1e-8, "{found} {b}");
        }
    }
}

/// Half solutions of sparse rows give the same products as full solutions.
#[test]
fn half_solutions_multiply_to_what_one_row_does_to_another() {
    let mut draw = Draw(2);
    let thrown = Thrown::drawn(branched(&mut draw), &mut draw);
    let mechanics = thrown.mechanics(&[0.05; 7]);
    let tree = &thrown.tree;
    let (n, factors) = (tree.dofs(), mechanics.factors());
    let mut row = |joint: Option<usize>| {
        let root = nalgebra::Vector6::from_fn(|_, _| draw.next());
        let shares: Vec<f64> = (0..7).map(|_| draw.next()).collect();
        let path = joint.map_or(Path::NONE, |joint| tree.path(joint, |at| shares[at]));
        let mut dense = vec![0.0; n];
        dense[..6].copy_from_slice(root.as_slice());
        for (joint, share) in path.iter() {
            dense[6 + joint] = share;
        }
        (root, path, dense)
    };
    let rows = [None, Some(3), Some(2), Some(5), Some(6), Some(0)].map(&mut row);
    for (root, path, dense) in &rows {
        let mut whole = dense.clone();
        factors.solve(tree, &mut whole);
        let mut half = (*root, *path);
        factors.halve(tree, &mut half.0, &mut half.1);
        let mut completed = vec![0.0; n];
        completed[..6].copy_from_slice(half.0.as_slice());
        for (joint, share) in half.1.iter() {
            completed[6 + joint] = share;
        }
        factors.complete(tree, &mut completed);
        for (a, b) in completed.iter().zip(&whole) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
        for (root, path, other) in &rows {
            let mut by = (*root, *path);
            factors.halve(tree, &mut by.0, &mut by.1);
            let product = half.0.dot(&by.0) + half.1.dot(&by.1);
            let expected: f64 = whole.iter().zip(other).map(|(x, b)| x * b).sum();
            assert!((product - expected).abs() < 1e-12, "{product} {expected}");
        }
    }
}

/// The forces of rotating frames are those of Lagrange's equations, d/dt (dT/dq') = M q'' + M' q':
/// with the computed accelerations, momentum and energy are conserved.
#[test]
fn accelerations_keep_the_momenta_and_the_energy() {
    const H: f64 = 1e-4;
    let mut draw = Draw(3);
    for _ in 0..5 {
        let thrown = Thrown::drawn(branched(&mut draw), &mut draw);
        let loads = Loads::none(&thrown.tree);
        let gains = thrown.accelerations(&thrown.rates, &loads, &Vector3::zeros());
        // A second-order motion on either side of the moment.
        let at = |t_s: f64| {
            let means: Vec<f64> = (thrown.rates.iter().zip(&gains))
                .map(|(rate, gains)| rate + 0.5 * t_s * gains)
                .collect();
            let mut then = thrown.moved_on(&means, t_s);
            for (rate, gains) in then.rates.iter_mut().zip(&gains) {
                *rate += t_s * gains;
            }
            then.momenta()
        };
        let (ahead, behind) = (at(H), at(-H));
        // Central differences: of second order in H, on top of the rounding of the velocities,
        // 1e-11 / H.
        let most = 1e-5;
        assert!((ahead.0 - behind.0).norm() / (2.0 * H) < most);
        assert!((ahead.1 - behind.1).norm() / (2.0 * H) < most);
        assert!((ahead.2 - behind.2).abs() / (2.0 * H) < most);
    }
}

/// The change of a thrown tree's angular momentum and energy in a second.
fn lost(dt_s: f64) -> (f64, f64) {
    let mut draw = Draw(4);
    let mut thrown = Thrown::drawn(branched(&mut draw), &mut draw);
    let (_, from, from_j) = thrown.momenta();
    for _ in 0..(1.0 / dt_s).round() as usize {
        thrown.step(dt_s, &Vector3::zeros());
    }
    let (_, to, to_j) = thrown.momenta();
    (
        (to - from).norm() / from.norm(),
        (to_j - from_j).abs() / from_j,
    )
}

/// Half the step, a quarter of the error.
#[test]
fn a_thrown_tree_keeps_angular_momentum_and_energy_to_second_order() {
    let (coarse, fine) = (lost(2e-3), lost(1e-3));
    println!("{coarse:?} {fine:?}");
    for (coarse, fine) in [(coarse.0, fine.0), (coarse.1, fine.1)] {
        assert!(coarse < 1e-4, "{coarse:.1e}");
        assert!((coarse / fine - 4.0).abs() < 0.4, "{coarse:.2e} {fine:.2e}");
    }
}

/// A body so heavy that bodies on it do not move it.
fn anchored(joints: Vec<Joint>) -> Tree {
    let root = MassProperties {
        mass_kg: 1e12,
        center_of_mass_m: Vector3::zeros(),
        inertia_kg_m2: Matrix3::identity() * 1e12,
    };
    Tree::new(root, joints)
}

/// A joint about the floor's y axis at a place of its parent, with a point mass below it.
fn swinging(parent: Option<usize>, below_m: f64, mass_kg: f64, length_m: f64) -> Joint {
    // Its z along y, its y down: z cross x is y.
    let axes = Matrix3::from_columns(&[-Vector3::x(), -Vector3::z(), -Vector3::y()]);
    let rotation = match parent {
        None => UnitQuaternion::from_matrix(&axes),
        Some(_) => UnitQuaternion::identity(),
    };
    Joint {
        parent,
        motion: Motion::Turns,
        parent_from_link: Isometry3::from_parts(Translation3::new(0.0, below_m, 0.0), rotation),
        mass: MassProperties::point(mass_kg, Vector3::new(0.0, length_m, 0.0)),
        armature: 0.0,
    }
}

/// A mathematical pendulum at an angle: q'' = -(g / l) sin q.
#[test]
fn a_pendulum_falls_as_it_should() {
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let tree = anchored(vec![swinging(None, 0.0, 0.7, 0.4)]);
    for angle_rad in [0.01, 0.6, 2.0] {
        let hanging = Thrown {
            floor_from_root: Isometry3::identity(),
            moved: vec![angle_rad],
            rates: vec![0.0; 7],
            tree: tree.clone(),
        };
        // The root is held against gravity.
        let mut loads = Loads::none(&tree);
        loads.force_on_root_n = -gravity * 1e12;
        let gains = hanging.accelerations(&hanging.rates, &loads, &gravity);
        let expected = -9.81 / 0.4 * libm::sin(angle_rad);
        // The force of 1e13 N is rounded to 1e-3 N, which is negligible for 1e12 kg.
        assert!(
            (gains[6] / expected - 1.0).abs() < 1e-9,
            "{gains:?} {expected}"
        );
    }
}

/// A double pendulum of equal masses and lengths has w^2 = (2 -+ sqrt 2) g / l: its accelerations
/// at small angles in either mode are -w^2 times the angles. The modes are 1 : +-sqrt 2 of the
/// angles to the vertical.
#[test]
fn a_double_pendulum_has_its_two_frequencies() {
    let (g, l) = (9.81, 0.3);
    let gravity = Vector3::new(0.0, 0.0, -g);
    let tree = anchored(vec![
        swinging(None, 0.0, 0.5, l),
        swinging(Some(0), l, 0.5, l),
    ]);
    for sign in [1.0, -1.0] {
        let (first, second) = (1e-6, sign * 2.0_f64.sqrt() * 1e-6);
        let hanging = Thrown {
            floor_from_root: Isometry3::identity(),
            moved: vec![first, second - first],
            rates: vec![0.0; 8],
            tree: tree.clone(),
        };
        let mut loads = Loads::none(&tree);
        loads.force_on_root_n = -gravity * 1e12;
        let gains = hanging.accelerations(&hanging.rates, &loads, &gravity);
        let square = (2.0 - sign * 2.0_f64.sqrt()) * g / l;
        assert!(
            (gains[6] / (-square * first) - 1.0).abs() < 1e-8,
            "{gains:?}"
        );
        assert!(
            (gains[7] / (-square * (second - first)) - 1.0).abs() < 1e-8,
            "{gains:?}"
        );
    }
}

/// A fast disc on a resting body is tilted: the torque that turns its axis is w x (I s),
/// perpendicular to both.
#[test]
fn a_gyroscope_asks_for_the_torque_that_turns_its_axis() {
    let (along, across) = (2e-3, 1.1e-3);
    let disc = MassProperties {
        mass_kg: 0.4,
        center_of_mass_m: Vector3::zeros(),
        inertia_kg_m2: Matrix3::from_diagonal(&Vector3::new(across, across, along)),
    };
    let tree = anchored(vec![Joint {
        parent: None,
        motion: Motion::Turns,
        parent_from_link: Isometry3::identity(),
        mass: disc,
        armature: 0.0,
    }]);
    let (spins, tilts) = (300.0, 0.7);
    let thrown = Thrown {
        floor_from_root: Isometry3::identity(),
        moved: vec![0.4],
        rates: vec![0.0, 0.0, 0.0, tilts, 0.0, 0.0, spins],
        tree: tree.clone(),
    };
    let mut mechanics = thrown.mechanics(&[0.0]);
    let mut forces = vec![0.0; 7];
    let loads = Loads::none(&tree);
    mechanics.forces(
        &tree,
        &thrown.rates,
        (&loads, &Vector3::zeros()),
        &mut forces,
    );
    // x cross z is -y: the remaining torque on the root is the opposite of the disc's.
    let expected = along * spins * tilts;
    assert!(
        (forces[4] - expected).abs() < 1e-12 * expected,
        "{forces:?}"
    );
    assert!(forces[3].abs() < 1e-12 && forces[5].abs() < 1e-12 && forces[6].abs() < 1e-12);
}
