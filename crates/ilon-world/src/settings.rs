//! How a world is built and stepped. Every default is the outcome of the measurements in `docs/accuracy.md`.

/// Which rollers are rigid bodies of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RollerBodies {
    /// Every roller, always.
    #[default]
    All,
    /// The contact window: every roller keeps its place and spin, and those that can touch the ground have a body.
    Near,
}

/// Numerical settings of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Length of one physics step, in seconds, > 0.
    pub dt_s: f64,
    /// Which rollers are bodies.
    pub roller_bodies: RollerBodies,
    /// Natural frequency of a contact's spring, in Hz, > 0: how fast penetration is pushed out. It scales with the
    /// mass at the contact; at 1000 Hz a 10 kg robot sinks by less than a micrometre.
    pub contact_frequency_hz: f64,
    /// Damping ratio of a contact's spring, dimensionless, > 0.
    pub contact_damping_ratio: f64,
    /// Gauss-Seidel sweeps over the contacts of one step, >= 1. Friction across rollers converges slowly: the light
    /// direction (the roller spins) and the heavy one (it carries the robot) are coupled.
    pub sweeps: usize,
    /// Rotor inertia added to every roller's spin, in kg m^2, >= 0: it eases the solver's work and slows the spin's
    /// transients by its share of the roller's own inertia.
    pub roller_armature_kg_m2: f64,
    /// Contacts are foreseen at this distance, in metres, > 0.
    pub prediction_m: f64,
    /// Gravity along -z, in m/s^2.
    pub gravity_m_s2: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dt_s: 1.0 / 500.0,
            roller_bodies: RollerBodies::All,
            contact_frequency_hz: 1000.0,
            contact_damping_ratio: 1.0,
            sweeps: 16,
            roller_armature_kg_m2: 4e-6,
            prediction_m: 1e-3,
            gravity_m_s2: 9.81,
        }
    }
}

/// The ground a robot drives on.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    /// Coulomb friction coefficient between roller and ground, >= 0.
    pub friction: f64,
    /// Slope: the angle by which the plane falls towards +x, in radians. 0 is level.
    pub slope_rad: f64,
}

impl Default for Floor {
    fn default() -> Self {
        Self {
            friction: 0.6,
            slope_rad: 0.0,
        }
    }
}
