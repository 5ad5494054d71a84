//! Any tasks in any order, eqs. (32)-(34).

use ilon_control::{
    ControlError, Desired, Gain, Guidance, GuidanceSettings, GuidanceTask, Kinematics, Priority,
    Saturation,
};
use ilon_robot::{Pose, Twist};
use nalgebra::Vector2;

use crate::paper::fixtures::mecanum4;

fn law(limit_rad_s: f64, saturation: Saturation) -> Guidance {
    let settings = GuidanceSettings {
        position_gain: Gain::Scalar(1.5),
        heading_gain: 2.0,
        wheel_rate_limit_rad_s: limit_rad_s,
        saturation,
    };
    Guidance::new(Kinematics::new(&mecanum4()).unwrap(), &settings).unwrap()
}

fn pose(x_m: f64, y_m: f64, heading_rad: f64) -> Pose {
    Pose {
        x_m,
        y_m,
        heading_rad,
    }
}

fn desired() -> Desired {
    Desired {
        pose: pose(0.4, -0.2, 0.5),
        velocity_in_world: Twist::new(0.3, 0.2, -0.4),
    }
}

const POSITION_FIRST: [GuidanceTask; 4] = [
    GuidanceTask::PositionFeedforward,
    GuidanceTask::PositionFeedback,
    GuidanceTask::HeadingFeedforward,
    GuidanceTask::HeadingFeedback,
];

/// The paper's two orders are two of all orders, to the bit.
#[test]
fn the_papers_orders_are_two_of_them() {
    let seen = pose(-0.1, 0.3, -0.2);
    let [a, b, c, d] = POSITION_FIRST;
    for (priority, order) in [
        (Priority::Position, [a, b, c, d]),
        (Priority::Heading, [c, d, a, b]),
    ] {
        let mut by_priority = law(12.0, Saturation::Prioritised(priority));
        let mut by_order = law(12.0, Saturation::Prioritised(Priority::Position))
            .with_tasks(&order)
            .unwrap();
        assert_eq!(
            by_priority.update(&seen, &desired()),
            by_order.update(&seen, &desired())
        );
    }
}

/// In every order of the four, what stands before is served before, the capacities fall by what is
/// taken, and no wheel is beyond its limit.
#[test]
fn each_order_serves_what_stands_first() {
    let seen = pose(-0.1, 0.3, -0.2);
    let limit_rad_s = 12.0;
    for first in 0..4 {
        for second in (0..4).filter(|second| *second != first) {
            let rest = (0..4).filter(|other| *other != first && *other != second);
            let order: Vec<_> = [first, second]
                .into_iter()
                .chain(rest)
                .map(|i| POSITION_FIRST[i])
                .collect();
            let mut law = law(limit_rad_s, Saturation::Prioritised(Priority::Position))
                .with_tasks(&order)
                .unwrap();
            let command = law.update(&seen, &desired());
            let mut left = limit_rad_s;
            for (share, task) in command.tasks.iter().zip(&order) {
                assert_eq!(share.name, task.name());
                assert!((share.capacity_rad_s - left).abs() < 1e-12);
                left = (left - share.asked_rad_s * share.weight).max(0.0);
            }
            assert!(
                command
                    .wheel_rates_rad_s
                    .iter()
                    .all(|rate| rate.abs() <= limit_rad_s)
            );
            // The first has all that the limit leaves it.
            let asked_rad_s = command.tasks[0].asked_rad_s;
            let weight = (limit_rad_s / asked_rad_s).min(1.0);
            assert!((command.tasks[0].weight - weight).abs() < 1e-12);
        }
    }
}

/// A robot that follows a path and looks at a point ends up looking at it; what the heading's own
/// tasks ask for is not served.
#[test]
fn a_robot_that_faces_a_point_turns_to_it() {
    let point_m = Vector2::new(2.0, 1.0);
    let tasks = [
        GuidanceTask::PositionFeedback,
        GuidanceTask::Face {
            x_m: point_m.x,
            y_m: point_m.y,
            gain_per_s: 3.0,
        },
    ];
    let mut law = law(f64::INFINITY, Saturation::Prioritised(Priority::Position))
        .with_tasks(&tasks)
        .unwrap();
    let goal = Desired {
        pose: pose(0.5, -0.5, 3.0),
        velocity_in_world: Twist::default(),
    };
    let mut seen = pose(0.0, 0.0, -2.5);
    let dt_s = 0.01;
    for _ in 0..1000 {
        let twist = law
            .update(&seen, &goal)
            .saturated_twist_in_body
            .rotated(seen.heading_rad);
        seen.x_m += dt_s * twist.vx_m_s;
        seen.y_m += dt_s * twist.vy_m_s;
        seen.heading_rad += dt_s * twist.omega_rad_s;
    }
    let to = point_m - seen.position_m();
    let off_rad = ilon_robot::wrap_angle(to.y.atan2(to.x) - seen.heading_rad);
    // Ten seconds are 15 and 30 times what the gains take.
    assert!(off_rad.abs() < 1e-5, "{off_rad}");
    assert!((seen.position_m() - goal.pose.position_m()).norm() < 1e-5);
}

#[test]
fn tasks_that_make_no_sense_are_refused() {
    let with = |tasks: &[GuidanceTask]| law(1.0, Saturation::Clip).with_tasks(tasks).err();
    assert_eq!(with(&[]), Some(ControlError::NoTasks));
    let twice = [GuidanceTask::HeadingFeedback, GuidanceTask::HeadingFeedback];
    let fault = with(&twice).expect("refused").to_string();
    assert!(fault.contains("`heading feedback` twice"), "{fault}");
    let nowhere = GuidanceTask::Face {
        x_m: f64::NAN,
        y_m: 0.0,
        gain_per_s: 1.0,
    };
    assert!(with(&[nowhere]).is_some());
    let away = GuidanceTask::Face {
        x_m: 0.0,
        y_m: 0.0,
        gain_per_s: -1.0,
    };
    assert!(with(&[away]).is_some());
    let endless = GuidanceTask::Twist {
        vx_m_s: f64::INFINITY,
        vy_m_s: 0.0,
        omega_rad_s: 0.0,
    };
    assert!(with(&[endless]).is_some());
}
