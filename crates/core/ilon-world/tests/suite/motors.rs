//! Motor torques within a step: rate limits and gears; and the robot's velocity after it.

use crate::support;

use ilon_robot::{Pose, Robot};
use ilon_world::{Floor, MotorTorque, Payload, RollerBodies, Settings, World};
use support::mecanum4;

fn on_ice(robot: &Robot, dt_s: f64) -> World {
    let floor = Floor {
        friction: 0.0,
        ..Floor::default()
    };
    let settings = Settings {
        dt_s,
        roller_bodies: RollerBodies::Near,
        ..Settings::default()
    };
    World::new(robot, &floor, Pose::default(), &settings).expect("valid")
}

/// A light wheel that its motor would take far beyond the limit within a step ends at the limit, in
/// either sense and from any rate.
#[test]
fn no_motor_drives_beyond_its_rate_limit_in_either_sense() {
    const LIMIT_RAD_S: f64 = 5.0;
    for dt_s in [1e-3, 4e-3, 1e-2] {
        let mut world = on_ice(&mecanum4(), dt_s);
        for signs in [[1.0, 1.0, -1.0, -1.0], [-1.0, 1.0, 1.0, -1.0]] {
            let motors = signs.map(|sign| MotorTorque {
                rate_limit_rad_s: LIMIT_RAD_S,
                ..MotorTorque::constant(20.0 * sign)
            });
            for _ in 0..20 {
                world.robot_mut().drive(&motors);
                world.step();
                for (rate, sign) in world.robot().wheel_rates_rad_s().iter().zip(signs) {
                    // The solver ends at a residual far below this.
                    assert!(rate * sign < LIMIT_RAD_S + 1e-4, "{dt_s}: {rate}");
                }
            }
            for (rate, sign) in world.robot().wheel_rates_rad_s().iter().zip(signs) {
                assert!((rate * sign - LIMIT_RAD_S).abs() < 1e-4, "{dt_s}: {rate}");
            }
            // There it gives the torque that keeps a lossless wheel at its rate: zero.
            for torque_n_m in world.robot().motor_torques_n_m() {
                assert!(torque_n_m.abs() < 1e-4, "{dt_s}: {torque_n_m}");
            }
        }
    }
}

/// A payload at the chassis's centre of mass is driven like a chassis with that additional mass, at
/// steps in which a loop changes the wheels' rates a lot.
///
/// D dt / J is 1 for the bare robot, and 0.4 with 20 kg: if the loop assumed the bare robot, its
/// mean torque would be off by 5 %, and the wheels' gain in their first steps by 1 %. Both worlds
/// are at rest before; the rest of the settling is of the order of its last change in height, 1e-4
/// of the wheels' forces.
#[test]
fn a_payload_is_driven_as_a_heavier_chassis_is() {
    const CARRIED_KG: f64 = 20.0;
    let (bare, mut heavy) = (mecanum4(), mecanum4());
    heavy.chassis.mass.mass_kg += CARRIED_KG;
    let settings = Settings {
        dt_s: 0.01,
        roller_bodies: RollerBodies::Near,
        ..Settings::default()
    };
    let gained = |robot: &Robot, payloads: &[Payload]| {
        let mut world =
            World::new(robot, &Floor::default(), Pose::default(), &settings).expect("valid");
        world.robot_mut().carry(payloads);
        let mut after = Vec::new();
        for step in 0..110 {
            let target_rad_s = if step < 100 { 0.0 } else { 2.0 };
            let motors: Vec<MotorTorque> = (world.robot().wheel_rates_rad_s().iter())
                .map(|rate| MotorTorque::with_droop(0.7 * (target_rad_s - rate), 0.7))
                .collect();
            world.robot_mut().drive(&motors);
            world.step();
            if step >= 100 {
                after.push(world.robot().wheel_rates_rad_s()[0]);
            }
        }
        after
    };
    let center_m = bare.chassis.mass.center_of_mass_m;
    let payload = Payload::new(CARRIED_KG, center_m).expect("a payload");
    let (carried, built_in) = (gained(&bare, &[payload]), gained(&heavy, &[]));
    for (carried, built_in) in carried.iter().zip(&built_in) {
        println!("{carried:.5} {built_in:.5}");
        assert!(
            (carried / built_in - 1.0).abs() < 1e-3,
            "{carried} {built_in}"
        );
    }
}

/// A gear of efficiency 0.8 accelerates its wheel by 0.8 of what a gear without losses does under a
/// constant torque, from the first step to the last; a distant rate limit has no effect.
#[test]
fn a_gear_takes_its_share_of_a_constant_torque_from_the_first_step_on() {
    let turned = |efficiency: f64, rate_limit_rad_s: f64| {
        let mut robot = mecanum4();
        for wheel in &mut robot.wheels {
            wheel.drive.gear_efficiency = efficiency;
            (wheel.joint.friction_n_m, wheel.joint.damping_n_m_s) = (0.0, 0.0);
        }
        let mut world = on_ice(&robot, 1e-3);
        let motor = MotorTorque {
            rate_limit_rad_s,
            ..MotorTorque::constant(0.01)
        };
        for _ in 0..20 {
            world.robot_mut().drive(&[motor; 4]);
            world.step();
        }
        world.robot().wheel_rates_rad_s()[0]
    };
    let share = turned(0.8, 100.0) / turned(1.0, 100.0);
    assert!((share - 0.8).abs() < 1e-5, "{share}");
    assert!((turned(0.8, f64::INFINITY) - turned(0.8, 100.0)).abs() < 1e-12);
}

/// In a turn the velocity read after a step is that with which the pose moves, also in steps that
/// do not resolve rollers: in the frame of a step's end it would show a lateral slip of v omega dt
/// / 2, here 5 mm/s.
#[test]
fn the_twist_of_long_steps_is_that_of_the_motion() {
    const DT_S: f64 = 1e-2;
    let robot = mecanum4();
    let settings = Settings {
        dt_s: DT_S,
        roller_bodies: RollerBodies::Near,
        ..Settings::default()
    };
    let mut world =
        World::new(&robot, &Floor::default(), Pose::default(), &settings).expect("valid");
    let target = support::ideal_rates(&robot, ilon_robot::Twist::new(1.0, 0.0, 1.0));
    let (mut read_m_s, mut moved_m_s, mut count) = (0.0, 0.0, 0.0);
    for step in 0..300 {
        let share = (f64::from(step) / 100.0).min(1.0);
        let rates = world.robot().wheel_rates_rad_s().to_vec();
        let motors: Vec<MotorTorque> = (target.iter().zip(rates))
            .map(|(target, rate)| MotorTorque::with_droop(2.0 * (share * target - rate), 2.0))
            .collect();
        world.robot_mut().drive(&motors);
        let before = world.robot().state().pose;
        world.step();
        let body = world.robot().state();
        if step >= 150 {
            read_m_s += body.twist_in_body.vy_m_s;
            moved_m_s += before.displacement_to(&body.pose).vy_m_s / DT_S;
            count += 1.0;
        }
    }
    let off_m_s = (read_m_s - moved_m_s) / count;
    // The error is of second order: v omega^2 dt^2 / 12 = 8e-6 m/s, and hand-overs within a step.
    assert!(off_m_s.abs() < 1e-4, "{off_m_s}");
}
