//! Drives and bearings.

use ilon_robot::Joint;
use nalgebra::Vector3;

/// What turns a wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Nothing but its bearing.
    Free,
    /// A torque in N m.
    Torque(f64),
    /// The torque k (target - rate), held to a limit.
    Rate {
        /// In rad/s.
        target_rad_s: f64,
        /// k, in N m s/rad.
        gain_n_m_s: f64,
        /// Largest torque in N m, 0 or more; may be infinite.
        limit_n_m: f64,
    },
    /// It stands still against the chassis, whatever torque that takes.
    Locked,
}

impl Drive {
    /// The torque at this rate in rad/s, in N m; `None` where the wheel is locked.
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

/// A force from outside on the chassis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// In the world frame, in N.
    pub force_in_world_n: Vector3<f64>,
    /// Where it acts, in the body frame, in metres.
    pub point_in_body_m: Vector3<f64>,
}

/// A bearing: viscous damping, and dry friction that grows to its full size over a small rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bearing {
    damping: f64,
    friction: f64,
    /// Dry friction for each newton that presses the part on its axle, in N m.
    per_load: f64,
    /// The rate at which dry friction is whole, for each newton metre of it, in rad/s.
    whole_at_per_n_m: f64,
}

impl Bearing {
    /// A bearing of a part with this inertia about its axis, for steps of `h` seconds. Dry friction f needs the rate
    /// 2 f h / inertia to grow whole: then a step takes half of the part's rate at most, and does not overshoot. What is held by
    /// dry friction creeps below that rate, which vanishes with the step.
    pub fn new(joint: &Joint, inertia: f64, h: f64) -> Self {
        Self {
            damping: joint.damping_n_m_s,
            friction: joint.friction_n_m,
            per_load: 0.0,
            whole_at_per_n_m: 2.0 * h / inertia,
        }
    }

    /// The same, with dry friction beside it that each newton of load makes, in N m.
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
