//! Between the project's f64 and nalgebra and rapier's f32 and glam.

use nalgebra::{Isometry3, Matrix3, Quaternion, UnitQuaternion, Vector3};
use rapier3d::math::{Matrix, Pose, Real, Rotation, Vector};

pub(crate) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x as Real, v.y as Real, v.z as Real)
}

pub(crate) fn rotation(q: &UnitQuaternion<f64>) -> Rotation {
    Rotation::from_xyzw(q.i as Real, q.j as Real, q.k as Real, q.w as Real).normalize()
}

pub(crate) fn pose(iso: &Isometry3<f64>) -> Pose {
    Pose::from_parts(vector(&iso.translation.vector), rotation(&iso.rotation))
}

pub(crate) fn matrix(m: &Matrix3<f64>) -> Matrix {
    let column = |i: usize| vector(&m.column(i).into_owned());
    Matrix::from_cols(column(0), column(1), column(2))
}

pub(crate) fn to_f64(v: Vector) -> Vector3<f64> {
    Vector3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}

pub(crate) fn to_matrix(m: Matrix) -> Matrix3<f64> {
    Matrix3::from_columns(&[to_f64(m.x_axis), to_f64(m.y_axis), to_f64(m.z_axis)])
}

pub(crate) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let q = pose.rotation;
    let [w, i, j, k] = [q.w, q.x, q.y, q.z].map(f64::from);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    Isometry3::from_parts(to_f64(pose.translation).into(), rotation)
}
