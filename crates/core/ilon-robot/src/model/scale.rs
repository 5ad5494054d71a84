//! Natural units of a robot: length, time, force and stiffness scales.
//!
//! Robots of one shape and any size move alike under gravity (Froude's similarity): if lengths
//! scale by s and masses by s^3, times scale by sqrt(s), speeds by sqrt(s), forces by s^3 and
//! stiffnesses by s^2. So a chosen number in a simulation should be a share of one of these units.

/// Smallest gravity used for these units, in m/s^2, a tenth of the earth's: a weightless robot
/// still hits walls.
pub(super) const LEAST_GRAVITY_M_S2: f64 = 0.981;

/// The units of a robot on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Mean radius of its wheels, in metres.
    pub length_m: f64,
    /// Mass per wheel, in kg: an equal share of the robot's.
    pub load_kg: f64,
    /// Gravity, in m/s^2; at least a tenth of the earth's.
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

    /// Returns the stiffness that deflects by this share of a wheel's radius under its load, in
    /// N/m.
    pub fn stiffness_n_m(&self, sag: f64) -> f64 {
        self.load_kg * self.gravity_m_s2 / (sag * self.length_m)
    }
}
