//! Shared parts of wheels with rollers and wheels that get some: the hub's frame, axis and motor.

use nalgebra::{
    Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};

use super::source::Source;
use crate::error::{Fault, RobotError};
use crate::model::{MotorLimits, Remark};

/// Largest angle of hub axes from the ground plane, in radians: beyond it the model of the wheel is
/// invalid.
const MOST_LEAN_RAD: f64 = 0.02;
/// Adds a remark on missing limits of a motor.
pub(super) fn remark_motor(wheel: &str, limits: &MotorLimits, remarks: &mut Vec<Remark>) {
    let missing = match (
        limits.effort_n_m.is_finite(),
        limits.velocity_rad_s.is_finite(),
    ) {
        (true, true) => return,
        (false, true) => "effort",
        (true, false) => "velocity",
        (false, false) => "effort and velocity",
    };
    remarks.push(Remark::new(
        format!("wheel `{wheel}`"),
        format!("its joint sets no limit of {missing}: the motor is taken as unlimited there"),
    ));
}

/// Rejects a hub axis that is not parallel to the ground.
pub(super) fn check_level(
    source: &Source,
    joint: &str,
    axis: &Unit<Vector3<f64>>,
) -> Result<(), RobotError> {
    let lean_rad = libm::asin(axis.z.abs().min(1.0));
    if lean_rad > MOST_LEAN_RAD {
        let lean_deg = lean_rad.to_degrees();
        return Err(source.joint_error(joint, Fault::HubNotLevel { lean_deg }));
    }
    Ok(())
}

/// Returns the hub frame at wheel angle zero: z along the axis, x as straight down as possible.
pub(crate) fn hub_frame(origin: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> Isometry3<f64> {
    hub_frame_towards(&origin.coords, axis, &-Vector3::z())
}

/// Returns a frame with z along a hub axis and x as close as possible to a direction, which must
/// differ from the axis.
pub(super) fn hub_frame_towards(
    origin_m: &Vector3<f64>,
    axis: &Unit<Vector3<f64>>,
    towards: &Vector3<f64>,
) -> Isometry3<f64> {
    let z = axis.into_inner();
    let x = (towards - z * towards.dot(&z)).normalize();
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
    Isometry3::from_parts(
        Translation3::from(*origin_m),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}
