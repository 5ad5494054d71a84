//! Joints and motors.

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

impl Default for MotorLimits {
    fn default() -> Self {
        Self {
            effort_n_m: f64::INFINITY,
            velocity_rad_s: f64::INFINITY,
        }
    }
}
