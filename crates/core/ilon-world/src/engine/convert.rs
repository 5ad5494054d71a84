//! Conversions between the project's nalgebra and rapier's glam.

use nalgebra::{Isometry3, Matrix3, Quaternion, UnitQuaternion, Vector3};
use rapier3d::math::{Matrix, Pose, Rotation, Vector};

pub(crate) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(crate) fn rotation(q: &UnitQuaternion<f64>) -> Rotation {
    Rotation::from_xyzw(q.i, q.j, q.k, q.w).normalize()
}

pub(crate) fn pose(iso: &Isometry3<f64>) -> Pose {
    Pose::from_parts(vector(&iso.translation.vector), rotation(&iso.rotation))
}

pub(crate) fn matrix(m: &Matrix3<f64>) -> Matrix {
    let column = |i: usize| vector(&m.column(i).into_owned());
    Matrix::from_cols(column(0), column(1), column(2))
}

pub(crate) fn to_vector(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

pub(crate) fn to_matrix(m: Matrix) -> Matrix3<f64> {
    Matrix3::from_columns(&[
        to_vector(m.x_axis),
        to_vector(m.y_axis),
        to_vector(m.z_axis),
    ])
}

pub(crate) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let q = pose.rotation;
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z));
    Isometry3::from_parts(to_vector(pose.translation).into(), rotation)
}
