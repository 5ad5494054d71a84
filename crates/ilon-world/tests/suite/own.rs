//! Bodies of a program's own, which rapier moves: pushed, hit and carried by a robot, and what they do to it.

use ilon_world::rapier3d::prelude::*;
use ilon_world::{Floor, Push, World};
use nalgebra::Vector3;

use crate::free::{hold, robot, world};

const G: f64 = 9.81;
/// Half of the length of the robot's chassis, and the height of its upper side.
const FRONT_M: f64 = 0.2;
const TOP_M: f32 = 0.11;

/// A cube of one's own, at rest.
fn cube(world: &mut World, side_m: f32, mass_kg: f32, at: [f32; 3]) -> RigidBodyHandle {
    put(world, side_m, mass_kg, at, 0.5)
}

fn put(
    world: &mut World,
    side_m: f32,
    mass_kg: f32,
    [x, y, z]: [f32; 3],
    friction: f32,
) -> RigidBodyHandle {
    let half_m = 0.5 * side_m;
    let body = RigidBodyBuilder::dynamic().translation(Vector::new(x, y, z));
    let collider = ColliderBuilder::cuboid(half_m, half_m, half_m)
        .mass(mass_kg)
        .friction(friction);
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    rapier.insert(body, collider).0
}

fn body(world: &World, handle: RigidBodyHandle) -> &RigidBody {
    &world.rapier().expect("it was asked for").bodies[handle]
}

/// What the wheels carry, in N.
fn loads_n(world: &World) -> f64 {
    world.robot().support().wheels_n
}

/// What the balance of energy misses, in J: what came in less what is stored and what was lost.
fn missing_j(world: &World, before_j: f64) -> f64 {
    let energy = world.energy();
    let stored_j = energy.kinetic_j + energy.potential_j - before_j;
    let lost_j = world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.impact_energy_j()
        + world.bearing_energy_j();
    world.motor_energy_j() + world.outside_energy_j() - stored_j - lost_j
}

/// On ice both have after the hit what the robot had before it, and go on together: nothing bounces. rapier keeps velocities in f32, 6e-8 of them.
#[test]
fn a_robot_hits_a_body_of_ones_own_and_momentum_stays() {
    let floor = Floor {
        friction: 0.0,
        ..Floor::default()
    };
    for (dt_s, mass_kg) in [(1e-3, 3.0_f32), (2e-3, 30.0), (5e-4, 0.2)] {
        let mut world = world(&floor, dt_s);
        let id = put(&mut world, 0.12, mass_kg, [0.4, 0.0, 0.06], 0.0);
        let robot_kg = robot().mass_kg();
        for _ in 0..(0.1 / dt_s) as usize {
            world.robot_mut().push(&Push {
                force_in_world_n: Vector3::new(robot_kg * 5.0, 0.0, 0.0),
                place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
            });
            world.step();
        }
        let before_m_s = world.robot().state().twist_in_body.vx_m_s;
        for _ in 0..(0.8 / dt_s) as usize {
            world.step();
        }
        let robot_m_s = world.robot().state().twist_in_body.vx_m_s;
        let body_m_s = f64::from(body(&world, id).linvel().x);
        let mass_kg = f64::from(body(&world, id).mass());
        let after = robot_kg * robot_m_s + mass_kg * body_m_s;
        let share = after / (robot_kg * before_m_s);
        println!("{dt_s} {mass_kg}: {share} robot {robot_m_s} body {body_m_s}");
        assert!((share - 1.0).abs() < 1e-5, "{share}");
        let together_m_s = robot_kg * before_m_s / (robot_kg + mass_kg);
        assert!(
            (body_m_s / together_m_s - 1.0).abs() < 0.01,
            "{body_m_s} {together_m_s}"
        );
    }
}

/// Pushed at a steady speed, a box takes mu m g, and that times the way is what went outside.
#[test]
fn pushing_a_body_of_ones_own_takes_its_friction() {
    for (dt_s, friction, mass_kg) in [(1e-3, 0.3_f32, 2.0_f32), (2e-3, 0.2, 4.0)] {
        let mut world = world(&Floor::default(), dt_s);
        let before_j = world.energy().kinetic_j + world.energy().potential_j;
        let id = put(&mut world, 0.2, mass_kg, [0.31, 0.0, 0.1], friction);
        let steps = (1.0 / dt_s) as usize;
        for _ in 0..steps {
            hold(&mut world, 4.0);
            world.step();
        }
        let (from_m, from_j) = (body(&world, id).translation().x, world.outside_energy_j());
        let mut force_n = 0.0;
        for _ in 0..steps {
            hold(&mut world, 4.0);
            world.step();
            force_n += world.force_on_own_n(id).x / steps as f64;
        }
        let way_m = f64::from(body(&world, id).translation().x - from_m);
        let work_j = from_j - world.outside_energy_j();
        let expected_n = f64::from(friction * mass_kg) * G;
        println!(
            "{dt_s}: {} of {expected_n} N, {force_n}, missing {}",
            work_j / way_m,
            missing_j(&world, before_j)
        );
        assert!(way_m > 0.15, "{way_m}");
        assert!((work_j / way_m / expected_n - 1.0).abs() < 0.02);
    }
}

/// What lies on the robot's deck is carried by its wheels.
#[test]
fn a_body_of_ones_own_on_the_deck_adds_its_weight() {
    for (dt_s, mass_kg) in [(1e-3, 3.0_f32), (2e-3, 0.5), (5e-4, 20.0)] {
        let mut world = world(&Floor::default(), dt_s);
        let alone_n = robot().mass_kg() * G;
        let id = cube(&mut world, 0.1, mass_kg, [0.05, 0.02, TOP_M + 0.05]);
        let steps = (0.5 / dt_s) as usize;
        let (mut sum_n, mut least_n, mut most_n) = (0.0, f64::INFINITY, 0.0_f64);
        for step in 0..2 * steps {
            hold(&mut world, 0.0);
            world.step();
            if step >= steps {
                let load_n = loads_n(&world) - alone_n;
                sum_n += load_n / steps as f64;
                least_n = least_n.min(load_n);
                most_n = most_n.max(load_n);
            }
        }
        let expected_n = f64::from(body(&world, id).mass()) * G;
        let (v, w) = (body(&world, id).linvel(), body(&world, id).angvel());
        println!(
            "{dt_s} {mass_kg}: {sum_n} of {expected_n}, {least_n} to {most_n}; {v:?} {w:?} {:?} sleeping {}",
            body(&world, id).translation(),
            body(&world, id).is_sleeping()
        );
        assert!((sum_n / expected_n - 1.0).abs() < 0.01);
        assert!(least_n > 0.97 * expected_n && most_n < 1.03 * expected_n);
    }
}
