//! The robot as the rest of the project sees it, whatever file it came from.

use std::fmt;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3, Unit, UnitQuaternion, Vector2, Vector3};

use crate::{Profile, wrap_angle};

/// An omnidirectional robot: a chassis carried by N >= 3 driven wheels with passive rollers.
#[derive(Clone, Debug)]
pub struct Robot {
    /// The robot's name in its file.
    pub name: String,
    /// Everything that neither turns with a wheel nor rolls.
    pub chassis: Chassis,
    /// The driven wheels, in the order in which their joints stand in the file.
    pub wheels: Vec<Wheel>,
    /// What the loader ignored or doubts.
    pub remarks: Vec<Remark>,
}

/// The rigid body that carries the wheels. Links on fixed joints are merged into it.
#[derive(Clone, Debug)]
pub struct Chassis {
    /// The name of its link, which is the body frame.
    pub name: String,
    /// Mass properties in the body frame.
    pub mass: MassProperties,
    /// What of it can touch the world.
    pub collisions: Vec<Collision>,
}

/// Mass, centre and inertia of one rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass in kg, > 0.
    pub mass_kg: f64,
    /// Centre of mass in the body's own frame, in metres.
    pub center_of_mass_m: Vector3<f64>,
    /// Inertia about the centre of mass, along the axes of the body's own frame, in kg m^2.
    pub inertia_kg_m2: Matrix3<f64>,
}

/// A collision shape and where it sits.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// Pose of the shape in the frame of the body that carries it.
    pub body_from_shape: Isometry3<f64>,
    /// The shape.
    pub shape: CollisionShape,
}

/// The collision shapes of URDF, all but the hull centred on their own frame.
#[derive(Clone, Debug, PartialEq)]
pub enum CollisionShape {
    /// A box with sides along the axes.
    Box {
        /// Half of each side, in metres.
        half_extents_m: Vector3<f64>,
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius in metres.
        radius_m: f64,
        /// Length along z, in metres.
        length_m: f64,
    },
    /// A capsule along z.
    Capsule {
        /// Radius in metres.
        radius_m: f64,
        /// Length of the cylindrical part along z, in metres.
        length_m: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius in metres.
        radius_m: f64,
    },
    /// The convex hull of a mesh's vertices.
    ConvexHull {
        /// The vertices, in metres.
        points_m: Arc<[Point3<f64>]>,
    },
}

impl Collision {
    /// How far the shape reaches from the origin of the body that carries it, in a unit direction of that body's frame, in
    /// metres.
    pub fn reach_m(&self, direction: &Vector3<f64>) -> f64 {
        let d = self.body_from_shape.rotation.inverse() * direction;
        let from_middle_m = match &self.shape {
            CollisionShape::Box { half_extents_m } => half_extents_m.dot(&d.abs()),
            CollisionShape::Cylinder { radius_m, length_m } => {
                radius_m * d.xy().norm() + 0.5 * length_m * d.z.abs()
            }
            CollisionShape::Capsule { radius_m, length_m } => radius_m + 0.5 * length_m * d.z.abs(),
            CollisionShape::Sphere { radius_m } => *radius_m,
            CollisionShape::ConvexHull { points_m } => points_m
                .iter()
                .map(|p| p.coords.dot(&d))
                .fold(f64::NEG_INFINITY, f64::max),
        };
        self.body_from_shape.translation.vector.dot(direction) + from_middle_m
    }
}

/// A driven Swedish wheel: hub, motor and the passive rollers on its rim.
#[derive(Clone, Debug)]
pub struct Wheel {
    /// The name of the wheel's joint.
    pub name: String,
    /// Pose of the hub frame in the body frame at wheel angle zero: origin at the wheel's centre, z along the hub
    /// axis, x straight down.
    pub body_from_hub: Isometry3<f64>,
    /// Mass properties of the hub without its rollers, in the hub frame.
    pub hub: MassProperties,
    /// The paper's rho: distance from the hub axis to the ground, in metres.
    pub radius_m: f64,
    /// The paper's gamma, signed: the angle from the hub axis to the rolling direction of the roller that points
    /// down, counter-clockwise seen from above, in (-pi/2, pi/2]. The sign is the wheel's handedness.
    pub gamma_rad: f64,
    /// The rollers, ordered by their angle about the hub axis.
    pub rollers: Vec<Roller>,
    /// What the motor can do, at the wheel.
    pub motor: MotorLimits,
    /// Damping and friction of the wheel's own bearing and gear.
    pub joint: Joint,
}

/// A passive roller on the rim of a wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct Roller {
    /// The name of the roller's joint.
    pub name: String,
    /// The roller's centre in the hub frame, in metres.
    pub center_in_hub_m: Vector3<f64>,
    /// The roller's axis in the hub frame; its sense is that of the joint.
    pub axis_in_hub: Unit<Vector3<f64>>,
    /// The largest radius, at the roller's middle, in metres.
    pub radius_m: f64,
    /// Length along its axis, between the centres of the outermost spheres of the barrel
    /// (see [`crate::barrel`]), in metres.
    pub length_m: f64,
    /// Mass in kg.
    pub mass_kg: f64,
    /// Inertia about its axis, in kg m^2.
    pub axial_inertia_kg_m2: f64,
    /// Inertia about any axis through its centre across its own, in kg m^2.
    pub transverse_inertia_kg_m2: f64,
    /// Damping and friction of its bearing.
    pub joint: Joint,
    /// What it touches the world with.
    pub form: RollerForm,
}

/// What a roller touches the world with.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RollerForm {
    /// The exact barrel of its figures (see [`crate::barrel`]).
    #[default]
    Barrel,
    /// The collision shapes of its file.
    AsModelled(ModelledRoller),
}

/// A roller as its file models it, in the roller frame (see [`Roller::hub_from_roller`]).
#[derive(Clone, Debug, PartialEq)]
pub struct ModelledRoller {
    /// Its collision shapes, at least one.
    pub shapes: Vec<Collision>,
    /// Their outline about the roller's axis.
    pub profile: Profile,
}

/// Damping and dry friction of a joint (URDF `dynamics`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Joint {
    /// Viscous damping in N m s/rad.
    pub damping_n_m_s: f64,
    /// Dry (Coulomb) friction in N m.
    pub friction_n_m: f64,
}

/// Limits of a wheel's drive, at the wheel (URDF `limit`); infinite where the file sets none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLimits {
    /// Largest torque in N m, > 0.
    pub effort_n_m: f64,
    /// Largest rate in rad/s, > 0: the paper's q'_max of this wheel.
    pub velocity_rad_s: f64,
}

/// Something a person should know about how their file was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// The element it is about, such as ``joint `arm` ``.
    pub subject: String,
    /// The line in the file where that element stands, from 1, where it is one.
    pub line: Option<usize>,
    /// What was ignored, assumed or doubted.
    pub text: String,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            subject,
            line,
            text,
        } = self;
        match line {
            Some(line) => write!(f, "{subject} (line {line}): {text}"),
            None => write!(f, "{subject}: {text}"),
        }
    }
}

impl Wheel {
    /// The wheel's centre in the body frame: the paper's **b**, with its height, in metres.
    pub fn position_m(&self) -> Vector3<f64> {
        self.body_from_hub.translation.vector
    }

    /// The hub axis **n** in the ground plane of the body frame.
    pub fn axis(&self) -> Vector2<f64> {
        let n = self.body_from_hub.rotation * Vector3::z();
        n.xy().normalize()
    }

    /// The roller's rolling direction **u**_gamma in the body frame, of the roller that points straight down: the
    /// hub axis turned by gamma.
    pub fn roller_rolling_direction(&self) -> Vector2<f64> {
        let (s, c) = libm::sincos(self.gamma_rad);
        let n = self.axis();
        Vector2::new(c * n.x - s * n.y, s * n.x + c * n.y)
    }

    /// The roller's axis **n**_gamma = **k** x **u**_gamma in the body frame, of the roller that points straight down.
    pub fn roller_axis(&self) -> Vector2<f64> {
        let u_gamma = self.roller_rolling_direction();
        Vector2::new(-u_gamma.y, u_gamma.x)
    }
}

impl Roller {
    /// The roller's place on the rim: the angle of its centre about the hub axis, from the hub frame's x axis (down
    /// at wheel angle zero), in [-pi, pi). At wheel angle q it stands `place_rad() + q` from straight down.
    pub fn place_rad(&self) -> f64 {
        wrap_angle(libm::atan2(self.center_in_hub_m.y, self.center_in_hub_m.x))
    }

    /// Distance of the roller's centre from the hub axis, in metres.
    pub fn ring_radius_m(&self) -> f64 {
        self.center_in_hub_m.xy().norm()
    }

    /// Pose of the roller frame in the hub frame: origin at the roller's centre, z along its axis.
    pub fn hub_from_roller(&self) -> Isometry3<f64> {
        let z = Vector3::z();
        let rotation =
            UnitQuaternion::rotation_between(&z, &self.axis_in_hub).unwrap_or_else(|| {
                UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
            });
        Isometry3::from_parts(self.center_in_hub_m.into(), rotation)
    }

    /// Where the roller sits along the hub axis, from the wheel's centre, in metres: non-zero in wheels of two rows.
    pub fn row_offset_m(&self) -> f64 {
        self.center_in_hub_m.z
    }
}

impl Default for MotorLimits {
    fn default() -> Self {
        Self {
            effort_n_m: f64::INFINITY,
            velocity_rad_s: f64::INFINITY,
        }
    }
}

impl Robot {
    /// Mass of the whole robot, in kg.
    pub fn mass_kg(&self) -> f64 {
        let wheel_kg = |w: &Wheel| w.hub.mass_kg + w.rollers.iter().map(|r| r.mass_kg).sum::<f64>();
        self.chassis.mass.mass_kg + self.wheels.iter().map(wheel_kg).sum::<f64>()
    }

    /// Height of the body frame's origin above the ground when the robot stands level, its wheel angles zero, in metres.
    pub fn ride_height_m(&self) -> f64 {
        let lowest = |w: &Wheel| w.position_m().z - w.reach_at_rest_m();
        -self.wheels.iter().map(lowest).fold(f64::INFINITY, f64::min)
    }

    /// The paper's q'_max = min_j q'_max_j (before eq. (29)), in rad/s; infinite where no wheel has a limit.
    pub fn wheel_rate_limit_rad_s(&self) -> f64 {
        self.wheels
            .iter()
            .map(|w| w.motor.velocity_rad_s)
            .fold(f64::INFINITY, f64::min)
    }
}

impl Wheel {
    /// How far the wheel reaches down from its centre at wheel angle zero, in metres: its radius, but for rollers that have
    /// the shapes of their file.
    pub fn reach_at_rest_m(&self) -> f64 {
        let down_in_hub = self.body_from_hub.rotation.inverse() * -Vector3::z();
        let reach_m = |roller: &Roller| match &roller.form {
            RollerForm::Barrel => self.radius_m,
            RollerForm::AsModelled(modelled) => {
                let hub_from_roller = roller.hub_from_roller();
                let down = hub_from_roller.rotation.inverse() * down_in_hub;
                let reaches = modelled.shapes.iter().map(|shape| shape.reach_m(&down));
                hub_from_roller.translation.vector.dot(&down_in_hub)
                    + reaches.fold(f64::NEG_INFINITY, f64::max)
            }
        };
        let reaches = self.rollers.iter().map(reach_m);
        reaches.reduce(f64::max).unwrap_or(self.radius_m)
    }

    /// The exact barrel of one of this wheel's rollers (see [`crate::barrel`]).
    pub fn barrel(&self, roller: &Roller) -> crate::Barrel {
        crate::Barrel {
            wheel_radius_m: self.radius_m,
            ring_radius_m: roller.ring_radius_m(),
            sin_delta: libm::cos(self.gamma_rad),
            half_length_m: 0.5 * roller.length_m,
        }
    }
}
