//! Wheels without rollers, against what Coulomb's law says of their places of contact.

use crate::support;

use ilon_robot::{Pose, Robot, Roller};
use ilon_world::{Floor, MotorTorque, Settings, World};
use nalgebra::{Matrix3, Vector2, Vector3};
use support::mecanum4;
use test_case::test_case;

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

/// In a steady turn each place slides as in the last step, and starts from its own impulse there:
/// hardly more than one step of Newton's method corrects it. Starting from another place's impulse,
/// of another direction, takes three.
#[test]
fn each_place_of_a_tyre_continues_from_its_own_impulse() {
    let mut world = world(&skid(), 1e-3);
    let rates_rad_s = [-3.0, 3.0, -3.0, 3.0];
    turn(&mut world, &rates_rad_s, 2.0);
    let (mut newton_steps, mut searches) = (0, 0);
    for _ in 0..200 {
        turn(&mut world, &rates_rad_s, 1e-3);
        newton_steps += world.contact_solution().newton_steps;
        searches += world.contact_solution().searches;
    }
    assert!(
        2 * newton_steps <= 3 * searches,
        "{newton_steps} in {searches}"
    );
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

/// The twist (v_x, v_y, omega) of the origin at which a turning skid robot stays: the forces of the
/// three places of each tyre, a third of mu N each against their sliding, keep the centre of mass
/// on its circle, and have no moment about it. Wheels stand at (+-x, +-y); the loads bear the
/// weight, and the moment of the accelerated centre over the floor.
fn by_coulomb(robot: &Robot, friction: f64, rates_rad_s: &[f64]) -> Vector3<f64> {
    let (mass_kg, center_m) = (robot.mass_kg(), robot.center_of_mass_m());
    let height_m = robot.ride_height_m() + center_m.z;
    let center_m = center_m.xy();
    let missing = |twist: Vector3<f64>| {
        let omega = twist.z;
        let velocity = |at: Vector2<f64>| twist.xy() + omega * Vector2::new(-at.y, at.x);
        let v = velocity(center_m);
        // The acceleration of the centre, which turns with the body.
        let a = omega * Vector2::new(-v.y, v.x);
        let leans_n_m = mass_kg * (9.81 * center_m - height_m * a);
        let mut sum = Vector3::new(-mass_kg * a.x, -mass_kg * a.y, 0.0);
        for (wheel, rate) in robot.wheels.iter().zip(rates_rad_s) {
            let hub_m = wheel.position_m().xy();
            let lean_n = leans_n_m.component_div(&hub_m).sum();
            let load_n = 0.25 * (9.81 * mass_kg + lean_n);
            for side in [-1.0, 0.0, 1.0] {
                let at = hub_m + Vector2::new(0.0, side * (0.5 * WIDTH_M - SHOULDER_M));
                let slides = velocity(at) - Vector2::new(wheel.radius_m * rate, 0.0);
                let force = -friction * load_n / 3.0 * slides / slides.norm();
                sum += force.push((at - center_m).perp(&force));
            }
        }
        sum
    };
    // Newton's method, never away from the solution, from a turn about the middle of all tyres.
    let mut twist = Vector3::new(0.0, 0.0, 0.5);
    for _ in 0..50 {
        let now = missing(twist);
        let column = |axis: usize| (missing(twist + 1e-7 * Vector3::ith(axis, 1.0)) - now) / 1e-7;
        let slope = Matrix3::from_columns(&[column(0), column(1), column(2)]);
        let step = slope.lu().solve(&now).expect("friction falls with sliding");
        let ways = (0..30).map(|halvings| twist - step * 0.5_f64.powi(halvings));
        let nearer = |way: &Vector3<f64>| missing(*way).norm() < now.norm();
        twist = ways.into_iter().find(nearer).unwrap_or(twist);
    }
    assert!(missing(twist).norm() < 1e-6, "{twist}");
    twist
}

/// Wheels `x_m` ahead and behind, `y_m` to both sides, and the chassis's centre ahead by `ahead_m`:
/// the robot turns on the spot as Coulomb's law says, also where its axles carry different loads,
/// and it turns about a point behind its middle.
#[test_case(0.6, 0.15, 0.16, 0.0; "as long as wide")]
#[test_case(0.9, 0.20, 0.12, 0.0; "long")]
#[test_case(0.3, 0.08, 0.18, 0.03; "wide, on a slippery floor, loaded ahead")]
fn a_skid_robot_turns_as_coulomb_says(friction: f64, x_m: f64, y_m: f64, ahead_m: f64) {
    let mut robot = skid();
    for wheel in &mut robot.wheels {
        let place = &mut wheel.body_from_hub.translation;
        (place.x, place.y) = (place.x.signum() * x_m, place.y.signum() * y_m);
    }
    robot.chassis.mass.center_of_mass_m.x = ahead_m;
    let floor = Floor {
        friction,
        ..Floor::default()
    };
    let mut world =
        World::new(&robot, &floor, Pose::default(), &Settings::default()).expect("valid");
    let rate = 6.0;
    turn(&mut world, &[-rate, rate, -rate, rate], 3.0);
    // The motors stay behind by what they push with.
    let rates = world.robot().wheel_rates_rad_s();
    let by_hand = by_coulomb(&robot, friction, rates);
    let twist = world.robot().state().twist_in_body;
    let off = Vector3::new(twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s) - by_hand;
    // The places stand where the hubs are; the robot does not lean.
    assert!(
        off.z.abs() < 2e-3 * by_hand.z && off.xy().norm() < 2e-3 * by_hand.z * x_m,
        "{twist:?}, by hand {by_hand}"
    );
}
