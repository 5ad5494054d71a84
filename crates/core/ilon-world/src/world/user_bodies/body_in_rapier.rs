//! A user body as one more articulated body of a step, with rapier's data.

use ilon_robot::{Chassis, MassProperties, Scale};
use nalgebra::{Isometry3, Matrix3, Matrix6, Vector3, Vector6};
use rapier3d::prelude::*;

use super::rapier_world::{Exchange, Spatial};
use super::search::velocities;
use crate::contact::search::bounds::Bounds;
use crate::dynamics::Attached;
use crate::engine::convert;
use crate::free::{Coupled, LEAST_GRAVITY_M_S2, UserBody};
use crate::robot::articulated::{Articulated, Kind};
use crate::robot::payload::ActingPush;
use crate::robot::shared_robot::{BodyShape, SharedRobot};
use crate::settings::{ContactSpring, Settings};

/// The mass along a locked axis, or inertia about one, relative to the mass of the heaviest body
/// near it. Chosen.
const IMMOVABLE: f64 = 1e9;

/// A user body, with the data for ilon's step.
pub(super) struct BodyInRapier {
    floor_from_body: Isometry3<f64>,
    mass: MassProperties,
    /// Velocity of its centre of mass in m/s, and its angular velocity in rad/s.
    pub(super) velocities: (Vector3<f64>, Vector3<f64>),
    /// Its weight and the program's forces on it: force in N and torque in N m.
    force: Spatial,
    /// The axes of the world along which, and then about which, it is locked.
    locked: [bool; 6],
}

impl BodyInRapier {
    /// A fixed body in a pose.
    pub(super) fn fixed(floor_from_body: &Pose) -> Self {
        Self {
            floor_from_body: convert::isometry(floor_from_body),
            mass: MassProperties {
                mass_kg: 1.0,
                center_of_mass_m: Vector3::zeros(),
                inertia_kg_m2: Matrix3::identity(),
            },
            velocities: (Vector3::zeros(), Vector3::zeros()),
            force: Spatial::default(),
            locked: [true; 6],
        }
    }

    /// A rigid body under a gravity in m/s^2, in a step of `dt_s`.
    pub(super) fn of(body: &RigidBody, gravity: Vector, dt_s: f64) -> Self {
        let of = &body.mass_properties().local_mprops;
        let mut this = Self::fixed(body.position());
        this.mass.center_of_mass_m = convert::to_vector(of.local_com);
        this.velocities = velocities(body, dt_s);
        if !body.is_dynamic() {
            return this;
        }
        let weight = body.mass() * body.gravity_scale() * gravity;
        this.force = [weight + body.user_force(), body.user_torque()].map(convert::to_vector);
        let flags = body.locked_axes();
        let weighs = of.inv_mass > 0.0;
        let turns = of.inv_principal_inertia.cmpgt(Vector::ZERO).all();
        if weighs {
            this.mass.mass_kg = 1.0 / of.inv_mass;
        }
        if turns {
            let inertia = convert::to_matrix(of.reconstruct_inertia_matrix());
            this.mass.inertia_kg_m2 = 0.5 * (inertia + inertia.transpose());
        }
        this.locked = [
            !weighs || flags.contains(LockedAxes::TRANSLATION_LOCKED_X),
            !weighs || flags.contains(LockedAxes::TRANSLATION_LOCKED_Y),
            !weighs || flags.contains(LockedAxes::TRANSLATION_LOCKED_Z),
            !turns || flags.contains(LockedAxes::ROTATION_LOCKED_X),
            !turns || flags.contains(LockedAxes::ROTATION_LOCKED_Y),
            !turns || flags.contains(LockedAxes::ROTATION_LOCKED_Z),
        ];
        this
    }

    /// As an articulated body for contacts.
    pub(super) fn built(
        &self,
        user: UserBody,
        shapes: Vec<BodyShape>,
        settings: &Settings,
    ) -> Articulated {
        let around = shapes.iter().fold(Bounds::NONE, |around, of| {
            let bounds = of.shape.compute_local_aabb();
            let size = convert::to_vector(bounds.extents());
            around.merged(&Bounds {
                least_m: Vector3::zeros(),
                most_m: size,
            })
        });
        let scale = self.scale(&around, settings);
        let chassis = Chassis {
            name: String::new(),
            mass: self.mass.clone(),
            collisions: Vec::new(),
        };
        let robot = SharedRobot::of_one(chassis, shapes);
        let mut body = Articulated::build(robot, &self.floor_from_body, settings);
        body.scale = scale;
        body.spring = ContactSpring::of(settings, &body.scale);
        body.kind = Kind::Coupled(Box::new(Coupled {
            body: user,
            start: self.velocities.into(),
            contacts: Vec::new(),
            impulse: Spatial::default(),
        }));
        body
    }

    /// Its units: those of a free body within the same box, but at most a robot's.
    fn scale(&self, around: &Bounds, settings: &Settings) -> Scale {
        /// In metres. Chosen.
        const LARGE: f64 = 0.25;
        let sizes_m = (around.most_m - around.least_m).map(|size| size.clamp(1e-3, 1e3));
        let is_fixed = self.locked[..3].iter().all(|locked| *locked);
        Scale {
            length_m: (0.5 * libm::cbrt(sizes_m.product())).min(LARGE),
            // Immovable bodies are as stiff as the stiffest.
            load_kg: if is_fixed {
                1e6
            } else {
                0.25 * self.mass.mass_kg
            },
            gravity_m_s2: settings.gravity_m_s2.max(LEAST_GRAVITY_M_S2),
        }
    }

    /// Makes it immovable along and about its locked axes.
    pub(super) fn hold(&self, body: &mut Articulated, heaviest_kg: f64) {
        if !self.locked.contains(&true) {
            return;
        }
        let immovable = IMMOVABLE * heaviest_kg.max(self.mass.mass_kg);
        let held = self
            .locked
            .map(|locked| if locked { immovable } else { 0.0 });
        let inertia = Matrix6::from_diagonal(&Vector6::from(held));
        body.mechanics.attached = Some(Box::new(Attached::new(inertia, &Vector3::zeros())));
    }

    /// rapier's forces on it besides contacts, as a push in the step.
    pub(super) fn acts(&self, exchange: &Exchange, dt_s: f64) -> ActingPush {
        let turn = self.floor_from_body.rotation.to_rotation_matrix();
        let inertia = turn * self.mass.inertia_kg_m2 * turn.transpose();
        ActingPush {
            force_n: self.force[0] + self.mass.mass_kg * exchange.foreseen[0] / dt_s,
            lever_m: Vector3::zeros(),
            moment_n_m: self.force[1] + inertia * exchange.foreseen[1] / dt_s,
        }
    }
}

/// The shapes of a collider in the frame of its body, with its friction.
pub(super) fn shapes_of(collider: &Collider, body_from_collider: Pose) -> Vec<BodyShape> {
    let shape = |body_from_shape: Pose, shape: &SharedShape| BodyShape {
        joint: None,
        carrier_from_shape: convert::isometry(&body_from_shape),
        shape: shape.clone(),
        friction: Some(collider.friction().max(0.0)),
    };
    match collider.shape().as_compound() {
        Some(compound) => {
            let parts = compound.shapes().iter();
            parts
                .map(|(pose, part)| shape(body_from_collider * *pose, part))
                .collect()
        }
        None => vec![shape(body_from_collider, collider.shared_shape())],
    }
}
