//! The sharpest turn of a robot whose unsteered tyres hold it sideways.
//!
//! Such a robot turns about points of its unsteered axle. A steered wheel at b rolls about c if its
//! way is across b - c; how far it has to turn for that grows as c comes nearer. Limits of the
//! steering joints therefore end the turns at a radius.

use std::f64::consts::TAU;

use ilon_robot::{Robot, Twist, bisected, wrap_angle};
use nalgebra::{Vector2, Vector3};

use crate::Kinematics;
use crate::kinematics::matrix::vector_of;

/// A turn of a robot on tyres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Distance of its centre from the middle of the unsteered tyres, in metres; 0 on the spot.
    pub radius_m: f64,
    /// Its twist of the body's origin in the body frame, at 1 rad/s.
    pub twist_in_body: Twist,
}

/// Returns the sharpest turn that the steering joints allow to both sides, of a robot whose joints
/// stand at `positions`. `None` for a robot without one direction of unsteered tyres, or whose
/// joints do not even allow the way straight ahead.
pub fn sharpest_turn(robot: &Robot, positions: &[f64]) -> Option<Turn> {
    let posed = robot.posed(positions);
    let kinematics = Kinematics::new(&posed).ok()?;
    let [row] = kinematics.excluded_rows() else {
        return None;
    };
    // n . v + m omega = 0 in the point that is m ahead along u = n x k.
    let u = Vector2::new(row.y, -row.x);
    let middle_m = row.z * u;
    let about = |radius_m: f64| {
        let v = radius_m * u + Vector2::new(middle_m.y, -middle_m.x);
        Twist::new(v.x, v.y, 1.0)
    };
    let can = |radius_m: f64| {
        let twist = about(radius_m);
        (0..robot.wheels.len()).all(|wheel| {
            let joint = robot.steering_of(&robot.wheels[wheel]);
            joint.is_none_or(|joint| reaches(robot, &kinematics, (wheel, joint), positions, twist))
        })
    };
    let far = |wheel: &ilon_robot::Wheel| (wheel.position_m().xy() - middle_m).norm();
    let size_m = posed.wheels.iter().map(far).fold(0.0, f64::max);
    let sharpest = [1.0, -1.0].map(|side| least(|radius_m| can(side * radius_m), size_m));
    let radius_m = sharpest[0]?.max(sharpest[1]?);
    Some(Turn {
        radius_m,
        twist_in_body: about(radius_m),
    })
}

/// Returns the least radius from which all larger ones are possible, to rounding; 0 if all are.
fn least(can: impl Fn(f64) -> bool, size_m: f64) -> Option<f64> {
    /// The largest radius, over the robot's size: straight ahead.
    const STRAIGHT: f64 = 1e3;
    /// Steps between the radii that are tried first, as a factor.
    const STEP: f64 = 0.95;
    let mut high = STRAIGHT * size_m;
    if !can(high) {
        return None;
    }
    let mut low = STEP * high;
    while can(low) {
        (high, low) = (low, STEP * low);
        if low < 1e-6 * size_m {
            return Some(if can(0.0) { 0.0 } else { high });
        }
    }
    Some(bisected((high, low), 60, can).0)
}

/// Whether a steering joint reaches the direction that a twist gives its wheel, or its opposite.
fn reaches(
    robot: &Robot,
    kinematics: &Kinematics,
    (wheel, joint): (usize, usize),
    positions: &[f64],
    twist: Twist,
) -> bool {
    /// A wheel this slow over the twist keeps its angle.
    const STILL: f64 = 1e-12;
    let (Some(module), Some(v_h)) = (
        kinematics.module(wheel),
        kinematics.hub_velocity_m_s(wheel, twist),
    ) else {
        return true;
    };
    if v_h.norm() < STILL {
        return true;
    }
    let n = kinematics.wheels()[wheel].axis();
    let (of, now_rad) = (&robot.joints[joint], libm::atan2(-n.x, n.y));
    let sense = (of.body_from_joint.rotation * Vector3::z()).z.signum();
    let at = positions.get(joint).copied().unwrap_or(0.0);
    let [lower, upper] = of.limits;
    let ways = module.rolling(&vector_of(twist));
    ways.into_iter().flatten().any(|(way_rad, _)| {
        let to = at + sense * wrap_angle(way_rad - now_rad);
        [-TAU, 0.0, TAU]
            .iter()
            .any(|turn| (lower..=upper).contains(&(to + turn)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::tyres::on_tyres;

    /// A robot without steering turns on the spot about the middle of its tyres.
    #[test]
    fn a_differential_robot_turns_on_the_spot() {
        let turn = sharpest_turn(&on_tyres(&[[-0.2, 0.2], [-0.2, -0.2]]), &[]).expect("it turns");
        assert_eq!(turn.radius_m, 0.0);
        let off = turn.twist_in_body - Twist::new(0.0, 0.2, 1.0);
        assert!(off.linear_m_s().norm() < 1e-12, "{turn:?}");
    }
}
