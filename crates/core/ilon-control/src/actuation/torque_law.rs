//! The interface of all laws that turn wheel rates into torques.

use std::fmt::Debug;

use ilon_robot::Robot;
use nalgebra::Vector3;

use super::motor::TorqueRange;

/// A law that turns wheel rates into wheel torques, step by step: one PID per wheel, computed
/// torque, torque by priority, or a user's own law. To restart a law, copy it before its first
/// step.
pub trait TorqueLaw: Debug + Send + Sync {
    /// Computes the torques for a demand, whose period is positive.
    fn step(&mut self, demand: &Demand<'_>);

    /// The torques of the last step, in N m, one per wheel and within the demand's limits.
    fn torques_n_m(&self) -> &[f64];

    /// Steps the law and returns [`Self::torques_n_m`]; without a positive period the torques do
    /// not change.
    fn update(&mut self, demand: &Demand<'_>) -> &[f64] {
        if demand.dt_s > 0.0 {
            self.step(demand);
        }
        self.torques_n_m()
    }

    /// Passes sensor values other than the wheels' rates to the next update. A law that uses rates
    /// only ignores them.
    fn sense(&mut self, _known: &BodySense<'_>) {}

    /// Torques are commanded in place of rates: what the law began in its last update ends here.
    fn pause(&mut self) {}

    /// Updates masses, loads and kinematics to the robot's current pose of its joints between
    /// bodies ([`Robot::posed`]). A law that uses none of them ignores it; a law that cannot be
    /// built in such a pose stays unchanged.
    fn stand(&mut self, _posed: &Robot) {}

    /// Wrenches and torques of a passive law in its last update; `None` for other laws.
    fn passive_effort(&self) -> Option<PassiveEffort<'_>> {
        None
    }

    /// Torques of a law that acts between its updates, one per wheel; empty if the torques are
    /// held.
    fn falling(&self) -> &[FallingTorque] {
        &[]
    }

    /// Shares of the tasks in the last torques; `None` for a law without tasks.
    fn shares(&self) -> Option<TorqueShares> {
        None
    }

    /// A copy in the same state.
    fn boxed(&self) -> Box<dyn TorqueLaw>;
}

/// The inputs of a torque law, one number per wheel each.
#[derive(Clone, Copy, Debug)]
pub struct Demand<'a> {
    /// Target wheel rates, in rad/s.
    pub targets_rad_s: &'a [f64],
    /// Current wheel rates, in rad/s.
    pub rates_rad_s: &'a [f64],
    /// The torques that the motors can give.
    pub limits: &'a [TorqueRange],
    /// The period until the next demand, in seconds; it may vary.
    pub dt_s: f64,
}

impl<'a> Demand<'a> {
    /// A demand from target rates and rates in rad/s, the motors' torque ranges, and a period in
    /// seconds.
    pub fn new(
        targets_rad_s: &'a [f64],
        rates_rad_s: &'a [f64],
        limits: &'a [TorqueRange],
        dt_s: f64,
    ) -> Self {
        Self {
            targets_rad_s,
            rates_rad_s,
            limits,
            dt_s,
        }
    }
}

/// Sensor values of a robot other than its wheels' rates.
#[derive(Clone, Copy, Debug)]
pub struct BodySense<'a> {
    /// The wheels' angles in radians, unwrapped, one per wheel; their zero does not matter.
    pub angles_rad: &'a [f64],
    /// The acceleration of gravity in the body frame, in m/s^2, from an IMU's tilt; `None` without
    /// an IMU.
    pub gravity_in_body_m_s2: Option<Vector3<f64>>,
}

/// Wrenches and torques of a passive law in its last update. A wrench is the force, in N, and the
/// moment, in N m, on the body about the law's reference point, in the body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassiveEffort<'a> {
    /// The wrench of the targets: damping times the target twist, which is the spring K e if the
    /// guidance gives K e / D.
    pub pull: Vector3<f64>,
    /// The whole wrench, within the motors' limits.
    pub wrench: Vector3<f64>,
    /// The part of the wrench that compensates gravity.
    pub against_gravity: Vector3<f64>,
    /// The torques between the wheels, in N m, one per wheel; included in the law's torques.
    pub between_n_m: &'a [f64],
    /// Energy stored in the springs between the wheels, in J.
    pub stored_j: f64,
}

/// A torque that falls as its wheel gains rate, before the motor's limits, which apply at every
/// moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FallingTorque {
    /// Torque at the rate of the update, in N m.
    pub torque_n_m: f64,
    /// Decrease of the torque per rate gained before the next update, in N m s/rad, >= 0.
    pub droop_n_m_s: f64,
    /// Decrease of the torque per acceleration, in N m s^2/rad, >= 0.
    pub per_acceleration_n_m_s2: f64,
}

/// The share of each acceleration task in the last update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorqueShares {
    /// Weight of the linear acceleration, in [0, 1].
    pub position: f64,
    /// Weight of the angular acceleration, in [0, 1].
    pub heading: f64,
    /// The largest use of grip of any wheel, in [0, 1]: push over friction times load. NaN if
    /// friction is infinite.
    pub grip: f64,
}

impl Clone for Box<dyn TorqueLaw> {
    fn clone(&self) -> Self {
        self.as_ref().boxed()
    }
}
