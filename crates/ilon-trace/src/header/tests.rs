use super::*;

#[test]
fn the_outline_of_a_box_turned_by_a_quarter_turn_has_its_sides_exchanged() {
    let body_from_shape = nalgebra::Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2);
    let shape = CollisionShape::Box {
        half_extents_m: Vector3::new(0.2, 0.1, 0.05),
    };
    let outline = outline_from_above_m(&body_from_shape, &shape);
    assert_eq!(outline.len(), 4);
    for [x, y] in &outline {
        // One rotation of numbers below 1: rounding stays below 1e-15.
        assert!((x.abs() - 0.1).abs() < 1e-15 && (y.abs() - 0.2).abs() < 1e-15);
    }
    // The shoelace sum is twice the signed area: positive is counter-clockwise; 0.4 x 0.2.
    let area: f64 = (0..4)
        .map(|k| {
            let ([ax, ay], [bx, by]) = (outline[k], outline[(k + 1) % 4]);
            0.5 * (ax * by - ay * bx)
        })
        .sum();
    assert!((area - 0.08).abs() < 1e-15);
}

#[test]
fn the_m_row_of_a_mecanum_wheel_is_the_one_known_in_closed_form() {
    // Hub at (0.15, 0.16), axis +y, gamma +45 deg: u_gamma = (-1, 1)/sqrt 2, n_gamma = (-1, -1)/sqrt 2, and
    // b . u_gamma = 0.01/sqrt 2.
    let wheel = WheelHeader {
        position_m: [0.15, 0.16],
        axis: [0.0, 1.0],
        gamma_rad: std::f64::consts::FRAC_PI_4,
        ..WheelHeader::default()
    };
    let r = 0.5_f64.sqrt();
    let expected = [r, r, -0.01 * r];
    for (got, want) in wheel.m_row().iter().zip(expected) {
        // A handful of roundings of numbers below 1.
        assert!((got - want).abs() < 1e-15);
    }
}
