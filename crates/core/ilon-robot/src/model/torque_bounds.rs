//! The limits of a motor's torque.

/// The limits of the torque of a motor near a rate of its wheel, such as that at the beginning of a
/// step: the two lines of a DC motor's back-EMF, which fall with the rate, and a constant limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueBounds {
    /// The smallest torque of the lines at this rate, in N m: a DC motor's at full reverse;
    /// infinite without lines.
    pub least_n_m: f64,
    /// The largest, in N m: at full forward.
    pub most_n_m: f64,
    /// Decrease of both per rate gained, in N m s/rad, >= 0; 0 without lines.
    pub fall_n_m_s: f64,
    /// The largest magnitude of the torque, in N m, >= 0; it applies even if the lines demand more.
    pub limit_n_m: f64,
    /// Whether the lines impose a torque on a wheel beyond their zero; otherwise the motor is free
    /// there.
    pub regenerates: bool,
}

impl TorqueBounds {
    /// No limits.
    pub const NONE: Self = Self {
        least_n_m: f64::NEG_INFINITY,
        most_n_m: f64::INFINITY,
        fall_n_m_s: 0.0,
        limit_n_m: f64::INFINITY,
        regenerates: true,
    };

    /// The smallest and largest torque after the wheel has gained a rate, in rad/s.
    pub fn at_gain(&self, gained_rad_s: f64) -> [f64; 2] {
        let lost_n_m = self.fall_n_m_s * gained_rad_s;
        let (mut least_n_m, mut most_n_m) = (self.least_n_m - lost_n_m, self.most_n_m - lost_n_m);
        if !self.regenerates {
            (least_n_m, most_n_m) = (least_n_m.min(0.0), most_n_m.max(0.0));
        }
        [least_n_m, most_n_m].map(|bound| bound.max(-self.limit_n_m).min(self.limit_n_m))
    }

    /// The decrease per rate gained of a limit that applies at this rate, in N m s/rad: a line
    /// falls, a constant limit does not.
    pub fn fall_of(&self, bound_n_m: f64) -> f64 {
        if bound_n_m == self.least_n_m || bound_n_m == self.most_n_m {
            self.fall_n_m_s
        } else {
            0.0
        }
    }

    /// The limits of a motor that turns the other way.
    pub fn mirrored(&self) -> Self {
        Self {
            least_n_m: -self.most_n_m,
            most_n_m: -self.least_n_m,
            ..*self
        }
    }
}
