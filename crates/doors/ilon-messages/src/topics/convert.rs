//! Converts quantities of a trace to those of messages.

use ilon_robot::{Pose, Twist};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::builtin_interfaces::Time;
use crate::geometry_msgs::{self as geometry, Point, Quaternion, Transform, Vector3};

/// Returns the time of a row, in ns: never zero, which tf2 interprets as "the latest", and never
/// too late for a stamp.
pub(super) fn time_ns(t_s: f64) -> u64 {
    const LATEST_NS: f64 = i32::MAX as f64 * 1e9;
    ((t_s * 1e9).round().min(LATEST_NS) as u64).max(1)
}

/// Returns a stamp of such a time.
pub(super) fn stamp(time_ns: u64) -> Time {
    Time::from_nanoseconds(time_ns).unwrap_or_default()
}

/// Returns a planar pose with the height and the lean of the body frame.
pub(super) fn isometry(pose: Pose, height_m: f64, roll_rad: f64, pitch_rad: f64) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(pose.x_m, pose.y_m, height_m),
        UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, pose.heading_rad),
    )
}

pub(super) fn quaternion(rotation: &UnitQuaternion<f64>) -> Quaternion {
    let [x, y, z, w]: [f64; 4] = rotation.coords.into();
    Quaternion { x, y, z, w }
}

pub(super) fn transform(pose: &Isometry3<f64>) -> Transform {
    let [x, y, z]: [f64; 3] = pose.translation.vector.into();
    Transform {
        translation: Vector3 { x, y, z },
        rotation: quaternion(&pose.rotation),
    }
}

pub(super) fn pose(pose: &Isometry3<f64>) -> geometry::Pose {
    let [x, y, z]: [f64; 3] = pose.translation.vector.into();
    geometry::Pose {
        position: Point { x, y, z },
        orientation: quaternion(&pose.rotation),
    }
}

pub(super) fn twist(twist: Twist) -> geometry::Twist {
    let mut message = geometry::Twist::default();
    message.linear.x = twist.vx_m_s;
    message.linear.y = twist.vy_m_s;
    message.angular.z = twist.omega_rad_s;
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_stamp_is_zero_or_beyond_what_ros_can_say() {
        assert_eq!(time_ns(0.0), 1);
        assert_eq!(time_ns(-1.0), 1);
        assert_eq!(time_ns(0.01), 10_000_000);
        assert_eq!(stamp(time_ns(1e12)).sec, i32::MAX);
    }
}
