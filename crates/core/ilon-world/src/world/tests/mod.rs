//! Tests of a world's internals.

mod given_up;
mod off_the_flat;
mod two_bodies;
mod user_bodies;

use ilon_formats::LoadRobot;
use ilon_robot::{Pose as PlanarPose, Robot};
use nalgebra::{DVector, UnitQuaternion, Vector3};

use super::{World, with_solver};
use crate::contact::reactions::reaction::Part;
use crate::contact::scene::Scenes;
use crate::contact::search::free_bodies::{solids, travel_m};
use crate::contact::search::on_ground::Workspace;
use crate::robot::articulated::{Articulated, wheel_inertia};
use crate::{Floor, GroundBox, MotorTorque, Push, RollerBodies, Settings};

fn shipped(name: &str) -> Robot {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    Robot::load(format!("{folder}/{name}.urdf")).expect("a shipped robot")
}

/// Angular momentum of all bodies about the origin of the floor's frame, part by part, in kg m^2/s.
fn angular_momentum(world: &World) -> Vector3<f64> {
    world.bodies.iter().map(momentum_about_origin).sum()
}

fn momentum_about_origin(body: &Articulated) -> Vector3<f64> {
    let state = &body.state;
    let chassis = &body.chassis_mass;
    let center_m = state.center_m();
    let rotation = state.floor_from_chassis().rotation;
    let in_body = rotation.inverse() * state.angular_rad_s;
    let mut sum = rotation * (chassis.inertia_kg_m2 * in_body)
        + chassis.mass_kg * center_m.cross(&state.velocity_m_s);
    for (index, wheel) in body.robot.wheels.iter().enumerate() {
        let hub = &state.hubs()[index];
        let in_hub = state.hub_rate_in_hub(index);
        let moving = |mass_kg: f64, in_hub_m: &Vector3<f64>| {
            let place_m = hub.place_m(in_hub_m);
            mass_kg * place_m.cross(&state.hub_velocity_m_s(index, &place_m))
        };
        sum += moving(wheel.hub.mass_kg, &wheel.hub.center_of_mass_m)
            + hub.rotation * (wheel.hub.inertia_kg_m2 * in_hub);
        let states = &body.wheels[index].rollers;
        for (roller, state) in wheel.rollers.iter().zip(states) {
            let d = roller.axis_in_hub.into_inner();
            let turning = roller.transverse_inertia_kg_m2 * (in_hub - d * d.dot(&in_hub))
                + roller.axial_inertia_kg_m2 * state.axial_rate_rad_s * d;
            sum += moving(roller.mass_kg, &roller.center_in_hub_m) + hub.rotation * turning;
        }
    }
    sum
}

/// A floating, tumbling robot, one of its wheels turning.
fn tumbling(robot: &Robot, dt_s: f64, angular_rad_s: Vector3<f64>) -> World {
    let settings = Settings {
        dt_s,
        gravity_m_s2: 0.0,
        roller_bodies: RollerBodies::Near,
        ..Settings::default()
    };
    let mut world = World::new(robot, &Floor::default(), PlanarPose::default(), &settings)
        .expect("a robot above a plane");
    let mut pose = *world.bodies[0].state.floor_from_chassis();
    pose.translation.z += 1.0;
    world.bodies[0].state.place(pose);
    world.bodies[0].state.angular_rad_s = angular_rad_s;
    world.bodies[0].state.wheel_rates_mut()[1] = 5.0;
    world
}

/// The relative change of a robot's angular momentum in half a second of floating and tumbling,
/// while the rollers of one wheel spin at 1e4 rad/s.
fn lost_tumbling(dt_s: f64) -> f64 {
    let mut world = tumbling(&shipped("mecanum4"), dt_s, Vector3::new(0.3, -0.2, 0.5));
    for roller in &mut world.bodies[0].wheels[0].rollers {
        roller.axial_rate_rad_s = 1e4;
    }
    let from = angular_momentum(&world);
    for _ in 0..(0.5 / dt_s).round() as usize {
        world.step();
        assert!(
            world
                .robot()
                .contacts()
                .iter()
                .all(|contact| !contact.touching)
        );
    }
    (angular_momentum(&world) - from).norm() / from.norm()
}

/// The torque that turns the flywheels' axes with their hub comes from the hub, and the bearings'
/// torques go there: the robot keeps its angular momentum.
///
/// The axes are tilted by 45 degrees, so that nine rollers carry 9 I w / sqrt 2 = 0.046 kg m^2/s
/// along the hub's, with I = 7.2e-7 kg m^2. Turned at 0.6 rad/s for half a second that is 0.01 kg
/// m^2/s, a tenth of the robot's angular momentum. A step of dt is accurate to second order in
/// that, and to first order in the small effect of the bearings: at half the step, at most half the
/// error.
#[test]
fn flywheels_keep_the_angular_momentum_of_a_robot_that_tumbles() {
    let (coarse, fine) = (lost_tumbling(5e-4), lost_tumbling(2.5e-4));
    assert!(coarse < 1e-4, "{coarse:.1e}");
    assert!(fine < 0.6 * coarse, "{fine:.1e} for {coarse:.1e}");
}

/// The relative change of the energy of a robot with free rollers in half a second of floating and
/// tumbling with a turning wheel.
fn gained_tumbling(dt_s: f64) -> f64 {
    let mut robot = shipped("mecanum4");
    for wheel in &mut robot.wheels {
        (wheel.joint.friction_n_m, wheel.joint.damping_n_m_s) = (0.0, 0.0);
        for roller in &mut wheel.rollers {
            (roller.joint.friction_n_m, roller.joint.damping_n_m_s) = (0.0, 0.0);
        }
    }
    let mut world = tumbling(&robot, dt_s, Vector3::new(1.5, -1.0, 2.5));
    let from_j = world.energy().kinetic_j;
    for _ in 0..(0.5 / dt_s).round() as usize {
        world.step();
    }
    (world.energy().kinetic_j - from_j).abs() / from_j
}

/// Nothing does work on a freely tumbling robot. It turns by 1.6 rad, 3 mrad per step, and a step
/// is of second order: half of it, a quarter of the error.
#[test]
fn a_robot_that_tumbles_keeps_its_energy_to_second_order_of_the_step() {
    let (coarse, fine) = (gained_tumbling(2e-3), gained_tumbling(1e-3));
    println!("{coarse:.2e} {fine:.2e}");
    assert!(coarse < 1e-6, "{coarse:.1e}");
    assert!(fine < 0.3 * coarse, "{fine:.1e} for {coarse:.1e}");
}

/// A robot that falls on its back loses its potential energy to impacts and scraping of its
/// chassis: 11 kg over some 0.45 m, 50 J. The balance closes to a hundredth; without the chassis
/// all of it would be missing.
#[test]
fn a_fall_on_its_back_goes_into_the_hits_of_the_chassis() {
    let robot = shipped("mecanum4");
    let settings = Settings::default();
    let mut world = World::new(&robot, &Floor::default(), PlanarPose::default(), &settings)
        .expect("a robot above a plane");
    let mut pose = *world.bodies[0].state.floor_from_chassis();
    pose.translation.z = 0.5;
    pose.rotation = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.1, 0.0);
    world.bodies[0].state.place(pose);
    let energy_j = |world: &World| world.energy().kinetic_j + world.energy().potential_j;
    let from_j = energy_j(&world);
    for _ in 0..500 {
        world.step();
    }
    let lost_j = from_j - energy_j(&world);
    let counted_j = world.impact_energy_j() + world.slip_energy_j() + world.bearing_energy_j();
    assert!(lost_j > 40.0, "{lost_j} J");
    assert!(
        (counted_j - lost_j).abs() < 0.01 * lost_j,
        "{counted_j} J of {lost_j} J"
    );
}

/// A motor within its limits is linear and solved with the masses: it needs no law of its own,
/// whether a push moves it up or down its line.
#[test]
fn motors_on_their_line_need_no_law_of_their_own() {
    let robot = shipped("mecanum4");
    let (floor, settings) = (Floor::default(), Settings::default());
    let motors = vec![MotorTorque::with_droop(0.05, 0.2); robot.wheels.len()];
    for force_n in [-30.0, 30.0] {
        let mut world = World::new(&robot, &floor, PlanarPose::default(), &settings)
            .expect("a robot above a plane");
        for _ in 0..50 {
            world.robot_mut().drive(&motors);
            world.robot_mut().push(&Push {
                force_in_world_n: Vector3::new(force_n, 0.0, 0.0),
                place_in_body_m: Vector3::zeros(),
            });
            world.step();
            let of_drives = |part: Part| matches!(part, Part::Drive(_));
            let mut parts = world.reactions.all().iter().map(|reaction| reaction.a.part);
            assert!(!parts.any(of_drives), "{force_n} N");
        }
    }
}

/// The jump of a hand-over ends before motors react: the robot moves the same way whether their
/// torques fall with the rate or not.
#[test]
fn motors_do_not_react_within_the_jump_of_a_hand_over() {
    let settings = Settings {
        dt_s: 1e-3,
        ..Settings::default()
    };
    let (robot, floor) = (shipped("mecanum4"), Floor::default());
    let mut world =
        World::new(&robot, &floor, PlanarPose::default(), &settings).expect("a robot on a plane");
    let way_of_step = |world: &mut World| {
        world.step();
        let jump: Vec<f64> = with_solver(|solver| solver.start_change(0).collect());
        DVector::from_vec(jump).try_normalize(0.0)
    };
    let mut jumps = 0;
    for _ in 0..600 {
        let rates = world.robot().wheel_rates_rad_s().iter();
        let torques: Vec<f64> = rates.map(|rate| 2.0 * (4.0 - rate)).collect();
        let mut constant = world.clone();
        constant.robot_mut().apply(&torques);
        let motors: Vec<MotorTorque> = (torques.iter())
            .map(|torque| MotorTorque::with_droop(*torque, 2.0))
            .collect();
        world.robot_mut().drive(&motors);
        let ways = (way_of_step(&mut world), way_of_step(&mut constant));
        if let (Some(falls), Some(stays)) = ways {
            jumps += 1;
            // Rounding of the responses with motors and without.
            let apart = (falls - stays).norm();
            assert!(apart < 1e-10, "{apart:e}");
        }
    }
    assert!(jumps > 3, "{jumps} jumps");
}

/// What a motor loses per acceleration is an inertia, and whatever comes in a step, jumps of
/// hand-overs too, it has lost all of it by the end: it owes nothing to the next.
#[test]
fn motors_that_fall_with_the_acceleration_alone_owe_nothing() {
    let settings = Settings::default();
    let (robot, floor) = (shipped("mecanum4"), Floor::default());
    let mut world =
        World::new(&robot, &floor, PlanarPose::default(), &settings).expect("a robot on a plane");
    for _ in 0..600 {
        let rates = world.robot().wheel_rates_rad_s().iter();
        let motors: Vec<MotorTorque> = rates
            .map(|rate| MotorTorque {
                per_acceleration_n_m_s2: 0.01,
                ..MotorTorque::constant(0.5 * (4.0 - rate))
            })
            .collect();
        world.robot_mut().drive(&motors);
        world.step();
        let owed = &world.bodies[0].memory.motors_owe_n_m_s;
        // Rounding of rates of some 4 rad/s.
        assert!(owed.iter().all(|owed| owed.abs() < 1e-12), "{owed:?}");
    }
}

/// While a robot stands, only places within a fiftieth of a wheel's radius, 1 mm, are found: the
/// floor under each wheel, not a wall 10 mm ahead, and nothing of the chassis.
#[test]
fn only_what_is_near_is_looked_at() {
    let robot = shipped("mecanum4");
    let rims_m = robot
        .wheels
        .iter()
        .map(|wheel| wheel.position_m().x + wheel.radius_m);
    let wall = GroundBox {
        center_m: Vector3::new(rims_m.fold(0.0, f64::max) + 0.06, 0.0, 0.1),
        half_sides_m: Vector3::new(0.05, 0.5, 0.1),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    };
    let floor = Floor {
        boxes: vec![wall],
        ..Floor::default()
    };
    let settings = Settings::default();
    let mut world = World::new(&robot, &floor, PlanarPose::default(), &settings)
        .expect("a robot before a wall");
    world.step();
    let scenes = Scenes {
        ground: &world.ground,
        settings: &world.settings,
        dt_s: world.settings.dt_s,
        bodies: &world.bodies,
        reactions: &world.reactions,
    };
    let (scene, mut found) = (scenes.of(0), Vec::new());
    scene.find_ground(&mut found);
    assert!(found.is_empty(), "{found:?}");
    for wheel in 0..robot.wheels.len() {
        scene.find_wheel(wheel, &mut Workspace::default(), &mut found);
        let normals: Vec<_> = found.iter().map(|place| place.normal).collect();
        assert_eq!(normals, [Vector3::z()], "{found:?}");
    }
}

/// Each wheel contributes to the inertia that motors feel: an increase of one hub about its axle
/// increases the mean by a fourth, and a smaller one is the minimum. The sums are rounded to some
/// 1e-16.
#[test]
fn each_wheel_counts_for_what_motors_feel() {
    let robot = shipped("mecanum4");
    let before = wheel_inertia(&robot, 0.0);
    let change = 0.1 * robot.wheels[0].hub.inertia_kg_m2[(2, 2)];
    let rounding = 1e-14 * before.on_ground_kg_m2;
    for wheel in 0..4 {
        let with = |change: f64| {
            let mut robot = robot.clone();
            robot.wheels[wheel].hub.inertia_kg_m2[(2, 2)] += change;
            wheel_inertia(&robot, 0.0)
        };
        let (heavier, lighter) = (with(change), with(-change));
        let gained = heavier.on_ground_kg_m2 - before.on_ground_kg_m2;
        assert!((gained - 0.25 * change).abs() < rounding, "wheel {wheel}");
        let lost = before.spinning_kg_m2 - lighter.spinning_kg_m2;
        assert!((lost - change).abs() < rounding, "wheel {wheel}");
        let of_others = heavier.spinning_kg_m2 - before.spinning_kg_m2;
        assert!(of_others.abs() < rounding, "wheel {wheel}");
        // Rollers turn with their hub across their own axles.
        let mut thicker = robot.clone();
        thicker.wheels[wheel].rollers[2].transverse_inertia_kg_m2 += change;
        let gained = wheel_inertia(&thicker, 0.0).on_ground_kg_m2 - before.on_ground_kg_m2;
        assert!((gained - 0.25 * change).abs() < rounding, "wheel {wheel}");
    }
}

fn standing(robot: &Robot, settings: &Settings) -> World {
    World::new(robot, &Floor::default(), PlanarPose::default(), settings).expect("it stands")
}

/// Motors feel the chassis's loads and the coupled inertia of another engine, both together.
#[test]
fn motors_feel_payloads_and_what_is_attached() {
    let robot = shipped("mecanum4");
    let mut world = standing(&robot, &Settings::default());
    let carried = crate::Payload::new(3.0, Vector3::new(0.0, 0.0, 0.1)).expect("a payload");
    world.robot_mut().carry(&[carried]);
    let attached = nalgebra::Matrix6::from_diagonal_element(5.0);
    world.robot_mut().attach(Some(&attached));
    let expected = wheel_inertia(&robot, 3.0 + 5.0);
    assert_eq!(world.bodies[0].wheel_inertia, expected);
}

/// A chassis that turns on the spot may move as fast as its furthest corner, and no faster than a
/// ball around it.
#[test]
fn the_furthest_way_of_a_chassis_is_that_of_its_corner() {
    let robot = shipped("mecanum4");
    let mut world = standing(&robot, &Settings::default());
    let body = &mut world.bodies[0];
    let center_m = body.state.center_m();
    let corner_m = solids(body, &body.state)
        .map(|solid| {
            let bounds = solid.shape.compute_local_aabb();
            let corners = bounds.vertices().map(|corner| {
                let corner = nalgebra::Point3::from(crate::engine::convert::to_vector(corner));
                (solid.floor_from_shape * corner).coords - center_m
            });
            corners.iter().map(Vector3::norm).fold(0.0, f64::max)
        })
        .fold(0.0, f64::max);
    assert!(corner_m > 0.2);
    body.state.angular_rad_s = Vector3::z() * 10.0;
    let way_m = travel_m(body, &body.state, 1e-3);
    assert!(
        (1e-2 * corner_m..2e-2 * corner_m).contains(&way_m),
        "{way_m} m"
    );
}

/// Bodies that another engine moves along with the chassis have the same inertia as a payload there
/// against a push from rest, and the part of the push's work that they take is not the robot's: the
/// external energy equals the robot's. Without gravity, at a point off all axes.
#[test]
fn what_is_attached_weighs_as_a_payload_does() {
    let robot = shipped("mecanum4");
    let (mass_kg, place_m) = (4.0, Vector3::new(0.2, -0.15, 0.3));
    let floats = || {
        let settings = Settings {
            dt_s: 1e-3,
            gravity_m_s2: 0.0,
            ..Settings::default()
        };
        standing(&robot, &settings)
    };
    let pushed = |world: &mut World| {
        world.robot_mut().push(&Push {
            force_in_world_n: Vector3::new(30.0, -20.0, 10.0),
            place_in_body_m: Vector3::new(-0.1, 0.2, 0.25),
        });
        world.step();
        let body = &world.bodies[0];
        let state = &body.state;
        // Of the origin of the body frame, because the two have different centres of mass.
        let to_center_m = body.chassis_mass.center_of_mass_m;
        let origin_m = state.center_m() - state.floor_from_chassis().rotation * to_center_m;
        (state.chassis_velocity_m_s(&origin_m), state.angular_rad_s)
    };
    let mut carries = floats();
    let payload = crate::Payload::new(mass_kg, place_m).expect("a payload");
    carries.robot_mut().carry(&[payload]);
    let mut bears = floats();
    let cross = place_m.cross_matrix();
    let mut inertia = nalgebra::Matrix6::zeros();
    let mut put = |at: (usize, usize), block: nalgebra::Matrix3<f64>| {
        inertia.fixed_view_mut::<3, 3>(at.0, at.1).copy_from(&block);
    };
    put((0, 0), nalgebra::Matrix3::identity() * mass_kg);
    put((0, 3), -mass_kg * cross);
    put((3, 0), mass_kg * cross);
    put((3, 3), -mass_kg * cross * cross);
    bears.robot_mut().attach(Some(&inertia));
    let (v, w) = pushed(&mut carries);
    let (borne_v, borne_w) = pushed(&mut bears);
    // Second order in a rotation by some 1e-4 rad.
    assert!((borne_v - v).norm() < 1e-3 * v.norm(), "{borne_v} {v}");
    assert!((borne_w - w).norm() < 1e-3 * w.norm(), "{borne_w} {w}");
    let energy = bears.energy();
    let has_j = energy.kinetic_j + energy.potential_j + bears.impact_energy_j();
    let went_j = has_j + bears.slip_energy_j() + bears.bearing_energy_j();
    let outside_j = bears.outside_energy_j();
    assert!(
        (outside_j / went_j - 1.0).abs() < 1e-6,
        "{outside_j} {went_j}"
    );
}
