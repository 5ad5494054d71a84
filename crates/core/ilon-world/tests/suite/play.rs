//! Rollers with axial play: backlash and lost motion by hand, energy, and the limit of zero play.

use crate::support;

use std::f64::consts::{FRAC_PI_4, TAU};

use ilon_robot::{Pose, Robot, Twist};
use ilon_world::{
    ContactSolver, Floor, FloorSurface, MotorTorque, Push, RollerBodies, Settings, World,
    WorldError,
};
use nalgebra::Vector3;
use support::{ideal_rates, mecanum4, volksbot};

fn with_play(mut robot: Robot, play_m: f64) -> Robot {
    for wheel in &mut robot.wheels {
        wheel.surface.axial_play_m = play_m;
    }
    robot
}

fn settings(dt_s: f64) -> Settings {
    Settings {
        dt_s,
        ..Settings::default()
    }
}

fn world(robot: &Robot, dt_s: f64) -> World {
    let floor = Floor {
        friction: 1.0,
        ..Floor::default()
    };
    World::new(robot, &floor, Pose::default(), &settings(dt_s)).expect("valid")
}

fn push_n(world: &mut World, x_n: f64, y_n: f64) {
    world.robot_mut().push(&Push {
        force_in_world_n: Vector3::new(x_n, y_n, 0.0),
        place_in_body_m: Vector3::new(0.0, 0.0, 0.06),
    });
}

/// The error of the energy balance, in J.
fn open_j(world: &World, began_j: f64) -> f64 {
    let energy = world.energy();
    let lost_j = world.slip_energy_j()
        + world.spin_up_energy_j()
        + world.bearing_energy_j()
        + world.impact_energy_j();
    world.motor_energy_j() + world.outside_energy_j()
        - lost_j
        - (energy.kinetic_j + energy.potential_j - began_j)
}

/// Robot A with its wheels held, a roller of each straight down, pushed ahead and back with 0.2 N.
/// The floor holds the rollers, and their axles at 45 degrees slide through them: the robot moves
/// by p / (2 cos gamma) from the middle of the play, and by p / cos gamma back, under F = (m + the
/// rollers' contribution) a.
#[test]
fn a_robot_with_its_wheels_held_has_the_backlash_of_its_play() {
    const PLAY_M: f64 = 1e-3;
    // So little that the impact at a stop, m v in a step, stays within the friction limit.
    const FORCE_N: f64 = 0.2;
    let mut robot = with_play(mecanum4(), PLAY_M);
    for wheel in &mut robot.wheels {
        wheel.joint.friction_n_m = 5.0;
    }
    // Half of the speed goes along each axle and half across it: the rollers' own mass there, m_r,
    // and I / r^2 here.
    let roller = &robot.wheels[0].rollers[0];
    let turning_kg = roller.axial_inertia_kg_m2 / roller.radius_m.powi(2);
    let moved_kg = robot.mass_kg() + 4.0 * 0.5 * (roller.mass_kg + turning_kg);
    let half_m = 0.5 * PLAY_M / FRAC_PI_4.cos();
    let half_s = (2.0 * half_m * moved_kg / FORCE_N).sqrt();
    for dt_s in [1e-3, 2.5e-4] {
        let mut world = world(&robot, dt_s);
        let began_j = world.energy().kinetic_j + world.energy().potential_j;
        let mut arrived_s = None;
        while world.time_s() < 2.0 * half_s {
            push_n(&mut world, FORCE_N, 0.0);
            world.step();
            let x_m = world.robot().state().pose.x_m;
            if arrived_s.is_none() && x_m > half_m - 1e-6 {
                arrived_s = Some(world.time_s());
            }
        }
        // It reaches its stop within the step; the last part of the way is at twice the mean speed.
        // Bearings damp by 1e-6 N m s.
        let arrived_s = arrived_s.expect("it comes to its stop");
        assert!(
            (arrived_s - half_s).abs() < 1.5 * dt_s + 1e-3 * half_s,
            "{arrived_s} {half_s}"
        );
        // At the stop only the floor deflects, by micrometres of a stiff contact.
        let ahead_m = world.robot().state().pose.x_m;
        assert!((ahead_m - half_m).abs() < 2e-6, "{ahead_m} {half_m}");
        // All are at their stops, except for the displacement of the others by the first one's
        // impact, over which the floor holds them.
        let from_stop_m = (0..4).map(|wheel| {
            let place_m = world
                .robot()
                .roller_places_m(wheel)
                .next()
                .expect("a roller");
            (place_m.abs() - 0.5 * PLAY_M).abs()
        });
        let from_stop_m: Vec<f64> = from_stop_m.collect();
        assert!(from_stop_m.iter().all(|m| *m < 5e-6), "{from_stop_m:?}");
        // Back takes twice the way, and root 2 of the time from rest.
        let back_s = world.time_s() + 2.0 * 2f64.sqrt() * half_s;
        while world.time_s() < back_s {
            push_n(&mut world, -FORCE_N, 0.0);
            world.step();
        }
        let back_m = world.robot().state().pose.x_m;
        assert!((ahead_m - back_m - 2.0 * half_m).abs() < 2e-6, "{back_m}");
        // The work of the push is lost at the stops at once: F times the way.
        let pushed_j = FORCE_N * (ahead_m + (ahead_m - back_m));
        assert!((world.outside_energy_j() - pushed_j).abs() < 1e-6 * pushed_j.max(1.0));
        assert!(open_j(&world, began_j).abs() < 1e-2 * pushed_j);
    }
}

/// With a roller straight down under each wheel all axles are level: no force acts along them.
#[test]
fn a_robot_at_rest_stays_at_rest() {
    for robot in [mecanum4(), volksbot()] {
        let robot = with_play(robot, 5e-4);
        let mut world = world(&robot, 1e-3);
        for _ in 0..500 {
            world.step();
        }
        let body = world.robot().state();
        assert!(
            body.pose.position_m().norm() < 1e-7 && body.pose.heading_rad.abs() < 1e-6,
            "{body:?}"
        );
        assert!(
            world
                .robot()
                .wheel_angles_rad()
                .iter()
                .all(|a| a.abs() < 1e-5)
        );
    }
}

/// Gain of the wheels' loops: as soft as those of real robots, so that wheels deflect at the impact
/// on a stop.
const GAIN_N_M_S: f64 = 0.5;

/// The load of a wheel along the way.
struct Pull {
    twist: Twist,
    /// Along the way, in N.
    force_n: f64,
}

/// The results of a drive with a force along the way.
struct Went {
    /// Way over that of the ideal kinematics for the wheels' angles.
    ratio: f64,
    /// The error of the energy balance, over the work of motors and push.
    unexplained: f64,
}

fn went(robot: &Robot, pull: &Pull, dt_s: f64) -> Went {
    let mut world = world(robot, dt_s);
    let targets = ideal_rates(robot, pull.twist);
    let way = Vector3::new(pull.twist.vx_m_s, pull.twist.vy_m_s, 0.0).normalize();
    let began_j = world.energy().kinetic_j + world.energy().potential_j;
    let step = |world: &mut World, share: f64| {
        let rates = world.robot().wheel_rates_rad_s().to_vec();
        let motor = |(target, rate): (&f64, &f64)| {
            MotorTorque::with_droop(GAIN_N_M_S * (share * target - rate), GAIN_N_M_S)
        };
        let motors: Vec<_> = targets.iter().zip(&rates).map(motor).collect();
        world.robot_mut().drive(&motors);
        push_n(
            world,
            share * pull.force_n * way.x,
            share * pull.force_n * way.y,
        );
        world.step();
    };
    while world.time_s() < 0.5 {
        let share = (world.time_s() / 0.4).min(1.0);
        step(&mut world, share);
    }
    let turned = |world: &World| world.robot().wheel_angles_rad()[0].abs();
    // From the middle of one roller to that of another, two turns on.
    let count = robot.wheels[0].rollers.len() as f64;
    let pitch_rad = TAU / count;
    let next = (turned(&world) / pitch_rad).ceil() * pitch_rad;
    while turned(&world) < next {
        step(&mut world, 1.0);
    }
    let (from, from_rad) = (world.robot().state().pose.position_m(), turned(&world));
    while turned(&world) < next + 2.0 * TAU {
        step(&mut world, 1.0);
    }
    let gone_m = (world.robot().state().pose.position_m() - from).dot(&way.xy());
    let speed_m_s = pull.twist.vx_m_s.hypot(pull.twist.vy_m_s);
    let ideal_m = (turned(&world) - from_rad) * speed_m_s / targets[0].abs();
    let worked_j = world.motor_energy_j().abs() + world.outside_energy_j().abs();
    Went {
        ratio: gone_m / ideal_m,
        unexplained: open_j(&world, began_j) / worked_j,
    }
}

/// n p / (2 pi rho cos gamma).
fn lost(robot: &Robot, play_m: f64) -> f64 {
    let wheel = &robot.wheels[0];
    let count = wheel.rollers.len() as f64;
    count * play_m / (TAU * wheel.radius_m * wheel.gamma_rad.cos())
}

fn drives() -> [(&'static str, Twist); 4] {
    [
        ("ahead", Twist::new(0.1, 0.0, 0.0)),
        ("back", Twist::new(-0.1, 0.0, 0.0)),
        ("to the left", Twist::new(0.0, 0.1, 0.0)),
        ("to the right", Twist::new(0.0, -0.1, 0.0)),
    ]
}

/// 35 N against the way exceed the axial load of tilted axles: each roller in turn is pushed
/// through its play before it pulls. The same force along the way meets it at its stop. The loss is
/// of first order in the play.
#[test]
fn a_wheel_that_pulls_loses_its_play_with_each_roller_and_one_that_brakes_none() {
    for (name, twist) in drives() {
        let ratio = |play_m: f64, force_n: f64| {
            let robot = with_play(mecanum4(), play_m);
            let pull = Pull { twist, force_n };
            let went = went(&robot, &pull, 5e-4);
            // Landings, and the ends of slides, are known to a step: 5 mm/s along an axle for 0.5
            // ms.
            assert!(
                went.unexplained.abs() < 2e-3,
                "{name}: {}",
                went.unexplained
            );
            went.ratio
        };
        let [tight_pulled, tight_braked] = [-35.0, 35.0].map(|force_n| ratio(0.0, force_n));
        for play_m in [1e-4, 2e-4] {
            let lost = lost(&mecanum4(), play_m);
            let pulls = (tight_pulled - ratio(play_m, -35.0)) / lost;
            let brakes = (tight_braked - ratio(play_m, 35.0)) / lost;
            println!("{name}, {play_m} m: {lost:.5}, pulls {pulls:.3}, brakes {brakes:.3}");
            // The impacts on stops have an error of some per cent at a step of 0.5 ms. Sideways a
            // roller that comes down does not spin yet, and does not stick along its axle until it
            // does: the load moves it aside, and the second engine shows the same.
            let aside = if twist.vy_m_s == 0.0 { 0.05 } else { 0.15 };
            assert!((pulls - 1.0).abs() < 0.05, "{name}, {play_m}: {pulls}");
            assert!(brakes.abs() < aside, "{name}, {play_m}: {brakes}");
        }
    }
}

/// For small play the effect is proportional to it.
#[test]
fn less_play_nears_none_by_first_order() {
    let course = |play_m: f64| {
        let robot = with_play(mecanum4(), play_m);
        let pull = Pull {
            twist: Twist::new(0.1, 0.0, 0.0),
            force_n: -35.0,
        };
        went(&robot, &pull, 5e-4).ratio
    };
    let tight = course(0.0);
    let apart = [2e-4, 1e-4, 5e-5, 2.5e-5].map(|play_m| (course(play_m) - tight).abs());
    for pair in apart.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        println!("{apart:?} {order}");
        assert!((order - 1.0).abs() < 0.15, "{apart:?}");
    }
}

/// On any floor with rolling resistance and creep, every step with axial play is solved, and the
/// motors' work is accounted for.
#[test]
fn rollers_with_play_are_solved_on_floors_that_drag_and_creep() {
    // A slow circle, in which the robot drives in all directions and turns once.
    const LASTS_S: f64 = 3.0;
    for dt_s in [5e-4, 2e-3] {
        for (rolling_resistance, creep) in
            [(0.0, 0.0), (0.1, 0.0), (0.0, 0.2), (0.1, 0.2), (1.0, 20.0)]
        {
            let surface = FloorSurface {
                rolling_resistance,
                creep,
                ..FloorSurface::default()
            };
            let floor = Floor {
                surface,
                friction: 0.6,
                ..Floor::default()
            };
            let robot = with_play(mecanum4(), 5e-4);
            let mut world =
                World::new(&robot, &floor, Pose::default(), &settings(dt_s)).expect("valid");
            let began_j = world.energy().kinetic_j + world.energy().potential_j;
            let mut worst_m_s = 0_f64;
            while world.time_s() < LASTS_S {
                let (y, x) = (TAU * world.time_s() / LASTS_S).sin_cos();
                let share = (world.time_s() / 0.3).min(1.0);
                let targets = ideal_rates(
                    &robot,
                    Twist::new(0.3 * share * x, 0.3 * share * y, share * TAU / LASTS_S),
                );
                let rates = world.robot().wheel_rates_rad_s().to_vec();
                let motor = |(target, rate): (&f64, &f64)| {
                    MotorTorque::with_droop(GAIN_N_M_S * (target - rate), GAIN_N_M_S)
                };
                let motors: Vec<_> = targets.iter().zip(&rates).map(motor).collect();
                world.robot_mut().drive(&motors);
                world.step();
                worst_m_s = worst_m_s.max(world.contact_residual_m_s());
            }
            let unexplained = open_j(&world, began_j) / world.motor_energy_j();
            println!(
                "{dt_s} s, drag {rolling_resistance}, creep {creep}: {worst_m_s:e}, {unexplained:e}"
            );
            assert!(worst_m_s <= 1e-8, "{worst_m_s:e}");
            // Landings and the ends of slides are known to a step.
            assert!(unexplained.abs() < 2e-3, "{unexplained:e}");
        }
    }
}

fn places(world: &World) -> Vec<u64> {
    let wheels = 0..world.robot().wheel_angles_rad().len();
    let rollers = wheels.flat_map(|wheel| world.robot().roller_places_m(wheel));
    rollers.map(f64::to_bits).collect()
}

fn pose_bits(world: &World) -> [u64; 3] {
    let pose = world.robot().state().pose;
    [pose.x_m, pose.y_m, pose.heading_rad].map(f64::to_bits)
}

#[test]
fn a_copy_goes_on_and_another_run_comes_out_bit_by_bit() {
    let robot = with_play(mecanum4(), 5e-4);
    let torques = [0.1, -0.05, 0.02, 0.07];
    let go = |world: &mut World, steps: usize| {
        for _ in 0..steps {
            world.robot_mut().apply(&torques);
            world.step();
        }
    };
    let mut one = world(&robot, 1e-3);
    go(&mut one, 400);
    let mut copy = one.clone();
    go(&mut one, 400);
    go(&mut copy, 400);
    let mut again = world(&robot, 1e-3);
    go(&mut again, 800);
    for other in [copy, again] {
        assert_eq!(pose_bits(&one), pose_bits(&other));
        assert_eq!(places(&one), places(&other));
    }
    assert!(places(&one).iter().any(|bits| *bits != 0));
    // After a change of load, rollers keep their positions on their axles.
    let before = places(&one);
    one.robot_mut()
        .carry(&[ilon_world::Payload::new(2.0, Vector3::new(0.0, 0.0, 0.1)).expect("a mass")]);
    assert_eq!(places(&one), before);
}

#[test]
fn rollers_near_the_ground_alone_do_as_all_do() {
    let robot = with_play(mecanum4(), 5e-4);
    let end = |roller_bodies| {
        let settings = Settings {
            roller_bodies,
            ..settings(1e-3)
        };
        let mut world = World::new(&robot, &Floor::default(), Pose::default(), &settings).unwrap();
        for _ in 0..800 {
            world.robot_mut().apply(&[0.1, -0.05, 0.02, 0.07]);
            world.step();
        }
        (pose_bits(&world), places(&world))
    };
    assert_eq!(end(RollerBodies::All), end(RollerBodies::Near));
}

/// A wheel that turns in the air: each roller is at its lower end, except where its axle is level.
#[test]
fn in_the_air_rollers_lie_at_their_lower_ends() {
    let robot = with_play(mecanum4(), 4e-4);
    let mut world = world(&robot, 1e-3);
    for _ in 0..100 {
        world.step();
    }
    for (index, wheel) in robot.wheels.iter().enumerate() {
        let turned = wheel.body_from_hub.rotation;
        for (roller, place_m) in wheel
            .rollers
            .iter()
            .zip(world.robot().roller_places_m(index))
        {
            let down = -(turned * roller.axis_in_hub.into_inner()).z;
            if down.abs() > 1e-9 {
                assert_eq!(place_m, 2e-4f64.copysign(down));
            }
        }
    }
}

#[test]
fn play_that_is_none_is_refused_and_by_rapier_all_of_it() {
    let refused = |play_m: f64, contacts| {
        let settings = Settings {
            contacts,
            ..Settings::default()
        };
        let robot = with_play(mecanum4(), play_m);
        World::new(&robot, &Floor::default(), Pose::default(), &settings).err()
    };
    for play_m in [-1e-4, 0.2, f64::NAN, f64::INFINITY] {
        let fault = refused(play_m, ContactSolver::Ilon);
        assert!(
            matches!(&fault, Some(WorldError::Wheel { reason, .. }) if reason.contains("a play of")),
            "{play_m}"
        );
    }
    let fault = refused(1e-4, ContactSolver::Rapier);
    assert!(matches!(fault, Some(WorldError::NotInRapier { .. })));
    assert_eq!(refused(0.0, ContactSolver::Rapier), None);
}
