//! Too few rollers: what they take from sideways motion, and what it takes of grip.

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
