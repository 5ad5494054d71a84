//! Queries of a world: every shape in it, and ray casts.

use ilon_robot::RollerForm;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use parry3d::query::Ray;
use rapier3d::prelude::*;

use super::islands::id_of;
use crate::contact::search::free_bodies::solids;
use crate::contact::search::solid::Solid;
use crate::engine::convert;
use crate::robot::articulated::Articulated;
use crate::world::World;
use crate::{BodyId, WorldObject};

/// A hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RayHit {
    /// The object that it hits.
    pub object: WorldObject,
    /// Distance, in metres.
    pub distance_m: f64,
    /// Point in the world, in metres.
    pub place_m: Vector3<f64>,
    /// Outward unit normal of the object, in the world.
    pub normal: Vector3<f64>,
}

impl World {
    /// The first hit of a ray within a distance in metres, from a point in the world along a
    /// direction of any length; `None` if it hits nothing. A ray that starts inside an object hits
    /// it at once.
    pub fn cast_ray(
        &self,
        from_m: Vector3<f64>,
        direction: Vector3<f64>,
        most_m: f64,
    ) -> Option<RayHit> {
        let along = direction.try_normalize(0.0)?;
        let mut nearest: Option<RayHit> = None;
        self.each_part(|object, part| {
            let pose = &part.floor_from_shape;
            let from = pose.inverse_transform_point(&Point3::from(from_m));
            let ray = Ray::new(
                convert::vector(&from.coords),
                convert::vector(&pose.inverse_transform_vector(&along)),
            );
            let limit_m = nearest.map_or(most_m, |hit| hit.distance_m);
            let hit = part
                .shape
                .cast_local_ray_and_get_normal(&ray, limit_m, true);
            let Some(hit) = hit else {
                return;
            };
            let distance_m = hit.time_of_impact;
            if distance_m < limit_m || nearest.is_none() {
                nearest = Some(RayHit {
                    object,
                    distance_m,
                    place_m: from_m + distance_m * along,
                    normal: pose.rotation * convert::to_vector(hit.normal),
                });
            }
        });
        nearest
    }

    /// Passes every shape of ilon's in the world, with its object, to `show`.
    pub(in crate::world) fn each_part(&self, mut show: impl FnMut(WorldObject, Solid<'_>)) {
        if self.ground.is_solid_below() {
            let plane = Solid {
                shape: &SharedShape::halfspace(Vector::Z),
                floor_from_shape: Isometry3::identity(),
            };
            show(WorldObject::Ground, plane);
        }
        for solid in self.ground.solids() {
            show(WorldObject::Ground, solid);
        }
        let all = self.bodies.iter().chain(self.islands.bodies());
        for (index, body) in all.enumerate() {
            let object = id_of(body).map_or(WorldObject::Robot(BodyId(index)), WorldObject::Free);
            for solid in solids(body, &body.state) {
                show(object, solid);
            }
            for wheel in 0..body.wheels.len() {
                let (floor_from_shape, shape) = wheel_of(body, wheel);
                let shape = &shape;
                show(
                    object,
                    Solid {
                        shape,
                        floor_from_shape,
                    },
                );
            }
        }
    }
}

/// A wheel as a cylinder around its rollers.
fn wheel_of(body: &Articulated, wheel: usize) -> (Isometry3<f64>, SharedShape) {
    let (hub, of) = (&body.state.hubs()[wheel], &body.robot.wheels[wheel]);
    let half_m = of.rollers.iter().map(|roller| {
        let along = roller.axis_in_hub.z.abs();
        let half_m = match roller.form {
            RollerForm::AsModelled(_) => roller.radius_m,
            RollerForm::Tyre(_) => 0.5 * roller.length_m,
            _ => of.barrel(roller).half_length_m,
        };
        roller.center_in_hub_m.z.abs() + along * half_m
    });
    let half_m = half_m.fold(0.0, f64::max).max(1e-3 * of.radius_m);
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(hub.rotation);
    let z_to_y = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    let floor_from_shape = Isometry3::from_parts(
        hub.center_m.into(),
        UnitQuaternion::from_rotation_matrix(&rotation) * z_to_y,
    );
    let shape = SharedShape::cylinder(half_m, of.radius_m);
    (floor_from_shape, shape)
}
