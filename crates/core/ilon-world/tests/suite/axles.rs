//! Friction on the rollers' axles, proportional to the load, against derivations by hand.
//!
//! A roller on an axle of radius a carries a load N and turns at s relative to its hub: the
//! friction mu N on the axle's surface takes the power mu N a |s|. Without sliding, s follows from
//! the motion of the robot: at the contact point p the velocity of the hub, q' n x (p - c), plus
//! that of the roller, s d x (p - b), cancels that of the robot, in both directions of the ground.
//! These are two equations for q' and s.

use crate::support;

use std::f64::consts::{FRAC_PI_2, PI};

use ilon_robot::{Pose, Robot, Tread, Twist, Wheel, wrap_angle};
use ilon_world::{Floor, Push, Settings, World, WorldError};
use nalgebra::{Isometry3, Matrix2, Vector2, Vector3};
use support::rig::{G, follow};
use support::{brake, mecanum4, volksbot};

const FRICTION: f64 = 0.2;
const AXLE_M: f64 = 2e-3;

/// The robot on axles, with bearings without other losses.
fn on_axles(mut robot: Robot, friction: f64, axle_m: f64) -> Robot {
    for wheel in &mut robot.wheels {
        wheel.surface.axle_friction = friction;
        wheel.surface.axle_radius_m = axle_m;
        for roller in &mut wheel.rollers {
            roller.joint.damping_n_m_s = 0.0;
        }
    }
    robot
}

fn on(robot: &Robot, floor: &Floor, dt_s: f64) -> World {
    let settings = Settings {
        dt_s,
        ..Settings::default()
    };
    World::new(robot, floor, Pose::default(), &settings).expect("valid")
}

/// The rate of the touching roller relative to its hub, in rad/s, on a robot that moves without
/// rotation.
fn spin_rad_s(wheel: &Wheel, angle_rad: f64, velocity_m_s: Vector2<f64>) -> f64 {
    let hub = wheel.body_from_hub * Isometry3::rotation(angle_rad * Vector3::z());
    let off = |place_rad: f64| wrap_angle(place_rad + angle_rad).abs();
    let rollers = wheel.rollers.iter();
    let roller = rollers
        .min_by(|a, b| off(a.place_rad()).total_cmp(&off(b.place_rad())))
        .expect("rollers");
    let axis = hub.rotation * roller.axis_in_hub.into_inner();
    let barrel = wheel.barrel(roller);
    let along_m = barrel.support_place_m(-axis.z);
    let lever_m = along_m * axis - barrel.sphere_radius_m(along_m) * Vector3::z();
    let from_hub_m = hub.rotation * roller.center_in_hub_m + lever_m;
    let turned = (hub.rotation * Vector3::z()).cross(&from_hub_m).xy();
    let rolled = axis.cross(&lever_m).xy();
    let both = Matrix2::from_columns(&[turned, rolled]);
    both.lu().solve(&-velocity_m_s).expect("a tilted roller").y
}

fn energies_j(world: &World) -> f64 {
    world.energy().kinetic_j + world.energy().potential_j
}

fn lost_j(world: &World) -> f64 {
    world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.bearing_energy_j()
        + world.impact_energy_j()
}

#[test]
fn friction_on_axles_takes_coefficient_radius_and_load_for_each_radian() {
    let treads = |mut robot: Robot| {
        for wheel in &mut robot.wheels {
            wheel.surface.tread = Some(Tread::new(1e6));
        }
        robot
    };
    for robot in [volksbot(), mecanum4(), treads(mecanum4())] {
        let robot = on_axles(robot, FRICTION, AXLE_M);
        let load_n = robot.mass_kg() * G / robot.wheels.len() as f64;
        for (vx, vy) in [(0.0, 0.2), (0.1, 0.2), (-0.15, 0.15)] {
            let twist = Twist::new(vx, vy, 0.0);
            let mut world = on(&robot, &Floor::default(), 1e-3);
            let rest_j = energies_j(&world);
            follow(&mut world, &robot, twist, 1.0, 0.0);
            let began_j = world.bearing_energy_j();
            let mut expected_j = 0.0;
            for _ in 0..1000 {
                follow(&mut world, &robot, twist, 1e-3, 0.0);
                let state = world.robot().state();
                let (v, angles) = (state.twist_in_body, world.robot().wheel_angles_rad());
                let velocity_m_s = Vector2::new(v.vx_m_s, v.vy_m_s);
                for (wheel, angle_rad) in robot.wheels.iter().zip(angles) {
                    let spin_rad_s = spin_rad_s(wheel, *angle_rad, velocity_m_s);
                    expected_j += FRICTION * load_n * AXLE_M * spin_rad_s.abs() * 1e-3;
                }
            }
            let took_j = world.bearing_energy_j() - began_j;
            // Ripple, yaw and load shifts: a hundredth.
            assert!(
                (took_j / expected_j - 1.0).abs() < 0.01,
                "{} {twist:?}: {took_j} {expected_j}",
                robot.name
            );
            // The balance closes with it.
            let gained_j = energies_j(&world) - rest_j;
            let open_j = world.motor_energy_j() - lost_j(&world) - gained_j;
            assert!(
                open_j.abs() < 1e-3 * world.motor_energy_j(),
                "{open_j} of {}",
                world.motor_energy_j()
            );
        }
    }
}

/// Lateral velocity, and the robot's lateral inertia, at the start of coasting, and the velocity
/// half a second later.
fn coasts(robot: &Robot, sideways_m_s: f64, dt_s: f64) -> (f64, f64, World) {
    let mut world = on(robot, &Floor::default(), dt_s);
    follow(
        &mut world,
        robot,
        Twist::new(0.0, sideways_m_s, 0.0),
        1.0,
        0.0,
    );
    let before_m_s = world.robot().state().twist_in_body.vy_m_s;
    let moving_kg = 2.0 * world.energy().kinetic_j / (before_m_s * before_m_s);
    for _ in 0..(0.5 / dt_s) as usize {
        world.robot_mut().apply(&[0.0; 4]);
        world.step();
    }
    (before_m_s, moving_kg, world)
}

/// Sideways on mecanum wheels: m' a = mu m g (a s / v), with s / v averaged over a turn of the
/// wheel; with rollers of one radius r, sqrt(2) / r.
#[test]
fn a_robot_on_bushings_coasts_sideways_as_derived() {
    let slowed_m_s = |friction: f64, sideways_m_s: f64| {
        let robot = on_axles(mecanum4(), friction, AXLE_M);
        let (before_m_s, moving_kg, world) = coasts(&robot, sideways_m_s, 1e-3);
        let after_m_s = world.robot().state().twist_in_body.vy_m_s;
        (before_m_s.abs() - after_m_s.abs(), moving_kg, world)
    };
    let robot = mecanum4();
    let turns = (0..360).map(|i| 2.0 * PI * (f64::from(i) + 0.5) / 360.0);
    let spin_1_m = turns
        .map(|angle| spin_rad_s(&robot.wheels[0], angle, Vector2::y()).abs())
        .sum::<f64>()
        / 360.0;
    // The ends of a roller are thinner than its middle, and turn faster.
    let at_middle_1_m = 2.0f64.sqrt() / 0.012;
    assert!(
        spin_1_m > at_middle_1_m && spin_1_m < 1.3 * at_middle_1_m,
        "{spin_1_m}"
    );

    let (without_m_s, ..) = slowed_m_s(0.0, 0.8);
    let (with_m_s, moving_kg, left) = slowed_m_s(FRICTION, 0.8);
    let slows_m_s2 = (with_m_s - without_m_s) / 0.5;
    let expected_m_s2 = FRICTION * robot.mass_kg() * G * AXLE_M * spin_1_m / moving_kg;
    // The hand-over losses without friction are those at another speed, and the mean is not over
    // whole turns.
    assert!(
        (slows_m_s2 / expected_m_s2 - 1.0).abs() < 0.03,
        "{slows_m_s2} {expected_m_s2}"
    );

    // The mirror image.
    let (_, _, right) = slowed_m_s(FRICTION, -0.8);
    let (left, right) = (left.robot().state().pose, right.robot().state().pose);
    let off_m = (left.y_m + right.y_m).abs() + (left.x_m - right.x_m).abs();
    assert!(off_m < 1e-6 * left.y_m, "{left:?} {right:?}");
    assert!((left.heading_rad + right.heading_rad).abs() < 1e-6);
}

/// More friction than the floor can turn a roller against: the rollers do not turn, and the robot
/// slides, at any step.
#[test]
fn rollers_that_their_axles_hold_do_not_turn() {
    let (friction, axle_m) = (5.0, 6e-3);
    let robot = on_axles(mecanum4(), friction, axle_m);
    let mut ends_m = Vec::new();
    for dt_s in [4e-3, 1e-3, 2.5e-4] {
        let mut world = on(&robot, &Floor::default(), dt_s);
        let rest_j = energies_j(&world);
        follow(&mut world, &robot, Twist::new(0.0, 0.3, 0.0), 1.0, 0.0);
        let open_j = world.motor_energy_j() - lost_j(&world) - (energies_j(&world) - rest_j);
        assert!(
            open_j.abs() < 2e-3 * world.motor_energy_j(),
            "{dt_s}: {open_j} of {}",
            world.motor_energy_j()
        );
        // Friction on the axles takes hardly any energy, because nothing turns there except when a
        // load grows fivefold within a step: the load of the step before counts, so that the energy
        // falls with the step.
        let bearings = world.bearing_energy_j() / world.motor_energy_j();
        assert!(bearings < 0.5 * dt_s, "{dt_s}: {bearings}");
        ends_m.push(world.robot().state().pose.position_m());
    }
    let way_m = ends_m[2].norm();
    for end_m in &ends_m[..2] {
        assert!(
            (end_m - ends_m[2]).norm() < 0.02 * way_m.max(0.05),
            "{ends_m:?}"
        );
    }
}

/// On a slope of 1.5 deg, 0.026 of the weight, a mecanum robot rolls away sideways on free rollers;
/// on bushings it stands, because friction holds it with sqrt(2) mu a / r = 0.047 of it.
#[test]
fn bushings_hold_at_rest() {
    let floor = Floor {
        slope_rad: 1.5f64.to_radians(),
        ..Floor::default()
    };
    let rolls_m = |friction: f64| {
        let robot = on_axles(mecanum4(), friction, AXLE_M);
        let settings = Settings {
            dt_s: 1e-3,
            ..Settings::default()
        };
        let across = Pose {
            heading_rad: FRAC_PI_2,
            ..Pose::default()
        };
        let mut world = World::new(&robot, &floor, across, &settings).expect("valid");
        let mut came = Vec::new();
        for _ in 0..2 {
            for _ in 0..500 {
                world.robot_mut().apply(&[0.0; 4]);
                world.step();
            }
            came.push(world.robot().state().pose.position_m());
        }
        (came[1] - came[0]).norm()
    };
    assert!(rolls_m(0.0) > 0.05, "{}", rolls_m(0.0));
    assert!(rolls_m(FRICTION) < 1e-6, "{}", rolls_m(FRICTION));
}

#[test]
fn axles_that_are_none_are_refused() {
    for (friction, axle_m) in [
        (0.2, 0.0),
        (0.2, 0.012),
        (-0.1, 2e-3),
        (f64::NAN, 2e-3),
        (f64::INFINITY, 2e-3),
        (0.2, f64::NAN),
    ] {
        let robot = on_axles(mecanum4(), friction, axle_m);
        let made = World::new(
            &robot,
            &Floor::default(),
            Pose::default(),
            &Settings::default(),
        );
        let fault = made.err().expect("refused");
        assert!(
            matches!(&fault, WorldError::Wheel { reason, .. } if reason.contains("on axles of radius")),
            "{friction} {axle_m}: {fault}"
        );
    }
}

/// In the air the dry friction f of its bearing decelerates a roller by f / I, and damping c by
/// exp(-c t / I), until it stands.
#[test]
fn rollers_in_the_air_are_slowed_by_their_bearings() {
    let (friction_n_m, damping_n_m_s) = (6e-6, 4e-7);
    let mut robot = volksbot();
    for roller in robot.wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers) {
        (roller.joint.friction_n_m, roller.joint.damping_n_m_s) = (friction_n_m, damping_n_m_s);
    }
    let inertia_kg_m2 = robot.wheels[0].rollers[0].axial_inertia_kg_m2;
    let settings = Settings {
        dt_s: 1e-3,
        ..Settings::default()
    };
    let mut world =
        World::new(&robot, &Floor::default(), Pose::default(), &settings).expect("it stands");
    let push = |world: &mut World, force_n: Vector3<f64>| {
        brake(world);
        world.robot_mut().push(&Push {
            force_in_world_n: force_n,
            place_in_body_m: robot.center_of_mass_m(),
        });
        world.step();
    };
    let weight_n = robot.mass_kg() * 9.81;
    // Along the first wheel's axis, where its rollers roll and the others drag; then up, and into
    // flight.
    (0..200).for_each(|_| push(&mut world, Vector3::x() * 1.2 * weight_n));
    (0..40).for_each(|_| push(&mut world, Vector3::z() * 6.0 * weight_n));
    (0..10).for_each(|_| push(&mut world, Vector3::zeros()));
    assert!(world.robot().contacts().iter().all(|of| !of.touching));
    let spins = world.robot().roller_spins_rad_s(0);
    const STEPS: usize = 60;
    (0..STEPS).for_each(|_| push(&mut world, Vector3::zeros()));
    assert!(world.robot().contacts().iter().all(|of| !of.touching));
    let later = world.robot().roller_spins_rad_s(0);
    let time_s = 1e-3 * STEPS as f64;
    let mut spun = 0;
    for (before, after) in spins.iter().zip(&later) {
        // d|w|/dt = -(c |w| + f) / I.
        let (leaves, stop) = (
            (-damping_n_m_s * time_s / inertia_kg_m2).exp(),
            friction_n_m / damping_n_m_s,
        );
        let expected = ((before.abs() + stop) * leaves - stop).max(0.0);
        println!("{before} {after} {expected}");
        // Within each step friction and damping act in sequence: first order in c dt / I = 1e-3.
        assert!((after.abs() - expected).abs() < 2e-3 * before.abs() + 1e-6);
        spun += usize::from(expected > 1.0);
    }
    assert!(spun > 0, "{spins:?}");
}
