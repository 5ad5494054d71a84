use ilon_robot::{MotorLimits, Robot, Twist};

use super::*;
use crate::tests::robots::{mecanum4, volksbot};
use crate::{Heading, LimitSettings, MotorCurve, PushSharing};

fn limits(robot: &Robot, share: f64, slope_rad: f64) -> AccelerationLimits {
    let settings = LimitSettings {
        friction: 0.5,
        gravity_m_s2: 9.81,
        slope_rad,
        downhill_rad: 0.0,
        sharing: PushSharing::EqualLoops,
        share,
    };
    AccelerationLimits::new(robot, &settings).unwrap()
}

fn motors(count: usize, curve: MotorCurve) -> Vec<Motor> {
    vec![Motor::new(&MotorLimits::default(), curve).unwrap(); count]
}

/// Returns the fastest traversal of a path at a share of the limits, and the end of the last lap or
/// of the path.
fn fastest(
    path: &Reference,
    limits: &mut AccelerationLimits,
    motors: &[Motor],
    rate_limit_rad_s: f64,
) -> Result<Reference, ControlError> {
    let mut under = Fastest {
        limits,
        motors,
        wheel_rate_limit_rad_s: rate_limit_rad_s,
        reference_point_m: Vector2::zeros(),
        downhill_in_world_rad: 0.4,
    };
    path.as_fast_as_possible(&mut under, 30.0)
}

fn facing(heading_rad: f64) -> Heading {
    Heading::Constant { heading_rad }
}

/// Returns the time at which a reference reaches its final rest, in seconds.
fn done_s(reference: &Reference) -> f64 {
    let end = reference.at(1e6).pose;
    let is_done = |t_s: f64| (reference.at(t_s).pose.position_m() - end.position_m()).norm() < 1e-9;
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if is_done(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// From rest to rest over L with a each way: 2 sqrt(L / a); and with a top speed v: L / v + v / a.
#[test]
fn a_line_takes_the_time_of_constant_acceleration() {
    let robot = mecanum4();
    let mut limits = limits(&robot, 1.0, 0.0);
    let motors = motors(4, MotorCurve::Flat);
    let ahead = Twist::new(1.0, 0.0, 0.0);
    let a = limits
        .along(ahead, Twist::default(), &motors)
        .unwrap()
        .largest;
    let to = Vector2::new(2.0 * 0.3_f64.cos(), 2.0 * 0.3_f64.sin());
    let path = Reference::line(Vector2::zeros(), to, 0.1, facing(0.3)).unwrap();
    let free = fastest(&path, &mut limits, &motors, f64::INFINITY).unwrap();
    let expected_s = 2.0 * (2.0 / a).sqrt();
    // The end is detected within a nanometre, which takes sqrt(2e-9 / a) less.
    assert!(
        (done_s(&free) / expected_s - 1.0).abs() < 1e-4,
        "{} {expected_s}",
        done_s(&free)
    );
    // 20 rad/s on 50 mm.
    let held = fastest(&path, &mut limits, &motors, 20.0).unwrap();
    let expected_s = 2.0 + 1.0 / a;
    assert!(
        (done_s(&held) / expected_s - 1.0).abs() < 3e-3,
        "{} {expected_s}",
        done_s(&held)
    );
    let middle = held.at(0.5 * done_s(&held));
    assert!((middle.velocity_in_world.linear_m_s().norm() - 1.0).abs() < 1e-9);
    assert!((middle.pose.position_m() - 0.5 * to).norm() < 1e-2);
}

/// The paths of the tests below. However long a path is, it starts and ends like a short one: lines
/// of 2 m to 1000 km, and a lap of as much, whose own grid has steps of up to 8 km.
#[test]
fn long_paths_begin_and_end_as_short_ones_do() {
    let robot = mecanum4();
    let mut limits = limits(&robot, 1.0, 0.0);
    let motors = motors(4, MotorCurve::Flat);
    let mut line = |length_m: f64| {
        let to = Vector2::new(length_m, 0.0);
        let path = Reference::line(Vector2::zeros(), to, 0.1, facing(0.0)).unwrap();
        fastest(&path, &mut limits, &motors, 30.0).unwrap()
    };
    let gone_m = |reference: &Reference, t_s: f64| {
        (reference.at(t_s).pose.position_m() - reference.at(0.0).pose.position_m()).norm()
    };
    let short = line(2.0);
    for length_m in [20.0, 120.0, 1e6] {
        let long = line(length_m);
        for t_s in [0.1, 0.3, 0.6] {
            let (short_m, long_m) = (gone_m(&short, t_s), gone_m(&long, t_s));
            // Half of a step of 50 mm, at the speed there.
            assert!(
                (long_m / short_m - 1.0).abs() < 0.03,
                "{length_m} m: {long_m} {short_m} at {t_s} s"
            );
        }
    }
    // It stops within the same distance as it starts, and moves at its top speed in between.
    let (top_m_s, long) = (30.0 * 0.05, line(120.0));
    let (own_s, short_s) = (done_s(&long), done_s(&short));
    let expected_s = short_s + 118.0 / top_m_s;
    assert!(
        (own_s / expected_s - 1.0).abs() < 0.02,
        "{own_s} {expected_s}"
    );
    let circle =
        |radius_m: f64| Reference::circle(Vector2::zeros(), radius_m, 0.1, 0.0, facing(0.0));
    let lap = circle(1e6).unwrap();
    let lap = fastest(&lap, &mut self::limits(&robot, 1.0, 0.0), &motors, 30.0).unwrap();
    // Along +y: as far as a line that way.
    let to = Vector2::new(0.0, 2.0);
    let left = Reference::line(Vector2::zeros(), to, 0.1, facing(0.0)).unwrap();
    let left = fastest(&left, &mut self::limits(&robot, 1.0, 0.0), &motors, 30.0).unwrap();
    let (lap_m, left_m) = (gone_m(&lap, 0.3), gone_m(&left, 0.3));
    assert!((lap_m / left_m - 1.0).abs() < 0.03, "{lap_m} {left_m}");
}

fn paths() -> Vec<Reference> {
    let corners = [
        (0.0, 0.0),
        (1.0, 0.0),
        (1.0, 0.0),
        (1.0, 1.0),
        (1.0, 1.0),
        (0.0, 1.0),
        (0.0, 1.0),
        (0.0, 0.0),
    ];
    let corners = corners.map(|(x, y)| Vector2::new(x, y)).to_vec();
    let times_s: Vec<f64> = (0..8).map(f64::from).collect();
    let curve = [(0.0, 0.0), (0.8, 0.3), (1.0, 1.0), (0.2, 1.2)]
        .map(|(x, y)| Vector2::new(x, y))
        .to_vec();
    let eight =
        |heading| Reference::figure_eight(Vector2::zeros(), 0.8, 0.3, 7.0, heading).unwrap();
    vec![
        Reference::waypoints(&times_s, corners, facing(0.5)).unwrap(),
        Reference::waypoints_at_speed(curve, 0.7, facing(0.0)).unwrap(),
        eight(facing(0.0)),
        eight(Heading::Tangent { offset_rad: 0.2 }),
        Reference::circle(
            Vector2::zeros(),
            0.6,
            -0.4,
            0.0,
            Heading::Rate {
                start_rad: 0.0,
                rate_rad_s: 0.5,
            },
        )
        .unwrap(),
    ]
}

/// Returns the share of the limits that a reference needs at a time.
fn share_at(
    reference: &Reference,
    t_s: f64,
    limits: &mut AccelerationLimits,
    motors: &[Motor],
) -> f64 {
    let phi = reference.at(t_s).pose.heading_rad;
    let twist = reference.at(t_s).velocity_in_world.rotated(-phi);
    let omega = twist.omega_rad_s;
    let rate = reference.acceleration_in_world(t_s).rotated(-phi)
        + Twist::new(omega * twist.vy_m_s, -omega * twist.vx_m_s, 0.0);
    limits.turn_slope(0.4 - phi).unwrap();
    limits.used(rate, twist, motors).unwrap().share
}

/// At a share of 0.9 no moment needs much more than 0.9, and nearly every moment needs it: the
/// difference is the grid, which matters most where curvature jumps, at inner waypoints.
#[test]
fn the_share_is_kept_and_used_up() {
    for (robot, slope_rad) in [(mecanum4(), 0.0), (mecanum4(), 0.08), (volksbot(), 0.0)] {
        let n = robot.wheels.len();
        let curve = MotorCurve::dc_line(1.2, 40.0).unwrap();
        let motors = motors(n, curve);
        for (index, path) in paths().into_iter().enumerate() {
            let made = fastest(&path, &mut limits(&robot, 0.9, slope_rad), &motors, 35.0).unwrap();
            let mut whole = limits(&robot, 1.0, slope_rad);
            let end_s = done_s(&made).min(12.0);
            let mut shares: Vec<f64> = (1..2000)
                .map(|k| f64::from(k) * end_s / 2000.0 + 1e-7)
                .map(|t_s| share_at(&made, t_s, &mut whole, &motors))
                .collect();
            shares.sort_by(f64::total_cmp);
            let [least, most] = [shares[200], shares[1998]];
            println!(
                "path {index}, {n} wheels, slope {slope_rad}: {end_s:.3} s, a tenth below {least:.3}, most {most:.3}"
            );
            assert!(most < 0.95, "{index}");
            // The wheels' rate limit holds eights and circle for part of their laps.
            let at_least = if index < 2 { 0.8 } else { 0.5 };
            assert!(least > at_least, "{index}");
        }
    }
}

/// Computes the minimal time by dynamic programming over all speed profiles on a grid: for each
/// position and squared speed the smallest time from rest over all predecessors with a possible
/// acceleration. Returns the times at the positions of the fastest profile.
fn brute_force_s(
    path: &Reference,
    own_s: &[f64],
    limits: &mut AccelerationLimits,
    motors: &[Motor],
    most: f64,
) -> Vec<f64> {
    const LEVELS: usize = 240;
    let square = |j: usize| most * j as f64 / (LEVELS - 1) as f64;
    let point = |own_s: f64| path.at(own_s);
    let mut time_s = vec![f64::INFINITY; LEVELS];
    time_s[0] = 0.0;
    let mut came_from: Vec<Vec<usize>> = Vec::new();
    let mut times: Vec<Vec<f64>> = vec![time_s.clone()];
    for pair in own_s.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let middle = point(0.5 * (from + to));
        let phi = middle.pose.heading_rad;
        // Tangents at both ends, and the length between, from a fine polygon.
        let fine: Vec<Vector2<f64>> = (0..=20)
            .map(|k| {
                point(from + (to - from) * f64::from(k) / 20.0)
                    .pose
                    .position_m()
            })
            .collect();
        let length_m: f64 = fine.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        let tangent = |own_s: f64| point(own_s).velocity_in_world.linear_m_s().normalize();
        let inside = 1e-4 * (to - from);
        let bend = (tangent(to - inside) - tangent(from + inside)) / length_m;
        let along = middle.velocity_in_world.linear_m_s().normalize();
        let in_body = |v: Vector2<f64>| Twist::new(v.x, v.y, 0.0).rotated(-phi);
        limits.turn_slope(0.4 - phi).unwrap();
        let mut next = vec![f64::INFINITY; LEVELS];
        let mut best = vec![0; LEVELS];
        for (j, from_s) in time_s.iter().enumerate() {
            for (k, (next_s, best)) in next.iter_mut().zip(&mut best).enumerate() {
                let gain = (square(k) - square(j)) / (2.0 * length_m);
                if !from_s.is_finite() || gain.abs() > 12.0 || j + k == 0 {
                    continue;
                }
                let arrives_s = from_s + 2.0 * length_m / (square(j).sqrt() + square(k).sqrt());
                if arrives_s >= *next_s {
                    continue;
                }
                let mean = 0.5 * (square(j) + square(k));
                let rate = in_body(gain * along + mean * bend);
                let twist = in_body(mean.sqrt() * along);
                if limits.used(rate, twist, motors).unwrap().share <= 1.0 {
                    (*next_s, *best) = (arrives_s, j);
                }
            }
        }
        time_s = next;
        came_from.push(best);
        times.push(time_s.clone());
    }
    // Backtracking from the best end.
    let mut level = (0..LEVELS)
        .min_by(|a, b| time_s[*a].total_cmp(&time_s[*b]))
        .unwrap();
    let mut passed = vec![0.0; own_s.len()];
    for i in (0..own_s.len()).rev() {
        passed[i] = times[i][level];
        if i > 0 {
            level = came_from[i - 1][level];
        }
    }
    passed
}

/// Within 3 % of the search over all speed profiles; its grid makes that slower than necessary by
/// as much.
#[test]
fn an_eight_and_a_square_take_what_a_search_over_all_profiles_finds() {
    let robot = mecanum4();
    let mut limits = limits(&robot, 1.0, 0.0);
    let motors = motors(4, MotorCurve::Flat);
    let all = paths();
    // The side of the square, from rest to rest, is half of a symmetric path: from rest to its
    // middle, twice, four times.
    let square = fastest(&all[0], &mut limits, &motors, f64::INFINITY).unwrap();
    let side = Reference::line(Vector2::zeros(), Vector2::new(0.0, 0.5), 1.0, facing(0.5)).unwrap();
    let other =
        Reference::line(Vector2::zeros(), Vector2::new(0.5, 0.0), 1.0, facing(0.5)).unwrap();
    let own_s: Vec<f64> = (0..=5).map(|k| f64::from(k) * 0.1).collect();
    let [up_s, ahead_s] = [side, other].map(|half| {
        *brute_force_s(&half, &own_s, &mut limits, &motors, 4.0)
            .last()
            .unwrap()
    });
    let expected_s = 4.0 * (up_s + ahead_s);
    println!(
        "square {:.3} s, by search {expected_s:.3} s",
        done_s(&square)
    );
    assert!((done_s(&square) / expected_s - 1.0).abs() < 0.03);
    // The second lap of the eight, of three.
    let eight = fastest(&all[2], &mut limits, &motors, f64::INFINITY).unwrap();
    let own_s: Vec<f64> = (0..=100).map(|k| f64::from(k) * 7.0 / 40.0).collect();
    let passed = brute_force_s(&all[2], &own_s, &mut limits, &motors, 4.0);
    let expected_s = passed[80] - passed[40];
    // A lap is complete when the robot is at the same place in the same direction.
    let at = |t_s: f64| eight.at(t_s).pose.position_m();
    let lap_s = (1..40_000)
        .map(|k| 1.0 + 1e-4 * f64::from(k))
        .min_by(|a, b| {
            (at(6.0 + a) - at(6.0))
                .norm()
                .total_cmp(&(at(6.0 + b) - at(6.0)).norm())
        })
        .unwrap();
    println!("eight {lap_s:.3} s, by search {expected_s:.3} s");
    assert!((lap_s / expected_s - 1.0).abs() < 0.03);
}

/// If a robot cannot stand there is no solution, and a held pose is no path.
#[test]
fn what_cannot_be_driven_is_refused() {
    let robot = mecanum4();
    let motors = motors(4, MotorCurve::Flat);
    let path = Reference::line(Vector2::zeros(), Vector2::new(0.0, 1.0), 1.0, facing(0.0)).unwrap();
    let refused = fastest(&path, &mut limits(&robot, 1.0, 0.5), &motors, 20.0);
    assert!(
        matches!(refused, Err(ControlError::CannotBeDriven { .. })),
        "{refused:?}"
    );
    let hold = Reference::hold(ilon_robot::Pose::default()).unwrap();
    assert_eq!(
        fastest(&hold, &mut limits(&robot, 1.0, 0.0), &motors, 20.0).unwrap(),
        hold
    );
}
