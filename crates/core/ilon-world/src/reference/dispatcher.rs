//! Contacts of the exact roller with the ground: one point each, from the barrel itself instead of
//! facets.

use nalgebra::{Isometry3, Vector3};
use parry3d::math::{Pose, Real, Vector};
use parry3d::query::details::ShapeCastOptions;
use parry3d::query::details::{
    ContactManifoldsWorkspace, NormalConstraints, contact_manifolds_heightfield_shape_shapes,
};
use parry3d::query::{
    ClosestPoints, Contact, ContactManifold, DefaultQueryDispatcher, NonlinearRigidMotion,
    PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit, ShapeDistance, ShapeIntersection,
    TrackedContact, Unsupported,
};
use parry3d::shape::{PackedFeatureId, Shape};

use super::barrel_shape::BarrelShape;
use crate::contact::search::nearest::{Nearest, Piece, PlacedBarrel, SolidBox, Triangle};
use crate::engine::convert;

/// parry's default dispatcher, with exact contacts for [`BarrelShape`].
///
/// It serves whole worlds: parry takes height fields apart and their triangles come back here,
/// which a dispatcher merely chained before the default one would never see.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RollerDispatcher;

/// A piece of the ground, in its own frame, with the side that a roller sees; `None` for other
/// shapes.
fn piece_of(ground: &dyn Shape, seen_from_m: &Vector3<f64>) -> Option<Piece> {
    if ground.as_halfspace().is_some() {
        // The only one is the floor's plane.
        return Some(Piece::Plane);
    }
    if let Some(cuboid) = ground.as_cuboid() {
        return Some(Piece::Box(SolidBox {
            floor_from_box: Isometry3::identity(),
            half_sides_m: convert::to_vector(cuboid.half_extents),
        }));
    }
    let corners_m = ground.as_triangle()?.vertices().map(convert::to_vector);
    Triangle::new(corners_m, &(seen_from_m - corners_m[0])).map(Piece::Triangle)
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
    if nearest.gap_m > prediction {
        manifold.clear();
        return;
    }
    let normal = convert::vector(&nearest.normal);
    let on_ground = convert::vector(&nearest.place_m);
    let on_roller = on_ground + normal * nearest.gap_m;
    let roller_from_ground = ground_from_roller.inverse();
    let contact = TrackedContact::flipped(
        on_ground,
        roller_from_ground * on_roller,
        PackedFeatureId::face(0),
        PackedFeatureId::face(0),
        nearest.gap_m,
        flipped,
    );
    if manifold.points.len() == 1 {
        manifold.points[0].copy_geometry_from(contact);
    } else {
        manifold.clear();
        manifold.points.push(contact);
    }
    let normal_in_roller = roller_from_ground.rotation * -normal;
    (manifold.local_n1, manifold.local_n2) = if flipped {
        (normal_in_roller, normal)
    } else {
        (normal, normal_in_roller)
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
        if ground.as_heightfield().is_some() {
            contact_manifolds_heightfield_shape_shapes(
                self, pos12, g1, g2, prediction, manifolds, workspace,
            );
            return Ok(());
        }
        if manifolds.is_empty() {
            manifolds.push(ContactManifold::new());
        }
        let manifold = &mut manifolds[0];
        self.contact_manifold_convex_convex(pos12, g1, g2, None, None, prediction, manifold)
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
        let placed = PlacedBarrel {
            barrel: &roller.0,
            center_m: convert::to_vector(ground_from_roller.translation),
            axis: convert::to_vector(ground_from_roller.rotation * Vector::Z),
        };
        let piece = piece_of(ground, &placed.center_m).ok_or(Unsupported)?;
        let mut nearest = placed.nearest_to(&piece);
        if let Some(constraints) = constraints {
            // Internal edges of a mesh: the mesh corrects the normal, and with it the sphere that
            // touches.
            let raw = convert::vector(&nearest.normal);
            let mut normal = raw;
            if !constraints.project_local_normal_mut(&mut normal) {
                manifold.clear();
                return Ok(());
            }
            if raw != normal {
                nearest = along_normal(&placed, &piece, convert::to_vector(normal));
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
/// furthest against the normal, held to the plane that supports the piece along it.
fn along_normal(placed: &PlacedBarrel<'_>, piece: &Piece, normal: Vector3<f64>) -> Nearest {
    let (on_roller_m, _) = placed.support(&normal);
    let foot_m = piece.foot(&on_roller_m).place_m;
    let gap_m = (on_roller_m - foot_m).dot(&normal);
    Nearest {
        normal,
        gap_m,
        place_m: on_roller_m - gap_m * normal,
        ..placed.nearest_to(piece)
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
