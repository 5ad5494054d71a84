//! What the laws that turn wheel rates into torques have in common.

use std::fmt::Debug;

use ilon_robot::Robot;
use nalgebra::Vector3;

use super::motor::TorqueRange;

/// A law that turns wheel rates into wheel torques, step by step: one PID a wheel, computed torque,
/// torque by priority, or one of a person's own. A copy that has not run is how to begin anew.
pub trait TorqueLaw: Debug + Send + Sync {
    /// Finds the torques that a demand asks for, whose period is positive.
    fn step(&mut self, demand: &Demand<'_>);

    /// The torques that were found last, in N m, one a wheel and within the demand's limits.
    fn torques_n_m(&self) -> &[f64];

    /// [`Self::torques_n_m`] for a demand; without a positive period they stay as they were.
    fn update(&mut self, demand: &Demand<'_>) -> &[f64] {
        if demand.dt_s > 0.0 {
            self.step(demand);
        }
        self.torques_n_m()
    }

    /// What the robot knows beside its wheels' rates, for the next update. A law that goes by rates
    /// alone leaves it unread.
    fn sense(&mut self, _known: &BodySense<'_>) {}

    /// Takes up the robot as it stands now, with its joints between bodies counted from where they
    /// are ([`Robot::posed`]), for the next updates: its masses, loads and kinematics. A law that
    /// goes by none of them leaves it unread, and one that cannot be had in such a pose stays as it
    /// was.
    fn stand(&mut self, _posed: &Robot) {}

    /// What a passive law did in its last update; `None` of any other.
    fn passive_effort(&self) -> Option<PassiveEffort<'_>> {
        None
    }

    /// What a law that acts between its updates asks for, one a wheel; empty of a law whose torques
    /// are held.
    fn falling(&self) -> &[FallingTorque] {
        &[]
    }

    /// How much of each task the last torques gave; `None` of a law that weighs none.
    fn shares(&self) -> Option<TorqueShares> {
        None
    }

    /// A copy in the same state.
    fn boxed(&self) -> Box<dyn TorqueLaw>;
}

/// What a torque law is asked for, one number a wheel each.
#[derive(Clone, Copy, Debug)]
pub struct Demand<'a> {
    /// Rates that the wheels shall have, in rad/s.
    pub targets_rad_s: &'a [f64],
    /// Rates that they have, in rad/s.
    pub rates_rad_s: &'a [f64],
    /// What the motors can give.
    pub limits: &'a [TorqueRange],
    /// The period until the next demand, in seconds; it may change from one to the next.
    pub dt_s: f64,
}

impl<'a> Demand<'a> {
    /// Target rates and rates in rad/s, what the motors can give, and a period in seconds.
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

/// What a robot knows beside its wheels' rates.
#[derive(Clone, Copy, Debug)]
pub struct BodySense<'a> {
    /// The wheels' angles in radians, unwrapped, one a wheel; from where they count does not
    /// matter.
    pub angles_rad: &'a [f64],
    /// The acceleration of gravity in the body frame, in m/s^2, as an IMU's tilt gives it; `None`
    /// without an IMU.
    pub gravity_in_body_m_s2: Option<Vector3<f64>>,
}

/// What a passive law did in its last update. Wrenches are the force, in N, and the moment, in N m,
/// on the body about the law's reference point, in the body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassiveEffort<'a> {
    /// What the targets pull with: damping times the target twist, which is the spring K e where
    /// the guidance gives K e / D.
    pub pull: Vector3<f64>,
    /// The whole wrench, within what the motors can give.
    pub wrench: Vector3<f64>,
    /// The part of it that holds gravity off.
    pub against_gravity: Vector3<f64>,
    /// The torques between the wheels, in N m, one a wheel: they are a part of the law's.
    pub between_n_m: &'a [f64],
    /// Energy stored in the springs between the wheels, in J.
    pub stored_j: f64,
}

/// A torque that falls as its wheel gains rate, before the motor's limits, which hold it at every
/// moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FallingTorque {
    /// At the rate of the update, in N m.
    pub torque_n_m: f64,
    /// By how much it falls per rate that the wheel gains before the next update, in N m s/rad, >=
    /// 0.
    pub droop_n_m_s: f64,
}

/// How much of each acceleration task was given in the last update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorqueShares {
    /// Weight of the linear acceleration, in [0, 1].
    pub position: f64,
    /// Weight of the angular acceleration, in [0, 1].
    pub heading: f64,
    /// The worst use of grip of any wheel, in [0, 1]: its push over friction times load. Not a
    /// number where friction is infinite.
    pub grip: f64,
}

impl Clone for Box<dyn TorqueLaw> {
    fn clone(&self) -> Self {
        self.as_ref().boxed()
    }
}
