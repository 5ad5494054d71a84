//! The point of a sphere or cylinder nearest to a given point, in f64.

use nalgebra::{Isometry3, Point3, Vector3};

/// A solid sphere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidBall {
    /// Its centre, in the floor's frame, in metres.
    pub center_m: Vector3<f64>,
    pub radius_m: f64,
}

/// A solid cylinder along the y axis of its frame, as in parry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidCylinder {
    /// Pose of its centre.
    pub floor_from_cylinder: Isometry3<f64>,
    pub radius_m: f64,
    /// Half of its length, in metres.
    pub half_length_m: f64,
}

/// A point on the surface, the outward unit normal, and the distance of the given point, negative
/// inside.
type Foot = (Vector3<f64>, Vector3<f64>, f64);

impl SolidBall {
    /// Its point nearest to a given point.
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
    /// Its point nearest to a given point.
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

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, UnitQuaternion};

    use super::*;

    /// A cylinder of radius 0.3 m and length 2 m is nearest with its side, its end or its rim; from
    /// inside, with the nearer of side and end: at either end, in any pose.
    #[test]
    fn a_cylinder_is_nearest_with_its_side_its_end_or_its_rim() {
        let poses = [
            Isometry3::identity(),
            Isometry3::from_parts(
                Translation3::new(2.0, -1.0, 3.0),
                UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0),
            ),
        ];
        // A point, the nearest one, the normal there, and the distance: radial and axial.
        let seen = [
            ([0.8, 0.5], [0.3, 0.5], [1.0, 0.0], 0.5),
            ([0.1, 1.2], [0.1, 1.0], [0.0, 1.0], 0.2),
            ([0.6, 1.4], [0.3, 1.0], [0.6, 0.8], 0.5),
            ([0.2, 0.5], [0.3, 0.5], [1.0, 0.0], -0.1),
            ([0.1, 0.9], [0.1, 1.0], [0.0, 1.0], -0.1),
        ];
        for (floor_from_cylinder, way) in poses.iter().flat_map(|pose| [(pose, 1.0), (pose, -1.0)])
        {
            let cylinder = SolidCylinder {
                floor_from_cylinder: *floor_from_cylinder,
                radius_m: 0.3,
                half_length_m: 1.0,
            };
            let turned = |[out, up]: [f64; 2]| {
                floor_from_cylinder.rotation * Vector3::new(0.0, way * up, out)
            };
            let at_m = |place: [f64; 2]| turned(place) + floor_from_cylinder.translation.vector;
            for (point, nearest, normal, distance_m) in seen {
                let (place_m, out, found_m) = cylinder.foot(&at_m(point));
                // Sums of some metres.
                assert!((place_m - at_m(nearest)).norm() < 1e-14, "{point:?}");
                assert!((out - turned(normal)).norm() < 1e-14, "{point:?}");
                assert!((found_m - distance_m).abs() < 1e-14, "{point:?}");
            }
        }
    }
}
