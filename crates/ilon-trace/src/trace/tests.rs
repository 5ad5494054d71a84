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

#[test]
fn wheels_lie_flat_and_are_found_again_by_step_and_by_wheel() {
    let header = Header {
        wheels: vec![WheelHeader::default(); 3],
        control_dt_s: 0.01,
        ..Header::default()
    };
    let mut trace = Trace::with_capacity(header, 5);
    for step in 0..5 {
        let wheels: Vec<_> = (0..3)
            .map(|j| WheelSample {
                rate_rad_s: f64::from(10 * step + j),
                ..WheelSample::default()
            })
            .collect();
        trace.push(Record::default(), &wheels);
    }
    assert_eq!(trace.wheels_at(2)[1].rate_rad_s, 21.0);
    let rates: Vec<_> = trace.wheel(2).map(|w| w.rate_rad_s).collect();
    assert_eq!(rates, [2.0, 12.0, 22.0, 32.0, 42.0]);
    assert!(trace.wheels_at(5).is_empty());
    assert_eq!(trace.wheel(3).len(), 0);
}

#[test]
fn rows_and_wheels_that_there_are_not_are_empty() {
    let header = Header {
        wheels: vec![WheelHeader::default(); 2],
        ..Header::default()
    };
    let mut trace = Trace::with_capacity(header, 0);
    // No row yet: the second wheel would begin beyond the end.
    assert_eq!(trace.wheel(1).len(), 0);
    assert!(trace.wheels_at(usize::MAX).is_empty());
    // Missing samples are zero, surplus ones dropped.
    let sample = WheelSample {
        rate_rad_s: 1.0,
        ..WheelSample::default()
    };
    trace.push(Record::default(), &[sample]);
    trace.push(Record::default(), &[sample; 3]);
    let rates: Vec<_> = trace.wheel(1).map(|wheel| wheel.rate_rad_s).collect();
    assert_eq!(rates, [0.0, 1.0]);
}
