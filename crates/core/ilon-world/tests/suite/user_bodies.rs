//! User bodies, which rapier moves: pushed, hit and carried by a robot, and their effect on it.

use ilon_robot::{Pose as PlanarPose, Tread, Twist};
use ilon_world::rapier3d::prelude::*;
use ilon_world::{Floor, Push, World};
use nalgebra::Vector3;

use crate::free::{hold, robot, world};
use crate::support::ideal_rates;

const G: f64 = 9.81;
/// Half of the length of the robot's chassis, and the height of its upper side.
const FRONT_M: f64 = 0.2;
const TOP_M: f64 = 0.11;

/// A user's cube, at rest.
fn cube(world: &mut World, side_m: f64, mass_kg: f64, at: [f64; 3]) -> RigidBodyHandle {
    put(world, side_m, mass_kg, at, 0.5)
}

fn put(
    world: &mut World,
    side_m: f64,
    mass_kg: f64,
    [x, y, z]: [f64; 3],
    friction: f64,
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

/// Load of the wheels, in N.
fn loads_n(world: &World) -> f64 {
    world.robot().support().wheels_n
}

/// The error of the energy balance, in J: what came in less the storage and the losses.
fn missing_j(world: &World, before_j: f64) -> f64 {
    let energy = world.energy();
    let stored_j = energy.kinetic_j + energy.potential_j - before_j;
    let lost_j = world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.impact_energy_j()
        + world.bearing_energy_j();
    world.motor_energy_j() + world.outside_energy_j() - stored_j - lost_j
}

/// On ice both have after the impact the robot's momentum before it, and nothing bounces: they
/// separate at most as fast as ilon pushes out penetrations, 5 mm/s.
#[test]
fn a_robot_hits_a_body_of_ones_own_and_momentum_stays() {
    let floor = Floor {
        friction: 0.0,
        ..Floor::default()
    };
    for (dt_s, mass_kg) in [(1e-3, 3.0), (2e-3, 30.0), (5e-4, 0.2)] {
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
        let body_m_s = body(&world, id).linvel().x;
        let mass_kg = body(&world, id).mass();
        let after = robot_kg * robot_m_s + mass_kg * body_m_s;
        let share = after / (robot_kg * before_m_s);
        println!("{dt_s} {mass_kg}: {share} robot {robot_m_s} body {body_m_s}");
        assert!((share - 1.0).abs() < 1e-5, "{share}");
        assert!(body_m_s > 0.1, "it was hit");
        let parts_m_s = body_m_s - robot_m_s;
        assert!((0.0..5.5e-3).contains(&parts_m_s), "{parts_m_s}");
    }
}

/// Adds a box with friction on the floor and a frictionless back, which the robot pushes.
fn with_slippery_back(world: &mut World, mass_kg: f64, x_m: f64, friction: f64) -> RigidBodyHandle {
    let id = put(world, 0.2, mass_kg, [x_m, 0.0, 0.1], friction);
    let back = ColliderBuilder::cuboid(0.005, 0.1, 0.05)
        .translation(Vector::new(-0.105, 0.0, 0.0))
        .density(0.0)
        .friction(0.0);
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    rapier.insert_collider(back, Some(id));
    id
}

/// Pushed at a constant speed, a box takes mu m g, and that times the way is external work. There
/// is no friction between its back and the robot, which would change its load. This holds in each
/// step: rapier finds friction in a few iterations, to thousandths.
#[test]
fn pushing_a_body_of_ones_own_takes_its_friction() {
    for (dt_s, friction, mass_kg) in [(1e-3, 0.3, 2.0), (2e-3, 0.2, 4.0)] {
        let mut world = world(&Floor::default(), dt_s);
        let before_j = world.energy().kinetic_j + world.energy().potential_j;
        let id = with_slippery_back(&mut world, mass_kg, FRONT_M + 0.12, friction);
        let steps = (1.0 / dt_s) as usize;
        for _ in 0..steps {
            hold(&mut world, 4.0);
            world.step();
        }
        let (from_m, from_j) = (body(&world, id).translation().x, world.outside_energy_j());
        let mut force_n = 0.0;
        let expected_n = friction * mass_kg * G;
        for _ in 0..steps {
            hold(&mut world, 4.0);
            world.step();
            let of_step_n = world.force_on_user_body_n(id).x;
            assert!((of_step_n / expected_n - 1.0).abs() < 0.01, "{of_step_n}");
            force_n += of_step_n / steps as f64;
        }
        let way_m = body(&world, id).translation().x - from_m;
        let work_j = from_j - world.outside_energy_j();
        println!(
            "{dt_s}: {} of {expected_n} N, {force_n}, missing {}",
            work_j / way_m,
            missing_j(&world, before_j)
        );
        assert!(way_m > 0.15, "{way_m}");
        assert!((work_j / way_m / expected_n - 1.0).abs() < 0.02);
    }
}

/// A body on the robot's deck is carried by its wheels.
#[test]
fn a_body_of_ones_own_on_the_deck_adds_its_weight() {
    for (dt_s, mass_kg) in [(1e-3, 3.0), (2e-3, 0.5), (5e-4, 20.0)] {
        let mut world = world(&Floor::default(), dt_s);
        let alone_n = robot().mass_kg() * G;
        let id = cube(&mut world, 0.1, mass_kg, [0.05, 0.02, TOP_M + 0.05]);
        let steps = (0.5 / dt_s) as usize;
        let (mut sum_n, mut least_n, mut most_n) = (0.0, f64::INFINITY, 0.0);
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
        let expected_n = body(&world, id).mass() * G;
        let (v, w) = (body(&world, id).linvel(), body(&world, id).angvel());
        println!(
            "{dt_s} {mass_kg}: {sum_n} of {expected_n}, {least_n} to {most_n}; {v:?} {w:?} {:?} sleeping {}",
            body(&world, id).translation(),
            body(&world, id).is_sleeping()
        );
        // A step is solved to 1e-8 m/s, and starts from one that was: twice that of the momentum of
        // both, and as much again.
        let within_n = 4e-8 * (robot().mass_kg() + mass_kg) / dt_s;
        assert!((sum_n - expected_n).abs() < within_n);
        assert!(least_n > expected_n - within_n && most_n < expected_n + within_n);
    }
}

/// Two boxes on a joint, of which the robot pushes one: it takes the friction of both.
#[test]
fn a_joint_of_rapier_takes_the_other_body_along() {
    for dt_s in [1e-3, 2e-3] {
        let mut world = world(&Floor::default(), dt_s);
        // The joint may move weight from one to the other: with equal frictions, their sum stays.
        let near = with_slippery_back(&mut world, 2.0, FRONT_M + 0.12, 0.25);
        let far = put(&mut world, 0.2, 3.0, [FRONT_M + 0.42, 0.0, 0.1], 0.25);
        let joint = RevoluteJointBuilder::new(Vector::Y)
            .local_anchor1(Vector::new(0.15, 0.0, 0.0))
            .local_anchor2(Vector::new(-0.15, 0.0, 0.0));
        let rapier = world.rapier_mut().expect("ilon solves the contacts");
        rapier.insert_impulse_joint(near, far, joint);
        let steps = (1.0 / dt_s) as usize;
        let (mut force_n, mut from_m) = (0.0, 0.0);
        for step in 0..2 * steps {
            hold(&mut world, 4.0);
            world.step();
            if step >= steps {
                force_n += world.force_on_user_body_n(near).x / steps as f64;
            } else {
                from_m = body(&world, far).translation().x;
            }
        }
        let expected_n = 0.25 * 5.0 * G;
        let way_m = body(&world, far).translation().x - from_m;
        println!("{dt_s}: {force_n} of {expected_n}, {way_m} m");
        assert!((force_n / expected_n - 1.0).abs() < 0.02 && way_m > 0.15);
    }
}

/// A wall moved by a program takes a freely rolling robot along; a fixed one stops it.
#[test]
fn what_is_fixed_or_moved_by_a_program_pushes_robots() {
    let wall = || ColliderBuilder::cuboid(0.05, 0.3, 0.2).friction(0.0);
    let behind = Vector::new(-FRONT_M - 0.051, 0.0, 0.2);
    for by_position in [false, true] {
        let mut world = world(&Floor::default(), 1e-3);
        let rapier = world.rapier_mut().expect("ilon solves the contacts");
        let moved = if by_position {
            RigidBodyBuilder::kinematic_position_based()
        } else {
            RigidBodyBuilder::kinematic_velocity_based().linvel(Vector::new(0.2, 0.0, 0.0))
        };
        let (id, _) = rapier.insert(moved.translation(behind), wall());
        let before_j = world.energy().kinetic_j + world.energy().potential_j;
        for step in 0..1500 {
            if by_position {
                let rapier = world.rapier_mut().expect("ilon solves the contacts");
                let next = behind + Vector::new(2e-4 * (step + 1) as f64, 0.0, 0.0);
                rapier.bodies[id].set_next_kinematic_translation(next);
            }
            world.step();
        }
        let state = world.robot().state();
        let at_m = body(&world, id).translation().x + 0.05 + FRONT_M;
        println!(
            "{by_position}: {state:?} {at_m} {}",
            missing_j(&world, before_j)
        );
        assert!((state.twist_in_body.vx_m_s - 0.2).abs() < 6e-3);
        assert!((-1e-5..5e-3).contains(&(state.pose.x_m - at_m)));
        assert!(missing_j(&world, before_j).abs() < 1e-3);
    }
    for with_body in [false, true] {
        let mut world = world(&Floor::default(), 1e-3);
        let before_j = world.energy().kinetic_j + world.energy().potential_j;
        let rapier = world.rapier_mut().expect("ilon solves the contacts");
        let ahead = Vector::new(FRONT_M + 0.25, 0.0, 0.2);
        if with_body {
            rapier.insert(RigidBodyBuilder::fixed().translation(ahead), wall());
        } else {
            rapier.insert_collider(wall().translation(ahead), None);
        }
        for _ in 0..2500 {
            hold(&mut world, 4.0);
            world.step();
        }
        let state = world.robot().state();
        println!(
            "{with_body}: {} m/s at {}, missing {}",
            state.twist_in_body.vx_m_s,
            state.pose.x_m,
            missing_j(&world, before_j)
        );
        assert!((state.pose.x_m - 0.2).abs() < 1e-4 && state.twist_in_body.vx_m_s.abs() < 1e-3);
        assert!(missing_j(&world, before_j).abs() < 0.01);
    }
}

/// All readable values of a robot and of the user bodies, as bits.
fn bits(world: &World) -> Vec<u64> {
    let pose = world.robot().state().pose;
    let mut all = [
        pose.x_m,
        pose.y_m,
        pose.heading_rad,
        world.slip_energy_j(),
        world.outside_energy_j(),
    ]
    .map(f64::to_bits)
    .to_vec();
    for (_, body) in world
        .rapier()
        .into_iter()
        .flat_map(|rapier| rapier.rigid_bodies())
    {
        let (at, v) = (body.translation(), body.linvel());
        let of = [at.x, at.y, at.z, v.x, v.y, v.z];
        all.extend(of.map(|x| x.to_bits()));
    }
    all
}

/// A copy continues identically to the bit, with bodies on the robot and bodies that it pushes.
#[test]
fn copies_with_bodies_of_ones_own_are_equal_to_the_bit() {
    let mut world = world(&Floor::default(), 1e-3);
    cube(&mut world, 0.1, 1.0, [0.05, 0.0, TOP_M + 0.05]);
    cube(&mut world, 0.1, 1.0, [0.0, 0.0, TOP_M + 0.151]);
    put(&mut world, 0.15, 2.0, [FRONT_M + 0.1, 0.02, 0.075], 0.3);
    let run = |world: &mut World, steps: usize| {
        for _ in 0..steps {
            hold(world, 4.0);
            world.step();
        }
    };
    run(&mut world, 400);
    let mut copy = world.clone();
    run(&mut world, 400);
    run(&mut copy, 400);
    assert_eq!(bits(&world), bits(&copy));
}

/// A world with a rapier world, and one with bodies far away, move the robot to the bit as if
/// alone.
#[test]
fn what_is_far_away_changes_nothing() {
    let mut worlds = [(); 3].map(|()| world(&Floor::default(), 1e-3));
    worlds[1].rapier_mut().expect("ilon solves the contacts");
    cube(&mut worlds[2], 0.1, 1.0, [0.0, 5.0, 0.05]);
    for _ in 0..600 {
        for world in &mut worlds {
            hold(world, 5.0);
            world.step();
        }
        let [alone, asked, beside] = [0, 1, 2].map(|k| worlds[k].robot().state());
        assert_eq!(alone, asked);
        assert_eq!(alone, beside);
    }
    assert_eq!(worlds[0].slip_energy_j(), worlds[2].slip_energy_j());
}

/// Rollers with treads on a user's plate deflect as on the ground: a robot pushed to the side moves
/// by the deflection of its treads and of its wheels' loops, equal on both.
#[test]
fn treads_bend_on_a_plate_of_ones_own_as_on_the_ground() {
    let mut robot = robot();
    for wheel in &mut robot.wheels {
        wheel.surface.tread = Some(Tread::new(2e5));
    }
    let moves_m = [false, true].map(|on_plate| {
        let settings = crate::free::settings(1e-3);
        let mut world = World::new(&robot, &Floor::default(), PlanarPose::default(), &settings)
            .expect("it stands");
        if on_plate {
            let rapier = world.rapier_mut().expect("ilon solves the contacts");
            let plate = ColliderBuilder::cuboid(1.0, 1.0, 0.05)
                .translation(Vector::new(0.0, 0.0, -0.0495))
                .friction(0.6);
            rapier.insert_collider(plate, None);
        }
        let run = |world: &mut World, force_n: f64| {
            for _ in 0..400 {
                world.robot_mut().push(&Push {
                    force_in_world_n: Vector3::new(0.0, force_n, 0.0),
                    place_in_body_m: Vector3::new(0.0, 0.0, 0.05),
                });
                hold(world, 0.0);
                world.step();
            }
            world.robot().state().pose.y_m
        };
        // It is put half a millimetre into the plate, and hops.
        run(&mut world, 0.0);
        run(&mut world, 0.0);
        let from_m = run(&mut world, 0.0);
        let by_m = run(&mut world, 10.0) - from_m;
        let later_m = run(&mut world, 10.0) - from_m;
        println!(
            "{from_m:e}: {by_m:e} m, {later_m:e} m, {:?}",
            world.robot().state()
        );
        [by_m, later_m]
    });
    for [on_ground_m, on_plate_m] in [0, 1].map(|k| moves_m.map(|of| of[k])) {
        assert!(on_ground_m > 1e-5);
        assert!((on_plate_m / on_ground_m - 1.0).abs() < 0.01);
    }
}

/// A body removed between two steps has no effect any more, and one added inside the robot is
/// pushed out, slowly.
#[test]
fn bodies_may_vanish_and_appear_anywhere() {
    let mut world = world(&Floor::default(), 1e-3);
    let alone_n = robot().mass_kg() * G;
    let id = cube(&mut world, 0.1, 5.0, [0.0, 0.0, TOP_M + 0.05]);
    let run = |world: &mut World, steps: usize| {
        let mut fastest_m_s = 0.0_f64;
        for _ in 0..steps {
            hold(world, 0.0);
            world.step();
            let twist = world.robot().state().twist_in_body;
            fastest_m_s = fastest_m_s.max(twist.vx_m_s.abs() + twist.vy_m_s.abs());
        }
        fastest_m_s
    };
    run(&mut world, 200);
    assert!((loads_n(&world) - alone_n - 5.0 * G).abs() < 0.1);
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    rapier.remove_body(id);
    run(&mut world, 100);
    assert!((loads_n(&world) - alone_n).abs() < 1e-3);
    assert_eq!(world.force_on_user_body_n(id), Vector3::zeros());
    for at in [
        [0.0, 0.0, 0.06],
        [0.15, 0.0, 0.06],
        [0.0, 0.0, TOP_M],
        [0.15, 0.16, 0.05],
    ] {
        let mut world = world.clone();
        let id = cube(&mut world, 0.1, 1.0, at);
        let fastest_m_s = run(&mut world, 1000);
        let to = body(&world, id).translation();
        println!("{at:?}: robot {fastest_m_s} m/s, body at {to:?}");
        assert!(fastest_m_s < 0.1 && to.is_finite());
    }
}

/// A body without mass, and one with locked axes, stop a robot like a wall; a sensor, a disabled
/// body or one without a common group does not.
#[test]
fn what_nothing_moves_stops_a_robot_and_what_is_not_there_does_not() {
    let ahead = Vector::new(FRONT_M + 0.25, 0.0, 0.2);
    let wall = || ColliderBuilder::cuboid(0.05, 0.3, 0.2).friction(0.0);
    let dynamic = || RigidBodyBuilder::dynamic().translation(ahead);
    let bodies: [(&str, RigidBodyBuilder, ColliderBuilder, bool); 8] = [
        (
            "no mass",
            dynamic().gravity_scale(0.0),
            wall().density(0.0),
            true,
        ),
        (
            "locked",
            dynamic().lock_translations().lock_rotations(),
            wall().mass(2.0),
            true,
        ),
        (
            "locked along x",
            dynamic()
                .locked_axes(LockedAxes::TRANSLATION_LOCKED_X | LockedAxes::ROTATION_LOCKED)
                .gravity_scale(0.0),
            wall().mass(2.0),
            true,
        ),
        (
            "in two parts",
            RigidBodyBuilder::fixed().translation(ahead),
            ColliderBuilder::compound(vec![
                (
                    Pose::from_translation(Vector::new(0.0, 0.2, 0.0)),
                    SharedShape::cuboid(0.05, 0.1, 0.2),
                ),
                (
                    Pose::from_translation(Vector::new(0.0, -0.2, 0.0)),
                    SharedShape::cuboid(0.05, 0.2, 0.2),
                ),
            ]),
            true,
        ),
        (
            "mesh",
            RigidBodyBuilder::fixed().translation(ahead),
            {
                let (points, triangles) = Cuboid::new(Vector::new(0.05, 0.3, 0.2)).to_trimesh();
                ColliderBuilder::trimesh(points, triangles)
                    .expect("a box")
                    .friction(0.0)
            },
            true,
        ),
        (
            "sensor",
            RigidBodyBuilder::fixed().translation(ahead),
            wall().sensor(true),
            false,
        ),
        (
            "off",
            RigidBodyBuilder::fixed().translation(ahead).enabled(false),
            wall(),
            false,
        ),
        (
            "no group",
            RigidBodyBuilder::fixed().translation(ahead),
            wall().collision_groups(InteractionGroups::none()),
            false,
        ),
    ];
    for (name, body, collider, stops) in bodies {
        let mut world = world(&Floor::default(), 1e-3);
        let rapier = world.rapier_mut().expect("ilon solves the contacts");
        rapier.insert(body, collider);
        for _ in 0..2500 {
            hold(&mut world, 4.0);
            world.step();
        }
        let state = world.robot().state();
        println!(
            "{name}: {} m/s at {}",
            state.twist_in_body.vx_m_s, state.pose.x_m
        );
        if stops {
            assert!((state.pose.x_m - 0.2).abs() < 1e-3, "{name}: {state:?}");
        } else {
            assert!(state.pose.x_m > 0.4, "{name}: {state:?}");
        }
    }
}

/// A soft body of rapier touches no robot: one that is pinned in place lets a robot through, which
/// moves to the bit as if alone.
#[test]
fn a_soft_body_does_not_touch_a_robot() {
    let mut worlds = [(); 2].map(|()| world(&Floor::default(), 1e-3));
    let ahead = Vector::new(FRONT_M + 0.03, 0.0, 0.08);
    let soft = SoftBodyBuilder::cuboid(ahead, Vector::splat(0.02), 2, 2, 2);
    let rapier = worlds[1].rapier_mut().expect("ilon solves the contacts");
    rapier.insert_soft_body(soft.pinned_particles(0..8));
    for _ in 0..300 {
        for world in &mut worlds {
            hold(world, 5.0);
            world.step();
        }
    }
    let [alone, beside] = [0, 1].map(|k| worlds[k].robot().state());
    assert!(alone.pose.x_m > 0.05, "{} m", alone.pose.x_m);
    assert_eq!(alone, beside);
}

/// A disabled wall has no effect from the next step on: the robot that its wheels press against it
/// with F gains F dt / m.
#[test]
fn a_wall_that_is_switched_off_lets_go_in_the_next_step() {
    const DT_S: f64 = 1e-3;
    let mut world = world(&Floor::default(), DT_S);
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    let ahead = RigidBodyBuilder::fixed().translation(Vector::new(FRONT_M + 0.06, 0.0, 0.2));
    let wall = ColliderBuilder::cuboid(0.05, 0.3, 0.2).friction(0.0);
    let (wall, _) = rapier.insert(ahead, wall);
    let presses_n_m = 0.3;
    let press = |world: &mut World| {
        let ahead = ideal_rates(&robot(), Twist::new(1.0, 0.0, 0.0));
        let torques: Vec<f64> = ahead
            .iter()
            .map(|rate| presses_n_m * rate.signum())
            .collect();
        world.robot_mut().apply(&torques);
        world.step();
        world.robot().state().twist_in_body.vx_m_s
    };
    let speeds: Vec<f64> = (0..1000).map(|_| press(&mut world)).collect();
    assert!(speeds[999].abs() < 1e-6, "{} m/s at the wall", speeds[999]);
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    rapier.bodies[wall].set_enabled(false);
    let gained_m_s = press(&mut world);
    // Four rims of 50 mm. The rotating parts of the wheels make the robot heavier by 4 I / rho^2, a
    // tenth.
    let expected_m_s = 4.0 * presses_n_m / 0.05 / robot().mass_kg() * DT_S;
    let share = gained_m_s / expected_m_s;
    assert!((0.8..1.0).contains(&share), "{share}");
}

/// Bodies of rapier and of ilon carry one another: on the robot's deck, and far from it on the
/// floor.
#[test]
fn bodies_of_rapier_and_of_ilon_stand_on_one_another() {
    for (x, y, z) in [(0.0, 0.0_f64, TOP_M), (0.0, 2.0, 0.0)] {
        let mut world = world(&Floor::default(), 1e-3);
        let alone_n = robot().mass_kg() * G;
        let mut low = crate::free::cube("low", 0.1, 1.0, x, y);
        low.height_m = Some(z + 0.05);
        let low = world.add_body(&low).expect("room");
        let middle = cube(&mut world, 0.1, 1.0, [x, y, z + 0.15]);
        let mut high = crate::free::cube("high", 0.1, 1.0, x, y);
        high.height_m = Some(z + 0.25);
        let high = world.add_body(&high).expect("room");
        for _ in 0..1500 {
            hold(&mut world, 0.0);
            world.step();
        }
        let heights = [
            world.free_body(low).expect("it is there").place_m.z - z - 0.05,
            body(&world, middle).translation().z - z - 0.15,
            world.free_body(high).expect("it is there").place_m.z - z - 0.25,
        ];
        println!(
            "{heights:?} {:?} loads {}",
            world.force_on_user_body_n(middle),
            loads_n(&world) - alone_n
        );
        assert!(heights.iter().all(|off| off.abs() < 1e-4), "{heights:?}");
        // The load on it equals the support from below minus its weight.
        assert!((world.force_on_user_body_n(middle).z - G).abs() < 0.05);
        if z > 0.0 {
            assert!((loads_n(&world) - alone_n - 3.0 * G).abs() < 0.1);
        }
        let rapier = world.rapier_mut().expect("ilon solves the contacts");
        rapier.remove_body(middle);
        (0..600).for_each(|_| world.step());
        let fell_m = z + 0.25 - world.free_body(high).expect("it is there").place_m.z;
        assert!((fell_m - 0.1).abs() < 1e-3, "{fell_m}");
    }
}

/// A light free body bears a heavy one of rapier, two hundred and fifty times its weight, while
/// pushes keep it awake far from the robot: the reaction between the two continues in the next
/// step, although the robot is stepped in between. After settling each step supports the weight, to
/// the rest of the settling.
#[test]
fn a_light_free_body_bears_a_heavy_one_of_ones_own() {
    let mut world = world(&Floor::default(), 1e-3);
    let low = crate::free::cube("low", 0.1, 0.02, 0.0, 2.0);
    let low = world.add_body(&low).expect("room");
    let high = cube(&mut world, 0.1, 5.0, [0.0, 2.0, 0.15]);
    let weight_n = body(&world, high).mass() * G;
    for step in 0..1000 {
        let force_n = if step % 2 == 0 { 0.1 } else { -0.1 };
        world.push_body(low, Vector3::x() * force_n, Vector3::zeros());
        world.step();
        if step >= 600 {
            let borne_n = world.force_on_user_body_n(high).z;
            assert!((borne_n / weight_n - 1.0).abs() < 1e-5, "{borne_n} N");
        }
    }
    let low = world.free_body(low).expect("it is there");
    assert!(!low.sleeps && (low.place_m.z - 0.05).abs() < 1e-3);
}

/// A ball of 10 g at 50 m/s does not go through a chassis, and leaves its momentum there; a wheel
/// drives up a plate of 4 mm.
#[test]
fn what_is_fast_hits_and_what_is_thin_lifts() {
    let floor = Floor {
        friction: 0.0,
        ..Floor::default()
    };
    let mut world = world(&floor, 1e-3);
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    let ball = RigidBodyBuilder::dynamic()
        .translation(Vector::new(-1.03, 0.0, 0.06))
        .linvel(Vector::new(50.0, 0.0, 0.0))
        .gravity_scale(0.0);
    let (id, _) = rapier.insert(ball, ColliderBuilder::ball(0.01).mass(0.01).friction(0.0));
    (0..60).for_each(|_| world.step());
    let (robot_m_s, ball_m_s) = (
        world.robot().state().twist_in_body.vx_m_s,
        body(&world, id).linvel().x,
    );
    let momentum = robot().mass_kg() * robot_m_s + 0.01 * ball_m_s;
    println!("{momentum} N s, robot {robot_m_s}, ball {ball_m_s}");
    assert!((momentum / 0.5 - 1.0).abs() < 1e-5 && ball_m_s < 0.5);

    let mut world = crate::free::world(&Floor::default(), 1e-3);
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    let plate = ColliderBuilder::cuboid(0.4, 0.5, 0.002).translation(Vector::new(0.75, 0.0, 0.002));
    rapier.insert_collider(plate, None);
    for _ in 0..5500 {
        hold(&mut world, 3.0);
        world.step();
    }
    let state = world.robot().state();
    println!("{state:?}");
    assert!((state.height_m - 0.004).abs() < 1e-3, "{state:?}");
}

/// A freely rolling robot at 0.5 m/s pushes a box against a wall: it stops there, because the wall
/// supports the box, and separates from it no faster than ilon pushes out penetrations, 5 mm/s for
/// each of the two contacts. Pressed with 20 N, less the resistance of its wheels, the box takes
/// that.
#[test]
fn a_body_of_ones_own_with_its_back_to_a_wall_stops_a_robot() {
    let floor = Floor {
        friction: 0.0,
        ..Floor::default()
    };
    let push = |world: &mut World, force_n: f64| {
        world.robot_mut().push(&Push {
            force_in_world_n: Vector3::new(force_n, 0.0, 0.0),
            place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
        });
    };
    for mass_kg in [0.1, 2.0, 20.0] {
        let mut world = world(&floor, 1e-3);
        let id = put(&mut world, 0.12, mass_kg, [0.4, 0.0, 0.06], 0.0);
        let wall = ColliderBuilder::cuboid(0.05, 0.3, 0.2).friction(0.0);
        let rapier = world.rapier_mut().expect("ilon solves the contacts");
        rapier.insert_collider(wall.translation(Vector::new(0.71, 0.0, 0.2)), None);
        let robot_kg = robot().mass_kg();
        let mut backwards_m_s = 0.0_f64;
        for step in 0..2000 {
            if step < 100 {
                push(&mut world, 5.0 * robot_kg);
            }
            world.step();
            backwards_m_s = backwards_m_s.min(world.robot().state().twist_in_body.vx_m_s);
        }
        println!("{mass_kg}: {backwards_m_s} m/s");
        assert!((-0.011..0.0).contains(&backwards_m_s));
        // A light one in between, without any friction, slips out to the side.
        if mass_kg > 1.0 {
            let mut force_n = 0.0;
            for step in 0..1500 {
                push(&mut world, 20.0);
                world.step();
                if step >= 1000 {
                    force_n += world.force_on_user_body_n(id).x / 500.0;
                }
            }
            assert!((force_n / 20.0 - 1.0).abs() < 1e-3, "{force_n}");
            let at_m = world.robot().state().pose.x_m;
            assert!((at_m - 0.34).abs() < 1e-4, "{at_m}");
        }
    }
}

/// A tower on the deck has the weight of its bodies, also while the robot starts and stops; at rest
/// it does not move.
#[test]
fn a_tower_of_ones_own_is_carried() {
    let mut world = world(&Floor::default(), 1e-3);
    let alone_n = robot().mass_kg() * G;
    for k in 0..3 {
        cube(
            &mut world,
            0.1,
            1.0,
            [0.0, 0.0, TOP_M + 0.05 + 0.1 * k as f64],
        );
    }
    for (rate_rad_s, within) in [(0.0, 2.0), (0.0, 0.01), (2.0, 2.0), (0.0, 2.0)] {
        let mut sum_n = 0.0;
        for _ in 0..500 {
            hold(&mut world, rate_rad_s);
            world.step();
            let load_n = loads_n(&world) - alone_n;
            sum_n += load_n / 500.0;
            assert!((load_n / (3.0 * G) - 1.0).abs() < within, "{load_n}");
        }
        println!("{rate_rad_s}: {sum_n} of {}", 3.0 * G);
        assert!((sum_n / (3.0 * G) - 1.0).abs() < 2e-3);
    }
}

/// Ground that begins to tilt wakes bodies that sleep on it, user bodies too: on 45 degrees a box
/// of friction mu slides with g (sin - mu cos).
#[test]
fn ground_that_leans_wakes_bodies_of_ones_own() {
    let (dt_s, friction) = (1e-3, 0.3);
    let mut world = world(&Floor::default(), dt_s);
    let id = put(&mut world, 0.2, 2.0, [3.0, 0.0, 0.1], friction);
    for _ in 0..3000 {
        world.step();
    }
    assert!(body(&world, id).is_sleeping());
    let from_m = body(&world, id).translation().x;
    world.lean(&Vector3::new(1.0, 0.0, -1.0));
    let time_s = 0.3;
    for _ in 0..(time_s / dt_s) as usize {
        world.step();
    }
    let way_m = body(&world, id).translation().x - from_m;
    let share = (1.0 - friction) / f64::sqrt(2.0);
    let expected_m = 0.5 * G * share * time_s * time_s;
    println!("{way_m} of {expected_m} m");
    // rapier advances with the velocity after the step, which is dt / t more, and finds friction to
    // some thousandths.
    assert!((way_m / expected_m - 1.0).abs() < 0.01);
}

/// A user body locked laterally is a wall to a robot moving that way, and a body without friction
/// to a robot moving along.
#[test]
fn a_body_of_ones_own_stays_on_its_locked_axes() {
    for (force, is_wall) in [(Vector::X, false), (Vector::Y, true)] {
        let mut world = world(&Floor::default(), 1e-3);
        let rapier = world.rapier_mut().expect("ilon solves the contacts");
        // It floats beside the front right corner of the chassis, before it and to its left.
        let (front, side) = (FRONT_M + 0.05, 0.12 + 0.05);
        let at = if is_wall {
            Vector::new(0.0, side, 0.2)
        } else {
            Vector::new(front, 0.0, 0.2)
        };
        let body = RigidBodyBuilder::dynamic()
            .translation(at)
            .gravity_scale(0.0)
            .lock_rotations()
            .enabled_translations(true, false, false);
        let plate = ColliderBuilder::cuboid(0.049, 0.049, 0.15)
            .mass(1.0)
            .friction(0.0);
        let (id, _) = rapier.insert(body, plate);
        for _ in 0..500 {
            world.robot_mut().push(&Push {
                force_in_world_n: 12.0 * Vector3::new(force.x, force.y, 0.0),
                place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
            });
            world.step();
        }
        let pose = world.robot().state().pose;
        let at_now = body_at(&world, id);
        println!("{pose:?} {at_now:?}");
        if is_wall {
            // A millimetre of clearance.
            assert!((pose.y_m - 1e-3).abs() < 1e-4 && pose.heading_rad.abs() < 0.02);
        } else {
            // a t^2 / 2, of the robot and the body together; rollers and wheels spin up with them.
            let expected_m = 0.5 * 12.0 / (robot().mass_kg() + 1.0) * 0.25;
            assert!((pose.x_m / expected_m - 1.0).abs() < 0.06, "{expected_m}");
            assert!((at_now.x - front - pose.x_m).abs() < 2e-3);
        }
        assert!((at_now.y - at.y).abs() < 1e-4 && (at_now.z - at.z).abs() < 1e-4);
    }
}

fn body_at(world: &World, handle: RigidBodyHandle) -> Vector {
    body(world, handle).translation()
}

/// A box that a robot pushes over a plate which a program moves across resists with its friction,
/// as on the ground, once it moves across with the plate.
#[test]
fn a_box_is_pushed_over_a_plate_that_a_program_moves() {
    let (dt_s, friction, mass_kg, across_m_s) = (1e-3, 0.3, 2.0_f64, 0.03);
    let mut world = world(&Floor::default(), dt_s);
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    // Between the wheels and beneath the chassis, 4 mm thick.
    let moved = RigidBodyBuilder::kinematic_velocity_based()
        .translation(Vector::new(0.9, 0.0, 0.002))
        .linvel(Vector::new(0.0, across_m_s, 0.0));
    rapier.insert(
        moved,
        ColliderBuilder::cuboid(0.7, 0.06, 0.002).friction(friction),
    );
    let id = with_slippery_back(&mut world, mass_kg, FRONT_M + 0.112, friction);
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    let lifted = rapier.bodies[id].translation() + Vector::new(0.0, 0.0, 0.004);
    rapier.bodies[id].set_translation(lifted, true);
    let steps = (0.8 / dt_s) as usize;
    let mut force_n = 0.0;
    for step in 0..2 * steps {
        hold(&mut world, 4.0);
        world.step();
        if step >= steps {
            force_n += world.force_on_user_body_n(id).x / steps as f64;
        }
    }
    let expected_n = friction * mass_kg * G;
    let across = body(&world, id).linvel().y;
    println!("{force_n} of {expected_n} N, {across} m/s across");
    assert!((force_n / expected_n - 1.0).abs() < 0.02);
    assert!((across / across_m_s - 1.0).abs() < 0.02);
}
