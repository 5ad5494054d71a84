//! Free bodies: boxes, cylinders and spheres that belong to no robot and can be pushed.
//!
//! A free body is one more articulated body without joints: it moves by the same f64 dynamics, and
//! its contacts are in the same problem as those of the robots, so that momentum is conserved to
//! rounding and the energy balance closes as it does for a robot.

use std::sync::Arc;

use ilon_robot::{Chassis, Collision, FreeShape, MassProperties, Robot, Scale};
use nalgebra::{Isometry3, UnitQuaternion, Vector2, Vector3};

use crate::WorldError;

/// The identity of a free body of a world and its copies, until it is removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FreeBodyId(pub(crate) u32);

/// The parameters of a free body: a rigid body of uniform density.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeBody {
    /// Its name in errors and reports.
    pub name: String,
    /// Its shape.
    pub shape: FreeShape,
    /// Its mass, in kg, > 0.
    pub mass_kg: f64,
    /// Coulomb friction coefficient of its surface, >= 0. On the floor and between two free bodies
    /// the lower of both coefficients applies.
    pub friction: f64,
    /// The same against robots, their chassis and rollers, >= 0; `None` if it is the same.
    pub friction_on_robots: Option<f64>,
    /// Position of its centre in the floor's plane, in metres.
    pub place_m: Vector2<f64>,
    /// Height of its centre over the floor's plane, in metres; `None` puts it down on whatever is
    /// beneath it.
    pub height_m: Option<f64>,
    /// Its orientation in the world.
    pub rotation: UnitQuaternion<f64>,
    /// Velocity of its centre in the world, in m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Its angular velocity in the world, in rad/s.
    pub angular_rad_s: Vector3<f64>,
}

/// The smallest gravity for computing units, in m/s^2: a tenth of the earth's, as for robots.
/// Chosen.
pub(crate) const LEAST_GRAVITY_M_S2: f64 = 0.981;

/// The data of a free body besides its state.
#[derive(Clone, Debug)]
pub(crate) struct Free {
    pub id: FreeBodyId,
    pub name: Arc<str>,
    pub friction: f64,
    pub friction_on_robots: f64,
    /// Time for which it has been slow, in seconds.
    pub slow_s: f64,
    /// The effect of robots in a step: impulses so far within it, in N s, and then means over it,
    /// in N.
    pub from_robots: Vector3<f64>,
    /// Work that robots have done on it, in J.
    pub work_j: f64,
    /// Largest penetration between it and its partners so far, in metres.
    pub pressed_m: f64,
}

/// A rapier handle as a key: handles have no order.
pub(crate) type RawHandle = (u32, u32);

/// A user's body in rapier: a rigid body with its colliders, or a collider without a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum UserBody {
    Rigid(RawHandle),
    Collider(RawHandle),
}

/// The additional data of a user's body that is coupled to a step.
#[derive(Clone, Debug)]
pub(crate) struct Coupled {
    pub body: UserBody,
    /// Its velocity and angular velocity at the beginning of the step, in m/s and rad/s.
    pub start: [Vector3<f64>; 2],
    /// Its contacts with other user bodies and what is fixed, as rapier found them.
    pub contacts: Vec<RapierContact>,
    /// The effect of robots and free bodies in the step so far: impulse in N s, and moment about
    /// its centre of mass in N m s.
    pub impulse: [Vector3<f64>; 2],
}

/// A contact that rapier found for a coupled body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RapierContact {
    /// Its place, from the body's centre of mass along its own axes, in metres.
    pub in_body_m: Vector3<f64>,
    /// Unit vector in the world out of its partner.
    pub normal: Vector3<f64>,
    /// Distance in metres; 0 if the two overlap.
    pub gap_m: f64,
    /// The index among the step's bodies of the coupled body that it touches; `None` for fixed
    /// ones.
    pub other: Option<usize>,
    pub friction: f64,
}

impl FreeBody {
    /// A body at rest that is put down on whatever is beneath a point of the plane, in metres.
    pub fn new(name: &str, shape: FreeShape, mass_kg: f64, place_m: Vector2<f64>) -> Self {
        Self {
            name: name.to_owned(),
            shape,
            mass_kg,
            friction: 0.5,
            friction_on_robots: None,
            place_m,
            height_m: None,
            rotation: UnitQuaternion::identity(),
            velocity_m_s: Vector3::zeros(),
            angular_rad_s: Vector3::zeros(),
        }
    }

    /// Refuses an invalid body.
    pub(crate) fn check(&self) -> Result<(), WorldError> {
        /// The largest ratio of two sides: a plate of 1 m is at least 1 mm thick. Chosen.
        const SLENDER: f64 = 1e3;
        let refused = |reason: String| {
            let name = self.name.clone();
            Err(WorldError::FreeBody { name, reason })
        };
        let sizes = self.shape.sizes_m();
        let above_0 = |value: f64| value.is_finite() && value > 0.0;
        let positive = sizes.iter().copied().chain([("mass_kg", self.mass_kg)]);
        for (key, value) in positive {
            if !above_0(value) {
                return refused(format!("its {key} is {value}, but must be above 0"));
            }
        }
        for friction in [Some(self.friction), self.friction_on_robots]
            .into_iter()
            .flatten()
        {
            if !(friction.is_finite() && friction >= 0.0) {
                return refused(format!("its friction is {friction}, but must be 0 or more"));
            }
        }
        let most_m = sizes.iter().map(|(_, size)| *size).fold(0.0, f64::max);
        if sizes.iter().any(|(_, size)| *size * SLENDER < most_m) {
            return refused(format!(
                "one of its sizes is more than {SLENDER:.0} times another; make the thin one thicker"
            ));
        }
        let place = self.place_m.iter().chain(&self.height_m);
        let moves = self.velocity_m_s.iter().chain(&self.angular_rad_s);
        if place.chain(moves).any(|x| !x.is_finite()) {
            return refused("its place and velocity must be finite numbers".to_owned());
        }
        Ok(())
    }

    /// Whether it is put down at rest.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.velocity_m_s == Vector3::zeros() && self.angular_rad_s == Vector3::zeros()
    }

    /// The body as a robot with only a chassis.
    pub(crate) fn as_robot(&self) -> Robot {
        Robot {
            name: self.name.clone(),
            chassis: Chassis {
                name: self.name.clone(),
                mass: MassProperties {
                    mass_kg: self.mass_kg,
                    center_of_mass_m: Vector3::zeros(),
                    inertia_kg_m2: self.mass_kg * self.shape.inertia_m2(),
                },
                collisions: vec![Collision {
                    friction: None,
                    body_from_shape: Isometry3::identity(),
                    shape: self.shape.collision(),
                }],
            },
            joints: Vec::new(),
            couplings: Vec::new(),
            wheels: Vec::new(),
            remarks: Vec::new(),
        }
    }

    /// Its own units: half the side of a cube of its volume takes the place of a wheel's radius,
    /// and a quarter of its mass that of a wheel's load.
    pub(crate) fn scale(&self, gravity_m_s2: f64) -> Scale {
        Scale {
            length_m: 0.5 * libm::cbrt(self.shape.volume_m3()),
            load_kg: 0.25 * self.mass_kg,
            gravity_m_s2: gravity_m_s2.max(LEAST_GRAVITY_M_S2),
        }
    }
}
