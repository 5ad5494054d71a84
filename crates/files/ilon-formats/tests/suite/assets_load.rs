//! The models of the shipped robots, against figures derived by hand.

use crate::common;

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI};
use std::path::Path;

use approx::assert_relative_eq;
use common::options;
use ilon_formats::{LoadRobot, RollerForms};
use ilon_robot::Robot;
use nalgebra::{Vector2, Vector3};

fn load(name: &str) -> Robot {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../assets/robots")
        .join(format!("{name}.urdf"));
    Robot::load(path).unwrap_or_else(|e| panic!("{e}"))
}

// The files hold fifteen significant digits; the sum of a dozen products of them stays within this.
const TOLERANCE: f64 = 1e-13;

#[test]
fn mecanum4_is_read_as_described() {
    let robot = load("mecanum4");
    assert_eq!(robot.name, "mecanum4");
    assert_eq!(robot.chassis.name, "base_link");
    // 10 kg, four hubs of 0.25 kg, 36 rollers of 0.01 kg.
    assert_relative_eq!(robot.mass_kg(), 11.36, epsilon = TOLERANCE);
    assert_relative_eq!(robot.ride_height_m(), 0.0, epsilon = TOLERANCE);
    let names: Vec<&str> = robot.wheels.iter().map(|w| w.name.as_str()).collect();
    assert_eq!(
        names,
        ["front_left", "front_right", "rear_left", "rear_right"]
    );
    for (wheel, (x, y, sign)) in robot.wheels.iter().zip([
        (0.15, 0.16, -1.0),
        (0.15, -0.16, 1.0),
        (-0.15, 0.16, 1.0),
        (-0.15, -0.16, -1.0),
    ]) {
        assert_relative_eq!(
            wheel.position_m(),
            Vector3::new(x, y, 0.05),
            epsilon = TOLERANCE
        );
        assert_relative_eq!(wheel.axis(), Vector2::y(), epsilon = TOLERANCE);
        assert_relative_eq!(wheel.gamma_rad, sign * FRAC_PI_4, epsilon = TOLERANCE);
        assert_relative_eq!(wheel.radius_m, 0.05, epsilon = TOLERANCE);
        // Solid cylinder along the hub axis, z of the hub frame: m r^2 / 2 and m (3 r^2 + h^2)
        // / 12.
        assert_relative_eq!(wheel.hub.mass_kg, 0.25, epsilon = TOLERANCE);
        assert_relative_eq!(
            wheel.hub.inertia_kg_m2[(2, 2)],
            0.25 * 0.03 * 0.03 / 2.0,
            epsilon = 1e-17
        );
        assert_relative_eq!(
            wheel.hub.inertia_kg_m2[(0, 0)],
            0.25 * (3.0 * 0.03 * 0.03 + 0.04 * 0.04) / 12.0,
            epsilon = 1e-17
        );
        assert_eq!(wheel.motor.effort_n_m, 1.8);
        assert_eq!(wheel.motor.velocity_rad_s, 30.0);
        assert_eq!(wheel.joint.damping_n_m_s, 1e-3);
        assert_eq!(wheel.rollers.len(), 9);
        for roller in &wheel.rollers {
            assert_relative_eq!(roller.radius_m, 0.012, epsilon = TOLERANCE);
            assert_relative_eq!(roller.ring_radius_m(), 0.038, epsilon = TOLERANCE);
            // L = 2 a tan(pi/n) / cos(gamma).
            let length_m = 2.0 * 0.038 * (PI / 9.0).tan() / FRAC_1_SQRT_2;
            assert_relative_eq!(roller.length_m, length_m, epsilon = TOLERANCE);
            assert_eq!(roller.mass_kg, 0.01);
            assert_eq!(roller.joint.damping_n_m_s, 1e-6);
            // The angle between hub axis and roller axis is 90 deg - 45 deg.
            assert_relative_eq!(
                roller.axis_in_hub.z.abs(),
                FRAC_1_SQRT_2,
                epsilon = TOLERANCE
            );
        }
    }
    // Equation (8): the row of wheel j is proportional to (n_x, n_y, b x n) with n the axis of the
    // roller that points down. The front left wheel's is (1, -1, -0.31) / sqrt 2: the sum of both
    // arms turns the robot.
    let wheel = &robot.wheels[0];
    let (n, b) = (wheel.roller_axis(), wheel.position_m());
    let row = Vector3::new(n.x, n.y, b.x * n.y - b.y * n.x);
    assert_relative_eq!(
        row,
        Vector3::new(-1.0, 1.0, 0.31) * FRAC_1_SQRT_2,
        epsilon = TOLERANCE
    );
}

#[test]
fn volksbot_is_read_as_the_paper_describes_it() {
    let robot = load("volksbot");
    assert_eq!(robot.wheels.len(), 3);
    assert_relative_eq!(robot.mass_kg(), 8.0, epsilon = TOLERANCE);
    for (i, wheel) in robot.wheels.iter().enumerate() {
        let (s, c) = (i as f64 * 2.0 * PI / 3.0).sin_cos();
        assert_relative_eq!(
            wheel.position_m(),
            Vector3::new(0.25 * c, 0.25 * s, 0.05),
            epsilon = TOLERANCE
        );
        assert_relative_eq!(wheel.axis(), Vector2::new(c, s), epsilon = TOLERANCE);
        assert_relative_eq!(wheel.gamma_rad, 0.0, epsilon = TOLERANCE);
        assert_relative_eq!(wheel.radius_m, 0.05, epsilon = TOLERANCE);
        assert_eq!(wheel.rollers.len(), 8);
    }
}

#[test]
fn mecanum6_has_six_wheels_on_one_floor() {
    let robot = load("mecanum6");
    assert_eq!(robot.wheels.len(), 6);
    for wheel in &robot.wheels {
        assert_relative_eq!(wheel.radius_m, 0.0762, epsilon = TOLERANCE);
        assert_relative_eq!(wheel.gamma_rad.abs(), FRAC_PI_4, epsilon = TOLERANCE);
        assert_eq!(wheel.rollers.len(), 12);
    }
}

/// The models are bit-identical on every machine and after every change of the loader. After an
/// intended change, the test prints the new figures.
#[test]
fn every_shipped_robot_loads_to_the_same_bits() {
    let expected: [(&str, u64, u64); 7] = [
        ("mecanum4", 0x8c37_a7c8_5c74_daf3, 0x92c7_6eaf_a4b9_86c2),
        (
            "mecanum4_6_rollers",
            0x83f6_6f85_6c65_180d,
            0x353b_9ea2_08db_d1d2,
        ),
        (
            "mecanum4_12_rollers",
            0x2910_8df4_f71c_beac,
            0x9521_b1ab_f3d8_8647,
        ),
        (
            "mecanum4_payload",
            0x1c96_5312_42a1_984a,
            0xaa23_c925_30a1_751f,
        ),
        (
            "mecanum4_hard_rollers",
            0x506b_7a59_a6ec_8eef,
            0x98d6_1a24_25ff_9486,
        ),
        ("volksbot", 0x86cd_7f76_c12a_f9cb, 0x647a_782b_59ed_9489),
        ("mecanum6", 0x2fc0_daf1_a50b_d48b, 0x5ed4_2834_2018_4647),
    ];
    let found = expected.map(|(name, ..)| {
        let with = |rollers| {
            let options = options(|o| {
                o.rollers = rollers;
            });
            let path = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../../../assets/robots")
                .join(format!("{name}.urdf"));
            let loaded = Robot::load_with(path, &options).unwrap_or_else(|e| panic!("{e}"));
            common::fingerprint(&loaded.robot)
        };
        (
            name,
            with(RollerForms::Barrel),
            with(RollerForms::AsModelled),
        )
    });
    assert_eq!(found, expected, "{found:#x?}");
}
