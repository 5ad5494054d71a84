//! Section V's first step: the priorities of (33), (34) under rate limits and torque limits at
//! once.

use ilon_control::{
    Demand, Desired, DynamicModel, PrioritisedTorque, PrioritisedTorqueSettings, Priority,
    Saturation, TorqueLaw, TorqueRange,
};
use ilon_robot::{Pose, Robot, Twist};
use nalgebra::Vector2;
use proptest::prelude::*;

use crate::paper::random::{any_robot, cases};
use crate::paper::saturation::guidance;
use crate::paper::tracking::{any_desired, any_pose};

/// What the two layers make of a moment: the acceleration of the rolling robot, and the weight of
/// the higher task.
struct Outcome {
    rates_rad_s: Vec<f64>,
    torques_n_m: Vec<f64>,
    weight: f64,
    twist_rate: Twist,
}

fn act(robot: &Robot, priority: Priority, moment: &Moment, desired: &Desired) -> Outcome {
    let model = DynamicModel::new(robot).unwrap();
    let n = robot.wheels.len();
    let kinematics = model.kinematics().clone();
    let saturation = Saturation::Prioritised(priority);
    let mut guidance = guidance(kinematics, saturation, moment.limit_rad_s);
    let targets = guidance
        .update(&moment.seen, desired)
        .wheel_rates_rad_s
        .clone();
    let mut rates = vec![0.0; n];
    model.kinematics().wheel_rates(moment.twist, &mut rates);
    let settings = PrioritisedTorqueSettings {
        bandwidth_rad_s: 10.0,
        target_filter_s: 0.0,
        dt_s: 1e-3,
        priority,
        reference_point_m: Vector2::zeros(),
        friction: moment.friction,
        gravity_m_s2: 9.81,
    };
    let mut law = PrioritisedTorque::new(robot, &settings).unwrap();
    let limits = vec![moment.range; n];
    let torques_n_m = law
        .update(&Demand::new(&targets, &rates, &limits, 1e-3))
        .to_vec();
    let shares = law.shares().unwrap();
    Outcome {
        weight: match priority {
            Priority::Position => shares.position,
            Priority::Heading => shares.heading,
        },
        twist_rate: model.twist_rate(&rates, &torques_n_m, &mut vec![0.0; n]),
        rates_rad_s: targets,
        torques_n_m,
    }
}

#[derive(Clone, Debug)]
struct Moment {
    seen: Pose,
    twist: Twist,
    limit_rad_s: f64,
    range: TorqueRange,
    friction: f64,
}

fn any_moment() -> impl Strategy<Value = Moment> {
    let twist = (-0.3..0.3, -0.3..0.3, -0.5..0.5).prop_map(|(x, y, w)| Twist::new(x, y, w));
    let friction = prop_oneof![Just(f64::INFINITY), 0.2..0.9_f64];
    (
        any_pose(),
        twist,
        1.0..30.0_f64,
        (0.05..2.0_f64, 0.05..2.0_f64),
        friction,
    )
        .prop_map(|(seen, twist, limit_rad_s, (down, up), friction)| Moment {
            seen,
            twist,
            limit_rad_s,
            range: TorqueRange {
                min_n_m: -down,
                max_n_m: up,
            },
            friction,
        })
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn section_5_a_lower_task_changes_no_higher_one_under_rate_and_torque_limits_at_once(
        (robot, _) in any_robot(), moment in any_moment(), desired in any_desired(), other in any_desired(),
    ) {
        // The same position task with another heading task, and the other way round.
        let turned = Desired {
            pose: Pose { heading_rad: other.pose.heading_rad, ..desired.pose },
            velocity_in_world: Twist {
                omega_rad_s: other.velocity_in_world.omega_rad_s, ..desired.velocity_in_world
            },
        };
        let moved = Desired {
            pose: Pose { heading_rad: desired.pose.heading_rad, ..other.pose },
            velocity_in_world: Twist {
                omega_rad_s: desired.velocity_in_world.omega_rad_s, ..other.velocity_in_world
            },
        };
        for (priority, with) in [(Priority::Position, turned), (Priority::Heading, moved)] {
            let (one, two) = (act(&robot, priority, &moment, &desired), act(&robot, priority, &moment, &with));
            for outcome in [&one, &two] {
                prop_assert!(outcome.rates_rad_s.iter().all(|rate| rate.abs() <= moment.limit_rad_s));
                let range = moment.range;
                let within = |torque: &f64| (range.min_n_m..=range.max_n_m).contains(torque);
                prop_assert!(outcome.torques_n_m.iter().all(within));
            }
            // Targets go through q' and back: rounding of a poorly conditioned M, below 1e-9 of the
            // weight.
            prop_assert!((one.weight - two.weight).abs() < 1e-6, "{} {}", one.weight, two.weight);
            // Where not even the motion can be kept up, nothing is promised of the acceleration.
            if one.weight > 0.0 {
                let off = one.twist_rate - two.twist_rate;
                let size = match priority {
                    Priority::Position => off.linear_m_s().norm(),
                    Priority::Heading => off.omega_rad_s.abs(),
                };
                let scale = one.twist_rate.linear_m_s().norm() + one.twist_rate.omega_rad_s.abs();
                prop_assert!(size < 1e-6 * (1.0 + scale), "{:?} {:?}", one.twist_rate, two.twist_rate);
            }
        }
    }
}
