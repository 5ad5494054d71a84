//! The inverse of the contact kinematics: wheel rates that cancel the rollers' ripple, compared
//! with the paper's law with its constant gamma.
//!
//! Robot A sideways at 0.3 m/s. At constant wheel rates its speed is rho q' cos phi, |phi| <= 20
//! deg: the mean is sin(20 deg) / (20 deg in rad) = 0.980 of the command, with an rms ripple of
//! sqrt(<cos^2> - <cos>^2) = 0.0180 of it.

use super::run;

/// Mean over the commanded speed, and rms ripple over it.
fn sideways(settings: &[&str]) -> (f64, f64) {
    let asked_m_s = 0.3;
    let summary = run("mecanum4_lateral_compensated", settings).summary;
    let mean = summary.twist_mean.expect("it moves").vy_m_s;
    let ripple = summary.twist_ripple.expect("open loop").vy_m_s;
    (mean / asked_m_s, ripple / asked_m_s)
}

/// Mean and rms ripple of cos phi over |phi| <= 20 deg.
fn geometry() -> (f64, f64) {
    let p = 20_f64.to_radians();
    let mean = p.sin() / p;
    let square = 0.5 * (1.0 + (2.0 * p).sin() / (2.0 * p));
    (mean, (square - mean * mean).sqrt())
}

#[test]
fn contact_kinematics_makes_up_for_the_deficit_and_most_of_the_ripple() {
    let (mean, ripple) = geometry();
    let (with_gamma, ripple_with_gamma) = sideways(&["guidance.kinematics=ideal"]);
    let (with_contacts, ripple_with_contacts) = sideways(&[]);
    println!("constant gamma: mean {with_gamma:.5}, ripple {ripple_with_gamma:.5}");
    println!("derived for stiff wheels: mean {mean:.5}, ripple {ripple:.5}");
    println!("contacts: mean {with_contacts:.5}, ripple {ripple_with_contacts:.5}");
    // The paper's law falls short by the geometry.
    assert!((with_gamma - mean).abs() < 1e-3);
    // Wheels yield to the ripple's forces, so that slightly less of it reaches the robot.
    assert!((0.75 * ripple..ripple).contains(&ripple_with_gamma));
    // The contact kinematics commands what is needed: the whole speed, and the part of the ripple
    // that the wheel loops can follow.
    assert!((with_contacts - 1.0).abs() < 1e-3);
    assert!(ripple_with_contacts < 0.2 * ripple_with_gamma);
}

#[test]
fn slow_wheels_follow_it_and_shake_as_derived_without_it() {
    let slowly = |kinematics: &str| {
        let settings = ["twist.vy_m_s=0.05", kinematics];
        let summary = run("mecanum4_lateral_compensated", &settings).summary;
        summary.twist_ripple.expect("open loop").vy_m_s / 0.05
    };
    let (gamma, contacts) = (
        slowly("guidance.kinematics=ideal"),
        slowly("guidance.kinematics=contact"),
    );
    println!("at 0.05 m/s: ripple {gamma:.5} with constant gamma, {contacts:.5} with contacts");
    // Six times fewer rollers per second than at 0.3 m/s: a roller passes in 0.7 s, long compared
    // with the loop's time of tens of ms. The wheels then follow their commands, and the paper's
    // law gives the derived ripple. The window of the means holds four pitches and a part of one,
    // which weights some phases more than others: 20 %.
    assert!(contacts < 0.15 * gamma);
    assert!((gamma / geometry().1 - 1.0).abs() < 0.2);
}

#[test]
fn under_computed_torque_it_leaves_the_ripple() {
    // Eq. (12) takes every acceleration of the wheels for one of the robot, by the ideal
    // kinematics. The accelerations of the contact kinematics keep the robot from accelerating:
    // (12) adds a torque where none is needed.
    let (_, pid) = sideways(&[]);
    let (_, computed) = sideways(&["wheel_loop.law=computed_torque"]);
    println!("ripple {pid:.5} under the PID, {computed:.5} under the computed torque");
    assert!(computed > 2.0 * pid);
}
