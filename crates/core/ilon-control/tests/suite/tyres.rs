//! What tyres leave of the twists: dimensions, speeds and the sharpest turn.

use ilon_control::{Arrangement, Kinematics, SpeedLimits, sharpest_turn};
use ilon_formats::LoadRobot;
use ilon_robot::{Robot, Twist};

fn shipped(name: &str) -> Robot {
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    let file = std::path::Path::new(robots).join(format!("{name}.urdf"));
    let text = std::fs::read_to_string(file).expect("a shipped robot");
    Robot::from_urdf_str(&text, name).expect("a shipped robot")
}

fn limits(robot: &Robot) -> (Kinematics, SpeedLimits) {
    let kinematics = Kinematics::new(robot).expect("it drives");
    let rates: Vec<f64> = robot
        .wheels
        .iter()
        .map(|w| w.motor.velocity_rad_s)
        .collect();
    let limits = SpeedLimits::new(&kinematics, &rates);
    (kinematics, limits)
}

/// Wheels that roll ahead alone have rows of M in one plane; modules that stand ahead do not limit
/// where they can be turned to.
#[test]
fn ranks_and_reachable_twists_are_told_apart() {
    for (name, reachable, rows) in [
        ("differential", 2, 1),
        ("skid4", 2, 1),
        ("swerve4", 3, 4),
        ("tricycle", 2, 2),
    ] {
        let found = Arrangement::of(&shipped(name)).expect("it is on wheels");
        let of = (found.reachable, found.held.len());
        assert_eq!((found.rank, of), (3, (reachable, rows)), "{name}");
    }
    let found = Arrangement::of(&shipped("skid4")).expect("it is on wheels");
    // Axles at x = +-0.15 m.
    assert!((found.held[0].axles_apart_m - 0.3).abs() < 1e-12);
}

/// Wheels of 50 mm at 30 rad/s: 1.5 m/s in every direction, and over the 0.32 m to the modules.
#[test]
fn a_swerve_robot_is_as_fast_in_every_direction() {
    let (_, limits) = limits(&shipped("swerve4"));
    let (least, most) = limits.top_speed_range_m_s();
    assert!(
        (least - 1.5).abs() + (most - 1.5).abs() < 1e-12,
        "{least} {most}"
    );
    assert!((limits.top_yaw_rate_rad_s() - 1.5 / 0.25_f64.hypot(0.2)).abs() < 1e-12);
    // At a yaw rate all corners lie on the edge; straight ahead sqrt(1.5^2 - (0.25 w)^2) - 0.2 w.
    let omega = 2.0;
    let corners = limits.at_yaw_rate(omega);
    assert!(corners.len() > 8);
    for v in &corners {
        let share = limits.share(Twist::new(v.x, v.y, omega));
        // Sides of 4 degrees lie within the arc by 1 - cos 2 deg.
        assert!(
            share < 1.0 + 1e-9 && share > 2_f64.to_radians().cos() - 1e-9,
            "{share}"
        );
    }
    let ahead = corners.iter().map(|v| v.x).fold(0.0, f64::max);
    let expected = (1.5_f64.powi(2) - (0.25 * omega).powi(2)).sqrt() - 0.2 * omega;
    assert!((ahead - expected).abs() < 1.5 * (1.0 - 2_f64.to_radians().cos()) + 1e-9);
}

/// rho q' = 1.8 m/s ahead, and at a yaw rate w what 0.17 w of the outer wheel leaves.
#[test]
fn a_differential_robot_has_one_direction() {
    let (_, limits) = limits(&shipped("differential"));
    let (least, most) = limits.top_speed_range_m_s();
    assert!(least == 0.0 && (most - 1.8).abs() < 1e-12, "{least} {most}");
    assert!((limits.top_yaw_rate_rad_s() - 1.8 / 0.17).abs() < 1e-9);
    let ends = limits.at_yaw_rate(4.0);
    assert_eq!(ends.len(), 2);
    for v in ends {
        assert!(
            (v.x.abs() - (1.8 - 0.17 * 4.0)).abs() < 1e-9 && v.y.abs() < 1e-12,
            "{v}"
        );
    }
    assert!(limits.at_yaw_rate(11.0).is_empty());
}

/// The steered wheel stands 0.45 m ahead of the axle, and turns by up to 1.3 rad: 0.45 m / tan 1.3.
#[test]
fn a_tricycle_turns_as_sharply_as_its_steering_goes() {
    let robot = shipped("tricycle");
    let turn = sharpest_turn(&robot, &[0.0]).expect("it turns");
    let expected = 0.45 / 1.3_f64.tan();
    assert!(
        (turn.radius_m - expected).abs() < 1e-9,
        "{turn:?} {expected}"
    );
    let (_, limits) = limits(&robot);
    let fastest = 1.0 / limits.share(turn.twist_in_body);
    assert!(
        (fastest - 1.8 / expected.hypot(0.45)).abs() < 1e-9,
        "{fastest}"
    );
    let turned = sharpest_turn(&robot, &[0.7]).expect("it turns");
    assert!((turned.radius_m - expected).abs() < 1e-9, "{turned:?}");
    assert_eq!(sharpest_turn(&shipped("swerve4"), &[0.0; 4]), None);
}

/// The rates of free wheels follow from the driven ones: those given for them count for nothing, and
/// robots whose motors determine no motion keep theirs.
#[test]
fn free_wheels_roll_along_with_the_driven_ones() {
    let kinematics = Kinematics::new(&shipped("tricycle")).expect("a tricycle");
    let mut expected = [0.0; 3];
    kinematics.wheel_rates(Twist::new(0.3, 0.0, 0.0), &mut expected);
    let drive = expected.map(f64::abs).into_iter().fold(0.0, f64::max);
    assert!((drive - 0.3 / 0.06).abs() < 1e-12);
    let driven = |wheel: usize| kinematics.wheels()[wheel].motor.effort_n_m > 0.0;
    let mut rates = [0, 1, 2].map(|wheel| if driven(wheel) { expected[wheel] } else { -7.0 });
    kinematics.roll_idle(&mut rates);
    for (is, should) in rates.iter().zip(expected) {
        assert!((is - should).abs() < 1e-12, "{rates:?}");
    }
    // Two of three omni wheels determine no motion, however they stand.
    for angle_deg in 0..90 {
        let mut two = Robot::load("../../../assets/robots/volksbot.toml").expect("a robot");
        let turn = nalgebra::Isometry3::rotation(
            nalgebra::Vector3::z() * f64::from(angle_deg).to_radians(),
        );
        for wheel in &mut two.wheels {
            wheel.body_from_hub = turn * wheel.body_from_hub;
        }
        two.wheels[1].motor.effort_n_m = 0.0;
        let mut rates = [1.0, -7.0, 0.5];
        Kinematics::new(&two)
            .expect("three wheels")
            .roll_idle(&mut rates);
        assert_eq!(rates, [1.0, -7.0, 0.5], "at {angle_deg} degrees");
    }
    let mut idle = shipped("tricycle");
    idle.wheels
        .iter_mut()
        .for_each(|wheel| wheel.motor.effort_n_m = 0.0);
    let kinematics = Kinematics::new(&idle).expect("a tricycle");
    let mut rates = [1.0, 2.0, 3.0];
    kinematics.roll_idle(&mut rates);
    assert_eq!(rates, [1.0, 2.0, 3.0]);
}

/// Two tyres one behind the other turn the robot about no point: their ways are one line.
#[test]
fn tyres_in_line_are_refused_in_words_of_tyres() {
    let mut robot = shipped("differential");
    for (wheel, x_m) in robot.wheels.iter_mut().zip([0.2, -0.2]) {
        wheel.body_from_hub.translation.x = x_m;
        wheel.body_from_hub.translation.y = 0.0;
    }
    let words = Kinematics::new(&robot)
        .expect_err("it cannot turn")
        .to_string();
    assert!(
        words.contains("the ways of all wheels pass through (0.0000, 0.0000) m"),
        "{words}"
    );
    assert!(!words.contains("roller"), "{words}");
}
