//! Sections III-C, III-D and the appendix: eqs. (29)-(37), (51), (52).

use ilon_control::{
    Gain, Guidance, GuidanceSettings, Kinematics, Priority, Saturation, Task, TaskShare,
    share_capacity, sigma,
};
use ilon_robot::Twist;
use nalgebra::Vector2;
use proptest::prelude::*;

use crate::paper::fixtures::volksbot;
use crate::paper::random::{any_robot, cases};
use crate::paper::tracking::{any_desired, any_pose};

pub fn guidance(kinematics: Kinematics, saturation: Saturation, limit_rad_s: f64) -> Guidance {
    let settings = GuidanceSettings {
        position_gain: Gain::Scalar(1.0),
        heading_gain: 1.0,
        wheel_rate_limit_rad_s: limit_rad_s,
        saturation,
    };
    Guidance::new(kinematics, &settings).unwrap()
}

fn infinity_norm(rates: &[f64]) -> f64 {
    rates.iter().fold(0.0, |norm, rate| norm.max(rate.abs()))
}

/// Up to seven tasks of any size, some of them nothing.
fn any_tasks() -> impl Strategy<Value = Vec<Task>> {
    let size = prop_oneof![Just(0.0), 0.01..3.0];
    let task = (size, -1.0..1.0, -1.0..1.0, -3.0..3.0).prop_map(|(size, x, y, w)| Task {
        name: "any",
        twist_in_body: Twist::new(x, y, w).scaled(size),
    });
    prop::collection::vec(task, 1..=7)
}

fn any_saturation() -> impl Strategy<Value = Saturation> {
    prop_oneof![
        Just(Saturation::Prioritised(Priority::Position)),
        Just(Saturation::Prioritised(Priority::Heading)),
        Just(Saturation::Clip),
        Just(Saturation::Scale),
    ]
}

proptest! {
    #![proptest_config(cases(2000))]

    /// What follows (36) and (37): the rates of a robot that is where it shall be. They are those
    /// that the plain law commands there, and within the limit where both conditions hold.
    #[test]
    fn eq_36_37_keep_the_feedforward_within_the_limit(
        (_, kinematics) in any_robot(), limit in 0.1..200.0_f64, desired in any_desired(),
    ) {
        let mut guidance = guidance(kinematics, Saturation::None, limit);
        let asked = guidance.feedforward(&desired);
        let velocity = desired.velocity_in_world;
        let feasibility = guidance.feasibility(velocity.linear_m_s().norm(), velocity.omega_rad_s);
        prop_assert!(!feasibility.holds() || asked.share() < 1.0);
        let rates = &guidance.update(&desired.pose, &desired).wheel_rates_rad_s;
        prop_assert!((rates[asked.wheel] - asked.rate_rad_s).abs() <= 1e-9 * (1.0 + asked.rate_rad_s.abs()));
        prop_assert!((infinity_norm(rates) - asked.share() * limit).abs() <= 1e-9 * (1.0 + infinity_norm(rates)));
    }

    #[test]
    fn eq_29_and_35_the_command_never_exceeds_the_limit(
        (_, kinematics) in any_robot(), saturation in any_saturation(), limit in 0.1..50.0_f64,
        seen in any_pose(), desired in any_desired(),
    ) {
        let mut guidance = guidance(kinematics, saturation, limit);
        let command = guidance.update(&seen, &desired);
        // Not a rounding above: the limit is a promise to the motors.
        prop_assert!(infinity_norm(&command.wheel_rates_rad_s) <= limit);
    }

    #[test]
    fn eq_32_to_35_hold_for_any_number_of_tasks(
        (_, kinematics) in any_robot(), tasks in any_tasks(), limit in 0.1..50.0_f64,
    ) {
        let n = kinematics.wheel_count();
        let first = Saturation::Prioritised(Priority::Position);
        let mut guidance = guidance(kinematics.clone(), first, limit);
        let command = guidance.command(&tasks).clone();
        // Eqs. (33), (34) written out again, each wheel by itself.
        let (mut c, mut q_d) = (limit, vec![0.0; n]);
        for (task, share) in tasks.iter().zip(&command.tasks) {
            let mut q_h = vec![0.0; n];
            kinematics.wheel_rates(task.twist_in_body, &mut q_h);
            let x = infinity_norm(&q_h);
            // The reference gains a rounding of 1e-16 a step on numbers below 1e3.
            prop_assert!((share.asked_rad_s - x).abs() < 1e-12);
            prop_assert!((share.capacity_rad_s - c).abs() < 1e-9);
            let weight = if x == 0.0 { 0.0 } else { (c / x).min(1.0) };
            for (sum, rate) in q_d.iter_mut().zip(&q_h) {
                *sum += weight * rate;
            }
            c = (c - weight * x).max(0.0);
        }
        for (wheel, sum) in command.wheel_rates_rad_s.iter().zip(q_d) {
            prop_assert!((wheel - sum).abs() < 1e-9);
        }
        // Eq. (34): capacities fall, never below zero; once zero, zero for all below.
        for pair in command.tasks.windows(2) {
            prop_assert!(pair[1].capacity_rad_s <= pair[0].capacity_rad_s && pair[1].capacity_rad_s >= 0.0);
        }
        if limit.is_finite() {
            prop_assert!(infinity_norm(&command.wheel_rates_rad_s) <= limit);
        }
        // Without a limit eq. (33) is the plain sum (32).
        let mut free = self::guidance(kinematics.clone(), first, f64::INFINITY);
        let free = free.command(&tasks).clone();
        let mut sum = vec![0.0; n];
        kinematics.wheel_rates(free.twist_in_body, &mut sum);
        for (wheel, sum) in free.wheel_rates_rad_s.iter().zip(sum) {
            prop_assert!((wheel - sum).abs() < 1e-9);
        }
    }

    #[test]
    fn eq_51_52_the_appendix_adds_up(asked in prop::collection::vec(0.0..20.0_f64, 1..9), limit in 0.1..30.0_f64) {
        let mut shares: Vec<_> = asked.iter().map(|asked_rad_s| TaskShare {
            twist_in_body: Twist::default(),
            name: "any", asked_rad_s: *asked_rad_s, capacity_rad_s: 0.0, weight: 0.0,
        }).collect();
        share_capacity(limit, &mut shares);
        // Eq. (51), then eq. (52): c_1 = c_n + the sum of the first n - 1, and at least the sum of
        // all.
        let q_bar: Vec<f64> = shares.iter().map(|s| s.asked_rad_s * sigma(s.asked_rad_s, s.capacity_rad_s)).collect();
        let n = shares.len();
        let before_last: f64 = q_bar[..n - 1].iter().sum();
        prop_assert!((shares[0].capacity_rad_s - shares[n - 1].capacity_rad_s - before_last).abs() < 1e-12);
        prop_assert!(q_bar.iter().sum::<f64>() <= shares[0].capacity_rad_s + 1e-12);
    }

    #[test]
    fn eq_33_a_lower_task_never_changes_a_higher_one(
        (_, kinematics) in any_robot(), tasks in any_tasks(), others in any_tasks(), limit in 0.1..50.0_f64,
    ) {
        let first = Saturation::Prioritised(Priority::Position);
        let mut guidance = guidance(kinematics, first, limit);
        let alone = guidance.command(&tasks).clone();
        let joined: Vec<_> = tasks.iter().chain(&others).copied().collect();
        let together = guidance.command(&joined).clone();
        prop_assert_eq!(&alone.tasks[..], &together.tasks[..tasks.len()]);
    }

    #[test]
    fn eq_36_37_feasible_feedforward_fits_at_every_heading(
        (_, kinematics) in any_robot(), limit in 1.0..50.0_f64, share in 0.0..1.0_f64, turn_share in 0.0..1.0_f64,
        direction in -3.2..3.2_f64,
    ) {
        // A reference that uses the given shares of what (36) and (37) allow.
        let mut guidance = guidance(kinematics, Saturation::None, limit);
        let unit = guidance.feasibility(1.0, 1.0);
        let speed = share * 0.5 * limit / unit.position_rad_s;
        let rate = turn_share * 0.5 * limit / unit.heading_rad_s;
        let feasibility = guidance.feasibility(speed, rate);
        prop_assert!(feasibility.holds());
        let twist = Twist::new(speed * direction.cos(), speed * direction.sin(), rate);
        let command = guidance.command(&[Task { name: "feedforward", twist_in_body: twist }]);
        prop_assert!(infinity_norm(&command.wheel_rates_rad_s) <= limit * (1.0 + 1e-12));
    }
}

#[test]
fn eq_29_the_plain_law_does_exceed_it() {
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    let mut guidance = guidance(kinematics, Saturation::None, 8.7);
    let far = Task {
        name: "far",
        twist_in_body: Twist::new(1.5, 0.0, 0.0),
    };
    // 1.5 m/s cos(30 deg) / 0.05 m.
    let rates = &guidance.command(&[far]).wheel_rates_rad_s;
    assert!((infinity_norm(rates) - 1.5 * 0.75_f64.sqrt() / 0.05).abs() < 1e-12);
}

#[test]
fn eq_36_37_are_sufficient_but_not_necessary() {
    // The paper calls them necessary. Forward at 0.6 of the limit breaks (36), yet leaves room for
    // 0.1 of turning.
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    let mut guidance = guidance(kinematics, Saturation::Prioritised(Priority::Position), 8.7);
    let (speed, rate) = (0.6 * 8.7 * 0.05, 0.1 * 8.7 * 0.05 / 0.25);
    assert!(!guidance.feasibility(speed, rate).holds());
    let tasks = [
        Task {
            name: "position feedforward",
            twist_in_body: Twist::new(speed, 0.0, 0.0),
        },
        Task {
            name: "heading feedforward",
            twist_in_body: Twist::new(0.0, 0.0, rate),
        },
    ];
    assert!(
        guidance
            .command(&tasks)
            .tasks
            .iter()
            .all(|t| t.weight == 1.0)
    );
}

#[test]
fn eq_36_the_figures_of_the_volksbots_circle() {
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    let guidance = guidance(kinematics, Saturation::Prioritised(Priority::Position), 8.7);
    let feasibility = guidance.feasibility(0.2, 0.0);
    assert!((feasibility.position_rad_s - 4.0).abs() < 1e-12);
    assert_eq!(feasibility.heading_rad_s, 0.0);
    assert!(feasibility.holds());
    assert!(!guidance.feasibility(0.22, 0.0).holds());
}

#[test]
fn clipping_bends_the_motion_and_scaling_does_not() {
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    let wanted = Twist::new(0.8, 0.0, 2.0);
    let task = [Task {
        name: "any",
        twist_in_body: wanted,
    }];
    let angle = |t: Twist| Vector2::new(t.vx_m_s, t.vy_m_s).angle(&wanted.linear_m_s());
    let mut clip = guidance(kinematics.clone(), Saturation::Clip, 8.7);
    let clipped = clip.command(&task).saturated_twist_in_body;
    // rho times the rates is (-0.5, 0.19282, -1.19282) m/s, clipped to (-0.435, 0.19282, -0.435).
    // By hand from (7): omega = 0.67718 / 0.75, vx = (0.19282 + 0.435) / sqrt 3, vy = 0.435 - 0.25
    // omega.
    let expected = Twist::new(0.362_472, 0.209_273, 0.902_907);
    let off = clipped - expected;
    assert!(
        off.linear_m_s().norm() < 1e-5 && off.omega_rad_s.abs() < 1e-5,
        "{clipped:?}"
    );
    let mut scale = guidance(kinematics, Saturation::Scale, 8.7);
    let scaled = scale.command(&task).clone();
    assert!(angle(scaled.saturated_twist_in_body) < 1e-7);
    assert!((infinity_norm(&scaled.wheel_rates_rad_s) - 8.7).abs() < 1e-12);
}

#[test]
fn a_pose_that_is_not_a_number_commands_no_motion_by_feedback() {
    let kinematics = Kinematics::new(&volksbot()).unwrap();
    for saturation in [
        Saturation::Prioritised(Priority::Position),
        Saturation::Clip,
        Saturation::Scale,
        Saturation::None,
    ] {
        let mut guidance = guidance(kinematics.clone(), saturation, 8.7);
        let lost = ilon_robot::Pose {
            x_m: f64::NAN,
            ..Default::default()
        };
        let desired = ilon_control::Desired {
            pose: Default::default(),
            velocity_in_world: Twist::default(),
        };
        let command = guidance.update(&lost, &desired);
        assert!(
            command.wheel_rates_rad_s.iter().all(|rate| *rate == 0.0),
            "{saturation:?} {command:?}"
        );
    }
}
