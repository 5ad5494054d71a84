//! Wheels with few rollers: their loss of sideways motion, and the grip that their ripple needs.
//!
//! With n rollers the one in contact is at phi from straight down, |phi| <= pi / n. Its axis makes
//! delta = 90 deg - |gamma| with the hub axis, and delta_eff on the ground: tan delta_eff = tan
//! delta cos phi. For gamma = 45 deg a wheel at rate q' moves the robot sideways at rho q' cos phi,
//! with a mean of sin(pi/n) / (pi/n) of rho q' and a ripple of sqrt(<cos^2 phi> - <cos phi>^2). At
//! each hand-over the slope of cos phi jumps, and the acceleration reaches v^2 sin(pi/n) / rho: on
//! a slippery floor that alone exceeds the grip mu g / sqrt 2, at a steady speed.

use super::run;

#[test]
fn sideways_motion_falls_short_by_the_number_of_rollers() {
    for (name, rollers) in [
        ("mecanum4_6_rollers_lateral", 6.0),
        ("mecanum4_12_rollers_lateral", 12.0),
    ] {
        let summary = run(name, &[]).summary;
        let half_pitch_rad = std::f64::consts::PI / rollers;
        let derived = half_pitch_rad.sin() / half_pitch_rad;
        let measured = summary.twist_ratio_ideal.vy.expect("it moves sideways");
        println!("{name}: real over ideal {measured:.4}, derived {derived:.4}");
        // Wheel loops that yield to the ripple correlate its phase with the rate: about 0.1 %.
        assert!((measured / derived - 1.0).abs() < 2e-3);
        // All of the loss is geometry.
        let contact = summary.twist_ratio_contact.vy.expect("it moves sideways");
        assert!((contact - 1.0).abs() < 2e-3);
    }
}
