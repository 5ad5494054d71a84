//! Too few rollers: what they take from sideways motion, and what it takes of grip.
//!
//! With n rollers the one that touches stands at phi from straight down, |phi| <= pi / n. Its axis makes delta = 90 deg - |gamma| with the hub
//! axis, and delta_eff on the ground: tan delta_eff = tan delta cos phi. For gamma = 45 deg a wheel that turns at q' moves the robot sideways by
//! rho q' cos phi, in the mean sin(pi/n) / (pi/n) of rho q', with a ripple of sqrt(<cos^2 phi> - <cos phi>^2). At each hand-over the slope of
//! cos phi jumps, and the acceleration reaches v^2 sin(pi/n) / rho: on a slippery floor that alone is more than the grip mu g / sqrt 2, at a
//! steady speed.

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
        // Wheel loops that give way to the ripple make its phase and the rate go together: some 0.1 %.
        assert!((measured / derived - 1.0).abs() < 2e-3);
        // All of it is geometry.
        let contact = summary.twist_ratio_contact.vy.expect("it moves sideways");
        assert!((contact - 1.0).abs() < 2e-3);
    }
}
