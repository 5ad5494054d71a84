//! Wheels with spheres for rollers, as in published simulations: the effect of their number on the
//! base.

use std::f64::consts::{FRAC_PI_4, PI};

use ilon_formats::{LoadOptions, LoadRobot};
use ilon_robot::Robot;
use ilon_sim::{Scenario, inspect::Inspection};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");

/// For eight spheres on a ring of 59.4 mm: the travel of a wheel at an angle, in metres, with a
/// sphere straight down at 0. The lowest point of a sphere at psi from there moves with w (59.4
/// cos(psi) + 16.5) mm.
fn rolled_m(wheel_angle_rad: f64) -> f64 {
    let half = 0.5 * FRAC_PI_4;
    let spheres = (wheel_angle_rad / FRAC_PI_4).round();
    let psi = wheel_angle_rad - spheres * FRAC_PI_4;
    0.0594 * (2.0 * half.sin() * spheres + psi.sin()) + 0.0165 * wheel_angle_rad
}

/// The wheels of the right side are half a sphere ahead: the base yaws by the difference of the
/// travels of both sides, over twice the lever of rotations, 275.5 + 260 mm, eight times a turn.
/// The value of PickNikRobotics/moveit_pro_example_ws, pull request 875, 2 x 4.52 / 275.5 = 1.881
/// deg, takes the rise of the hubs for a travel along the floor. The base also rolls, by 4.5 mm
/// over its track, which is not included: hence a tolerance of a tenth.
#[test]
fn two_sides_in_antiphase_yaw_by_the_difference_of_what_they_roll() {
    let text = "robot.file = \"spheres.toml\"\n\
                robot.spec.overrides = { front_right = { phase_deg = 22.5 }, rear_right = { phase_deg = 22.5 } }\n\
                twist = { vx_m_s = 0.15 }\nrun = { duration_s = 4.5, control_dt_s = 0.005 }\n";
    let scenario = Scenario::from_toml(text, "spheres", FOLDER).expect("a scenario");
    let run = ilon_sim::run(&scenario).expect("it can be run");
    let twice_lever_m = 2.0 * (0.2755 + 0.26);
    let records = run.trace.records();
    let from = records
        .iter()
        .position(|row| row.t_s >= 1.5)
        .expect("it goes on");
    let (mut yaws, mut expected) = (Vec::new(), Vec::new());
    for (row, record) in records.iter().enumerate().skip(from) {
        let wheels = run.trace.wheels_at(row);
        let side_m = |names: [usize; 2], on: f64| {
            names
                .map(|wheel| rolled_m(wheels[wheel].angle_rad + on))
                .iter()
                .sum::<f64>()
                / 2.0
        };
        yaws.push(record.truth.pose.heading_rad);
        expected.push((side_m([1, 3], 0.5 * FRAC_PI_4) - side_m([0, 2], 0.0)) / twice_lever_m);
    }
    let spread = |values: &[f64]| {
        let (low, high) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(*x), high.max(*x))
            });
        high - low
    };
    let (found, analytic) = (spread(&yaws).to_degrees(), spread(&expected).to_degrees());
    let crossings = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values
            .windows(2)
            .filter(|pair| pair[0] < mean && pair[1] >= mean)
            .count()
    };
    let turned = run.trace.wheels_at(records.len() - 1)[0].angle_rad
        - run.trace.wheels_at(from)[0].angle_rad;
    println!(
        "yaw {found:.4} deg, computed {analytic:.4} deg; {} times in {:.2} turns",
        crossings(&yaws),
        turned / (2.0 * PI)
    );
    assert!((found / analytic - 1.0).abs() < 0.1, "{found} {analytic}");
    let times = turned.abs() / FRAC_PI_4;
    assert!(
        (crossings(&yaws) as f64 - times).abs() < 1.5,
        "{} {times}",
        crossings(&yaws)
    );
}

/// A robot without joints is its chassis and its wheels.
#[test]
fn wheels_and_chassis_have_the_mass_of_the_robot() {
    let (robot, seen) = inspected(|_| {});
    let wheels_kg: f64 = seen.wheels.iter().map(|wheel| wheel.mass_kg).sum();
    // Rounding of sums of some 10 kg.
    let off_kg = robot.chassis.mass.mass_kg + wheels_kg - seen.mass_kg;
    assert!(wheels_kg > 0.0 && off_kg.abs() < 1e-12, "{off_kg}");
}

#[test]
fn of_rollers_that_differ_the_largest_is_stated() {
    let (robot, seen) = inspected(|robot| {
        let roller = &mut robot.wheels[0].rollers[4];
        (roller.radius_m, roller.length_m) = (1.01 * roller.radius_m, 1.01 * roller.length_m);
    });
    let (wheel, largest) = (&seen.wheels[0], &robot.wheels[0].rollers[4]);
    let stated = (wheel.roller_radius_m, wheel.roller_length_m);
    assert_eq!(stated, (largest.radius_m, largest.length_m));
}

fn inspected(change: impl Fn(&mut Robot)) -> (Robot, Inspection) {
    let mut robot = Robot::load(format!("{FOLDER}/mecanum4.urdf")).expect("a shipped robot");
    change(&mut robot);
    let seen = Inspection::of(&robot).expect("four wheels");
    (robot, seen)
}

/// For rollers with a profile by numbers the shapes of their file do not roll, and no radius of
/// theirs is reported; for barrels it is.
#[test]
fn no_radius_is_said_of_shapes_that_do_not_roll() {
    for (file, count) in [("spheres.toml", 0), ("mecanum4.urdf", 4)] {
        let path = format!("{FOLDER}/{file}");
        let loaded = Robot::load_with(path, &LoadOptions::default()).expect("a shipped robot");
        let seen = Inspection::of_loaded(&loaded).expect("four wheels");
        assert_eq!(seen.outlines.len(), count, "{file}");
    }
}
