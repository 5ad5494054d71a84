//! Drives of robots on tyres: where their steering stands, and which wheels a motor drives.

use ilon_control::{Arrangement, Kinematics};
use ilon_robot::{Robot, Twist, Wheel, wrap_angle};
use nalgebra::Vector3;
use serde_json::{Map, Value, json};
use std::f64::consts::PI;

use crate::Error;

/// The positions of all joints as each steered wheel has turned to a twist of the body's origin;
/// `None` where limits do not allow that.
pub(super) fn positions(robot: &Robot, twist_in_body: Twist) -> Option<Vec<f64>> {
    /// Of a joint's range: a turn to its very limit is within.
    const ROUNDING_RAD: f64 = 1e-9;
    /// A hub beside its steering axis moves as its module turns; each pass is nearer by the share
    /// of that offset in the way to the centre of the turn.
    const PASSES: usize = 30;
    let mut positions = vec![0.0; robot.joints.len()];
    for _ in 0..PASSES {
        let posed = robot.posed(&positions);
        let kinematics = Kinematics::new(&posed).ok()?;
        let twist = kinematics.reachable(twist_in_body);
        for (index, wheel) in posed.wheels.iter().enumerate() {
            let Some(at) = steering(robot, wheel) else {
                continue;
            };
            let v_h = kinematics.hub_velocity_m_s(index, twist)?;
            if v_h.norm() < 1e-9 {
                continue;
            }
            let (joint, n) = (&robot.joints[at], wheel.axis());
            let sense = (joint.body_from_joint.rotation * Vector3::z()).z.signum();
            let axis_rad = libm::atan2(-n.x, n.y);
            let missing_rad = sense * wrap_angle(libm::atan2(v_h.y, v_h.x) - axis_rad);
            let [lower, upper] = joint.limits;
            let now_rad = positions[at];
            let ways = [0.0, -PI, PI]
                .into_iter()
                .map(|half| now_rad + missing_rad + half);
            let within = (lower - ROUNDING_RAD)..=(upper + ROUNDING_RAD);
            let ways = ways.filter(|rad| within.contains(rad));
            let turned = |rad: f64| (rad - now_rad).abs();
            positions[at] = ways.min_by(|a, b| turned(*a).total_cmp(&turned(*b)))?;
        }
    }
    Some(positions)
}

/// The joint that turns a tyre to each twist.
pub(super) fn steering(robot: &Robot, wheel: &Wheel) -> Option<usize> {
    robot.steering_of(wheel).filter(|_| wheel.has_tyre())
}

/// The wheels that a motor drives, by their indices.
pub(super) fn driven(robot: &Robot) -> Vec<usize> {
    let is_driven = |wheel: &usize| robot.wheels[*wheel].motor.effort_n_m != 0.0;
    (0..robot.wheels.len()).filter(is_driven).collect()
}

/// Rows whose product with a twist gives the rates of the driven wheels, and below them those that
/// tyres hold at zero.
pub(super) fn rows(robot: &Robot, kinematics: &Kinematics) -> Result<Vec<[f64; 3]>, Error> {
    let matrix = kinematics.rate_matrix();
    let of_wheel = |wheel: usize| [0, 1, 2].map(|axis| matrix[(wheel, axis)]);
    let mut rows: Vec<[f64; 3]> = driven(robot).into_iter().map(of_wheel).collect();
    let held = Arrangement::of(robot)?.held;
    rows.extend(held.iter().map(|held| [held.row.x, held.row.y, held.row.z]));
    Ok(rows)
}

/// The positions of the joints that steer, by name.
pub(super) fn named(robot: &Robot, positions: &[f64]) -> Value {
    let steering = robot.wheels.iter().filter_map(|of| steering(robot, of));
    let named = steering.map(|at| (robot.joints[at].name.clone(), json!(positions[at])));
    Value::Object(named.collect::<Map<_, _>>())
}
