//! The ideal kinematics and its odometry against what other projects hold theirs to: the numbers of
//! the tests of ros2_controllers (mecanum_drive_controller and omni_wheel_drive_controller, at
//! 94e74de3), of WPILib (MecanumDriveKinematicsTest and MecanumDriveOdometryTest, at caf0fb2d), and
//! of the youBot of Lynch and Park, *Modern Robotics*. Tolerances are theirs: they give as many
//! digits.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_4, TAU};

use ilon_control::Kinematics;
use ilon_formats::LoadRobot;
use ilon_robot::{Pose, Robot, Twist};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector2, Vector3};

fn load(name: &str) -> Robot {
    let path = format!(
        "{}/../../../assets/robots/{name}",
        env!("CARGO_MANIFEST_DIR")
    );
    Robot::load(path).unwrap()
}

/// Four mecanum wheels: front left, front right, rear left, rear right.
fn mecanum(radius_m: f64, x_m: f64, y_m: f64) -> Kinematics {
    let mut robot = load("mecanum4.urdf");
    let places = [(x_m, y_m), (x_m, -y_m), (-x_m, y_m), (-x_m, -y_m)];
    for (wheel, (x_m, y_m)) in robot.wheels.iter_mut().zip(places) {
        wheel.radius_m = radius_m;
        wheel.body_from_hub.translation = Translation3::new(x_m, y_m, radius_m);
    }
    Kinematics::new(&robot).unwrap()
}

/// So many omni wheels on a ring, the first at an angle from ahead.
fn omni(count: usize, first_rad: f64, distance_m: f64, radius_m: f64) -> Kinematics {
    let mut robot = load("volksbot.urdf");
    let mut first = robot.wheels[0].clone();
    let at = first.position_m();
    let back = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -libm::atan2(at.y, at.x));
    first.radius_m = radius_m;
    first.body_from_hub = Isometry3::from_parts(
        Translation3::new(distance_m, 0.0, radius_m),
        back * first.body_from_hub.rotation,
    );
    robot.wheels = (0..count)
        .map(|wheel| {
            let angle_rad = first_rad + TAU * wheel as f64 / count as f64;
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
            let mut wheel = first.clone();
            wheel.body_from_hub = turn * wheel.body_from_hub;
            wheel
        })
        .collect();
    Kinematics::new(&robot).unwrap()
}

#[track_caller]
fn near(found: &[f64], expected: &[f64], tolerance: f64) {
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    let worst = off.fold(0.0, f64::max);
    assert!(
        worst <= tolerance && found.len() == expected.len(),
        "{found:?} for {expected:?}"
    );
}

#[track_caller]
fn asks(kinematics: &Kinematics, twist: [f64; 3], expected: &[f64], tolerance: f64) {
    let mut rates = vec![0.0; expected.len()];
    kinematics.wheel_rates(Twist::new(twist[0], twist[1], twist[2]), &mut rates);
    near(&rates, expected, tolerance);
}

#[track_caller]
fn gives(kinematics: &Kinematics, rates: &[f64], expected: [f64; 3], tolerance: f64) {
    let twist = kinematics.twist(rates);
    near(
        &[twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s],
        &expected,
        tolerance,
    );
}

/// The pose after a second at these rates.
#[track_caller]
fn reaches(kinematics: &Kinematics, rates: &[f64], expected: [f64; 3], tolerance: f64) {
    let pose = Pose::default().moved(kinematics.twist(rates));
    near(
        &[pose.x_m, pose.y_m, pose.heading_rad],
        &expected,
        tolerance,
    );
}

#[test]
fn wheel_rates_of_ros2_controllers_mecanum() {
    let robot = mecanum(0.5, 0.5, 0.5);
    asks(&robot, [10.0, 5.0, 3.0], &[4.0, 36.0, 24.0, 16.0], 1e-3);
    asks(&robot, [1.5, 0.0, 0.0], &[3.0; 4], 1e-3);
}

#[test]
fn wheel_rates_of_ros2_controllers_omni() {
    let twist = [1.0; 3];
    asks(
        &omni(4, 0.0, 0.5, 0.1),
        twist,
        &[-15.0, 5.0, 5.0, -15.0],
        1e-6,
    );
    asks(
        &omni(3, 0.0, 0.5, 0.1),
        twist,
        &[-15.0, 8.66025, -8.66025],
        1e-4,
    );
    asks(
        &omni(3, FRAC_PI_3, 0.5, 0.1),
        twist,
        &[-1.33975, 5.0, -18.6603],
        1e-4,
    );
    asks(
        &omni(4, FRAC_PI_4, 0.5, 0.1),
        twist,
        &[-5.0, 9.14214, -5.0, -19.1421],
        1e-4,
    );
    asks(
        &omni(5, 0.0, 0.5, 0.1),
        twist,
        &[-15.0, 1.4204, 8.96802, -2.78768, -17.6007],
        1e-4,
    );
}

#[test]
fn odometry_of_ros2_controllers_omni() {
    let robot = omni(4, 0.0, 1.0, 0.1);
    reaches(&robot, &[0.0, 10.0, 0.0, -10.0], [1.0, 0.0, 0.0], 1e-5);
    reaches(&robot, &[-10.0, 0.0, 10.0, 0.0], [0.0, 1.0, 0.0], 1e-5);
    reaches(&robot, &[-20.0; 4], [0.0, 0.0, 2.0], 1e-5);
    let arc = [1.032_357_630_145_914_5, 1.110_282_033_601_738_5, 1.0];
    reaches(&robot, &[-15.0, 5.0, -5.0, -25.0], arc, 1e-5);
}

#[test]
fn wheel_speeds_and_odometry_of_wpilib() {
    // Speeds of rims: wheels of radius 1.
    let robot = mecanum(1.0, 12.0, 12.0);
    asks(&robot, [5.0, 0.0, 0.0], &[5.0; 4], 0.1);
    asks(&robot, [0.0, 4.0, 0.0], &[-4.0, 4.0, 4.0, -4.0], 0.1);
    asks(
        &robot,
        [0.0, 0.0, TAU],
        &[-150.79645, 150.79645, -150.79645, 150.79645],
        0.1,
    );
    asks(&robot, [2.0, 3.0, 1.0], &[-25.0, 29.0, -19.0, 23.0], 0.1);
    let about = robot.about(Vector2::new(12.0, 12.0)).unwrap();
    asks(&about, [0.0, 0.0, 1.0], &[0.0, 24.0, -24.0, 48.0], 0.1);
    asks(&about, [5.0, 2.0, 1.0], &[3.0, 31.0, -17.0, 51.0], 0.1);
    gives(
        &robot,
        &[-17.67767, 20.51, -13.44, 16.26],
        [1.413, 2.122, 0.707],
        0.1,
    );
    gives(
        &robot,
        &[0.0, 16.971, -16.971, 33.941],
        [8.48525, -8.48525, 0.707],
        0.1,
    );
    gives(
        &robot,
        &[2.12, 21.92, -12.02, 36.06],
        [12.02, -7.07, 0.707],
        0.1,
    );
    // There a gyroscope gives the turn of 90 degrees, and the wheels the way.
    let way = robot.twist(&[-13.328, 39.986, -13.329, 39.986]);
    let pose = Pose::default().moved(Twist::new(way.vx_m_s, way.vy_m_s, FRAC_PI_2));
    near(
        &[pose.x_m, pose.y_m, pose.heading_rad],
        &[8.4855, 8.4855, FRAC_PI_2],
        0.01,
    );
}

#[test]
fn odometry_of_the_youbot() {
    // There front left, front right, rear right, rear left.
    let robot = mecanum(0.0475, 0.235, 0.15);
    let ours = |[fl, fr, rr, rl]: [f64; 4]| [fl, fr, rl, rr];
    reaches(&robot, &ours([10.0; 4]), [0.475, 0.0, 0.0], 1e-3);
    reaches(
        &robot,
        &ours([-10.0, 10.0, -10.0, 10.0]),
        [0.0, 0.475, 0.0],
        1e-3,
    );
    reaches(
        &robot,
        &ours([-10.0, 10.0, 10.0, -10.0]),
        [0.0, 0.0, 1.234],
        1e-3,
    );
}
