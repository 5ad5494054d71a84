//! The contact window against the model of all rollers on uneven ground.

use crate::support;

use ilon_world::{Floor, GroundBox};
use nalgebra::Vector3;
use support::rig::{all, bumps, end_of_course, near};

#[test]
fn over_a_kerb_the_window_opens_and_ends_where_the_full_model_ends() {
    let floor = Floor {
        boxes: vec![GroundBox {
            center_m: Vector3::new(0.45, 0.0, 0.0),
            half_sides_m: Vector3::new(0.1, 1.0, 0.005),
            heading_rad: 0.1,
            pitch_rad: 0.0,
        }],
        ..Floor::default()
    };
    let (full, _) = end_of_course(&floor, &all(500.0));
    let (window, _) = end_of_course(&floor, &near(500.0));
    // 0.9 m of way with four impacts; the two differ by the rounding of hand-overs.
    assert!((full.position_m() - window.position_m()).norm() < 3e-3);
    assert!((full.heading_rad - window.heading_rad).abs() < 0.3f64.to_radians());
    // Finer steps end in the same place: an impact occurs in another step each time, worth a
    // millimetre or two.
    for hz in [1000.0, 2000.0] {
        let (fine, _) = end_of_course(&floor, &near(hz));
        let off_m = (window.position_m() - fine.position_m()).norm();
        assert!(off_m < 3e-3, "{off_m:.2e} m from the end at {hz} Hz");
    }
}

/// On bumps wheels lift and land, and the place of a landing depends on the last digit: two
/// solutions of the same drive diverge by millimetres. The window must differ less from the full
/// model than either differs from itself at another step.
#[test]
fn on_rough_ground_the_window_ends_where_the_full_model_ends() {
    let (mut from_full_m, mut from_finer_m) = (0.0, 0.0);
    for seed in 7..11 {
        let floor = bumps(seed);
        let (full, _) = end_of_course(&floor, &all(500.0));
        let (window, _) = end_of_course(&floor, &near(500.0));
        let (finer, _) = end_of_course(&floor, &near(1000.0));
        from_full_m += 0.25 * (full.position_m() - window.position_m()).norm();
        from_finer_m += 0.25 * (finer.position_m() - window.position_m()).norm();
    }
    assert!(
        from_full_m < from_finer_m,
        "{from_full_m} m from the full model, {from_finer_m} m from a finer step"
    );
    // 0.85 m of way: 1 %.
    assert!(from_full_m < 8.5e-3, "{from_full_m} m");
}
