use super::*;
use ilon_trace::{Support, Truth, WheelHeader};

fn header() -> Header {
    Header {
        wheels: vec![WheelHeader {
            radius_m: 0.05,
            ..WheelHeader::default()
        }],
        control_dt_s: 0.01,
        ..Header::default()
    }
}

/// What is said of two seconds of rows, each made from its time.
fn said(row: impl Fn(f64) -> (Record, WheelSample)) -> Vec<String> {
    let header = header();
    let mut posture = Posture::default();
    for step in 0..200 {
        let t_s = 0.01 * f64::from(step);
        let (record, sample) = row(t_s);
        posture.add(&header, &Record { t_s, ..record }, &[sample]);
    }
    let told = posture.episodes().into_iter();
    told.map(|episode| episode.sentence(&header, posture.end_s))
        .collect()
}

fn standing(wheels_n: f64, chassis_n: f64) -> (Record, WheelSample) {
    let record = Record {
        support: Some(Support {
            wheels_n,
            chassis_n,
            ..Support::default()
        }),
        ..Record::default()
    };
    let sample = WheelSample {
        touching: wheels_n > 0.0,
        hub_height_m: 0.05,
        ..WheelSample::default()
    }
    .steady();
    (record, sample)
}

#[test]
fn a_robot_on_its_wheels_goes_without_saying_and_one_on_its_chassis_does_not() {
    assert_eq!(said(|_| standing(111.0, 0.0)), Vec::<String>::new());
    // The solver's rounding is no chassis on the ground.
    assert_eq!(said(|_| standing(111.0, 1e-6)), Vec::<String>::new());
    let lines = said(|_| standing(33.0, 78.0));
    // 78 of 111 N.
    let expected =
        "the wheels carried 33.0 N, and the chassis 78.0 N, <b>70.3 %</b> of the weight.";
    assert!(lines.len() == 1 && lines[0].contains(expected), "{lines:?}");
    assert!(lines[0].starts_with("All through the run"), "{lines:?}");
}

#[test]
fn each_lean_has_its_side() {
    for (roll_deg, pitch_deg, on) in [
        (0.0, 80.0, "its nose"),
        (0.0, -80.0, "its back"),
        (80.0, 0.0, "its right side"),
        (-80.0, 0.0, "its left side"),
        (180.0, 0.0, "its top"),
    ] {
        let lines = said(|_| {
            let (mut record, sample) = standing(50.0, 50.0);
            record.truth = Truth {
                roll_rad: f64::to_radians(roll_deg),
                pitch_rad: f64::to_radians(pitch_deg),
                ..Truth::default()
            };
            (record, sample)
        });
        assert!(
            lines[0].contains(&format!("tipped over on {on}</b>")),
            "{lines:?}"
        );
    }
}

/// Up from 0.5 s at 1 m/s under 10 m/s^2, down again at 0.7 s: 50 mm high.
#[test]
fn a_jump_is_told_with_its_height_and_what_its_landing_took() {
    let lines = said(|t_s| {
        let flies = (0.505..0.695).contains(&t_s);
        let (mut record, sample) = standing(if flies { 0.0 } else { 100.0 }, 0.0);
        let up_s = (t_s - 0.5).clamp(0.0, 0.2);
        record.truth.height_m = 0.05 + up_s - 5.0 * up_s * up_s;
        record.impact_energy_j = if t_s > 0.695 { 31.0 } else { 0.0 };
        (record, sample)
    });
    let [line] = &lines[..] else {
        panic!("one flight: {lines:?}")
    };
    assert!(line.contains("From 0.50 to 0.69 s"), "{line}");
    assert!(
        line.contains("<b>50.00 mm</b> above") && line.contains("took <b>31.00 J</b>"),
        "{line}"
    );
}

#[test]
fn a_fall_ends_below_the_floor() {
    let lines = said(|t_s| {
        let (record, mut sample) = standing(if t_s < 1.0 { 100.0 } else { 0.0 }, 0.0);
        sample.hub_height_m = 0.05 - 5.1 * (t_s - 1.0).max(0.0).powi(2);
        (record, sample)
    });
    // 0.05 - 5.1 * 0.99^2 = -4.9485 m at the last row.
    assert!(
        lines[0].contains("<b>4.949 m</b> below the floor"),
        "{lines:?}"
    );
}

#[test]
fn what_stands_in_the_way_is_told_with_its_force_and_what_was_asked_for() {
    let lines = said(|t_s| {
        let (mut record, sample) = standing(100.0, 0.0);
        record.command_twist_in_body.vx_m_s = 0.5;
        let held = t_s > 0.995;
        record.truth.twist_in_body.vx_m_s = if held { 0.0 } else { 0.5 };
        if let Some(support) = &mut record.support {
            support.obstacles_x_n = if held { -12.0 } else { 0.0 };
        }
        (record, sample)
    });
    let expected =
        "of <b>500 mm/s</b> commanded it reached <b>0.00 mm/s</b>, held back by <b>12.0 N</b>.";
    assert!(lines[0].contains(expected), "{lines:?}");
    assert!(lines[0].starts_with("From 0.99 s to the end"), "{lines:?}");
}

/// 0.4 m/s asked for and 0.1 m/s done, over one and a half seconds: what is said are rates,
/// whatever the time.
#[test]
fn what_is_said_of_an_obstacle_are_means_over_its_time() {
    let lines = said(|t_s| {
        let (mut record, sample) = standing(100.0, 0.0);
        record.command_twist_in_body.vx_m_s = 0.4;
        let held = t_s > 0.495;
        record.truth.twist_in_body.vx_m_s = if held { 0.02 } else { 0.4 };
        if let Some(support) = &mut record.support {
            support.obstacles_x_n = if held { -12.0 } else { 0.0 };
        }
        (record, sample)
    });
    let expected =
        "of <b>400 mm/s</b> commanded it reached <b>20.00 mm/s</b>, held back by <b>12.0 N</b>.";
    assert!(lines[0].contains(expected), "{lines:?}");
}

/// A robot at (1, 2) looks along y; its hub is 0.3 m ahead of its middle, at (1, 2.3). Of two boxes
/// the one whose side is nearer counts, not the one whose middle is: a long wall and a small block.
#[test]
fn the_box_that_is_nearest_stands_in_the_way() {
    let wall = GroundBox {
        center_m: [5.0, 2.5],
        sides_m: [10.0, 0.2, 0.5],
        heading_rad: 0.0,
    };
    let block = GroundBox {
        center_m: [1.0, 3.0],
        sides_m: [0.2, 0.2, 0.1],
        heading_rad: 0.0,
    };
    let header = Header {
        wheels: vec![WheelHeader {
            position_m: [0.3, 0.0],
            ..WheelHeader::default()
        }],
        ground: Some(ilon_trace::Ground {
            boxes: vec![block, wall],
            ..ilon_trace::Ground::default()
        }),
        ..Header::default()
    };
    let mut record = Record::default();
    (record.truth.pose.x_m, record.truth.pose.y_m) = (1.0, 2.0);
    record.truth.pose.heading_rad = std::f64::consts::FRAC_PI_2;
    // 0.1 m to the wall, from (1, 2.3) to y = 2.4; 0.6 m to the block.
    assert_eq!(nearest_box(&header, &record), Some(wall));
    // The same seen from the other end: turned to the block, which is 0.1 m away where the wall has
    // been moved off.
    let far = GroundBox {
        center_m: [5.0, -2.5],
        ..wall
    };
    let near_block = GroundBox {
        center_m: [1.0, 2.5],
        ..block
    };
    let header = Header {
        ground: Some(ilon_trace::Ground {
            boxes: vec![far, near_block],
            ..ilon_trace::Ground::default()
        }),
        ..header
    };
    assert_eq!(nearest_box(&header, &record), Some(near_block));
}

/// A box of 40 kg ahead that does not move, and one on the deck that presses on the robot by its
/// weight.
#[test]
fn a_robot_that_a_body_holds_stands_against_it() {
    let body = |name: &str| ilon_trace::BodyHeader {
        name: name.to_owned(),
        shape: ilon_robot::FreeShape::Box { size_m: [0.2; 3] },
        mass_kg: 40.0,
        friction: 0.5,
    };
    let wheel = |x_m: f64, y_m: f64| WheelHeader {
        position_m: [x_m, y_m],
        radius_m: 0.05,
        ..WheelHeader::default()
    };
    let header = Header {
        wheels: vec![wheel(0.15, 0.16), wheel(-0.15, -0.16)],
        bodies: vec![body("load"), body("block")],
        ..header()
    };
    let said = |push_n: f64| {
        let mut posture = Posture::default();
        for step in 0..200 {
            let (mut record, sample) = standing(111.0, 0.0);
            record.t_s = 0.01 * f64::from(step);
            record.command_twist_in_body.vx_m_s = 0.3;
            (record.bodies[0].push_n, record.bodies[0].place_m) = (20.0, [0.0, 0.0, 0.3]);
            (record.bodies[1].push_n, record.bodies[1].place_m) = (push_n, [0.4, 0.0, 0.1]);
            posture.add(&header, &record, &[sample; 2]);
        }
        let told = posture.episodes().into_iter();
        told.map(|episode| episode.sentence(&header, posture.end_s))
            .collect::<Vec<_>>()
    };
    let lines = said(39.4);
    assert!(
        lines.len() == 1
            && lines[0].contains("stood <b>against block</b>")
            && lines[0].contains("39.4 N"),
        "{lines:?}"
    );
    // What lies on the deck holds nobody.
    assert_eq!(said(0.0), Vec::<String>::new());
}

/// A wall to the robot's right pushes it to the left, with 20 N across and 5 N against its way; a
/// kerb that does so is driven over, and what is pushed straight back is not slid along.
#[test]
fn a_wall_that_pushes_aside_is_slid_along() {
    let lines = |height_m: f64, x_n: f64, y_n: f64| {
        let header = Header {
            ground: Some(ilon_trace::Ground {
                boxes: vec![GroundBox {
                    center_m: [0.0, -0.5],
                    sides_m: [5.0, 0.2, height_m],
                    heading_rad: 0.0,
                }],
                ..ilon_trace::Ground::default()
            }),
            ..header()
        };
        let mut posture = Posture::default();
        for step in 0..100 {
            let (mut record, sample) = standing(100.0, 0.0);
            record.t_s = 0.01 * f64::from(step);
            record.command_twist_in_body.vx_m_s = 0.4;
            record.truth.twist_in_body.vx_m_s = 0.2;
            let support = record.support.as_mut().expect("it stands");
            (support.obstacles_x_n, support.obstacles_y_n) = (x_n, y_n);
            posture.add(&header, &record, &[sample]);
        }
        let found = posture.episodes().into_iter();
        let said = found.map(|episode| episode.sentence(&header, posture.end_s));
        said.collect::<Vec<String>>()
    };
    let said = lines(0.3, -5.0, 20.0);
    let expected = "<b>along a wall</b>, a box 300.0 mm high: of <b>400 mm/s</b> commanded it reached <b>200 mm/s</b>; the wall held it back by \
                    <b>5.0 N</b> and pushed it to the left by <b>20.0 N</b>.";
    assert!(said.len() == 1 && said[0].contains(expected), "{said:?}");
    assert!(lines(0.3, -5.0, -20.0)[0].contains("pushed it to the right by <b>20.0 N</b>"));
    for (height_m, x_n, y_n) in [(0.02, -5.0, 20.0), (0.3, -20.0, 0.0), (0.3, 0.0, 2.0)] {
        assert_eq!(lines(height_m, x_n, y_n), Vec::<String>::new());
    }
}

/// Something holds the robot back by the part of its force that is against the motion: 10 N against
/// a motion along (0.6, 0.8), and none of 10 N beside it.
#[test]
fn what_is_in_the_way_holds_back_along_the_motion() {
    for (force_n, held_back_n) in [([-6.0, -8.0], 10.0), ([-8.0, 6.0], 0.0)] {
        let mut record = Record {
            command_twist_in_body: ilon_robot::Twist::new(0.3, 0.4, 0.0),
            ..Record::default()
        };
        record.truth.twist_in_body = ilon_robot::Twist::new(0.06, 0.08, 0.0);
        let [obstacles_x_n, obstacles_y_n] = force_n;
        record.support = Some(Support {
            obstacles_x_n,
            obstacles_y_n,
            ..Support::default()
        });
        let (speed_m_s, found_n) = progress(&Header::default(), &record).expect("it is to move");
        assert!((speed_m_s - 0.1).abs() < 1e-12, "{speed_m_s}");
        assert!((found_n - held_back_n).abs() < 1e-12, "{found_n}");
    }
}
