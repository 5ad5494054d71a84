//! Contacts of the exact roller with the ground: one point each, from the barrel itself instead of
//! facets.
//!
//! The barrel is a family of spheres, so its distance to another shape is the minimum over the
//! family: dist = min over t of distance(axis(t)) - s(t). Against a plane the minimum has a closed
//! form; against a convex solid (box, triangle, hull) both terms are convex in t, so the minimum is
//! unique.

use parry3d::math::{Pose, Real, Vector};
use parry3d::query::details::ShapeCastOptions;
use parry3d::query::details::{
    ContactManifoldsWorkspace, NormalConstraints, contact_manifolds_composite_shape_shape,
    contact_manifolds_heightfield_shape_shapes, contact_manifolds_trimesh_shape_shapes,
};
use parry3d::query::{
    ClosestPoints, Contact, ContactManifold, DefaultQueryDispatcher, NonlinearRigidMotion,
    PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit, ShapeDistance, ShapeIntersection,
    TrackedContact, Unsupported,
};
use parry3d::shape::{HalfSpace, PackedFeatureId, Shape, ShapeType};

use super::barrel_shape::BarrelShape;

/// parry's default dispatcher, with exact contacts for [`BarrelShape`].
///
/// It serves whole worlds: composite grounds (triangle meshes, height fields, compounds) are taken
/// apart by parry and their pieces come back here, which a dispatcher merely chained before the
/// default one would never see.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RollerDispatcher;

/// The nearest points of a roller and another shape, in the other shape's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// Unit normal from the other shape towards the roller.
    pub normal: Vector,
    /// Signed distance in metres, negative in penetration.
    pub distance_m: Real,
    /// Centre of the nearest sphere of the barrel.
    pub center: Vector,
    /// Radius of that sphere, in metres.
    pub radius_m: Real,
}

/// The nearest points of a roller and a plane through the origin of its frame.
pub(crate) fn nearest_to_half_space(
    ground: &HalfSpace,
    ground_from_roller: &Pose,
    roller: &BarrelShape,
) -> Nearest {
    along_normal(ground_from_roller, roller, ground.normal, |_| Vector::ZERO)
}

/// The nearest points of a roller and a convex solid.
///
/// Starts from the sphere that faces the solid at the last minimum: on a flat face the normal does
/// not change and the closed form of the plane is the answer after one step. Over edges and
/// corners, where the normal changes with t, a golden-section search on the convex distance
/// follows.
pub(crate) fn nearest_to_convex(
    ground: &dyn Shape,
    ground_from_roller: &Pose,
    roller: &BarrelShape,
) -> Nearest {
    let axis = ground_from_roller.rotation * Vector::Z;
    let at = |t_m: Real| {
        let center = ground_from_roller.translation + axis * t_m;
        let foot = ground.project_local_point(center, false);
        let offset = center - foot.point;
        let gap = offset.length();
        let (normal, depth) = if gap <= Real::EPSILON {
            (outward_at(ground, center, ground_from_roller), 0.0)
        } else if foot.is_inside {
            (-offset / gap, -gap)
        } else {
            (offset / gap, gap)
        };
        let radius_m = roller.0.sphere_radius_m(t_m);
        Nearest {
            normal,
            distance_m: depth - radius_m,
            center,
            radius_m,
        }
    };

    let mut nearest = at(0.0);
    for _ in 0..2 {
        let next = at(roller.0.support_place_m(-nearest.normal.dot(axis)));
        // The normal did not change with the move along the axis: a flat face, for which the
        // plane's closed form holds.
        let settled = next.normal.dot(nearest.normal) > 1.0 - 4.0 * Real::EPSILON;
        nearest = next;
        if settled {
            return nearest;
        }
    }

    // Golden section: 40 steps shrink the bracket by 0.618^40 = 4e-9.
    const GOLDEN: Real = 0.618_034;
    let (mut low, mut high) = (-roller.0.half_length_m, roller.0.half_length_m);
    let (mut left, mut right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_left, mut at_right) = (at(left), at(right));
    for _ in 0..40 {
        if at_left.distance_m < at_right.distance_m {
            (high, right, at_right) = (right, left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = at(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = at(right);
        }
    }
    [nearest, at_left, at_right]
        .into_iter()
        .min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))
        .unwrap_or(nearest)
}

/// The outward normal for a sphere's centre on the surface itself, where the projection has none.
fn outward_at(ground: &dyn Shape, on_surface: Vector, ground_from_roller: &Pose) -> Vector {
    // From the solid's middle: exact for flat pieces seen from above, and any outward direction is
    // valid here.
    if let Some(triangle) = ground.as_triangle()
        && let Some(normal) = triangle.normal()
    {
        let towards = ground_from_roller.translation - on_surface;
        return if normal.dot(towards) < 0.0 {
            -normal
        } else {
            normal
        };
    }
    (on_surface - ground.compute_local_aabb().center()).normalize_or(Vector::Z)
}

/// Writes the one contact of a roller against a ground piece; keeps the warm start of the contact
/// that was there.
///
/// `flipped` says that the roller is the pair's first shape.
fn write_contact<ManifoldData, ContactData: Default + Copy>(
    nearest: &Nearest,
    ground_from_roller: &Pose,
    prediction: Real,
    flipped: bool,
    manifold: &mut ContactManifold<ManifoldData, ContactData>,
) {
    if nearest.distance_m > prediction {
        manifold.clear();
        return;
    }
    let on_roller = nearest.center - nearest.normal * nearest.radius_m;
    let on_ground = on_roller - nearest.normal * nearest.distance_m;
    let roller_from_ground = ground_from_roller.inverse();
    let contact = TrackedContact::flipped(
        on_ground,
        roller_from_ground * on_roller,
        PackedFeatureId::face(0),
        PackedFeatureId::face(0),
        nearest.distance_m,
        flipped,
    );
    if manifold.points.len() == 1 {
        manifold.points[0].copy_geometry_from(contact);
    } else {
        manifold.clear();
        manifold.points.push(contact);
    }
    let normal_in_roller = roller_from_ground.rotation * -nearest.normal;
    (manifold.local_n1, manifold.local_n2) = if flipped {
        (normal_in_roller, nearest.normal)
    } else {
        (nearest.normal, normal_in_roller)
    };
}

impl<ManifoldData, ContactData> PersistentQueryDispatcher<ManifoldData, ContactData>
    for RollerDispatcher
where
    ManifoldData: Default + Clone + Send + Sync,
    ContactData: Default + Copy + Send + Sync,
{
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: Real,
        manifolds: &mut Vec<ContactManifold<ManifoldData, ContactData>>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        let roller_is_first = g1.as_shape::<BarrelShape>().is_some();
        if !roller_is_first && g2.as_shape::<BarrelShape>().is_none() {
            return DefaultQueryDispatcher
                .contact_manifolds(pos12, g1, g2, prediction, manifolds, workspace);
        }
        let ground = if roller_is_first { g2 } else { g1 };
        match ground.shape_type() {
            ShapeType::TriMesh => contact_manifolds_trimesh_shape_shapes(
                self, pos12, g1, g2, prediction, manifolds, workspace,
            ),
            ShapeType::HeightField => contact_manifolds_heightfield_shape_shapes(
                self, pos12, g1, g2, prediction, manifolds, workspace,
            ),
            _ => match ground.as_composite_shape() {
                Some(composite) => {
                    let (ground_from_roller, roller) = if roller_is_first {
                        (pos12.inverse(), g1)
                    } else {
                        (*pos12, g2)
                    };
                    contact_manifolds_composite_shape_shape(
                        self,
                        &ground_from_roller,
                        composite,
                        roller,
                        prediction,
                        manifolds,
                        workspace,
                        roller_is_first,
                    );
                }
                None => {
                    if manifolds.is_empty() {
                        manifolds.push(ContactManifold::new());
                    }
                    return self.contact_manifold_convex_convex(
                        pos12,
                        g1,
                        g2,
                        None,
                        None,
                        prediction,
                        &mut manifolds[0],
                    );
                }
            },
        }
        Ok(())
    }

    fn contact_manifold_convex_convex(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        normal_constraints1: Option<&dyn NormalConstraints>,
        normal_constraints2: Option<&dyn NormalConstraints>,
        prediction: Real,
        manifold: &mut ContactManifold<ManifoldData, ContactData>,
    ) -> Result<(), Unsupported> {
        let first = g1.as_shape::<BarrelShape>();
        let (roller, ground, ground_from_roller, constraints) = match (first, g2.as_shape()) {
            // Two rollers never collide: collision groups keep them apart.
            (Some(_), Some(_)) => return Err(Unsupported),
            (Some(roller), None) => (roller, g2, pos12.inverse(), normal_constraints2),
            (None, Some(roller)) => (roller, g1, *pos12, normal_constraints1),
            (None, None) => {
                return DefaultQueryDispatcher.contact_manifold_convex_convex(
                    pos12,
                    g1,
                    g2,
                    normal_constraints1,
                    normal_constraints2,
                    prediction,
                    manifold,
                );
            }
        };
        let mut nearest = match ground.as_halfspace() {
            Some(plane) => nearest_to_half_space(plane, &ground_from_roller, roller),
            None => nearest_to_convex(ground, &ground_from_roller, roller),
        };
        if let Some(constraints) = constraints {
            // Internal edges of a mesh: the mesh corrects the normal, and with it the sphere that
            // touches.
            let raw = nearest.normal;
            if !constraints.project_local_normal_mut(&mut nearest.normal) {
                manifold.clear();
                return Ok(());
            }
            if raw != nearest.normal {
                let foot = |center| ground.project_local_point(center, false).point;
                nearest = along_normal(&ground_from_roller, roller, nearest.normal, foot);
            }
        }
        write_contact(
            &nearest,
            &ground_from_roller,
            prediction,
            first.is_some(),
            manifold,
        );
        Ok(())
    }
}

/// The contact of a roller with a ground piece along a given normal: the sphere that reaches
/// furthest against the normal, held to the plane that supports the piece along it. `foot` gives a
/// point of that plane, for the sphere's centre.
fn along_normal(
    ground_from_roller: &Pose,
    roller: &BarrelShape,
    normal: Vector,
    foot: impl Fn(Vector) -> Vector,
) -> Nearest {
    let axis = ground_from_roller.rotation * Vector::Z;
    let t_m = roller.0.support_place_m(-normal.dot(axis));
    let center = ground_from_roller.translation + axis * t_m;
    let radius_m = roller.0.sphere_radius_m(t_m);
    Nearest {
        normal,
        distance_m: (center - foot(center)).dot(normal) - radius_m,
        center,
        radius_m,
    }
}

/// One-shot queries go to parry: its support map makes the roller a convex shape like any other.
impl QueryDispatcher for RollerDispatcher {
    fn intersection_test(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        DefaultQueryDispatcher.intersection_test(pos12, g1, g2)
    }

    fn distance(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
    ) -> Result<ShapeDistance, Unsupported> {
        DefaultQueryDispatcher.distance(pos12, g1, g2)
    }

    fn contact(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: Real,
    ) -> Result<Option<Contact>, Unsupported> {
        DefaultQueryDispatcher.contact(pos12, g1, g2, prediction)
    }

    fn closest_points(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        max_dist: Real,
    ) -> Result<ClosestPoints, Unsupported> {
        DefaultQueryDispatcher.closest_points(pos12, g1, g2, max_dist)
    }

    fn cast_shapes(
        &self,
        pos12: &Pose,
        local_vel12: Vector,
        g1: &dyn Shape,
        g2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        DefaultQueryDispatcher.cast_shapes(pos12, local_vel12, g1, g2, options)
    }

    fn cast_shapes_nonlinear(
        &self,
        motion1: &NonlinearRigidMotion,
        g1: &dyn Shape,
        motion2: &NonlinearRigidMotion,
        g2: &dyn Shape,
        start_time: Real,
        end_time: Real,
        stop_at_penetration: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        DefaultQueryDispatcher.cast_shapes_nonlinear(
            motion1,
            g1,
            motion2,
            g2,
            start_time,
            end_time,
            stop_at_penetration,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_robot::Barrel;
    use parry3d::math::Rotation;
    use parry3d::shape::Cuboid;

    /// Over a face, an edge and a corner of a box, against a search along the whole axis: the
    /// smallest distance of the spheres.
    #[test]
    fn a_roller_is_as_far_from_a_box_as_the_nearest_of_its_spheres() {
        let roller = BarrelShape(Barrel::handing_over(0.05, 0.012, 0.7, 9));
        let ground = Cuboid::new(Vector::new(0.1, 0.1, 0.01));
        for step in 0..60 {
            let turn = 0.2 * step as Real;
            let rotation =
                Rotation::from_rotation_z(turn) * Rotation::from_rotation_x(1.2 + 0.01 * turn);
            // From over the middle, past an edge and a corner, to beside the box.
            let place = Vector::new(0.002 * step as Real, 0.0018 * step as Real, 0.023);
            let pose = Pose::from_parts(place, rotation);
            let found = nearest_to_convex(&ground, &pose, &roller);
            let least = (-2000..=2000)
                .map(|k| {
                    let t_m = roller.0.half_length_m * k as Real / 2000.0;
                    let center = pose.translation + (pose.rotation * Vector::Z) * t_m;
                    let foot =
                        parry3d::query::PointQuery::project_local_point(&ground, center, false);
                    let away_m = (center - foot.point).length();
                    let signed_m = if foot.is_inside { -away_m } else { away_m };
                    signed_m - roller.0.sphere_radius_m(t_m)
                })
                .fold(Real::INFINITY, Real::min);
            // The search has a step of 10 um on an axis tilted by less than 0.4.
            let off_m = (found.distance_m - least).abs();
            assert!(off_m < 2e-6, "{step}: {} {least}", found.distance_m);
        }
    }
}
