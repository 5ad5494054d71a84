use approx::assert_relative_eq;
use nalgebra::{Matrix3, Vector3};

use super::{Law, carried, error, poses, taken};
use crate::planar::drives::PlanarDrive;

fn law() -> Law {
    Law {
        shortfall: Matrix3::from_diagonal(&Vector3::new(1.0, 0.9, 0.8)),
        proportional_per_s: Vector3::new(20.0, 30.0, 40.0),
        integral_per_s2: Vector3::new(100.0, 200.0, 0.0),
        most: Vector3::new(4.0, 3.0, 10.0),
        exponent: 2.0,
        step_s: 1e-4,
    }
}

/// Within the limits the law is of second order: k_p e + k_i z has the closed form of two poles.
#[test]
fn a_small_start_is_that_of_two_poles() {
    let (k_p, k_i, t_s) = (20.0_f64, 100.0, 0.1);
    let came = law().follow(&[Vector3::new(0.01, 0.0, 0.0); 100], t_s / 100.0);
    // Both poles are at -10/s: the error is (1 - 10 t) exp(-10 t), as its rate at the start is
    // -k_p.
    assert_eq!(k_p * k_p, 4.0 * k_i);
    let missing = (1.0 - 10.0 * t_s) * (-10.0 * t_s).exp();
    // Explicit steps of 0.1 ms have a relative error of half a step: 20/s * 0.1 ms / 2.
    assert_relative_eq!(came[99].x, 0.01 * (1.0 - missing), epsilon = 0.01 * 2e-3);
}

/// The reached share stays below 1, and a hard start takes speed over the largest acceleration.
#[test]
fn a_hard_start_is_held_to_what_there_is() {
    let came = law().follow(&[Vector3::new(0.0, 2.0, 0.0); 400], 1e-3);
    assert_relative_eq!(came[199].y, 3.0 * 0.2, epsilon = 1e-9);
    let settled = law().follow(&[Vector3::new(0.1, 0.1, 0.0); 4000], 1e-3);
    assert_relative_eq!(settled[3999], Vector3::new(0.1, 0.09, 0.0), epsilon = 1e-6);
}

/// On a circle the body needs omega v towards the centre: above the limit it slides outwards.
#[test]
fn a_circle_takes_what_is_carried_round() {
    assert_eq!(
        carried(Vector3::new(2.0, 0.0, 3.0)),
        Vector3::new(0.0, 6.0, 0.0)
    );
    let law = Law {
        shortfall: Matrix3::identity(),
        ..law()
    };
    let gentle = law.follow(&[Vector3::new(0.5, 0.0, 1.0); 3000], 1e-3);
    assert_relative_eq!(gentle[2999], Vector3::new(0.5, 0.0, 1.0), epsilon = 1e-3);
    // 1.5 m/s at 3 rad/s needs 4.5 m/s^2; the limit is 3.
    let hard = law.follow(&[Vector3::new(1.5, 0.0, 3.0); 3000], 1e-3);
    assert!(hard[2999].y < -0.05, "{}", hard[2999]);
}

#[test]
fn what_is_taken_is_one_at_the_edge() {
    let most = Vector3::new(4.0, 3.0, 10.0);
    for axis in 0..3 {
        let edge = Vector3::ith(axis, -most[axis]);
        assert_relative_eq!(taken(edge, most, 1.3), 1.0, epsilon = 1e-12);
    }
    let both = Vector3::new(2.0, 1.5, 0.0);
    assert_relative_eq!(taken(both, most, 1.0), 1.0, epsilon = 1e-12);
    assert_relative_eq!(taken(both, most, 2.0), 0.5_f64.sqrt(), epsilon = 1e-12);
}

#[test]
fn errors_are_of_twist_place_and_heading() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let drive = PlanarDrive {
        asked: vec![Vector3::new(1.0, 0.0, 0.0); 1000],
        came: vec![Vector3::new(1.0, 0.0, quarter); 1000],
    };
    let end = poses(&drive.came, 1e-3).pop().unwrap();
    // A quarter circle with a path of 1 m.
    assert_relative_eq!(
        end,
        Vector3::new(1.0 / quarter, 1.0 / quarter, quarter),
        epsilon = 1e-6
    );
    let off = error(&[drive], 1e-3, <[_]>::to_vec);
    assert_relative_eq!(off.twist_rms[2], quarter, epsilon = 1e-9);
    assert_relative_eq!(off.heading_rms_rad, quarter, epsilon = 1e-9);
    let missed = (1.0 - 1.0 / quarter).hypot(1.0 / quarter);
    assert_relative_eq!(off.position_over_path, missed, epsilon = 1e-6);
}
