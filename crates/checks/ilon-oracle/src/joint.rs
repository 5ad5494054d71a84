//! Drives and bearings.

use ilon_robot::Joint;
use nalgebra::Vector3;

/// The drive of a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// None: only its bearing acts.
    Free,
    /// A torque in N m.
    Torque(f64),
    /// The torque k (target - rate), limited.
    Rate {
        /// In rad/s.
        target_rad_s: f64,
        /// k, in N m s/rad.
        gain_n_m_s: f64,
        /// Largest torque in N m, 0 or more; may be infinite.
        limit_n_m: f64,
    },
    /// Locked to the chassis, whatever torque that needs.
    Locked,
}

impl Drive {
    /// The torque at this rate in rad/s, in N m; `None` if the wheel is locked.
    pub(crate) fn torque_n_m(&self, rate_rad_s: f64) -> Option<f64> {
        match *self {
            Self::Free => Some(0.0),
            Self::Torque(torque_n_m) => Some(torque_n_m),
            Self::Rate {
                target_rad_s,
                gain_n_m_s,
                limit_n_m,
            } => Some(
                (gain_n_m_s * (target_rad_s - rate_rad_s))
                    .min(limit_n_m)
                    .max(-limit_n_m),
            ),
            Self::Locked => None,
        }
    }
}

/// An external force on the chassis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// In the world frame, in N.
    pub force_in_world_n: Vector3<f64>,
    /// Point of application in the body frame, in metres.
    pub point_in_body_m: Vector3<f64>,
}

/// A bearing: viscous damping, and dry friction that rises to its full value over a small rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bearing {
    damping: f64,
    friction: f64,
    /// Dry friction per newton of load on the axle, in N m.
    per_load: f64,
    /// The rate at which dry friction reaches its full value, per newton metre of it, in rad/s.
    whole_at_per_n_m: f64,
}

impl Bearing {
    /// A bearing of a part with this inertia about its axis, for steps of `h` seconds. Dry friction
    /// f reaches its full value at the rate 2 f h / inertia: a step then removes at most half of
    /// the part's rate, and does not overshoot. A part held by dry friction creeps below that rate,
    /// which vanishes with the step.
    pub fn new(joint: &Joint, inertia: f64, h: f64) -> Self {
        Self {
            damping: joint.damping_n_m_s,
            friction: joint.friction_n_m,
            per_load: 0.0,
            whole_at_per_n_m: 2.0 * h / inertia,
        }
    }

    /// Adds dry friction proportional to the load, in N m per newton.
    pub fn loaded(self, per_load: f64) -> Self {
        Self { per_load, ..self }
    }

    /// Its torque at this rate under a load in N, in N m.
    pub fn torque_n_m(&self, rate: f64, load_n: f64) -> f64 {
        let friction = self.friction + self.per_load * load_n;
        let dry = if friction > 0.0 {
            friction * (rate / (self.whole_at_per_n_m * friction)).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        -self.damping * rate - dry
    }
}
