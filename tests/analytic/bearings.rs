//! Bearing friction of rollers slows a torque-driven robot sideways, and has no effect straight
//! ahead.
//!
//! Consider the roller in contact at the angle phi, of a wheel at rate q' that drives its robot
//! along the hub axis at rho q' cos phi. It is carried over the ground at rho q' sqrt(1 + cos^2
//! phi) across its axis. Spin w of the roller compensates that at w s(phi) sqrt(cos^2 delta + sin^2
//! delta cos^2 phi), which for delta = 45 deg is w s sqrt((1 + cos^2 phi) / 2). So w = sqrt 2 rho
//! q' / s(phi), with the barrel's radius s(phi) = rho - a / cos phi. Straight ahead it does not
//! spin at all.
//!
//! Friction tau in its bearing dissipates the power tau w, which the wheel's motor supplies:
//! T = sqrt 2 rho tau / s(phi) in addition. At every hand-over a roller touches down at rest and is
//! spun up to w at the end of its barrel, s_e = s(pi/n): this takes I w^2 / 2, as much is lost to
//! sliding meanwhile, and its bearing stops it again once it has left the ground. That is I w^2 per
//! pitch, and a mean torque of I w^2 n / (2 pi). A drive with T = k (target - rate), as a motor at
//! a steady voltage, supplies that only if its rate is below its target by T / k.

use super::run;
use ilon_formats::LoadRobot;

const RADIUS_M: f64 = 0.05;
const RING_M: f64 = 0.038;
/// Of mecanum4_hard_rollers.
const FRICTION_N_M: f64 = 5e-3;
/// Of the scenarios.
const DRIVE_N_M_S: f64 = 0.06;
const HUB_DAMPING_N_M_S: f64 = 1e-3;
const ROLLER_DAMPING_N_M_S: f64 = 1e-6;

/// Mean over phi in +-20 deg of a function of the contacting roller's barrel radius.
fn mean(of_radius_m: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 1000;
    let half_pitch_rad = 20_f64.to_radians();
    let at = |k: u32| half_pitch_rad * (2.0 * (f64::from(k) + 0.5) / f64::from(STEPS) - 1.0);
    let values = (0..STEPS).map(|k| of_radius_m(RADIUS_M - RING_M / at(k).cos()));
    values.sum::<f64>() / f64::from(STEPS)
}

#[test]
fn rollers_that_turn_hard_slow_a_torque_driven_robot_sideways_by_what_their_bearings_take() {
    let summary = run("mecanum4_hard_rollers_lateral", &[]).summary;
    let target_rad_s = 0.3 / RADIUS_M;
    // k (target - q') = T_friction + (damping of hub and rollers) q' + T_spin-up(q'^2), solved by
    // iteration.
    let torque_n_m = mean(|s_m| 2_f64.sqrt() * RADIUS_M * FRICTION_N_M / s_m);
    let damping =
        HUB_DAMPING_N_M_S + mean(|s_m| 2.0 * (RADIUS_M / s_m).powi(2) * ROLLER_DAMPING_N_M_S);
    let spun_up_kg_m2 = {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/assets/robots/mecanum4_hard_rollers.urdf"
        );
        let robot = ilon::robot::Robot::load(path).expect("a shipped robot");
        robot.wheels[0].rollers[0].axial_inertia_kg_m2
    };
    let end_m = RADIUS_M - RING_M / 20_f64.to_radians().cos();
    let mut rate_rad_s = target_rad_s;
    for _ in 0..50 {
        let spin_rad_s = 2_f64.sqrt() * RADIUS_M * rate_rad_s / end_m;
        let spin_up_n_m = spun_up_kg_m2 * spin_rad_s.powi(2) * 9.0 / std::f64::consts::TAU;
        rate_rad_s =
            (DRIVE_N_M_S * target_rad_s - torque_n_m - spin_up_n_m) / (DRIVE_N_M_S + damping);
    }
    let measured_rad_s = summary.twist_ideal_mean.expect("it moves").vy_m_s / RADIUS_M;
    let short = |rate_rad_s: f64| 1.0 - rate_rad_s / target_rad_s;
    println!(
        "wheels short of their target by {:.2} %, derived {:.2} %",
        100.0 * short(measured_rad_s),
        100.0 * short(rate_rad_s)
    );
    // Neglected: slip between hand-overs, and the ripple of the rate itself.
    assert!((short(measured_rad_s) / short(rate_rad_s) - 1.0).abs() < 0.03);
    // The robot loses that, and in addition the geometric loss of the rollers, sin(20
    // deg) / (20 deg in rad) = 0.980.
    let real = summary.twist_mean.expect("it moves").vy_m_s / 0.3;
    let geometry = 20_f64.to_radians().sin() / 20_f64.to_radians();
    println!(
        "it moves sideways at {:.2} % of what was asked",
        100.0 * real
    );
    assert!((real / (geometry * rate_rad_s / target_rad_s) - 1.0).abs() < 0.005);
}

#[test]
fn rollers_that_turn_hard_do_not_slow_it_straight_ahead() {
    let summary = run("mecanum4_hard_rollers_forward", &[]).summary;
    // Only the hubs' own damping is left: d / (k + d).
    let short = 1.0 - summary.twist_mean.expect("it moves").vx_m_s / 0.3;
    let derived = HUB_DAMPING_N_M_S / (DRIVE_N_M_S + HUB_DAMPING_N_M_S);
    println!(
        "short by {:.3} %, derived {:.3} %",
        100.0 * short,
        100.0 * derived
    );
    assert!((short / derived - 1.0).abs() < 0.02);
}

#[test]
fn the_friction_of_hard_rollers_is_all_that_a_loop_with_an_integral_hides() {
    // The default loop has an integral part that supplies the bearing torque; only geometry is
    // left.
    let settings = [
        "wheel_loop.integral_n_m=0.5",
        "wheel_loop.proportional_n_m_s=0.12",
    ];
    let summary = run("mecanum4_hard_rollers_lateral", &settings).summary;
    let ideal = summary.twist_ideal_mean.expect("it moves").vy_m_s;
    assert!((ideal / 0.3 - 1.0).abs() < 1e-3, "{ideal}");
}
