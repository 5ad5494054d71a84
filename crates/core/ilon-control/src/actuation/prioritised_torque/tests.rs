use super::*;
use crate::DynamicModel;
use crate::TorqueRange;
use crate::tests::robots::{mecanum4, six_wheels, volksbot};
use crate::{ComputedTorque, ComputedTorqueSettings};
use ilon_robot::Twist;

fn law(robot: &Robot, priority: Priority, friction: f64) -> PrioritisedTorque {
    let settings = PrioritisedTorqueSettings {
        bandwidth_rad_s: 10.0,
        target_filter_s: 0.0,
        dt_s: 1e-3,
        priority,
        reference_point_m: Vector2::zeros(),
        friction,
        gravity_m_s2: 9.81,
    };
    PrioritisedTorque::new(robot, &settings).unwrap()
}

fn limits(n: usize, torque_n_m: f64) -> Vec<TorqueRange> {
    let range = TorqueRange {
        min_n_m: -torque_n_m,
        max_n_m: torque_n_m,
    };
    vec![range; n]
}

/// Acceleration of the robot, rolling with `now`, under the law's torques for `target`.
fn acceleration(
    robot: &Robot,
    torques: impl FnOnce(&[f64], &[f64]) -> Vec<f64>,
    now: Twist,
    target: Twist,
) -> Twist {
    let model = DynamicModel::new(robot).unwrap();
    let n = robot.wheels.len();
    let (mut rates, mut targets) = (vec![0.0; n], vec![0.0; n]);
    model.kinematics().wheel_rates(now, &mut rates);
    model.kinematics().wheel_rates(target, &mut targets);
    let torques = torques(&targets, &rates);
    model.twist_rate(&rates, &torques, &mut vec![0.0; n])
}

/// Off-centre robots with damped wheels. Without dry friction, because the law compensates it in
/// the targets' direction, which here differs from the rates'.
fn robots() -> Vec<Robot> {
    let mut robots = vec![mecanum4(), volksbot(), six_wheels()];
    for robot in &mut robots {
        robot.chassis.mass.center_of_mass_m += Vector3::new(0.04, -0.03, 0.05);
        for wheel in &mut robot.wheels {
            wheel.joint.damping_n_m_s = 2e-3;
        }
    }
    robots
}

const NOW: Twist = Twist {
    vx_m_s: 0.2,
    vy_m_s: -0.1,
    omega_rad_s: 0.5,
};

#[test]
fn with_torque_and_grip_to_spare_it_gives_the_acceleration_asked_for() {
    for robot in robots() {
        let n = robot.wheels.len();
        let mut law = law(&robot, Priority::Position, 0.8);
        let k = law.k_p;
        let target = Twist::new(0.23, -0.08, 0.55);
        let got = acceleration(
            &robot,
            |targets, rates| {
                law.update(&Demand::new(targets, rates, &limits(n, 50.0), 1e-3))
                    .to_vec()
            },
            NOW,
            target,
        );
        let wanted = (target - NOW).scaled(k + 0.25 * k * k * 1e-3);
        assert!(
            (got - wanted).linear_m_s().norm() < 1e-8,
            "{got:?} {wanted:?}"
        );
        assert!((got - wanted).omega_rad_s.abs() < 1e-8);
        let shares = law.shares().unwrap();
        assert!(shares.position == 1.0 && shares.heading == 1.0 && shares.grip < 1.0);
    }
}

#[test]
fn a_saturating_motor_slows_the_lower_task_and_not_the_higher_one() {
    for robot in robots() {
        let n = robot.wheels.len();
        let linear = Twist::new(0.23, -0.08, 0.5);
        let both = Twist::new(0.23, -0.08, 6.0);
        let torque_n_m = 0.3;
        let position_first = |target: Twist| {
            let mut law = law(&robot, Priority::Position, f64::INFINITY);
            let run = |t: &[f64], r: &[f64]| {
                law.update(&Demand::new(t, r, &limits(n, torque_n_m), 1e-3))
                    .to_vec()
            };
            let got = acceleration(&robot, run, NOW, target);
            (got, law.shares().unwrap())
        };
        let (alone, _) = position_first(linear);
        let (with_heading, shares) = position_first(both);
        assert!(shares.heading < 1.0, "{shares:?}");
        assert!(
            (alone - with_heading).linear_m_s().norm() < 1e-7,
            "{alone:?} {with_heading:?}"
        );
        assert!(with_heading.omega_rad_s > alone.omega_rad_s + 0.1);

        // Plain clipping of eq. (12) lets the rotation spoil the linear acceleration.
        let clipped = |target: Twist| {
            let model = DynamicModel::new(&robot).unwrap();
            let settings = ComputedTorqueSettings {
                bandwidth_rad_s: 10.0,
                target_filter_s: 0.0,
                dt_s: 1e-3,
            };
            let mut law = ComputedTorque::new(model, &settings).unwrap();
            let run = |t: &[f64], r: &[f64]| {
                law.update(&Demand::new(t, r, &limits(n, torque_n_m), 1e-3))
                    .to_vec()
            };
            acceleration(&robot, run, NOW, target)
        };
        let off = (clipped(linear) - clipped(both)).linear_m_s().norm();
        assert!(off > 0.1 * alone.linear_m_s().norm(), "{off}");
    }
}

#[test]
fn position_first_keeps_the_acceleration_of_the_reference_point() {
    // A point 0.3 m ahead of the origin: a reduced rotation must not affect it, though it affects
    // the origin.
    let c = Vector2::new(0.3, -0.1);
    let at_c = |twist: Twist| {
        let omega = twist.omega_rad_s;
        Vector2::new(twist.vx_m_s - omega * c.y, twist.vy_m_s + omega * c.x)
    };
    for robot in robots() {
        let n = robot.wheels.len();
        let got = |omega_rad_s: f64| {
            let mut law = law(&robot, Priority::Position, f64::INFINITY);
            let settings = PrioritisedTorqueSettings {
                reference_point_m: c,
                ..law.settings
            };
            law = PrioritisedTorque::new(&robot, &settings).unwrap();
            // The same velocity of c, whatever the rotation.
            let linear = Vector2::new(0.3, 0.1);
            let target = Twist::new(
                linear.x + omega_rad_s * c.y,
                linear.y - omega_rad_s * c.x,
                omega_rad_s,
            );
            let run = |t: &[f64], r: &[f64]| {
                law.update(&Demand::new(t, r, &limits(n, 0.3), 1e-3))
                    .to_vec()
            };
            let got = acceleration(&robot, run, Twist::default(), target);
            (got, law.shares().unwrap())
        };
        let ((alone, _), (both, shares)) = (got(0.0), got(6.0));
        assert!(shares.heading < 1.0 && shares.position > 0.0, "{shares:?}");
        assert!(
            (at_c(alone) - at_c(both)).norm() < 1e-7,
            "{alone:?} {both:?}"
        );
        assert!((alone - both).linear_m_s().norm() > 1e-2);
    }
}

#[test]
fn heading_first_keeps_the_turn() {
    for robot in robots() {
        let n = robot.wheels.len();
        let run = |target: Twist| {
            let mut law = law(&robot, Priority::Heading, f64::INFINITY);
            let run = |t: &[f64], r: &[f64]| {
                law.update(&Demand::new(t, r, &limits(n, 0.3), 1e-3))
                    .to_vec()
            };
            let got = acceleration(&robot, run, NOW, target);
            (got.omega_rad_s, law.shares().unwrap())
        };
        let (alone, _) = run(Twist::new(0.2, -0.1, 0.8));
        let (with_position, shares) = run(Twist::new(3.0, 2.0, 0.8));
        assert!(shares.position < 1.0, "{shares:?}");
        assert!((alone - with_position).abs() < 1e-7);
    }
}

#[test]
fn on_a_slippery_floor_no_wheel_is_asked_for_more_than_its_grip() {
    for robot in robots() {
        let n = robot.wheels.len();
        let mut law = law(&robot, Priority::Position, 0.1);
        let model = law.capacity.model.clone();
        let (mut rates, mut targets) = (vec![0.0; n], vec![0.0; n]);
        model.kinematics().wheel_rates(NOW, &mut rates);
        model
            .kinematics()
            .wheel_rates(Twist::new(2.0, 1.0, 3.0), &mut targets);
        law.update(&Demand::new(&targets, &rates, &limits(n, 50.0), 1e-3));
        assert!(law.shares().unwrap().position < 1.0);
        assert!(law.shares().unwrap().grip <= 1.0 + 1e-9);
        for (push, load) in law.pushes_n.iter().zip(&law.capacity.loads_n) {
            assert!(push.abs() <= 0.1 * load + 1e-6);
        }
    }
}

#[test]
fn free_torques_spare_the_wheel_with_little_load() {
    // Robot A with a payload over one corner: eq. (12) spreads the pushes by inertia, regardless of
    // the loads.
    let mut robot = mecanum4();
    robot.chassis.mass.center_of_mass_m += Vector3::new(0.08, 0.08, 0.0);
    let mut law = law(&robot, Priority::Position, 0.3);
    let model = law.capacity.model.clone();
    let mut targets = [0.0; 4];
    model
        .kinematics()
        .wheel_rates(Twist::new(0.06, 0.03, 0.0), &mut targets);
    law.update(&Demand::new(&targets, &[0.0; 4], &limits(4, 50.0), 1e-3));
    assert_eq!(law.shares().unwrap().position, 1.0);
    let spared = law.shares().unwrap().grip;

    let settings = ComputedTorqueSettings {
        bandwidth_rad_s: 10.0,
        target_filter_s: 0.0,
        dt_s: 1e-3,
    };
    let mut plain = ComputedTorque::new(model.clone(), &settings).unwrap();
    let torques = plain
        .update(&Demand::new(&targets, &[0.0; 4], &limits(4, 50.0), 1e-3))
        .to_vec();
    let mut accelerations = [0.0; 4];
    model.accelerations(&[0.0; 4], &torques, &mut [0.0; 4], &mut accelerations);
    let worst = (0..4)
        .map(|h| {
            let own = model.wheel_inertias_kg_m2()[h] * accelerations[h];
            let push = (torques[h] - own) / model.kinematics().lever_m()[h];
            push.abs() / (0.3 * law.capacity.loads_n[h])
        })
        .fold(0.0, f64::max);
    println!("worst use of grip: plain {worst:.3}, spared {spared:.3}");
    assert!(spared < 0.8 * worst, "{spared} {worst}");
}

#[test]
fn a_wheel_in_the_air_does_not_run_away() {
    // Every wheel alone, as if the robot hung in the air: rates stay near their targets.
    let robot = mecanum4();
    let mut law = law(&robot, Priority::Position, 0.5);
    let j = law.capacity.model.wheel_inertias_kg_m2().to_vec();
    let mut rates = [0.0; 4];
    let targets = [5.0, -3.0, 2.0, 4.0];
    for _ in 0..20_000 {
        let torques = law
            .update(&Demand::new(&targets, &rates, &limits(4, 2.0), 1e-3))
            .to_vec();
        for h in 0..4 {
            rates[h] += 1e-3 / j[h] * torques[h];
            assert!(rates[h].abs() < 20.0, "{rates:?}");
        }
    }
    for (rate, target) in rates.iter().zip(targets) {
        assert!((rate - target).abs() < 0.5, "{rates:?}");
    }
}

/// y = k_p e + k_i sum(e dt), k_i = k_p^2 / 4: after n steps of the same error the sum is n of it.
/// Errors while the motors are saturated are not added.
#[test]
fn an_error_that_stays_is_summed_in_both_tasks_and_only_where_it_can_be_given() {
    for robot in robots() {
        let n = robot.wheels.len();
        for priority in [Priority::Position, Priority::Heading] {
            let mut law = law(&robot, priority, 0.8);
            let k = law.k_p;
            let target = Twist::new(0.23, -0.08, 0.55);
            let asked_for = |steps: f64| (target - NOW).scaled(k + 0.25 * k * k * 1e-3 * steps);
            let mut after = |steps: usize, torque_n_m: f64| {
                let repeat = |targets: &[f64], rates: &[f64]| {
                    for _ in 1..steps {
                        law.update(&Demand::new(targets, rates, &limits(n, torque_n_m), 1e-3));
                    }
                    law.update(&Demand::new(targets, rates, &limits(n, torque_n_m), 1e-3))
                        .to_vec()
                };
                acceleration(&robot, repeat, NOW, target)
            };
            let off = |got: Twist, wanted: Twist| {
                let off = got - wanted;
                off.linear_m_s().norm() + off.omega_rad_s.abs()
            };
            // Five steps, then fifty in which almost no torque is available, then one more.
            assert!(off(after(5, 50.0), asked_for(5.0)) < 1e-8);
            after(50, 1e-6);
            let got = after(1, 50.0);
            assert!(off(got, asked_for(6.0)) < 1e-8, "{got:?}");
        }
    }
}
