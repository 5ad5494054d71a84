//! Finds the user bodies near ilon's bodies, and their contacts in rapier.

use std::collections::BTreeSet;

use nalgebra::{Point3, Vector3};
use rapier3d::prelude::*;

use super::rapier_world::{UserBodies, body_of};
use crate::contact::search::bounds::Bounds;
use crate::engine::convert;
use crate::free::{RapierContact, UserBody};
use crate::world::World;
use crate::world::free::islands::aabb;

impl World {
    /// Boxes around the moving user bodies, within which they may be near something in the coming
    /// step.
    pub(in crate::world) fn moving_user_bodies(&self) -> Vec<Bounds> {
        let rapier = self.user_bodies.as_ref();
        rapier.map_or_else(Vec::new, |rapier| rapier.moving(self.settings.dt_s))
    }
}

impl UserBodies {
    /// Whether rapier moves a user body by forces.
    pub(super) fn moves(&self, user: UserBody) -> bool {
        self.moved(user).is_some()
    }

    /// A body that rapier moves by forces.
    fn moved(&self, user: UserBody) -> Option<&RigidBody> {
        let UserBody::Rigid(raw) = user else {
            return None;
        };
        let body = self.world.bodies.get(body_of(raw))?;
        body.is_dynamic().then_some(body)
    }

    /// The contacts that rapier solves for a user body, each with its partner if that is not fixed.
    pub(super) fn touched_by(&self, user: UserBody) -> Vec<(Option<UserBody>, RapierContact)> {
        let Some(body) = self.moved(user) else {
            return Vec::new();
        };
        let colliders = body.colliders().iter();
        let pairs = colliders.flat_map(|collider| self.world.contact_pairs_with(*collider));
        // rapier also finds contacts with ilon's bodies, but does not solve them: counted here,
        // they would support a coupled body in ilon's step and not in rapier's.
        let is_solved = |manifold: &&ContactManifold| {
            let flags = manifold.data.solver_flags;
            flags.contains(SolverFlags::COMPUTE_RIGID_IMPULSES)
        };
        let manifolds = pairs.flat_map(|pair| pair.solver_manifolds());
        let contacts = manifolds.filter(is_solved).flat_map(|manifold| {
            let (data, of) = (&manifold.data, &manifold.data.solver_contacts);
            of.iter()
                .map(move |contact| self.contact(user, data, contact))
        });
        contacts.collect()
    }

    /// A contact that rapier found for a user body, and its partner if that is not fixed.
    fn contact(
        &self,
        user: UserBody,
        data: &ContactManifoldData,
        contact: &SolverContact,
    ) -> (Option<UserBody>, RapierContact) {
        let as_own =
            |body: Option<RigidBodyHandle>| body.map(|of| UserBody::Rigid(of.into_raw_parts()));
        let bodies = [data.rigid_body1, data.rigid_body2].map(as_own);
        let anchors = [contact.anchor1, contact.anchor2];
        let (this, other) = if bodies[0] == Some(user) {
            (0, 1)
        } else {
            (1, 0)
        };
        // rapier stores a point on a moving body along that body's axes, and any other in the
        // world.
        let handles = [data.rigid_body1, data.rigid_body2];
        let place = |k: usize| {
            let body = handles[k].and_then(|handle| self.world.bodies.get(handle));
            match body.filter(|body| !body.is_fixed()) {
                Some(body) => body.center_of_mass() + body.rotation() * anchors[k],
                None => anchors[k],
            }
        };
        // rapier's normal points out of the first.
        let normal = convert::to_vector(data.normal) * if this == 0 { -1.0 } else { 1.0 };
        let gap_m = normal.dot(&convert::to_vector(place(this) - place(other)));
        let is_fixed = |user: &UserBody| match user {
            UserBody::Rigid(raw) => {
                (self.world.bodies.get(body_of(*raw))).is_none_or(RigidBody::is_fixed)
            }
            UserBody::Collider(_) => true,
        };
        let contact = RapierContact {
            in_body_m: convert::to_vector(anchors[this]),
            normal,
            gap_m: gap_m.max(0.0),
            other: None,
            friction: data.friction,
        };
        (bodies[other].filter(|user| !is_fixed(user)), contact)
    }

    /// The user bodies that may be near bounds in the coming step, in a fixed order.
    pub(super) fn near(&self, around: &[Bounds], dt_s: f64) -> BTreeSet<UserBody> {
        let mut found = BTreeSet::new();
        let query = self.world.query_pipeline();
        let comes_m = self.comes_m(dt_s);
        for bounds in around {
            let within = aabb(&bounds.grown(comes_m));
            for (handle, collider) in query.intersect_aabb_conservative(within) {
                if self.objects.contains_key(&handle.into_raw_parts()) || !touches(collider) {
                    continue;
                }
                found.insert(match collider.parent() {
                    Some(body) => UserBody::Rigid(body.into_raw_parts()),
                    None => UserBody::Collider(handle.into_raw_parts()),
                });
            }
        }
        // rapier disables the colliders of a disabled body too.
        let is_rigid = |user: &UserBody| match user {
            UserBody::Rigid(raw) => {
                let body = self.world.bodies.get(body_of(*raw));
                body.is_some_and(|body| !body.is_soft_frame())
            }
            UserBody::Collider(_) => true,
        };
        found.retain(is_rigid);
        found
    }

    /// The largest displacement of any user body in a step, in metres.
    fn comes_m(&self, dt_s: f64) -> f64 {
        let moving = self.world.active_bodies();
        let comes_m = moving.map(|(_, body)| self.travel_m(body, dt_s));
        comes_m.fold(0.0, f64::max)
    }

    /// The largest displacement of a point of a body in a step, in metres.
    fn travel_m(&self, body: &RigidBody, dt_s: f64) -> f64 {
        let (velocity_m_s, angular_rad_s) = velocities(body, dt_s);
        if angular_rad_s == Vector3::zeros() {
            return dt_s * velocity_m_s.norm();
        }
        let center = body.center_of_mass();
        let reach_m = self.colliders_of(body).map(|collider| {
            let ball = collider.compute_aabb().bounding_sphere();
            (ball.center - center).length() + ball.radius
        });
        let rim_m_s = angular_rad_s.norm() * reach_m.fold(0.0, f64::max);
        dt_s * (velocity_m_s.norm() + rim_m_s)
    }

    /// Boxes around the moving user bodies, within which they may be near something in the coming
    /// step.
    fn moving(&self, dt_s: f64) -> Vec<Bounds> {
        let around = |(_, body): (RigidBodyHandle, &RigidBody)| {
            let bounds = self.colliders_of(body).map(|collider| {
                let around = collider.compute_aabb();
                Bounds {
                    least_m: convert::to_vector(around.mins),
                    most_m: convert::to_vector(around.maxs),
                }
            });
            let bounds = bounds.fold(Bounds::NONE, |all, of| all.merged(&of));
            bounds.grown(2.0 * self.travel_m(body, dt_s))
        };
        self.world.active_bodies().map(around).collect()
    }

    /// The colliders of a body that may touch ilon's bodies.
    pub(super) fn colliders_of<'a>(
        &'a self,
        body: &'a RigidBody,
    ) -> impl Iterator<Item = &'a Collider> {
        let all = body.colliders().iter();
        let colliders = all.filter_map(|handle| self.world.colliders.get(*handle));
        colliders.filter(|collider| touches(collider))
    }
}

/// Whether a user's collider touches ilon's bodies.
pub(super) fn touches(collider: &Collider) -> bool {
    let all = InteractionGroups::all();
    collider.is_enabled()
        && !collider.is_sensor()
        && collider.collision_groups().test(all)
        && collider.solver_groups().test(all)
}

/// Velocity of a body's centre of mass and its angular velocity in the coming step, in m/s and
/// rad/s.
pub(super) fn velocities(body: &RigidBody, dt_s: f64) -> (Vector3<f64>, Vector3<f64>) {
    if body.body_type() != RigidBodyType::KinematicPositionBased {
        return (
            convert::to_vector(body.linvel()),
            convert::to_vector(body.angvel()),
        );
    }
    // It moves to the program's target by the end of the step.
    let (from, to) = (
        convert::isometry(body.position()),
        convert::isometry(body.next_position()),
    );
    let center = Point3::from(convert::to_vector(body.local_center_of_mass()));
    let turned = to.rotation * from.rotation.inverse();
    (
        ((to * center) - (from * center)) / dt_s,
        turned.scaled_axis() / dt_s,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The displacement of a ball of 0.1 m in a second, half a metre from the centre of a moving
    /// body.
    fn travel_m(velocity_m_s: Vector, angular_rad_s: Vector) -> f64 {
        let mut rapier = UserBodies::new();
        let mass = rapier3d::dynamics::MassProperties::new(Vector::ZERO, 1.0, Vector::ONE);
        let body = RigidBodyBuilder::dynamic()
            .additional_mass_properties(mass)
            .linvel(velocity_m_s)
            .angvel(angular_rad_s);
        let ball = ColliderBuilder::ball(0.1).density(0.0);
        let beside = ball.translation(Vector::new(0.5, 0.0, 0.0));
        let (body, _) = rapier.world.insert(body, beside);
        // A step of zero length places the ball.
        rapier.world.integration_parameters.dt = 0.0;
        rapier.world.step();
        rapier.travel_m(&rapier.world.bodies[body], 1.0)
    }

    /// A rotating body moves as far as its furthest point, 0.6 m out, and little more is searched:
    /// the ball around its bounding box. A body without rotation moves by its displacement.
    #[test]
    fn what_turns_comes_as_far_as_its_rim() {
        let (goes, turns) = (Vector::new(0.0, 3.0, 4.0), Vector::new(0.0, 0.0, 2.0));
        assert!((travel_m(goes, Vector::ZERO) - 5.0).abs() < 1e-12);
        let most_m = 0.5 + 0.1 * 3.0_f64.sqrt();
        let found_m = travel_m(goes, turns);
        assert!(
            found_m >= 5.0 + 2.0 * 0.6 && found_m < 5.0 + 2.0 * most_m + 1e-12,
            "{found_m}"
        );
    }

    /// Where a body will be at the end of a step is within its box, whichever way it moves: a robot
    /// there is found before it is reached.
    #[test]
    fn the_box_of_a_moving_body_holds_where_it_will_be() {
        for velocity_m_s in [Vector::new(30.0, -20.0, 10.0), Vector::new(-5.0, 40.0, 0.0)] {
            let mut rapier = UserBodies::new();
            let body = RigidBodyBuilder::dynamic().linvel(velocity_m_s);
            rapier.world.insert(body, ColliderBuilder::ball(0.1));
            rapier.world.integration_parameters.dt = 0.0;
            rapier.world.step();
            let dt_s = 0.01;
            let [bounds] = &rapier.moving(dt_s)[..] else {
                panic!("one body moves");
            };
            let ends_m = dt_s * convert::to_vector(velocity_m_s);
            for axis in 0..3 {
                assert!(bounds.least_m[axis] <= ends_m[axis] - 0.1, "{bounds:?}");
                assert!(bounds.most_m[axis] >= ends_m[axis] + 0.1, "{bounds:?}");
            }
        }
    }
}
