//! The nearest place of a sphere and of a cylinder to a point, in f64.

use nalgebra::{Isometry3, Point3, Vector3};

/// A solid sphere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidBall {
    /// Its middle, in the floor's frame, in metres.
    pub center_m: Vector3<f64>,
    pub radius_m: f64,
}

/// A solid cylinder along the y axis of its frame, as parry has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidCylinder {
    /// Pose of its middle.
    pub floor_from_cylinder: Isometry3<f64>,
    pub radius_m: f64,
    /// Half of its length, in metres.
    pub half_length_m: f64,
}

/// On the surface, the unit normal out of it, and the distance of the point, negative inside.
type Foot = (Vector3<f64>, Vector3<f64>, f64);

impl SolidBall {
    /// Its nearest place to a point.
    pub fn foot(&self, point_m: &Vector3<f64>) -> Foot {
        let off_m = point_m - self.center_m;
        let far_m = off_m.norm();
        let normal = if far_m > 0.0 {
            off_m / far_m
        } else {
            Vector3::z()
        };
        let place_m = self.center_m + self.radius_m * normal;
        (place_m, normal, far_m - self.radius_m)
    }
}

impl SolidCylinder {
    /// Its nearest place to a point.
    pub fn foot(&self, point_m: &Vector3<f64>) -> Foot {
        let pose = &self.floor_from_cylinder;
        let local = pose.inverse_transform_point(&Point3::from(*point_m)).coords;
        let (radius_m, half_m) = (self.radius_m, self.half_length_m);
        let across_m = libm::hypot(local.x, local.z);
        let out = if across_m > 0.0 {
            Vector3::new(local.x, 0.0, local.z) / across_m
        } else {
            Vector3::x()
        };
        let (beyond_m, above_m) = (across_m - radius_m, local.y.abs() - half_m);
        let end = Vector3::y() * 1.0_f64.copysign(local.y);
        let (normal, distance_m) = if beyond_m > 0.0 && above_m > 0.0 {
            let distance_m = libm::hypot(beyond_m, above_m);
            ((beyond_m * out + above_m * end) / distance_m, distance_m)
        } else if beyond_m > above_m {
            (out, beyond_m)
        } else {
            (end, above_m)
        };
        let place = local - distance_m * normal;
        (
            (pose * Point3::from(place)).coords,
            pose.rotation * normal,
            distance_m,
        )
    }
}
