//! Wheels without rollers, against what Coulomb's law says of their places of contact.

use crate::support;

use ilon_robot::{Pose, Robot, Roller};
use ilon_world::{Floor, MotorTorque, Settings, World};
use nalgebra::Vector2;
use support::mecanum4;

const WIDTH_M: f64 = 0.03;
const SHOULDER_M: f64 = 0.125 * WIDTH_M;

/// Four wheels with tyres where `mecanum4` has its mecanum wheels.
fn skid() -> Robot {
    let mut robot = mecanum4();
    for wheel in &mut robot.wheels {
        wheel.gamma_rad = 0.0;
        wheel.rollers =
            vec![Roller::tyre(&wheel.name, wheel.radius_m, WIDTH_M, SHOULDER_M).expect("a tyre")];
    }
    robot
}

fn world(robot: &Robot, dt_s: f64) -> World {
    let settings = Settings {
        dt_s,
        ..Settings::default()
    };
    World::new(robot, &Floor::default(), Pose::default(), &settings).expect("valid")
}

/// Brings the wheels to these rates in half a second, and keeps them there.
fn turn(world: &mut World, rates_rad_s: &[f64], time_s: f64) {
    for _ in 0..(time_s / world.dt_s()).round() as usize {
        let share = (world.time_s() / 0.5).min(1.0);
        let now = world.robot().wheel_rates_rad_s().to_vec();
        let motor = |(target, rate): (&f64, &f64)| {
            MotorTorque::with_droop(20.0 * (share * target - rate), 20.0)
        };
        let motors: Vec<_> = rates_rad_s.iter().zip(&now).map(motor).collect();
        world.robot_mut().drive(&motors);
        world.step();
    }
}

/// The way is the radius times the angle but for the shear of the tread, which the pull of the
/// speeding up bends and leaves bent: it ends without a pull. A seized or freed roller is none of a
/// tyre.
#[test]
fn a_tyre_rolls_ahead_by_its_radius_and_slides_nowhere() {
    for dt_s in [1e-3, 4e-3] {
        let mut world = world(&skid(), dt_s);
        world.robot_mut().seize_roller(0, 0, false);
        turn(&mut world, &[6.0; 4], 3.0);
        let state = world.robot().state();
        let turned_rad: f64 = world.robot().wheel_angles_rad().iter().sum::<f64>() / 4.0;
        let off_m = state.pose.x_m - 0.05 * turned_rad;
        assert!(off_m.abs() < 1e-5, "{dt_s}: {off_m}");
        assert!(state.pose.y_m.abs() < 1e-9 && state.pose.heading_rad.abs() < 1e-9);
        // What the treads damp: a thousandth of the kinetic energy, 12 kg at 0.3 m/s.
        assert!(world.slip_energy_j() < 5e-4, "{}", world.slip_energy_j());
    }
}

/// A push to the side below the grip does not move it, and above the grip it slides.
#[test]
fn a_tyre_holds_the_robot_sideways_up_to_its_grip() {
    let robot = skid();
    let grip_n = 0.6 * robot.mass_kg() * 9.81;
    for (share, slides) in [(0.95, false), (1.05, true)] {
        let mut world = world(&robot, 1e-3);
        for _ in 0..500 {
            world.robot_mut().push(&ilon_world::Push {
                force_in_world_n: nalgebra::Vector3::new(0.0, share * grip_n, 0.0),
                place_in_body_m: nalgebra::Vector3::zeros(),
            });
            world.step();
        }
        // Above the grip it speeds up by 0.05 x 0.6 g for half a second: 37 mm; below it the treads
        // bend by tenths of a millimetre.
        let moved_m = world.robot().state().pose.y_m;
        assert_eq!(moved_m > 0.03, slides, "{share}: {moved_m}");
        assert!(slides || moved_m < 1e-3, "{share}: {moved_m}");
    }
}

/// Turning on the spot every place slides, and their moments about the middle cancel.
#[test]
fn a_skid_robot_turns_as_coulomb_says() {
    let mut world = world(&skid(), 1e-3);
    let rate = 6.0;
    turn(&mut world, &[-rate, rate, -rate, rate], 3.0);
    let omega = world.robot().state().twist_in_body.omega_rad_s;
    // The motors stay behind by what they push with.
    let rates = world.robot().wheel_rates_rad_s();
    let rate = rates.iter().map(|rate| rate.abs()).sum::<f64>() / 4.0;
    // The places of one wheel, by symmetry those of all: a third of the load each.
    let moment = |omega: f64| -> f64 {
        let along = [-1.0, 0.0, 1.0].map(|side| {
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
        if moment(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    // The places stand where the hubs are; the robot does not lean.
    assert!(
        (omega / low - 1.0).abs() < 2e-3,
        "{omega} rad/s, by hand {low}"
    );
}
