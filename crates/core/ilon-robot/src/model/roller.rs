//! Passive rollers.

use nalgebra::{Isometry3, Matrix3, Unit, UnitQuaternion, Vector3};

use super::{
    Barrel, Collision, Joint, MassProperties, Profile, ProfileError, SolidOfRevolution, wrap_angle,
};

/// A passive roller on the rim of a wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct Roller {
    /// The name of the roller's joint.
    pub name: String,
    /// The roller's centre in the hub frame, in metres.
    pub center_in_hub_m: Vector3<f64>,
    /// The roller's axis in the hub frame, in the direction of its joint.
    pub axis_in_hub: Unit<Vector3<f64>>,
    /// The largest radius, at the roller's middle, in metres.
    pub radius_m: f64,
    /// Length along its axis, between the centres of the outermost spheres of the barrel
    /// (see [`crate::barrel_profile`]), in metres.
    pub length_m: f64,
    /// Mass in kg.
    pub mass_kg: f64,
    /// Inertia about its axis, in kg m^2.
    pub axial_inertia_kg_m2: f64,
    /// Inertia about any axis through its centre across its own, in kg m^2.
    pub transverse_inertia_kg_m2: f64,
    /// Damping and friction of its bearing.
    pub joint: Joint,
    /// Its shape of contact.
    pub form: RollerForm,
}

/// A roller's shape of contact.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RollerForm {
    /// The ideal barrel of its dimensions (see [`crate::barrel_profile`]).
    #[default]
    Barrel,
    /// A barrel for another circle than the wheel's (see [`crate::rollers_as_made`]). Its
    /// `wheel_radius_m` and `ring_radius_m` are those of that circle.
    Made(Barrel),
    /// A body turned to a profile given by numbers.
    Turned(SolidOfRevolution),
    /// The tyre of a wheel without rollers, about the hub axis and fixed to the hub (see
    /// [`Roller::tyre`]).
    Tyre(SolidOfRevolution),
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

impl Roller {
    /// Returns the tyre of a wheel without rollers: a cylinder about the hub axis with rounded
    /// shoulders, in metres. It has no mass of its own; the hub's includes it.
    ///
    /// Upright on a flat floor it touches in its middle and where its shoulders begin, at
    /// `0.5 * width_m - shoulder_radius_m` on both sides, and each of the three places carries a
    /// third. With a shoulder radius of an eighth of the width they resist a turn on the spot as a
    /// line of the tyre's width under a uniform load does, with the moment mu N width / 4.
    ///
    /// It is named after the joint of its wheel.
    ///
    /// # Errors
    /// [`ProfileError`]: a radius or width that is not positive, or shoulders of half the width or
    /// more.
    pub fn tyre(
        wheel: &str,
        radius_m: f64,
        width_m: f64,
        shoulder_radius_m: f64,
    ) -> Result<Self, ProfileError> {
        let half_m = 0.5 * width_m;
        let points_m = [-half_m, 0.0, half_m].map(|t_m| [t_m, radius_m]);
        let form = RollerForm::Tyre(SolidOfRevolution::new(&points_m, shoulder_radius_m)?);
        Ok(Self {
            name: format!("{wheel}_tyre"),
            center_in_hub_m: Vector3::zeros(),
            axis_in_hub: Vector3::z_axis(),
            radius_m,
            length_m: width_m,
            mass_kg: 0.0,
            axial_inertia_kg_m2: 0.0,
            transverse_inertia_kg_m2: 0.0,
            joint: Joint::default(),
            form,
        })
    }

    /// Whether it is the tyre of a wheel without rollers.
    pub fn is_tyre(&self) -> bool {
        matches!(self.form, RollerForm::Tyre(_))
    }

    /// Returns the angle of the roller's centre about the hub axis, from the hub frame's x axis
    /// (down at wheel angle zero), in [-pi, pi). At wheel angle q it is at `place_rad() + q` from
    /// straight down.
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

    /// The roller's mass properties in the hub frame.
    pub fn mass_in_hub(&self) -> MassProperties {
        let a = self.axis_in_hub.into_inner();
        MassProperties {
            mass_kg: self.mass_kg,
            center_of_mass_m: self.center_in_hub_m,
            inertia_kg_m2: Matrix3::identity() * self.transverse_inertia_kg_m2
                + a * a.transpose() * (self.axial_inertia_kg_m2 - self.transverse_inertia_kg_m2),
        }
    }

    /// Returns the roller's position along the hub axis, from the wheel's centre, in metres:
    /// non-zero in wheels of two rows.
    pub fn row_offset_m(&self) -> f64 {
        self.center_in_hub_m.z
    }
}
