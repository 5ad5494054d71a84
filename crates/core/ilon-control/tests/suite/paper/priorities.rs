//! Section III-D: the prioritised tasks and their convergence, eqs. (38)-(50).

use std::f64::consts::TAU;

use ilon_control::{
    Command, Desired, Gain, Guidance, GuidanceSettings, Heading, Kinematics, Priority, Reference,
    Saturation,
};
use ilon_robot::{Pose, Robot, Twist};
use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;

use crate::paper::fixtures::{mecanum4, volksbot};
use crate::paper::random::{any_robot, cases};
use crate::paper::saturation::guidance;
use crate::paper::tracking::{any_desired, any_gain, any_pose, errors};

const POSITION_FIRST: Saturation = Saturation::Prioritised(Priority::Position);
const HEADING_FIRST: Saturation = Saturation::Prioritised(Priority::Heading);

/// The robot moves by the kinematic model for `dt_s`, with the twist held in the world frame.
fn roll(guidance: &Guidance, rates: &[f64], seen: &mut Pose, dt_s: f64) {
    let twist = guidance.kinematics().twist(rates).rotated(seen.heading_rad);
    seen.x_m += twist.vx_m_s * dt_s;
    seen.y_m += twist.vy_m_s * dt_s;
    seen.heading_rad += twist.omega_rad_s * dt_s;
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn eq_38_to_41_and_47_to_50_each_task_asks_for_its_rates(
        (_, kinematics) in any_robot(), seen in any_pose(), desired in any_desired(),
    ) {
        let (e_r, e_phi) = errors(&seen, &desired);
        let d = desired.velocity_in_world;
        let norm = |twist: Twist| {
            let mut rates = vec![0.0; kinematics.wheel_count()];
            kinematics.wheel_rates(twist, &mut rates);
            rates.iter().fold(0.0_f64, |norm, rate| norm.max(rate.abs()))
        };
        let linear = |x, y| Twist::new(x, y, 0.0).rotated(-seen.heading_rad);
        let position = [
            ("position feedforward", norm(linear(d.vx_m_s, d.vy_m_s))),
            ("position feedback", norm(linear(e_r.x, e_r.y))),
        ];
        let heading = [
            ("heading feedforward", norm(Twist::new(0.0, 0.0, d.omega_rad_s))),
            ("heading feedback", norm(Twist::new(0.0, 0.0, e_phi))),
        ];
        for (saturation, expected) in [
            (POSITION_FIRST, [position, heading].concat()),
            (HEADING_FIRST, [heading, position].concat()),
        ] {
            let mut guidance = guidance(kinematics.clone(), saturation, 5.0);
            let command = guidance.update(&seen, &desired);
            for (share, (name, asked)) in command.tasks.iter().zip(expected) {
                prop_assert_eq!(share.name, name);
                prop_assert!((share.asked_rad_s - asked).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn eq_42_43_the_robot_moves_with_the_weighted_tasks(
        (_, kinematics) in any_robot(), seen in any_pose(), desired in any_desired(), limit in 0.5..20.0_f64,
    ) {
        let (e_r, e_phi) = errors(&seen, &desired);
        let d = desired.velocity_in_world;
        let mut guidance = guidance(kinematics, POSITION_FIRST, limit);
        let command = guidance.update(&seen, &desired).clone();
        let moved = guidance.kinematics().twist(&command.wheel_rates_rad_s).rotated(seen.heading_rad);
        let w: Vec<f64> = command.tasks.iter().map(|t| t.weight).collect();
        let v_c = d.linear_m_s() * w[0] + e_r * w[1];
        let omega = d.omega_rad_s * w[2] + e_phi * w[3];
        prop_assert!((moved.linear_m_s() - v_c).norm() < 1e-9);
        prop_assert!((moved.omega_rad_s - omega).abs() < 1e-9);
        let told = command.saturated_twist_in_body.rotated(seen.heading_rad);
        prop_assert!((told.linear_m_s() - v_c).norm() < 1e-12 && (told.omega_rad_s - omega).abs() < 1e-12);
    }

    #[test]
    fn eq_42_the_heading_never_changes_the_linear_velocity_of_position_first(
        (_, kinematics) in any_robot(), seen in any_pose(), desired in any_desired(), other in any_desired(),
        limit in 0.5..20.0_f64,
    ) {
        let mut guidance = guidance(kinematics, POSITION_FIRST, limit);
        let mixed = Desired {
            pose: Pose { heading_rad: other.pose.heading_rad, ..desired.pose },
            velocity_in_world: Twist {
                omega_rad_s: other.velocity_in_world.omega_rad_s,
                ..desired.velocity_in_world
            },
        };
        let one = guidance.update(&seen, &desired).saturated_twist_in_body;
        let two = guidance.update(&seen, &mixed).saturated_twist_in_body;
        prop_assert_eq!(one.linear_m_s(), two.linear_m_s());
    }
}

/// A robot, gains, a start and a feasible reference that moves straight and turns steadily, so that
/// one Euler step of the kinematic model is exact.
#[derive(Clone, Debug)]
struct Course {
    kinematics: Kinematics,
    settings: GuidanceSettings,
    k_r: Matrix2<f64>,
    start: Pose,
    reference: Reference,
}

fn any_course(saturation: Saturation) -> impl Strategy<Value = Course> {
    let reference = (any_pose(), -3.2..3.2_f64, 0.05..0.95_f64, -0.95..0.95_f64);
    let robot = any_robot().prop_map(|(_, kinematics)| kinematics);
    (robot, any_gain(), 0.3..3.0_f64, any_pose(), reference).prop_map(
        move |(kinematics, k_r, k_phi, start, (from, direction, share, turn_share))| {
            let limit = 10.0;
            let settings = GuidanceSettings {
                position_gain: Gain::Matrix(k_r),
                heading_gain: k_phi,
                wheel_rate_limit_rad_s: limit,
                saturation,
            };
            // Shares of what the feasibility conditions (36), (37) allow.
            let guidance = Guidance::new(kinematics.clone(), &settings).unwrap();
            let unit = guidance.feasibility(1.0, 1.0);
            let speed = share * 0.5 * limit / unit.position_rad_s;
            let rate_rad_s = turn_share * 0.5 * limit / unit.heading_rad_s;
            let heading = Heading::Rate {
                start_rad: from.heading_rad,
                rate_rad_s,
            };
            let from = from.position_m();
            let to = from + 1e4 * Vector2::new(direction.cos(), direction.sin());
            let reference = Reference::line(from, to, speed, heading).unwrap();
            Course {
                kinematics,
                settings,
                k_r,
                start,
                reference,
            }
        },
    )
}

/// Runs a course: the command and the errors (16), (17) at each step.
fn run(course: &Course, dt_s: f64, steps: usize) -> Vec<(Command, Vector2<f64>, f64)> {
    let mut guidance = Guidance::new(course.kinematics.clone(), &course.settings).unwrap();
    let mut seen = course.start;
    (0..steps)
        .map(|k| {
            let desired = course.reference.at(k as f64 * dt_s);
            let command = guidance.update(&seen, &desired).clone();
            let (e_r, e_phi) = errors(&seen, &desired);
            roll(&guidance, &command.wheel_rates_rad_s, &mut seen, dt_s);
            (command, e_r, e_phi)
        })
        .collect()
}

/// Index from which on the two lower tasks are never held down: the paper's t*, as a step.
fn t_star(trail: &[(Command, Vector2<f64>, f64)]) -> usize {
    let starved = |(command, ..): &(Command, Vector2<f64>, f64)| {
        let (third, fourth) = (&command.tasks[2], &command.tasks[3]);
        third.is_saturated() || fourth.capacity_rad_s <= 0.0
    };
    trail.iter().rposition(starved).map_or(0, |k| k + 1)
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn eq_44_to_50_the_higher_error_never_grows_and_the_lower_one_not_after_t_star(
        position in any_course(POSITION_FIRST), heading in any_course(HEADING_FIRST),
    ) {
        let falls = |errors: Vec<f64>| errors.windows(2).all(|pair| {
            // As below: exact steps but for rounding.
            pair[1] <= pair[0] + 1e-10 * pair[0].sqrt().max(1e-3)
        });
        for (course, position_first) in [(&position, true), (&heading, false)] {
            let trail = run(course, 0.02, 600);
            let v_r = |from: usize| trail[from..].iter().map(|(_, e, _)| e.dot(&(course.k_r * e))).collect();
            let v_phi = |from: usize| trail[from..].iter().map(|(_, _, e)| e * e).collect();
            let star = t_star(&trail).min(trail.len() - 1);
            let (from_r, from_phi) = if position_first { (0, star) } else { (star, 0) };
            prop_assert!(falls(v_r(from_r)) && falls(v_phi(from_phi)), "{course:?}");
        }
    }
}

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn eq_44_to_46_position_first_v1_never_grows_and_v2_not_after_t_star(course in any_course(POSITION_FIRST)) {
        let trail = run(&course, 0.02, 6000);
        let v_1 = |e: &Vector2<f64>| 0.5 * e.dot(&(course.k_r * e));
        for pair in trail.windows(2) {
            // Exact steps but for rounding of positions that reach hundreds of metres: 1e-13 m on
            // errors up to 10 m.
            let (before, after) = (v_1(&pair[0].1), v_1(&pair[1].1));
            prop_assert!(after <= before + 1e-10 * before.sqrt().max(1e-3), "{before} {after}");
        }
        let star = t_star(&trail);
        // 120 s are many time constants of every gain and robot drawn, saturated phases included,
        // but a slow robot far away may still be on its way; then there is nothing to say of V2
        // yet.
        for pair in trail[star.min(trail.len() - 1)..].windows(2) {
            let (before, after) = (pair[0].2.powi(2), pair[1].2.powi(2));
            prop_assert!(after <= before + 1e-10 * before.sqrt().max(1e-3), "{before} {after}");
        }
        if star + 3000 < trail.len() {
            let (_, e_r, e_phi) = trail.last().unwrap();
            prop_assert!(e_r.norm() < 1e-3 && e_phi.abs() < 1e-3, "{e_r:?} {e_phi} {star}");
        }
    }

    #[test]
    fn eq_47_to_50_heading_first_v2_never_grows_and_v1_not_after_t_star(course in any_course(HEADING_FIRST)) {
        let trail = run(&course, 0.02, 6000);
        for pair in trail.windows(2) {
            let (before, after) = (pair[0].2.powi(2), pair[1].2.powi(2));
            prop_assert!(after <= before + 1e-10 * before.sqrt().max(1e-3), "{before} {after}");
        }
        let v_1 = |e: &Vector2<f64>| 0.5 * e.dot(&(course.k_r * e));
        for pair in trail[t_star(&trail).min(trail.len() - 1)..].windows(2) {
            let (before, after) = (v_1(&pair[0].1), v_1(&pair[1].1));
            prop_assert!(after <= before + 1e-10 * before.sqrt().max(1e-3), "{before} {after}");
        }
    }
}

/// The experiment of section IV under the kinematic model: a circle of 1 m, constant heading,
/// limited to 8.7 rad/s. Returns when position error and heading error get below 5 cm and 3 deg for
/// good, in seconds.
fn converged_s(robot: &Robot, saturation: Saturation) -> (f64, f64) {
    let settings = GuidanceSettings {
        position_gain: Gain::Scalar(1.0),
        heading_gain: 1.0,
        wheel_rate_limit_rad_s: 8.7,
        saturation,
    };
    let still = Heading::Constant { heading_rad: 0.0 };
    let course = Course {
        kinematics: Kinematics::new(robot).unwrap(),
        settings,
        k_r: Matrix2::identity(),
        start: Pose {
            x_m: 2.5,
            y_m: 0.0,
            heading_rad: TAU / 3.0,
        },
        reference: Reference::circle(Vector2::zeros(), 1.0, 0.2, 0.0, still).unwrap(),
    };
    let dt_s = 0.01;
    let trail = run(&course, dt_s, 4000);
    let last = |far: &dyn Fn(&Vector2<f64>, f64) -> bool| {
        dt_s * trail
            .iter()
            .rposition(|(_, e_r, e_phi)| far(e_r, *e_phi))
            .unwrap() as f64
    };
    (
        last(&|e_r, _| e_r.norm() > 0.05),
        last(&|_, e_phi| e_phi.abs() > 3.0_f64.to_radians()),
    )
}

#[test]
fn section_4_the_task_of_high_priority_converges_first() {
    let (position_s, heading_s) = converged_s(&volksbot(), POSITION_FIRST);
    assert!(position_s < heading_s, "{position_s} {heading_s}");
    let (position_s, heading_s) = converged_s(&volksbot(), HEADING_FIRST);
    assert!(heading_s < position_s, "{position_s} {heading_s}");
}

#[test]
fn eq_46_before_t_star_the_low_task_may_lose_ground() {
    // Position first, far away, with a turning heading reference: the position takes all, the
    // heading falls behind.
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    let mut guidance = guidance(kinematics, POSITION_FIRST, 8.7);
    let turning = Heading::Rate {
        start_rad: 0.3,
        rate_rad_s: 0.5,
    };
    let reference =
        Reference::line(Vector2::zeros(), Vector2::new(90.0, 0.0), 0.1, turning).unwrap();
    let mut seen = Pose {
        x_m: -4.0,
        ..Pose::default()
    };
    let mut heading_errors = Vec::new();
    for k in 0..100 {
        let desired = reference.at(0.02 * f64::from(k));
        let command = guidance.update(&seen, &desired).clone();
        assert_eq!(command.tasks[2].weight, 0.0);
        assert!(command.tasks[1].is_saturated());
        heading_errors.push(errors(&seen, &desired).1);
        roll(&guidance, &command.wheel_rates_rad_s, &mut seen, 0.02);
    }
    assert!(heading_errors.windows(2).all(|pair| pair[1] > pair[0]));
}

#[test]
fn an_infeasible_feedforward_starves_the_feedback() {
    // Assumption (36) broken for good: 0.6 m/s asks for up to 12 rad/s of 8.7. Task 1 takes
    // everything, the feedback gets no capacity, and the position error grows without end.
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    let mut guidance = guidance(kinematics, POSITION_FIRST, 8.7);
    assert!(!guidance.feasibility(0.6, 0.0).holds());
    let still = Heading::Constant { heading_rad: 0.0 };
    let reference = Reference::line(Vector2::zeros(), Vector2::new(90.0, 0.0), 0.6, still).unwrap();
    let mut seen = Pose::default();
    for k in 0..2000 {
        let desired = reference.at(0.02 * f64::from(k));
        let command = guidance.update(&seen, &desired).clone();
        assert_eq!(command.tasks[1].capacity_rad_s, 0.0);
        roll(&guidance, &command.wheel_rates_rad_s, &mut seen, 0.02);
    }
    let desired = reference.at(40.0);
    // 8.7 rad/s carry 0.435/cos(30 deg) m/s along x: the rest of 0.6 m/s is lost each second.
    let lost = 40.0 * (0.6 - 8.7 * 0.05 / 0.75_f64.sqrt());
    assert!((errors(&seen, &desired).0.norm() - lost).abs() < 1e-9);
}

#[test]
fn a_heading_rate_that_is_infeasible_costs_the_heading_and_not_the_position() {
    // Assumption (37) broken for good: 2 rad/s ask for 10 rad/s of 8.7. Position first, all the
    // same, converges as if nothing were; the heading falls behind by what the wheels lack.
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    let run_with = |rate_rad_s: f64| {
        let mut guidance = guidance(kinematics.clone(), POSITION_FIRST, 8.7);
        let turning = Heading::Rate {
            start_rad: 0.0,
            rate_rad_s,
        };
        let hold = Vector2::new(0.0, 0.0);
        let reference = Reference::line(hold, Vector2::new(1e-9, 0.0), 1e-12, turning).unwrap();
        assert_eq!(
            guidance.feasibility(0.0, rate_rad_s).holds(),
            rate_rad_s < 0.8
        );
        let mut seen = Pose {
            x_m: -0.5,
            ..Pose::default()
        };
        let (mut position_m, mut turned_rad) = (Vec::new(), 0.0);
        for k in 0..1000 {
            let desired = reference.at(0.01 * f64::from(k));
            let command = guidance.update(&seen, &desired).clone();
            position_m.push(errors(&seen, &desired).0.norm());
            let before_rad = seen.heading_rad;
            roll(&guidance, &command.wheel_rates_rad_s, &mut seen, 0.01);
            turned_rad += seen.heading_rad - before_rad;
        }
        (position_m, turned_rad)
    };
    let (position_m, turned_rad) = run_with(2.0);
    assert!(position_m.windows(2).all(|pair| pair[1] <= pair[0] + 1e-12));
    assert!(position_m[999] < 1e-4, "{}", position_m[999]);
    // 8.7 rad/s turn the robot with 1.74 rad/s at most: at least 2.6 rad are lost in 10 s.
    assert!(turned_rad < 17.4 + 1e-9, "{turned_rad}");
    let (_, feasible_rad) = run_with(0.5);
    assert!((feasible_rad - 5.0).abs() < 0.5, "{feasible_rad}");
}

#[test]
fn scaling_lets_the_heading_slow_the_position_down() {
    // What the paper holds against it, on robot A with a large heading error.
    let kinematics = Kinematics::new(&mecanum4()).unwrap();
    let seen = Pose::default();
    let desired = |heading_rad| Desired {
        pose: Pose {
            x_m: 0.3,
            y_m: 0.0,
            heading_rad,
        },
        velocity_in_world: Twist::default(),
    };
    let forward = |saturation, heading_rad| {
        let mut guidance = guidance(kinematics.clone(), saturation, 8.7);
        guidance
            .update(&seen, &desired(heading_rad))
            .saturated_twist_in_body
            .vx_m_s
    };
    assert_eq!(forward(POSITION_FIRST, 3.0), forward(POSITION_FIRST, 0.0));
    assert!(forward(Saturation::Scale, 3.0) < 0.5 * forward(Saturation::Scale, 0.0));
}
