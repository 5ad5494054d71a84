//! Section III-A: reference trajectories, eqs. (13)-(15), and their headings.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use ilon_control::{ControlError, Heading, Reference};
use ilon_robot::Twist;
use nalgebra::Vector2;

const STILL: Heading = Heading::Constant { heading_rad: 0.3 };
const ALONG: Heading = Heading::Tangent { offset_rad: 0.0 };

fn circle(heading: Heading) -> Reference {
    Reference::circle(Vector2::new(1.0, 2.0), 1.0, 0.2, 0.0, heading).unwrap()
}

fn eight(heading: Heading) -> Reference {
    Reference::figure_eight(Vector2::new(-1.0, 0.5), 0.8, 0.4, 20.0, heading).unwrap()
}

fn course(heading: Heading) -> Reference {
    let points = [(0.0, 0.0), (1.0, 0.0), (1.5, 0.8), (0.2, 1.2)];
    let points = points.iter().map(|&(x, y)| Vector2::new(x, y)).collect();
    Reference::waypoints_at_speed(points, 0.25, heading).unwrap()
}

#[test]
fn eq_13_velocities_are_the_derivatives_of_positions_and_headings() {
    let turning = Heading::Rate {
        start_rad: 0.1,
        rate_rad_s: -0.4,
    };
    let at_points = Heading::Waypoints {
        headings_rad: vec![0.0, 3.0, -3.0, 1.0],
    };
    let line = Reference::line(Vector2::zeros(), Vector2::new(3.0, 4.0), 0.25, ALONG).unwrap();
    for reference in [
        line,
        circle(ALONG),
        circle(turning.clone()),
        eight(ALONG),
        course(ALONG),
        course(at_points),
        course(turning),
    ] {
        for k in 1..700 {
            let (t_s, h) = (0.0173 * f64::from(k), 1e-5);
            let d = reference.at(t_s).velocity_in_world;
            let (a, b) = (reference.at(t_s - h).pose, reference.at(t_s + h).pose);
            let slope = (b.position_m() - a.position_m()) / (2.0 * h);
            // Third derivatives stay below 1e3, so the quotient errs by less than 1e3 h^2; rounding
            // adds 1e-10.
            assert!(
                (slope - d.linear_m_s()).norm() < 1e-6,
                "{reference:?} {t_s}"
            );
            let turn = ilon_robot::wrap_angle(b.heading_rad - a.heading_rad) / (2.0 * h);
            assert!((turn - d.omega_rad_s).abs() < 1e-5, "{reference:?} {t_s}");
        }
    }
}

/// The curvilinear abscissa s(t) of eq. (14) from time zero, in metres: the integral of the speed by
/// the midpoint rule, which is exact to 1e-8 m here, as the rounding of the sum is.
fn arc_length_m(reference: &Reference, until_s: f64) -> f64 {
    let step_s = until_s / 20_000.0;
    let speed = |k: i32| {
        let motion = reference.at(step_s * (f64::from(k) + 0.5));
        motion.velocity_in_world.linear_m_s().norm()
    };
    (0..20_000).map(speed).sum::<f64>() * step_s
}

#[test]
fn eq_14_arc_length_is_the_distance_gone() {
    for reference in [circle(STILL), eight(STILL), course(STILL)] {
        let (steps, end_s) = (20_000, 9.3);
        let place = |k: i32| {
            reference
                .at(end_s * f64::from(k) / f64::from(steps))
                .pose
                .position_m()
        };
        let polygon: f64 = (0..steps).map(|k| (place(k + 1) - place(k)).norm()).sum();
        let length = arc_length_m(&reference, end_s);
        // A polygon of chords c misses c^3 kappa^2 / 24 each: below 1e-8 m in all here.
        assert!((polygon - length).abs() < 1e-7, "{polygon} {length}");
    }
    let line = Reference::line(Vector2::zeros(), Vector2::new(3.0, 4.0), 0.5, STILL).unwrap();
    // Rounding of 20,000 equal parts; the second has its end at the edge of one.
    assert!((arc_length_m(&line, 4.0) - 2.0).abs() < 1e-11);
    assert!((arc_length_m(&line, 40.0) - 5.0).abs() < 1e-11);
}

#[test]
fn eq_14_a_whole_lemniscate_has_the_known_length() {
    // 2 a times the lemniscate constant 2.622057554292119. Over a whole period the rule converges
    // faster than any power of its step.
    let length = arc_length_m(&eight(STILL), 20.0);
    assert!(
        (length - 2.0 * 0.8 * 2.622_057_554_292_119).abs() < 1e-9,
        "{length}"
    );
}

#[test]
fn eq_15_the_heading_along_a_path_is_the_direction_of_motion() {
    for reference in [circle(ALONG), eight(ALONG), course(ALONG)] {
        for t_s in [0.7, 3.3, 8.1] {
            let (sin, cos) = reference.at(t_s).pose.heading_rad.sin_cos();
            let v = reference.at(t_s).velocity_in_world.linear_m_s();
            assert!((Vector2::new(cos, sin) - v.normalize()).norm() < 1e-14);
        }
    }
}

#[test]
fn the_lemniscate_has_its_defining_property() {
    // The product of the distances from the foci, at a/sqrt(2) from the crossing, is a^2/2
    // everywhere.
    let reference = Reference::figure_eight(Vector2::zeros(), 0.8, 0.0, 20.0, STILL).unwrap();
    let f = 0.8 / 2.0_f64.sqrt();
    for k in 0..200 {
        let p = reference.at(0.1 * f64::from(k)).pose.position_m();
        let product = (p - Vector2::new(f, 0.0)).norm() * (p + Vector2::new(f, 0.0)).norm();
        assert!((product - 0.32).abs() < 1e-14);
    }
    let start = reference.at(0.0);
    assert!(start.pose.position_m().norm() < 1e-15);
    // Speed at the crossing: 2 pi a / T / sqrt 2.
    let speed = start.velocity_in_world.linear_m_s().norm();
    assert!((speed - TAU * 0.8 / 20.0 / 2.0_f64.sqrt()).abs() < 1e-15);
}

#[test]
fn a_circle_runs_either_way_at_its_speed() {
    let there = circle(ALONG).at(0.0);
    assert!((there.velocity_in_world.vy_m_s - 0.2).abs() < 1e-15);
    assert!((there.pose.heading_rad - FRAC_PI_2).abs() < 1e-15);
    assert!((there.velocity_in_world.omega_rad_s - 0.2).abs() < 1e-15);
    let back = Reference::circle(Vector2::zeros(), 2.0, -0.2, PI, STILL)
        .unwrap()
        .at(0.0);
    assert!((back.velocity_in_world.vy_m_s - 0.2).abs() < 1e-15);
}

#[test]
fn headings_at_waypoints_turn_the_shorter_way() {
    let reference = course(Heading::Waypoints {
        headings_rad: vec![3.0, -3.0, -3.0, 3.0],
    });
    for k in 0..200 {
        let heading_rad = reference.at(0.1 * f64::from(k)).pose.heading_rad;
        // From 3.0 through pi to TAU - 3.0; a C1 curve may overshoot its ends a little, never turn
        // round.
        assert!((2.9..=TAU - 2.9).contains(&heading_rad), "{heading_rad}");
    }
}

#[test]
fn a_tangent_heading_is_defined_at_rest_too() {
    let reference = course(ALONG);
    let (start, soon) = (reference.at(0.0).pose, reference.at(1e-3).pose);
    assert!((start.heading_rad - soon.heading_rad).abs() < 1e-3);
    let end_s = 1e3;
    let before = reference.at(course_end_s() - 1e-3).pose.heading_rad;
    assert!((reference.at(end_s).pose.heading_rad - before).abs() < 1e-3);
    assert_eq!(reference.at(end_s).velocity_in_world, Twist::default());
}

/// Time at which the course ends: its chords at 0.25 m/s.
fn course_end_s() -> f64 {
    (1.0 + 0.5_f64.hypot(0.8) + 1.3_f64.hypot(0.4)) / 0.25
}

#[test]
fn peaks_are_the_largest_speed_and_heading_rate() {
    let (speed, rate) = circle(ALONG).peaks(30.0, 100);
    assert!((speed - 0.2).abs() < 1e-14 && (rate - 0.2).abs() < 1e-14);
    // The lemniscate is fastest at its tips: 2 pi a / T.
    let (speed, _) = eight(STILL).peaks(20.0, 2000);
    assert!((speed - TAU * 0.8 / 20.0).abs() < 1e-6);
}

#[test]
fn what_makes_no_reference_is_refused_by_name() {
    let o = Vector2::zeros();
    let message = |result: Result<Reference, ControlError>| result.unwrap_err().to_string();
    assert_eq!(
        message(Reference::circle(o, 0.0, 0.2, 0.0, STILL)),
        "the circle's radius in m is 0; it must be finite and above zero"
    );
    assert_eq!(
        message(Reference::line(o, o, 0.2, STILL)),
        "the line's length in m is 0; it must be finite and above zero"
    );
    assert_eq!(
        message(Reference::waypoints(&[0.0], vec![o], STILL)),
        "a path by waypoints needs at least 2 points, got 1"
    );
    assert_eq!(
        message(Reference::waypoints(&[0.0, 1.0, 1.0], vec![o, o, o], STILL)),
        "waypoint 2 is at 1 s, not later than the one before; times must increase"
    );
    assert_eq!(
        message(Reference::waypoints(&[0.0, 1.0], vec![o, o], ALONG)),
        "heading along the tangent needs a path that moves: waypoints 0 and 1 are the same point; give a constant \
         heading or a rate instead"
    );
    assert_eq!(
        message(Reference::circle(
            o,
            1.0,
            0.2,
            0.0,
            Heading::Waypoints {
                headings_rad: vec![]
            }
        )),
        "headings at waypoints need a path by waypoints; give a constant heading, a rate or the tangent instead"
    );
    assert_eq!(
        message(Reference::circle(o, 1.0, f64::NAN, 0.0, STILL)),
        "the amount of the circle's speed in m/s is NaN; it must be finite and above zero"
    );
}
