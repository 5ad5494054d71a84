//! How a world is built and stepped. Every default is the outcome of the measurements in `docs/accuracy.md`.

/// Which rollers have their shapes in the world. All have their mass, inertia and spin, whichever this is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RollerBodies {
    /// Every roller, always.
    #[default]
    All,
    /// The contact window: those that can touch the ground.
    Near,
}

/// Numerical settings of a world.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Length of one physics step, in seconds, > 0.
    pub dt_s: f64,
    /// Which rollers have their shapes in the world.
    pub roller_bodies: RollerBodies,
    /// Natural frequency of a contact's spring, in Hz, > 0: how fast penetration is pushed out. It scales with the
    /// mass at the contact; at 1000 Hz a 10 kg robot sinks by less than a micrometre.
    pub contact_frequency_hz: f64,
    /// Damping ratio of a contact's spring, dimensionless, > 0.
    pub contact_damping_ratio: f64,
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
            prediction_m: 1e-3,
            gravity_m_s2: 9.81,
        }
    }
}
