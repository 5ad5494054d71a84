//! Conversion of rotations to URDF's roll, pitch and yaw.

use nalgebra::Rotation3;

/// Returns roll, pitch and yaw, in radians, of R = Rz(yaw) Ry(pitch) Rx(roll). The textbook's arc
/// sine loses half of the digits near a pitch of 90 degrees, the orientation of the roller that
/// points down; here yaw is computed first and undone, which loses none.
pub fn roll_pitch_yaw(rotation: &Rotation3<f64>) -> [f64; 3] {
    let m = rotation.matrix();
    // At a pitch of 90 degrees yaw and roll are the same rotation: yaw is then zero.
    let upright = libm::hypot(m[(0, 0)], m[(1, 0)]) < 1e-9;
    let yaw = if upright {
        0.0
    } else {
        libm::atan2(m[(1, 0)], m[(0, 0)])
    };
    let (s, c) = libm::sincos(yaw);
    let pitch = libm::atan2(-m[(2, 0)], c * m[(0, 0)] + s * m[(1, 0)]);
    let roll = libm::atan2(s * m[(0, 2)] - c * m[(1, 2)], c * m[(1, 1)] - s * m[(0, 1)]);
    [roll, pitch, yaw]
}
