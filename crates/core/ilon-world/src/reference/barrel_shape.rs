//! The exact roller as a parry shape, for contacts that rapier solves.
//!
//! The barrel is the envelope of spheres centred on the roller's axis (see
//! [`ilon_robot::barrel_profile`]). Its frame has the origin at the roller's centre and z along the
//! roller's axis.

use ilon_robot::{Barrel, bisected};
use parry3d::bounding_volume::{Aabb, BoundingSphere};
use parry3d::mass_properties::MassProperties;
use parry3d::math::{Pose, Real, Vector};
use parry3d::query::details::local_ray_intersection_with_support_map_with_params;
use parry3d::query::gjk::VoronoiSimplex;
use parry3d::query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection};
use parry3d::shape::{FeatureId, Shape, ShapeType, SupportMap, TypedShape};

/// The barrel of one roller, in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BarrelShape(pub Barrel);

impl BarrelShape {
    /// The largest radius, at the roller's middle, in metres.
    fn middle_radius_m(&self) -> Real {
        self.0.sphere_radius_m(0.0)
    }

    /// Distance from the middle to the tips, in metres.
    fn tip_m(&self) -> Real {
        self.0.half_length_m + self.0.sphere_radius_m(self.0.half_length_m)
    }
}

impl SupportMap for BarrelShape {
    fn local_support_point(&self, direction: Vector) -> Vector {
        self.local_support_point_toward(direction.normalize_or(Vector::Z))
    }

    fn local_support_point_toward(&self, direction: Vector) -> Vector {
        let t_m = self.0.support_place_m(direction.z);
        Vector::Z * t_m + direction * self.0.sphere_radius_m(t_m)
    }
}

impl PointQuery for BarrelShape {
    /// The nearest sphere to a point minimises |p - t z| - s(t), which is convex in t: where the
    /// derivative (t - p_z)/|p - t z| + k^2 t / sqrt(a^2 + k^2 t^2) changes its sign. Bisection
    /// finds it to rounding.
    fn project_local_point(&self, point: Vector, solid: bool) -> PointProjection {
        let r = point.truncate().length();
        let Barrel {
            ring_radius_m,
            sin_delta,
            half_length_m,
            ..
        } = self.0;
        let slope = |t: Real| {
            let kt = sin_delta * t;
            (t - point.z) / libm::hypot(r, t - point.z).max(Real::MIN_POSITIVE)
                + sin_delta * kt / libm::hypot(ring_radius_m, kt)
        };
        let ends = (half_length_m, -half_length_m);
        let (high, low) = bisected(ends, 32, |t| slope(t) > 0.0);
        let t_m = 0.5 * (low + high);
        let center = Vector::Z * t_m;
        let radius = self.0.sphere_radius_m(t_m);
        let offset = point - center;
        let is_inside = offset.length() <= radius;
        if is_inside && solid {
            return PointProjection::new(true, point);
        }
        PointProjection::new(is_inside, center + offset.normalize_or(Vector::X) * radius)
    }

    fn project_local_point_and_get_feature(&self, point: Vector) -> (PointProjection, FeatureId) {
        (self.project_local_point(point, false), FeatureId::Face(0))
    }
}

impl RayCast for BarrelShape {
    fn cast_local_ray_and_get_normal(
        &self,
        ray: &Ray,
        max_time_of_impact: Real,
        solid: bool,
    ) -> Option<RayIntersection> {
        local_ray_intersection_with_support_map_with_params(
            self,
            &mut VoronoiSimplex::new(),
            ray,
            max_time_of_impact,
            solid,
        )
    }
}

impl Shape for BarrelShape {
    fn compute_local_aabb(&self) -> Aabb {
        let r = self.middle_radius_m();
        let half_extents = Vector::new(r, r, self.tip_m());
        Aabb::new(-half_extents, half_extents)
    }

    fn compute_aabb(&self, position: &Pose) -> Aabb {
        // Tight, from the support map: the box around a rotating roller should not reach further
        // down than the roller.
        let extent = |axis: Vector| {
            let local = position.rotation.inverse() * axis;
            (position.rotation * self.local_support_point_toward(local)).dot(axis)
        };
        let half_extents = Vector::new(extent(Vector::X), extent(Vector::Y), extent(Vector::Z));
        Aabb::new(
            position.translation - half_extents,
            position.translation + half_extents,
        )
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        BoundingSphere::new(Vector::ZERO, self.tip_m().max(self.middle_radius_m()))
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(*self)
    }

    fn scale_dyn(&self, scale: Vector, _num_subdivisions: u32) -> Option<Box<dyn Shape>> {
        // An unevenly scaled barrel is not a barrel.
        (scale.x == scale.y && scale.y == scale.z && scale.x > 0.0).then(|| {
            Box::new(Self(Barrel {
                wheel_radius_m: scale.x * self.0.wheel_radius_m,
                ring_radius_m: scale.x * self.0.ring_radius_m,
                sin_delta: self.0.sin_delta,
                half_length_m: scale.x * self.0.half_length_m,
            })) as Box<dyn Shape>
        })
    }

    fn mass_properties(&self, density: Real) -> MassProperties {
        // A roller's mass comes from its file, never from its shape; parry only needs a plausible
        // default.
        MassProperties::from_capsule(
            density,
            Vector::Z * -self.0.half_length_m,
            Vector::Z * self.0.half_length_m,
            self.middle_radius_m(),
        )
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> Real {
        self.middle_radius_m()
    }

    fn ccd_angular_thickness(&self) -> Real {
        std::f64::consts::FRAC_PI_2
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn as_support_map(&self) -> Option<&dyn SupportMap> {
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn shape() -> BarrelShape {
        BarrelShape(Barrel::handing_over(0.05, 0.012, 0.7, 9))
    }

    /// A point above a point of the surface along its normal is projected to that point; the
    /// support map gives points and normals. So is a point beneath it, which is recognised as
    /// inside.
    #[test]
    fn points_are_projected_to_where_the_normal_through_them_leaves_the_surface() {
        let barrel = shape();
        for step in 0..200 {
            let turn = 0.37 * step as Real;
            let tilt = (0.011 * step as Real).sin() * 1.5;
            let normal = Vector::new(tilt.cos() * turn.cos(), tilt.cos() * turn.sin(), tilt.sin());
            let on_surface = barrel.local_support_point_toward(normal);
            for (off_m, inside) in [(0.02, false), (1e-3, false), (-1e-3, true)] {
                let found = barrel.project_local_point(on_surface + normal * off_m, false);
                assert_eq!(found.is_inside, inside, "{step} {off_m}");
                // f32 of lengths below 0.1 m, bisected: the place along the axis is known to the
                // root of its rounding where the surface is nearly flat.
                let off = (found.point - on_surface).length();
                assert!(off < 2e-5, "{step} {off_m}: {off}");
            }
        }
    }

    /// The ball around a barrel contains all of its surface, and is as small as possible.
    #[test]
    fn the_ball_around_a_barrel_reaches_as_far_as_its_furthest_place() {
        let barrel = shape();
        let furthest_m = (0..=100).map(|step| {
            let (sin, cos) = (0.005 * PI * step as Real).sin_cos();
            let place = barrel.local_support_point_toward(Vector::new(cos, 0.0, sin));
            place.length()
        });
        let furthest_m = furthest_m.fold(0.0, Real::max);
        let ball = barrel.compute_local_bounding_sphere();
        // f32 of a few hundredths of a metre.
        assert!((ball.radius - furthest_m).abs() < 1e-8, "{furthest_m}");
        assert_eq!(ball.center, Vector::ZERO);
    }

    #[test]
    fn a_barrel_scaled_alike_is_a_barrel_and_else_none() {
        let scaled = |x: Real, y: Real, z: Real| shape().scale_dyn(Vector::new(x, y, z), 0);
        let twice = scaled(2.0, 2.0, 2.0).expect("a barrel");
        let half_extents = |shape: &dyn Shape| shape.compute_local_aabb().half_extents();
        let expected = half_extents(&shape()) * 2.0;
        assert!((half_extents(&*twice) - expected).length() < 1e-6);
        for (x, y, z) in [(2.0, 2.0, 3.0), (3.0, 2.0, 2.0), (-1.0, -1.0, -1.0)] {
            assert!(scaled(x, y, z).is_none(), "{x} {y} {z}");
        }
    }
}
