//! Wheels without rollers, against what Coulomb's law says of their places of contact.

use crate::support;

use ilon_robot::{Pose, Robot, Roller};
use ilon_world::{Floor, MotorTorque, Settings, World};
use nalgebra::Vector2;
use support::mecanum4;

const WIDTH_M: f64 = 0.03;
const SHOULDER_M: f64 = 0.25 * WIDTH_M;

/// Four wheels with tyres where `mecanum4` has its mecanum wheels.
fn skid() -> Robot {
    let mut robot = mecanum4();
    for wheel in &mut robot.wheels {
        wheel.gamma_rad = 0.0;
        wheel.rollers = vec![Roller::tyre(wheel.radius_m, WIDTH_M, SHOULDER_M).expect("a tyre")];
    }
    robot
}

fn world(robot: &Robot, floor: &Floor, dt_s: f64) -> World {
    let settings = Settings {
        dt_s,
        ..Settings::default()
    };
    World::new(robot, floor, Pose::default(), &settings).expect("valid")
}

/// Brings the wheels to these rates in half a second, and keeps them there.
fn turn(world: &mut World, rates_rad_s: &[f64], time_s: f64) {
    for _ in 0..(time_s / world.dt_s()).round() as usize {
        let share = (world.time_s() / 0.5).min(1.0);
        let now = world.robot().wheel_rates_rad_s().to_vec();
        let motor = |(target, rate): (&f64, &f64)| MotorTorque::with_droop(20.0 * (share * target - rate), 20.0);
        let motors: Vec<_> = rates_rad_s.iter().zip(&now).map(motor).collect();
        world.robot_mut().drive(&motors);
        world.step();
    }
}

#[test]
fn a_tyre_rolls_ahead_by_its_radius_and_slides_nowhere() {
    for dt_s in [1e-3, 4e-3] {
        let robot = skid();
        let mut world = world(&robot, &Floor::default(), dt_s);
        turn(&mut world, &[6.0; 4], 3.0);
        let state = world.robot().state();
        let turned_rad: f64 = world.robot().wheel_angles_rad().iter().sum::<f64>() / 4.0;
        eprintln!("{dt_s} {} {} {:?}", state.pose.x_m, 0.05 * turned_rad, world.robot().contacts());
        assert!(state.pose.y_m.abs() < 1e-9 && state.pose.heading_rad.abs() < 1e-9);
    }
}

/// Turning on the spot every place slides, and their moments about the middle cancel.
#[test]
fn a_skid_robot_turns_as_coulomb_says() {
    let robot = skid();
    let floor = Floor::default();
    let mut world = world(&robot, &floor, 1e-3);
    let rate = 6.0;
    turn(&mut world, &[-rate, rate, -rate, rate], 3.0);
    let omega = world.robot().state().twist_in_body.omega_rad_s;
    // The places of one wheel, by symmetry those of all: equal loads at both shoulders.
    let moment = |omega: f64| -> f64 {
        let along = [-1.0, 1.0].map(|side| {
            let at = Vector2::new(0.15, 0.16 + side * (0.5 * WIDTH_M - SHOULDER_M));
            let slides = Vector2::new(-omega * at.y + 0.05 * rate, omega * at.x);
            let force = -slides / slides.norm();
            at.x * force.y - at.y * force.x
        });
        along.iter().sum()
    };
    let (mut low, mut high) = (0.0, 3.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if moment(middle) > 0.0 { low = middle } else { high = middle }
    }
    assert!((omega / low - 1.0).abs() < 1e-2, "{omega} rad/s, by hand {low}");
}
