//! A robot's own units: what is long, quick, fast and stiff for it.
//!
//! Robots of one shape and any size move alike under gravity (Froude's similarity): where lengths grow by s and masses by s^3,
//! times grow by sqrt(s), speeds by sqrt(s), forces by s^3 and stiffnesses by s^2. So no number that a simulation chooses
//! may have a unit of its own: it is a share of one of these.

/// Gravity below which a robot is measured as if it had this, in m/s^2, a tenth of the earth's: one that weighs nothing still
/// hits walls.
pub(super) const LEAST_GRAVITY_M_S2: f64 = 0.981;

/// The units of a robot on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Radius of its wheels, in metres: their mean.
    pub length_m: f64,
    /// Mass that stands on a wheel, in kg: an even share of the robot's.
    pub load_kg: f64,
    /// Gravity, in m/s^2; a tenth of the earth's where it is less.
    pub gravity_m_s2: f64,
}

impl Scale {
    /// sqrt(rho / g), in seconds: 71 ms for wheels of 50 mm on earth.
    pub fn time_s(&self) -> f64 {
        (self.length_m / self.gravity_m_s2).sqrt()
    }

    /// sqrt(rho g), in m/s: 0.70 m/s for wheels of 50 mm on earth.
    pub fn speed_m_s(&self) -> f64 {
        (self.length_m * self.gravity_m_s2).sqrt()
    }

    /// The stiffness that gives way by this share of a wheel's radius under its load, in N/m.
    pub fn stiffness_n_m(&self, sag: f64) -> f64 {
        self.load_kg * self.gravity_m_s2 / (sag * self.length_m)
    }
}
