//! Joint friction, motor limits and gears.

use smart_default::SmartDefault;

/// Damping and dry friction of a joint (URDF `dynamics`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Joint {
    /// Viscous damping in N m s/rad.
    pub damping_n_m_s: f64,
    /// Dry (Coulomb) friction in N m.
    pub friction_n_m: f64,
}

/// Limits of a wheel's drive, at the wheel (URDF `limit`); infinite if the file sets none.
#[derive(Clone, Copy, Debug, SmartDefault, PartialEq)]
pub struct MotorLimits {
    /// Largest torque in N m, > 0; 0 for a wheel that no motor drives.
    #[default(f64::INFINITY)]
    pub effort_n_m: f64,
    /// Largest rate in rad/s, > 0: the paper's q'_max of this wheel.
    #[default(f64::INFINITY)]
    pub velocity_rad_s: f64,
}

/// The gear and the rotor between a motor and its wheel.
#[derive(Clone, Copy, Debug, SmartDefault, PartialEq)]
pub struct DriveTrain {
    /// Turns of the rotor per turn of the wheel, > 0; 1 for a motor without a gear.
    #[default = 1.0]
    pub gear_ratio: f64,
    /// Inertia of the rotor about its own axis, before the gear, in kg m^2, >= 0.
    pub rotor_inertia_kg_m2: f64,
    /// Efficiency eta of the gear, in (0, 1]: the share of the motor's power that reaches the
    /// wheel. If the load drives, 2 - 1 / eta of the wheel's power reaches the motor; at 0.5 and
    /// below the gear is self-locking.
    #[default = 1.0]
    pub gear_efficiency: f64,
    /// Dry friction of the gear, at the wheel, in N m, >= 0. It is added to that of the wheel's own
    /// bearing ([`Joint::friction_n_m`]).
    pub gear_friction_n_m: f64,
}

impl DriveTrain {
    /// Returns the rotor's inertia reflected to the wheel, in kg m^2: gear_ratio^2 times its own,
    /// because it turns gear_ratio times as fast, and its torque is gear_ratio times as large at
    /// the wheel. MuJoCo calls it `armature`.
    pub fn reflected_inertia_kg_m2(&self) -> f64 {
        self.gear_ratio * self.gear_ratio * self.rotor_inertia_kg_m2
    }
}
