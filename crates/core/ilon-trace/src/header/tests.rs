use super::*;
use ilon_formats::LoadRobot;

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

/// A patch of 2 m by 4 m around (1, 2) m ends at 2 m along x and at 4 m along y: the point (5, 8) m
/// is 3 m and 4 m beside it, which are 5 m.
#[test]
fn a_point_is_as_far_from_a_patch_as_from_its_nearest_edge_or_corner() {
    let patch = GroundPatch {
        center_m: [1.0, 2.0],
        sides_m: [2.0, 4.0],
        ..GroundPatch::default()
    };
    for (at_m, expected_m) in [
        ([5.0, 8.0], 5.0),
        ([-3.0, -3.0], 18.0_f64.sqrt()),
        ([1.5, 7.0], 3.0),
        ([-2.0, 0.5], 2.0),
        ([2.0, 4.0], 0.0),
        ([0.5, 0.5], 0.0),
    ] {
        // All numbers but the root are exact, and that is rounded once or twice.
        let off_m = (patch.distance_m(at_m) - expected_m).abs();
        assert!(off_m < 1e-14, "{at_m:?}: {off_m}");
    }
}

#[test]
fn the_m_row_of_a_mecanum_wheel_is_the_one_known_in_closed_form() {
    // Hub at (0.15, 0.16), axis +y, gamma +45 deg: u_gamma = (-1, 1)/sqrt 2, n_gamma = (-1,
    // -1)/sqrt 2, and b . u_gamma = 0.01/sqrt 2.
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

/// The window of the means holds the rows whose periods end in it: that at its beginning, and not
/// that at its end. Times are sums of steps: 0.1 * 3 is above 0.3, and 0.7 below 7 periods of 0.1.
#[test]
fn rows_are_found_in_spite_of_the_rounding_of_their_times() {
    let header = Header {
        control_dt_s: 0.1,
        record_every: 1,
        measure_from_s: 0.3,
        measure_to_s: 0.7,
        ..Header::default()
    };
    let measured: Vec<u32> = (0..10)
        .filter(|row| header.is_measured(0.1 * f64::from(*row)))
        .collect();
    assert_eq!(measured, [3, 4, 5, 6]);
    for row in 0..10 {
        let below_s = 0.1 * f64::from(row) - 1e-12;
        assert_eq!(header.row_end_s(below_s), 0.1 * f64::from(row + 1));
    }
}

/// The smallest and the largest x and y of a shape's outline, with the shape's z axis along the
/// body's x axis.
fn lying(shape: &CollisionShape) -> [f64; 4] {
    let z_to_x = nalgebra::Isometry3::rotation(Vector3::y() * std::f64::consts::FRAC_PI_2);
    let outline = outline_from_above_m(&z_to_x, shape);
    let along = |axis: usize| outline.iter().map(move |point| point[axis]);
    let least = |axis| along(axis).fold(f64::INFINITY, f64::min);
    let largest = |axis| along(axis).fold(f64::NEG_INFINITY, f64::max);
    [least(0), largest(0), least(1), largest(1)]
}

/// A box and a cylinder reach half their length to either side of their middle, a capsule its
/// radius further. Round shapes have sample points on their axes, so that the outline has the full
/// width.
#[test]
fn outlines_of_shapes_that_lie_are_as_long_and_as_wide_as_the_shapes() {
    let (radius_m, length_m) = (0.05, 0.4);
    let half_extents_m = Vector3::new(0.05, 0.05, 0.2);
    for (shape, half_length_m) in [
        (CollisionShape::Box { half_extents_m }, 0.2),
        (CollisionShape::Cylinder { radius_m, length_m }, 0.2),
        (CollisionShape::Capsule { radius_m, length_m }, 0.25),
        (CollisionShape::Sphere { radius_m }, 0.05),
    ] {
        let expected = [-half_length_m, half_length_m, -0.05, 0.05];
        for (got, want) in lying(&shape).iter().zip(expected) {
            // Sines of right angles, and a rotation of numbers below 1.
            assert!((got - want).abs() < 1e-15, "{shape:?}: {got} {want}");
        }
    }
}

#[test]
fn a_cylinder_that_stands_is_a_round_seen_from_above() {
    let shape = CollisionShape::Cylinder {
        radius_m: 0.2,
        length_m: 0.1,
    };
    let outline = outline_from_above_m(&nalgebra::Isometry3::identity(), &shape);
    // Every 15 degrees.
    assert_eq!(outline.len(), 24);
    for [x, y] in outline {
        assert!((x.hypot(y) - 0.2).abs() < 1e-15);
    }
}

#[test]
fn the_reference_point_goes_round_with_the_body() {
    let header = Header {
        reference_point_m: [0.3, 0.1],
        ..Header::default()
    };
    // With the heading along y, 0.3 m ahead is along +y and 0.1 m to the left along -x.
    let point = header.reference_point_at(Pose {
        x_m: 1.0,
        y_m: 2.0,
        heading_rad: std::f64::consts::FRAC_PI_2,
    });
    assert!((point.x_m - 0.9).abs() < 1e-15 && (point.y_m - 2.3).abs() < 1e-15);
    assert_eq!(point.heading_rad, std::f64::consts::FRAC_PI_2);
}

/// A wheel's width is the axial extent of its rollers: the row's offset plus half of a roller's
/// length along the axle.
#[test]
fn a_wheel_is_as_wide_as_its_rows_of_rollers_reach() {
    let urdf = include_str!("../../../../../assets/robots/mecanum4.urdf");
    let robot = ilon_robot::Robot::from_urdf_str(urdf, "mecanum4").unwrap();
    let mut wheel = robot.wheels[0].clone();
    let one_row_m = WheelHeader::of_wheel(&wheel).width_m;
    let roller = &wheel.rollers[0];
    let along_m = roller.length_m * roller.axis_in_hub.z.abs();
    assert!((one_row_m - along_m).abs() < 1e-12, "{one_row_m} {along_m}");
    // Every other roller moves 3 cm along the axle: the wheel grows by twice as much, because it is
    // drawn symmetric about its hub.
    for roller in wheel.rollers.iter_mut().step_by(2) {
        roller.center_in_hub_m.z -= 0.03;
    }
    let two_rows_m = WheelHeader::of_wheel(&wheel).width_m;
    assert!((two_rows_m - one_row_m - 0.06).abs() < 1e-12);
}
