//! Sections III-A and III-B: errors, the law without saturation and its stability, eqs. (16)-(28).

use std::f64::consts::PI;

use ilon_control::{Desired, Gain, Guidance, GuidanceSettings, Kinematics, Saturation};
use ilon_robot::{Pose, Twist, wrap_angle};
use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;

use crate::paper::fixtures::{mecanum4, volksbot};
use crate::paper::random::{any_robot, cases};

/// A symmetric positive definite gain with principal values between 0.3 and 3 1/s in any direction.
pub fn any_gain() -> impl Strategy<Value = Matrix2<f64>> {
    (0.3..3.0, 0.3..3.0, -PI..PI).prop_map(|(a, b, angle): (f64, f64, f64)| {
        let turn = nalgebra::Rotation2::new(angle);
        let gain = turn.matrix() * Matrix2::new(a, 0.0, 0.0, b) * turn.matrix().transpose();
        // Symmetric to the last bit.
        (gain + gain.transpose()) * 0.5
    })
}

pub fn any_pose() -> impl Strategy<Value = Pose> {
    (-3.0..3.0, -3.0..3.0, -PI..PI).prop_map(|(x_m, y_m, heading_rad)| Pose {
        x_m,
        y_m,
        heading_rad,
    })
}

pub fn any_desired() -> impl Strategy<Value = Desired> {
    (any_pose(), -0.5..0.5, -0.5..0.5, -1.0..1.0).prop_map(|(pose, x, y, w)| Desired {
        pose,
        velocity_in_world: Twist::new(x, y, w),
    })
}

fn plain(kinematics: Kinematics, k_r: Matrix2<f64>, k_phi: f64) -> Guidance {
    let settings = GuidanceSettings {
        position_gain: Gain::Matrix(k_r),
        heading_gain: k_phi,
        wheel_rate_limit_rad_s: f64::INFINITY,
        saturation: Saturation::None,
    };
    Guidance::new(kinematics, &settings).unwrap()
}

/// e_r and e_phi of eqs. (16), (17).
pub fn errors(seen: &Pose, desired: &Desired) -> (Vector2<f64>, f64) {
    (
        desired.pose.position_m() - seen.position_m(),
        wrap_angle(desired.pose.heading_rad - seen.heading_rad),
    )
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn eq_23_24_without_saturation_the_twist_is_feedforward_and_feedback(
        (_, kinematics) in any_robot(), k_r in any_gain(), k_phi in 0.3..3.0_f64,
        seen in any_pose(), desired in any_desired(),
    ) {
        let (e_r, e_phi) = errors(&seen, &desired);
        let mut guidance = plain(kinematics, k_r, k_phi);
        let command = guidance.update(&seen, &desired).clone();
        let in_world = command.twist_in_body.rotated(seen.heading_rad);
        let v_c = desired.velocity_in_world.linear_m_s() + k_r * e_r;
        let omega = desired.velocity_in_world.omega_rad_s + k_phi * e_phi;
        prop_assert!((in_world.linear_m_s() - v_c).norm() < 1e-12);
        prop_assert!((in_world.omega_rad_s - omega).abs() < 1e-12);
        prop_assert_eq!(command.twist_in_body, command.saturated_twist_in_body);
    }

    #[test]
    fn eq_18_to_20_and_26_to_28_rates_are_linear_part_and_angular_part(
        (_, kinematics) in any_robot(), k_r in any_gain(), k_phi in 0.3..3.0_f64,
        seen in any_pose(), desired in any_desired(),
    ) {
        let (e_r, e_phi) = errors(&seen, &desired);
        let n = kinematics.wheel_count();
        let (mut q_dl, mut q_da) = (vec![0.0; n], vec![0.0; n]);
        // Eq. (27): both of its vectors resolved in the body frame; eq. (28).
        let v = desired.velocity_in_world.linear_m_s() + k_r * e_r;
        kinematics.wheel_rates(Twist::new(v.x, v.y, 0.0).rotated(-seen.heading_rad), &mut q_dl);
        let omega = desired.velocity_in_world.omega_rad_s + k_phi * e_phi;
        kinematics.wheel_rates(Twist::new(0.0, 0.0, omega), &mut q_da);
        let mut guidance = plain(kinematics, k_r, k_phi);
        let command = guidance.update(&seen, &desired);
        for h in 0..n {
            // Rates reach some 1e3 rad/s: 1e-10 is a few roundings.
            prop_assert!((command.wheel_rates_rad_s[h] - q_dl[h] - q_da[h]).abs() < 1e-10);
        }
    }

    #[test]
    fn eq_18_linear_and_angular_commands_do_not_interfere_and_need_no_orthogonality(
        (_, kinematics) in any_robot(), x in -1.0..1.0, y in -1.0..1.0, omega in -3.0..3.0,
    ) {
        // The paper rests this on M_a being orthogonal to span(M_l). Rank 3 is enough: q'_dl = M_l
        // v / (rho cos gamma) lies in the range of M, where the twist is unique, and that twist is
        // (v, 0).
        let mut rates = vec![0.0; kinematics.wheel_count()];
        kinematics.wheel_rates(Twist::new(x, y, 0.0), &mut rates);
        prop_assert!(kinematics.twist(&rates).omega_rad_s.abs() < 1e-9);
        kinematics.wheel_rates(Twist::new(0.0, 0.0, omega), &mut rates);
        prop_assert!(kinematics.twist(&rates).linear_m_s().norm() < 1e-9);
    }

    #[test]
    fn eq_22_and_25_the_lyapunov_function_falls_at_the_rate_stated(
        (_, kinematics) in any_robot(), k_r in any_gain(), k_phi in 0.3..3.0_f64,
        seen in any_pose(), desired in any_desired(),
    ) {
        // V of eq. (21) along the kinematic model, differentiated numerically: the robot moves with
        // the commanded twist, the reference with its velocity.
        let mut guidance = plain(kinematics, k_r, k_phi);
        let rates = guidance.update(&seen, &desired).wheel_rates_rad_s.clone();
        let twist = guidance.kinematics().twist(&rates).rotated(seen.heading_rad);
        let (e_r, e_phi) = errors(&seen, &desired);
        let v = |t: f64| {
            let e_r = e_r + t * (desired.velocity_in_world.linear_m_s() - twist.linear_m_s());
            let e_phi = e_phi + t * (desired.velocity_in_world.omega_rad_s - twist.omega_rad_s);
            0.5 * e_r.dot(&(k_r * e_r)) + 0.5 * k_phi * e_phi * e_phi
        };
        // V is quadratic in t: the central difference is exact up to rounding, 1e-15 V / h.
        let slope = (v(1e-4) - v(-1e-4)) / 2e-4;
        let stated = -(k_r * e_r).norm_squared() - (k_phi * e_phi).powi(2);
        prop_assert!((slope - stated).abs() < 1e-8 * (1.0 + stated.abs()), "{slope} {stated}");
        prop_assert!(stated <= 0.0);
    }

    #[test]
    fn eq_16_the_reference_point_follows_wherever_it_sits(
        (_, kinematics) in any_robot(), x in -0.5..0.5, y in -0.5..0.5, seen in any_pose(), desired in any_desired(),
    ) {
        // The robot driven about a point of its body must move that point with the velocity of eq.
        // (23).
        let arm = Vector2::new(x, y);
        let mut guidance = plain(kinematics.about(arm).unwrap(), Matrix2::identity(), 1.0);
        let rates = guidance.update(&seen, &desired).wheel_rates_rad_s.clone();
        let twist = kinematics.twist(&rates).rotated(seen.heading_rad);
        let (s, c) = seen.heading_rad.sin_cos();
        let arm = Vector2::new(c * arm.x - s * arm.y, s * arm.x + c * arm.y);
        let v_point = twist.linear_m_s() + twist.omega_rad_s * Vector2::new(-arm.y, arm.x);
        let e_r = desired.pose.position_m() - (seen.position_m() + arm);
        let wanted = desired.velocity_in_world.linear_m_s() + e_r;
        prop_assert!((v_point - wanted).norm() < 1e-9);
    }
}

#[test]
fn eq_17_the_heading_error_wraps_to_the_shorter_way() {
    let mut guidance = plain(
        Kinematics::new(&volksbot()).unwrap(),
        Matrix2::identity(),
        1.0,
    );
    let at = |heading_deg: f64| Pose {
        heading_rad: heading_deg.to_radians(),
        ..Pose::default()
    };
    for (seen, wanted, shorter) in [
        (170.0, -170.0, 20.0),
        (-170.0, 170.0, -20.0),
        (10.0, 730.0, 0.0),
        (0.0, 179.0, 179.0),
    ] {
        let desired = Desired {
            pose: at(wanted),
            velocity_in_world: Twist::default(),
        };
        let omega = guidance
            .update(&at(seen), &desired)
            .twist_in_body
            .omega_rad_s;
        assert!((omega.to_degrees() - shorter).abs() < 1e-10, "{omega}");
    }
}

#[test]
fn eq_25_pose_regulation_converges_exponentially() {
    // Constant reference: e_r(t) = exp(-K_r t) e_r(0) and e_phi(t) = exp(-K_phi t) e_phi(0), at any
    // heading.
    let kinematics = Kinematics::new(&mecanum4()).unwrap();
    let mut guidance = plain(kinematics, Matrix2::identity() * 0.8, 1.5);
    let desired = Desired {
        pose: Pose {
            x_m: 1.0,
            y_m: -2.0,
            heading_rad: 2.0,
        },
        velocity_in_world: Twist::default(),
    };
    let mut seen = Pose::default();
    let dt_s = 1e-4;
    for _ in 0..20_000 {
        let rates = guidance.update(&seen, &desired).wheel_rates_rad_s.clone();
        let twist = guidance
            .kinematics()
            .twist(&rates)
            .rotated(seen.heading_rad);
        seen.x_m += twist.vx_m_s * dt_s;
        seen.y_m += twist.vy_m_s * dt_s;
        seen.heading_rad += twist.omega_rad_s * dt_s;
    }
    let (e_r, e_phi) = errors(&seen, &desired);
    // Euler's steps: (1 - K dt)^(t/dt) against exp(-K t) differ by K^2 t dt / 2 = 2.3e-4 of the
    // value at most.
    let expected = 5.0_f64.sqrt() * (-1.6_f64).exp();
    assert!((e_r.norm() / expected - 1.0).abs() < 3e-4);
    assert!((e_phi / (2.0 * (-3.0_f64).exp()) - 1.0).abs() < 3e-4);
}
