//! Section II: eqs. (1)-(10) and Lemma 1.

use std::f64::consts::{FRAC_PI_2, PI};

use ilon_control::{ControlError, Kinematics, SingularityKind};
use ilon_robot::{Twist, Wheel};
use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;

use crate::paper::fixtures::{WheelSpec, mecanum4, robot, six_wheels, volksbot};
use crate::paper::random::{any_robot, any_wheels, cases};

fn flat(v: Vector2<f64>) -> Vector3<f64> {
    Vector3::new(v.x, v.y, 0.0)
}

/// u = n x k.
fn drive_direction(w: &Wheel) -> Vector3<f64> {
    flat(w.axis()).cross(&Vector3::z())
}

fn any_twist() -> impl Strategy<Value = Twist> {
    (-1.0..1.0, -1.0..1.0, -3.0..3.0).prop_map(|(x, y, w)| Twist::new(x, y, w))
}

#[test]
fn eq_01_the_cross_product_is_a_skew_matrix() {
    let (a, b) = (Vector3::new(0.3, -1.2, 2.0), Vector3::new(-0.7, 0.1, 0.9));
    assert!((a.cross_matrix() * b - a.cross(&b)).norm() < 1e-15);
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn eq_02_hub_velocity_is_that_of_a_rigid_body((robot, kinematics) in any_robot(), twist in any_twist()) {
        // The body's motion over a short time, differentiated: turned by omega t, moved by v t.
        let place = |b: Vector2<f64>, t: f64| {
            let (s, c) = (twist.omega_rad_s * t).sin_cos();
            Vector2::new(c * b.x - s * b.y, s * b.x + c * b.y) + twist.linear_m_s() * t
        };
        for (h, w) in robot.wheels.iter().enumerate() {
            let b = w.position_m().xy();
            let slope = (place(b, 1e-5) - place(b, -1e-5)) / 2e-5;
            let v_h = kinematics.hub_velocity_m_s(h, twist).unwrap();
            // The quotient errs by omega^3 |b| h^2 / 6 < 1e-9 and by rounding, 1e-11.
            prop_assert!((slope - v_h).norm() < 1e-8);
        }
    }

    #[test]
    fn eq_03_hub_velocity_splits_into_rollers_and_motors_part((robot, kinematics) in any_robot(), twist in any_twist()) {
        for (h, w) in robot.wheels.iter().enumerate() {
            let (alpha, beta) = kinematics.rolling_split_m_s(h, twist).unwrap();
            let sum = alpha * flat(w.roller_rolling_direction()) + beta * drive_direction(w);
            let v = flat(kinematics.hub_velocity_m_s(h, twist).unwrap());
            prop_assert!((sum - v).norm() < 1e-12);
        }
    }

    #[test]
    fn eq_04_the_motors_part_is_rho_times_the_wheel_rate((robot, kinematics) in any_robot(), twist in any_twist()) {
        // Read with n_gamma^T for the misprinted n_gamma^2: the left-hand side is beta of eq. (3).
        let mut rates = vec![0.0; robot.wheels.len()];
        kinematics.wheel_rates(twist, &mut rates);
        for (h, w) in robot.wheels.iter().enumerate() {
            let v = flat(kinematics.hub_velocity_m_s(h, twist).unwrap());
            let n_g = flat(w.roller_axis());
            let left = n_g.dot(&v) / drive_direction(w).dot(&n_g);
            prop_assert!((left - w.radius_m * rates[h]).abs() < 1e-12);
        }
    }

    #[test]
    fn eq_05_residuals_are_its_two_sides_difference((robot, kinematics) in any_robot(), twist in any_twist()) {
        let n = robot.wheels.len();
        let rates: Vec<f64> = (0..n).map(|h| 3.0 - 1.7 * h as f64).collect();
        let mut residuals = vec![0.0; n];
        kinematics.residuals(twist, &rates, &mut residuals);
        for (h, w) in robot.wheels.iter().enumerate() {
            let (n_g, b, cos) = (flat(w.roller_axis()), flat(w.position_m().xy()), w.gamma_rad.cos());
            let left = -n_g.dot(&flat(twist.linear_m_s())) / cos
                + n_g.dot(&(b.cross_matrix() * Vector3::z())) / cos * twist.omega_rad_s;
            prop_assert!((residuals[h] - (left - w.radius_m * rates[h])).abs() < 1e-12);
        }
        // What it stands on: u^T n_gamma = -cos gamma.
        for w in &robot.wheels {
            prop_assert!((drive_direction(w).dot(&flat(w.roller_axis())) + w.gamma_rad.cos()).abs() < 1e-12);
        }
    }

    #[test]
    fn eq_06_the_moment_of_the_roller_axis((robot, _) in any_robot()) {
        for w in &robot.wheels {
            let (n_g, u_g) = (flat(w.roller_axis()), flat(w.roller_rolling_direction()));
            let b = flat(w.position_m().xy());
            let left = n_g.dot(&(b.cross_matrix() * Vector3::z()));
            prop_assert!((left - (n_g.x * b.y - n_g.y * b.x)).abs() < 1e-14);
            prop_assert!((left + b.dot(&u_g)).abs() < 1e-14);
            // u_gamma = n_gamma x k, and gamma is the angle from n to it.
            prop_assert!((n_g.cross(&Vector3::z()) - u_g).norm() < 1e-14);
        }
    }

    #[test]
    fn eq_07_holds_row_by_row_for_wheels_that_differ((robot, kinematics) in any_robot(), twist in any_twist()) {
        let mut rates = vec![0.0; robot.wheels.len()];
        kinematics.wheel_rates(twist, &mut rates);
        let left = kinematics.m() * Vector3::new(twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s);
        for (h, w) in robot.wheels.iter().enumerate() {
            prop_assert!((left[h] - w.radius_m * w.gamma_rad.cos() * rates[h]).abs() < 1e-12);
        }
    }

    #[test]
    fn eq_09_rates_and_twist_invert_each_other((_, kinematics) in any_robot(), twist in any_twist()) {
        let mut rates = vec![0.0; kinematics.wheel_count()];
        kinematics.wheel_rates(twist, &mut rates);
        let off = kinematics.twist(&rates) - twist;
        // Rounding times a condition below 100 (see the strategy), rates up to 1e3.
        prop_assert!(off.linear_m_s().norm() < 1e-10 && off.omega_rad_s.abs() < 1e-9);
    }

    #[test]
    fn eq_10_linear_and_angular_rates_add_up((_, kinematics) in any_robot(), twist in any_twist()) {
        let n = kinematics.wheel_count();
        let (mut all, mut linear, mut angular) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        kinematics.wheel_rates(twist, &mut all);
        kinematics.wheel_rates(Twist::new(twist.vx_m_s, twist.vy_m_s, 0.0), &mut linear);
        kinematics.wheel_rates(Twist::new(0.0, 0.0, twist.omega_rad_s), &mut angular);
        for h in 0..n {
            prop_assert!((all[h] - linear[h] - angular[h]).abs() < 1e-11);
        }
    }

    #[test]
    fn lemma_1_a_robot_is_refused_exactly_when_m_is_short_of_rank_3(wheels in any_wheels()) {
        let robot = robot(10.0, &wheels);
        let rows: Vec<_> = robot.wheels.iter().map(|w| {
            let (n_g, u_g) = (w.roller_axis(), w.roller_rolling_direction());
            -nalgebra::RowVector3::new(n_g.x, n_g.y, w.position_m().xy().dot(&u_g))
        }).collect();
        let s = nalgebra::MatrixXx3::from_rows(&rows).svd(false, false).singular_values;
        let verdict = Kinematics::new(&robot);
        // Between the two lies a band in which the scaling of the last column decides.
        if s.min() > 1e-3 * s.max() {
            prop_assert!(verdict.is_ok());
        }
        if s.min() < 1e-6 * s.max() {
            prop_assert!(verdict.is_err());
        }
    }

    #[test]
    fn lemma_1_axes_through_one_point_are_found_with_their_point(
        mut wheels in any_wheels(), x in -1.0..1.0, y in -1.0..1.0,
    ) {
        // Turn every hub so that its roller axis passes the point: roller axis = axis + gamma + 90
        // deg.
        let point = Vector2::new(x, y);
        let mut directions = Vec::new();
        for w in &mut wheels {
            let to = point - Vector2::new(w.x_m, w.y_m);
            w.axis_rad = to.y.atan2(to.x) - w.gamma_rad - FRAC_PI_2;
            directions.push(to.normalize());
        }
        // Nearly parallel directions would make their point uncertain, and nearly the same as
        // parallel axes.
        let spread = directions.iter().map(|d| d.perp(&directions[0]).abs()).fold(0.0, f64::max);
        prop_assume!(spread > 0.05);
        match Kinematics::new(&robot(10.0, &wheels)) {
            Err(ControlError::Uncontrollable { singularity }) => match singularity.kind {
                SingularityKind::Meet { point_m } => prop_assert!((point_m - point).norm() < 1e-9),
                other => prop_assert!(false, "{other:?}"),
            },
            other => prop_assert!(false, "{:?}", other.err()),
        }
    }

    #[test]
    fn lemma_1_parallel_axes_are_found_with_their_direction(mut wheels in any_wheels(), angle in -PI..PI) {
        for (i, w) in wheels.iter_mut().enumerate() {
            // Either sense of the axis: reversing it changes neither line nor verdict.
            let half_turn = if i % 2 == 0 { 0.0 } else { PI };
            w.axis_rad = angle + half_turn - w.gamma_rad - FRAC_PI_2;
        }
        let across = Vector2::new(-angle.sin(), angle.cos());
        let offsets: Vec<f64> = wheels.iter().map(|w| across.dot(&Vector2::new(w.x_m, w.y_m))).collect();
        let spread = offsets.iter().map(|o| (o - offsets[0]).abs()).fold(0.0, f64::max);
        // All on one line is another case.
        prop_assume!(spread > 0.01);
        match Kinematics::new(&robot(10.0, &wheels)) {
            Err(ControlError::Uncontrollable { singularity }) => match singularity.kind {
                SingularityKind::Parallel { direction } => prop_assert!(direction.dot(&across).abs() < 1e-9),
                other => prop_assert!(false, "{other:?}"),
            },
            other => prop_assert!(false, "{:?}", other.err()),
        }
    }
}

#[test]
fn eq_08_the_volksbot_has_the_matrix_of_its_geometry() {
    // gamma = 0, hub axes radial at 0, 120, 240 deg: n_gamma = k x n, and b . u_gamma = |b|.
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    let s = 3.0_f64.sqrt() / 2.0;
    let expected = nalgebra::MatrixXx3::from_row_slice(&[
        0.0, -1.0, -0.25, //
        s, 0.5, -0.25, //
        -s, 0.5, -0.25,
    ]);
    assert!((kinematics.m() - expected).norm() < 1e-14);
}

#[test]
fn section_4_the_volksbot_is_decoupled() {
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    let m = kinematics.m();
    for column in 0..2 {
        assert!(m.column(column).dot(&m.column(2)).abs() < 1e-15);
    }
}

#[test]
fn lemma_1_condition_1_gamma_of_90_degrees_loses_authority() {
    let wheels: Vec<_> = (0..3)
        .map(|i| {
            let a = f64::from(i) * 2.0;
            WheelSpec::new(0.2 * a.cos(), 0.2 * a.sin(), a, FRAC_PI_2, 8)
        })
        .collect();
    let error = Kinematics::new(&robot(5.0, &wheels)).unwrap_err();
    let all = (0..3).map(|i| format!("wheel_{i}")).collect();
    assert_eq!(error, ControlError::NoControlAuthority { wheels: all });
}

#[test]
fn lemma_1_robots_that_meet_both_conditions_are_accepted() {
    for robot in [mecanum4(), volksbot(), six_wheels()] {
        assert!(Kinematics::new(&robot).is_ok());
    }
}
