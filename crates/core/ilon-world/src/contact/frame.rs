//! The frame of a contact.

use nalgebra::Vector3;

/// A normal and two tangents, of which the first lies along a direction as far as it can.
pub(crate) fn frame(normal: Vector3<f64>, along: Vector3<f64>) -> [Vector3<f64>; 3] {
    let tangent = |v: Vector3<f64>| (v - normal * normal.dot(&v)).try_normalize(1e-3);
    let first = tangent(along)
        .or_else(|| tangent(Vector3::x()))
        .or_else(|| tangent(Vector3::y()))
        .unwrap_or_else(Vector3::z);
    [normal, first, normal.cross(&first)]
}

/// A vector along the axes of a frame.
pub(crate) fn along_frame(frame: &[Vector3<f64>; 3], vector: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from(frame.map(|axis| axis.dot(vector)))
}
