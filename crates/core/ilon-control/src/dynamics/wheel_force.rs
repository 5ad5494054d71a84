//! The force that an acceleration needs from a wheel, at its hub and on the ground.

use ilon_robot::Wheel;
use nalgebra::Vector3;

use super::model::{WheelSpin, wheel_spin};
use super::traction::PushRange;
use crate::{ControlError, TorqueRange};

/// 1e-9 N counts as rounding.
pub(super) const SLACK_N: f64 = 1e-9;

/// The robot's motion, as components in the body frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    pub nu: Vector3<f64>,
    /// The twist that dry friction opposes.
    pub towards: Vector3<f64>,
}

/// A wheel's roller on the ground.
#[derive(Clone, Debug)]
pub(super) struct Touch {
    spin: WheelSpin,
    roller_radius_m: f64,
    /// rho cos(gamma).
    pub lever_m: f64,
    radius_m: f64,
    gear_efficiency: f64,
}

/// The forces that a wheel needs and has, in N.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WheelForce {
    /// Push of the wheel's torque on the hub, positive where a positive torque pushes.
    pub push_n: f64,
    /// The ground's force along the roller's axis, in the same sense, and across it.
    pub at_ground_n: [f64; 2],
    pub grip_n: f64,
    pub motor: PushRange,
    pub load_n: f64,
}

impl Touch {
    /// The model of a wheel with its lever rho cos(gamma) in m.
    pub fn new(wheel: &Wheel, lever_m: f64) -> Result<Self, ControlError> {
        Ok(Self {
            spin: wheel_spin(wheel)?,
            roller_radius_m: wheel.rollers.first().map_or(1.0, |roller| roller.radius_m),
            lever_m,
            radius_m: wheel.radius_m,
            gear_efficiency: wheel.drive.gear_efficiency,
        })
    }

    /// Returns the difference between the ground's force along the roller's axis and the hub's
    /// push, and the ground's force across, in N: what turns the roller under a load, while the hub
    /// accelerates by `hub_rate_rad_s2`.
    pub fn beside_push(
        &self,
        moving: &Moving,
        nu_rate: Vector3<f64>,
        hub_rate_rad_s2: f64,
        load_n: f64,
    ) -> [f64; 2] {
        let spin = &self.spin;
        let dot = |v: &Vector3<f64>| (spin.roller * v)[0];
        let gained = dot(&nu_rate) + spin.roller_on_axis * hub_rate_rad_s2;
        let inertia_n_m = spin.roller_inertia_kg_m2 * gained;
        let dry_n_m = spin.dry_n_m(load_n) * spin.way(&moving.towards);
        let drag_n_m = spin.roller_damping_n_m_s * dot(&moving.nu) + dry_n_m;
        let across_n = (inertia_n_m + drag_n_m) / self.roller_radius_m;
        let beside_n =
            spin.roller_on_axis / self.lever_m * (self.radius_m * across_n - inertia_n_m);
        [beside_n, across_n]
    }

    /// Returns the torques at the wheel behind its gear for a motor's range, if the wheel turns
    /// towards a rate: less when driving, more when braking.
    pub fn geared(&self, range: TorqueRange, towards: f64) -> TorqueRange {
        let efficiency = self.gear_efficiency;
        let passed = |torque_n_m: f64| {
            if efficiency >= 1.0 || torque_n_m == 0.0 {
                torque_n_m
            } else if torque_n_m * towards >= 0.0 {
                efficiency * torque_n_m
            } else {
                // At an efficiency of a half or less the gear is self-locking: it brakes with any
                // torque.
                torque_n_m / (2.0 - 1.0 / efficiency).max(0.0)
            }
        };
        TorqueRange {
            min_n_m: passed(range.min_n_m),
            max_n_m: passed(range.max_n_m),
        }
    }
}

impl WheelForce {
    /// Returns the pushes that grip and motor allow.
    pub fn range(&self) -> PushRange {
        let [f, g] = self.at_ground_n;
        let offset_n = f - self.push_n;
        let left = self.grip_n * self.grip_n - g * g;
        // Crossed if the force that turns the roller already exceeds the grip.
        let along_n = libm::copysign(libm::sqrt(left.abs()), left);
        self.motor.within(PushRange {
            min_n: -along_n - offset_n,
            max_n: along_n - offset_n,
        })
    }
}

/// Returns a force as a share of its bound; infinite if the bound is zero.
pub(super) fn share_of(force_n: f64, bound_n: f64) -> f64 {
    if force_n <= SLACK_N {
        0.0
    } else if bound_n <= 0.0 {
        f64::INFINITY
    } else {
        force_n / bound_n
    }
}
