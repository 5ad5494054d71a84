//! The motion of a rigid body, expressed at another of its points, gives the same wheel and roller
//! motion; and the touching roller equals that of an independent search.

#[allow(dead_code)]
use crate::fixtures;

use fixtures::{WheelSpec, mecanum4, robot, six_wheels, volksbot};
use ilon_control::{ContactKinematics, Kinematics, WheelGains, WheelLoop, WheelLoopSettings};
use ilon_control::{Demand, Feasibility, TorqueLaw, TorqueRange};
use ilon_robot::{Robot, Twist};
use nalgebra::{Point3, UnitQuaternion, Vector2, Vector3};

const POINT_M: Vector2<f64> = Vector2::new(0.13, -0.21);

fn robots() -> [Robot; 3] {
    [mecanum4(), volksbot(), six_wheels()]
}

/// Eq. (2): the velocity of the point of the body.
fn at_point(twist: Twist) -> Twist {
    Twist::new(
        twist.vx_m_s - twist.omega_rad_s * POINT_M.y,
        twist.vy_m_s + twist.omega_rad_s * POINT_M.x,
        twist.omega_rad_s,
    )
}

fn angles_rad(count: usize) -> Vec<f64> {
    (0..count).map(|wheel| 0.37 + 0.61 * wheel as f64).collect()
}

/// Ten roundings of numbers around 1, through a division by a small arm.
const ROUNDING: f64 = 1e-12;

#[test]
fn hubs_move_the_same_whichever_point_tells_the_motion() {
    let twist = Twist::new(0.3, -0.2, 1.1);
    for robot in robots() {
        let origin = Kinematics::new(&robot).unwrap();
        let there = origin.about(POINT_M).unwrap();
        for wheel in 0..robot.wheels.len() {
            let (a, b) = (
                origin.hub_velocity_m_s(wheel, twist).unwrap(),
                there.hub_velocity_m_s(wheel, at_point(twist)).unwrap(),
            );
            assert!((a - b).norm() < ROUNDING);
        }
    }
}

#[test]
fn touching_rollers_ask_for_the_same_rates_and_spins_whichever_point_tells_the_motion() {
    let twist = Twist::new(0.3, -0.2, 1.1);
    for robot in robots() {
        let count = robot.wheels.len();
        let mut origin = ContactKinematics::new(&robot).unwrap();
        origin.update(&angles_rad(count));
        let mut there = origin.about(POINT_M).unwrap();
        there.update(&angles_rad(count));
        let of = |contact: &ContactKinematics, twist: Twist| {
            let (mut rates, mut residuals) = (vec![0.0; count], vec![0.0; count]);
            contact.wheel_rates_here(twist, &mut rates);
            contact.residuals_here(twist, &rates, &mut residuals);
            (rates, residuals)
        };
        let (rates, residuals) = of(&origin, twist);
        let (rates_there, _) = of(&there, at_point(twist));
        for wheel in 0..count {
            assert!((rates[wheel] - rates_there[wheel]).abs() < 1e3 * ROUNDING);
            assert!(residuals[wheel].abs() < ROUNDING);
        }
        let back = there.twist_here(&rates);
        let off = back - at_point(twist);
        assert!(off.vx_m_s.abs() + off.vy_m_s.abs() + off.omega_rad_s.abs() < 1e3 * ROUNDING);
    }
}

/// Returns, among all rollers, the one whose lowest sphere, found by sampling along its axis, is
/// deepest below the hub.
fn deepest(robot: &Robot, wheel: usize, angle_rad: f64) -> (usize, f64, f64) {
    let wheel = &robot.wheels[wheel];
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
    let hub_m = wheel.body_from_hub.translation.vector;
    let mut depths: Vec<(usize, f64)> = wheel
        .rollers
        .iter()
        .enumerate()
        .map(|(index, roller)| {
            let barrel = wheel.barrel(roller);
            let steps = 400;
            let depth_m = (0..=steps)
                .map(|step| {
                    let share = 2.0 * f64::from(step) / f64::from(steps) - 1.0;
                    let t_m = share * barrel.half_length_m;
                    let at_m = roller.center_in_hub_m + t_m * roller.axis_in_hub.into_inner();
                    let at = wheel.body_from_hub * (turn * Point3::from(at_m));
                    hub_m.z - at.z + barrel.sphere_radius_m(t_m)
                })
                .fold(f64::NEG_INFINITY, f64::max);
            (index, depth_m)
        })
        .collect();
    depths.sort_by(|a, b| b.1.total_cmp(&a.1));
    (depths[0].0, depths[0].1, depths[0].1 - depths[1].1)
}

/// The same robot with hub frames turned about their axles, a different angle each, and every other
/// roller half as long, so that the one nearest to straight down is not always the one that reaches
/// lowest.
fn uneven_and_turned(mut robot: Robot) -> Robot {
    for (index, wheel) in robot.wheels.iter_mut().enumerate() {
        let hub_from_new =
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.7 + 1.3 * index as f64);
        wheel.body_from_hub.rotation *= hub_from_new;
        for roller in &mut wheel.rollers {
            roller.center_in_hub_m = hub_from_new.inverse() * roller.center_in_hub_m;
            roller.axis_in_hub = hub_from_new.inverse() * roller.axis_in_hub;
        }
        for roller in wheel.rollers.iter_mut().step_by(2) {
            roller.length_m *= 0.5;
        }
    }
    robot
}

#[test]
fn the_touching_roller_is_the_one_that_reaches_lowest() {
    let uneven = robot(
        8.0,
        &[
            WheelSpec::new(0.3, 0.0, 0.0, 0.4, 5),
            WheelSpec::new(-0.2, 0.3, 2.0, -0.9, 7),
            WheelSpec::new(-0.2, -0.3, 4.0, 0.0, 12),
        ],
    );
    let turned = robots().map(uneven_and_turned);
    for robot in robots().into_iter().chain([uneven]).chain(turned) {
        let count = robot.wheels.len();
        let mut contact = ContactKinematics::new(&robot).unwrap();
        let mut looked_at = 0;
        for step in -40..120 {
            let angle_rad = 0.083 * f64::from(step);
            contact.update(&vec![angle_rad; count]);
            for (wheel, found) in contact.contacts().iter().enumerate() {
                let (index, depth_m, lead_m) = deepest(&robot, wheel, angle_rad);
                let hub_m = robot.wheels[wheel].body_from_hub.translation.vector;
                // The sampling along the axis misses the lowest sphere by at most half a step: 1e-6
                // m of depth.
                let told_m = hub_m.z - found.point_in_body_m.z;
                assert!((told_m - depth_m).abs() < 2e-6, "{told_m} m, {depth_m} m");
                let hub = &robot.wheels[wheel];
                let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
                let axis =
                    hub.body_from_hub.rotation * (turn * hub.rollers[found.roller].axis_in_hub);
                assert!((axis.into_inner() - found.axis_in_body.into_inner()).norm() < ROUNDING);
                if lead_m > 2e-6 {
                    assert_eq!(found.roller, index, "wheel {wheel} at {angle_rad} rad");
                    looked_at += 1;
                }
            }
        }
        assert!(looked_at > 100 * count, "hand-overs are the exception");
    }
}

#[test]
fn of_rollers_that_reach_equally_low_the_nearest_to_straight_down_touches() {
    for mut robot in robots() {
        // Barrels that overlap their neighbours by a fifth: there both lie on the wheel's circle.
        for roller in robot.wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers) {
            roller.length_m *= 1.2;
        }
        let mut contact = ContactKinematics::new(&robot).unwrap();
        for step in 0..200 {
            contact.update(&vec![0.0314 * f64::from(step); robot.wheels.len()]);
            for (wheel, found) in robot.wheels.iter().zip(contact.contacts()) {
                // Half a pitch, and what makes depths count as equal: a billionth of the radius, at
                // a slope below 1.
                let half_rad = std::f64::consts::PI / wheel.rollers.len() as f64;
                assert!(
                    found.angle_rad.abs() < half_rad + 1e-8,
                    "{}",
                    found.angle_rad
                );
            }
        }
    }
}

#[test]
fn a_reference_that_takes_exactly_half_of_the_limit_is_not_feasible() {
    let feasibility = |position_rad_s, heading_rad_s| Feasibility {
        position_rad_s,
        heading_rad_s,
        limit_rad_s: 8.0,
    };
    assert!(feasibility(3.999, 3.999).holds());
    assert!(!feasibility(4.0, 1.0).holds());
    assert!(!feasibility(1.0, 4.0).holds());
}

/// For a rate that rises uniformly the filtered acceleration is a_k = a_(k-1) + s (a - a_(k-1)), so
/// after k steps it is a (1 - (1 - s)^k) with s = dt / (T + dt).
#[test]
fn the_derivative_filter_settles_on_the_acceleration_as_a_first_order_lag() {
    let gains = WheelGains {
        proportional_n_m_s: 0.0,
        integral_n_m: 0.0,
        derivative_n_m_s2: 1.0,
    };
    let settings = WheelLoopSettings {
        derivative_filter_s: 0.03,
        ..WheelLoopSettings::new(gains)
    };
    let mut wheel_loop = WheelLoop::new(1, settings).unwrap();
    let (dt_s, acceleration_rad_s2) = (0.01, 5.0);
    for step in 0..40 {
        let rate_rad_s = acceleration_rad_s2 * dt_s * f64::from(step);
        let limits = [TorqueRange::UNLIMITED];
        let torque_n_m = wheel_loop.update(&Demand::new(&[0.0], &[rate_rad_s], &limits, dt_s))[0];
        // The first step has no earlier rate. s = 0.01 / 0.04.
        let expected_n_m = -acceleration_rad_s2 * (1.0 - 0.75_f64.powi(step));
        assert!(
            (torque_n_m - expected_n_m).abs() < 1e-12,
            "{torque_n_m}, {expected_n_m}"
        );
    }
}
