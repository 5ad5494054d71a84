//! What the laws that turn wheel rates into torques have in common.

use std::fmt::Debug;

use super::motor::TorqueRange;

/// A law that turns wheel rates into wheel torques, step by step: one PID a wheel, computed torque, torque by priority, or one
/// of a person's own. A copy that has not run is how to begin anew.
pub trait TorqueLaw: Debug + Send + Sync {
    /// Torques in N m, one a wheel and within `limits`, from target and measured rates in rad/s. The period `dt_s`, in seconds,
    /// may change from call to call; without a positive one the torques stay as they were.
    fn update(
        &mut self,
        targets_rad_s: &[f64],
        rates_rad_s: &[f64],
        limits: &[TorqueRange],
        dt_s: f64,
    ) -> &[f64];

    /// What a law that acts between its updates asks for, one a wheel; empty of a law whose torques are held.
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

/// A torque that falls as its wheel gains rate, before the motor's limits, which hold it at every moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FallingTorque {
    /// At the rate of the update, in N m.
    pub torque_n_m: f64,
    /// By how much it falls per rate that the wheel gains before the next update, in N m s/rad, >= 0.
    pub droop_n_m_s: f64,
}

/// How much of each acceleration task was given in the last update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorqueShares {
    /// Weight of the linear acceleration, in [0, 1].
    pub position: f64,
    /// Weight of the angular acceleration, in [0, 1].
    pub heading: f64,
    /// The worst use of grip of any wheel, in [0, 1]: its push over friction times load. Not a number where friction
    /// is infinite.
    pub grip: f64,
}

impl Clone for Box<dyn TorqueLaw> {
    fn clone(&self) -> Self {
        self.as_ref().boxed()
    }
}
