//! The frame of a contact.

use nalgebra::Vector3;

/// A frame of a normal and two tangents; the first tangent is as parallel to `along` as possible.
pub(crate) fn frame(normal: Vector3<f64>, along: Vector3<f64>) -> [Vector3<f64>; 3] {
    let tangent = |v: Vector3<f64>| (v - normal * normal.dot(&v)).try_normalize(1e-3);
    let first = tangent(along)
        .or_else(|| tangent(Vector3::x()))
        .or_else(|| tangent(Vector3::y()))
        .unwrap_or_else(Vector3::z);
    [normal, first, normal.cross(&first)]
}

/// The components of a vector in a frame.
pub(crate) fn along_frame(frame: &[Vector3<f64>; 3], vector: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from(frame.map(|axis| axis.dot(vector)))
}
