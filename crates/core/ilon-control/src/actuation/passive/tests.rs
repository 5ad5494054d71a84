use super::*;
use crate::Priority;
use crate::tests::robots::{mecanum4, six_wheels, volksbot};
use ilon_robot::Twist;

const DT_S: f64 = 1e-3;

fn settings(robot: &Robot) -> PassiveTorqueSettings {
    PassiveTorqueSettings::for_robot(robot, 9.81, DT_S, 0.01, 0.0).unwrap()
}

fn limits(n: usize, torque_n_m: f64) -> Vec<TorqueRange> {
    let range = TorqueRange {
        min_n_m: -torque_n_m,
        max_n_m: torque_n_m,
    };
    vec![range; n]
}

/// The wrench that torques put on the rolling body: M^T L^-1 tau.
fn wrench(kinematics: &Kinematics, torques: &[f64]) -> Vector3<f64> {
    let rows = kinematics.m().row_iter().zip(kinematics.lever_m());
    rows.zip(torques)
        .map(|((row, lever), torque)| row.transpose() * (torque / lever))
        .sum()
}

#[test]
fn the_body_feels_damping_times_the_rate_error_and_gravity_held_off() {
    for robot in [mecanum4(), volksbot(), six_wheels()] {
        let own = settings(&robot);
        let mut law = PassiveTorque::new(&robot, &own).unwrap();
        let kinematics = Kinematics::new(&robot).unwrap();
        let n = robot.wheels.len();
        let (mut targets, mut rates) = (vec![0.0; n], vec![0.0; n]);
        kinematics.wheel_rates(Twist::new(0.02, -0.01, 0.05), &mut targets);
        kinematics.wheel_rates(Twist::new(-0.01, 0.03, 0.02), &mut rates);
        let g = Vector3::new(0.3, -0.2, -9.8);
        law.sense(&BodySense {
            angles_rad: &vec![0.4; n],
            gravity_in_body_m_s2: Some(g),
        });
        let torques = law
            .update(&Demand::new(&targets, &rates, &limits(n, 50.0), DT_S))
            .to_vec();
        let c = robot.center_of_mass_m();
        let d = own.damping_n_s_m;
        let expected = Vector3::new(
            d * 0.03 - robot.mass_kg() * g.x,
            d * -0.04 - robot.mass_kg() * g.y,
            own.heading_damping_n_m_s_rad * 0.03 - robot.mass_kg() * (c.x * g.y - c.y * g.x),
        );
        let got = wrench(&kinematics, &torques);
        assert!((got - expected).norm() < 1e-10, "{got} {expected}");
    }
}

#[test]
fn a_wheel_that_slides_against_the_others_is_held_and_the_body_feels_nothing_of_it() {
    for robot in [mecanum4(), six_wheels()] {
        let own = settings(&robot);
        let mut law = PassiveTorque::new(&robot, &own).unwrap();
        let kinematics = Kinematics::new(&robot).unwrap();
        let n = robot.wheels.len();
        let mut angles = vec![0.0; n];
        let zeros = vec![0.0; n];
        for turned in [0.0, 0.02] {
            angles[0] = turned;
            law.sense(&BodySense {
                angles_rad: &angles,
                gravity_in_body_m_s2: None,
            });
            law.update(&Demand::new(&zeros, &zeros, &limits(n, 50.0), DT_S));
        }
        let torques = law.torques_n_m.clone();
        assert!(torques[0] < -1e-3, "{torques:?}");
        assert!(wrench(&kinematics, &torques).norm() < 1e-12);
    }
    // Three wheels can roll at any rates: no spring acts between them.
    let robot = volksbot();
    let mut law = PassiveTorque::new(&robot, &settings(&robot)).unwrap();
    for turned in [0.0, 0.02] {
        law.sense(&BodySense {
            angles_rad: &[turned, 0.0, 0.0],
            gravity_in_body_m_s2: None,
        });
        law.update(&Demand::new(&[0.0; 3], &[0.0; 3], &limits(3, 50.0), DT_S));
    }
    assert!(law.torques_n_m.iter().all(|torque| torque.abs() < 1e-12));
}

/// Whatever the wheels do, with targets at rest the law releases no more energy than its springs
/// stored.
#[test]
fn what_the_wheels_get_comes_out_of_the_springs_between_them() {
    let robot = six_wheels();
    let own = PassiveTorqueSettings {
        wheel_limit_n_m: 0.2,
        ..settings(&robot)
    };
    let mut law = PassiveTorque::new(&robot, &own).unwrap();
    let (mut angles, mut given_j, mut worst) = ([0.0; 6], 0.0, f64::NEG_INFINITY);
    let mut seed = 5_u64;
    let mut noise = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut rates = [0.0; 6];
    for k in 0..20_000 {
        if k % 50 == 0 {
            rates = std::array::from_fn(|_| 3.0 * noise());
        }
        let fine_s = 1e-4;
        for (angle, rate) in angles.iter_mut().zip(&rates) {
            *angle += rate * fine_s;
        }
        law.sense(&BodySense {
            angles_rad: &angles,
            gravity_in_body_m_s2: None,
        });
        let torques = law.update(&Demand::new(&[0.0; 6], &rates, &limits(6, 50.0), fine_s));
        let power: f64 = torques.iter().zip(&rates).map(|(t, r)| t * r).sum();
        given_j += power * fine_s;
        worst = f64::max(worst, given_j + law.stored_j);
    }
    // Energy goes into dampers and slides at every moment; a spring's energy over a step counts at
    // the step's end.
    assert!(worst < 1e-6 && given_j < -1.0, "{worst} {given_j}");
}

#[test]
fn a_weak_motor_takes_from_the_lower_task_alone() {
    let robot = mecanum4();
    for priority in [Priority::Position, Priority::Heading] {
        let own = PassiveTorqueSettings {
            priority,
            ..settings(&robot)
        };
        let mut law = PassiveTorque::new(&robot, &own).unwrap();
        let kinematics = Kinematics::new(&robot).unwrap();
        let (mut targets, rates) = ([0.0; 4], [0.0; 4]);
        kinematics.wheel_rates(Twist::new(0.2, 0.0, 2.0), &mut targets);
        law.update(&Demand::new(&targets, &rates, &limits(4, 0.35), DT_S));
        let shares = law.shares().unwrap();
        let (upper, lower) = match priority {
            Priority::Position => (shares.position, shares.heading),
            Priority::Heading => (shares.heading, shares.position),
        };
        assert_eq!(upper, 1.0);
        assert!(lower < 0.99, "{shares:?}");
        let got = wrench(&kinematics, &law.torques_n_m);
        // Forty bisections with loads a thousand times the wheels'.
        assert!((got - law.wrench).norm() < 1e-6, "{got}");
        assert!(law.torques_n_m.iter().all(|torque| torque.abs() <= 0.35));
    }
}

#[test]
fn gains_that_swing_up_are_refused_with_the_limit_that_holds() {
    let robot = mecanum4();
    let good = settings(&robot);
    let refused = |bad: PassiveTorqueSettings| {
        let error = PassiveTorque::new(&robot, &bad).unwrap_err();
        let ControlError::Unstable { value, most, .. } = error else {
            panic!("{error}");
        };
        assert!(most < value, "{error}");
        (error.to_string(), most)
    };
    let (said, most) = refused(PassiveTorqueSettings {
        stiffness_n_m: 40_000.0,
        pose_delay_s: 0.05,
        ..good
    });
    assert!(said.contains("0.05 s old and held over 0.01 s"), "{said}");
    let just_good = PassiveTorqueSettings {
        stiffness_n_m: 0.999 * most,
        pose_delay_s: 0.05,
        ..good
    };
    assert!(PassiveTorque::new(&robot, &just_good).is_ok());
    refused(PassiveTorqueSettings {
        heading_stiffness_n_m_rad: 4e3,
        ..good
    });
    refused(PassiveTorqueSettings {
        damping_n_s_m: 100.0 * good.damping_n_s_m,
        ..good
    });
    refused(PassiveTorqueSettings {
        wheel_stiffness_n_m_rad: 2.1 * good.wheel_damping_n_m_s_rad / DT_S,
        ..good
    });
    // A filter that takes the robot's own motion for tilt: m / D - D / K is 12 ms to first order.
    refused(PassiveTorqueSettings {
        damping_n_s_m: 0.2 * good.damping_n_s_m,
        tilt: Some(TiltLoop {
            time_constant_s: 0.02,
            delay_s: 0.0,
        }),
        ..good
    });
}

/// Slow control, late poses, light and heavy robots: settings derived from mass and timing are
/// stable.
#[test]
fn what_follows_from_mass_and_timing_is_accepted() {
    for robot in [mecanum4(), volksbot(), six_wheels()] {
        for (dt_s, period_s, delay_s) in [(1e-4, 1e-3, 0.0), (5e-3, 0.02, 0.1), (0.02, 0.02, 0.5)] {
            let own =
                PassiveTorqueSettings::for_robot(&robot, 9.81, dt_s, period_s, delay_s).unwrap();
            // A filter slower than the robot's stop.
            let stops_s = 1.2 * robot.mass_kg() / own.damping_n_s_m;
            let tilts = [None, Some((2.0 * stops_s, 0.0)), Some((20.0, 0.05))];
            for tilt in tilts {
                let tilt = tilt.map(|(time_constant_s, delay_s)| TiltLoop {
                    time_constant_s,
                    delay_s,
                });
                let made = PassiveTorque::new(&robot, &PassiveTorqueSettings { tilt, ..own });
                assert!(made.is_ok(), "{tilt:?} {made:?}");
            }
        }
    }
}
