//! The figures of a run: the content of `summary.json`.

use ilon_robot::Twist;
use serde::{Deserialize, Serialize};

use crate::design::Design;
use crate::effect::Effects;
use crate::ledger::Ledger;
use crate::odometry::Drift;
use crate::twin::Convergence;

/// Thresholds of the metrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The position has converged when its error stays below this, in metres.
    pub position_threshold_m: f64,
    /// The heading has converged when its error stays below this, in radians.
    pub heading_threshold_rad: f64,
    /// A component of the twist counts as driven, so that its ratio is meaningful, if its ideal
    /// mean is at least this share of the rms speed; the yaw rate counts at the outermost wheel.
    pub driven_share: f64,
}

impl Default for Settings {
    /// 5 cm, 3 deg, 1 %. Chosen.
    fn default() -> Self {
        Self {
            position_threshold_m: 0.05,
            heading_threshold_rad: 3.0_f64.to_radians(),
            driven_share: 0.01,
        }
    }
}

/// The figures of a run. A figure that does not apply is `None`, null in JSON.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Summary {
    /// The scenario's name.
    pub scenario: String,
    /// The robot's name.
    pub robot: String,
    /// Simulated time, in seconds.
    pub duration_s: f64,
    /// Number of physics steps.
    pub steps: u64,
    /// The physics step, in seconds.
    pub physics_dt_s: f64,
    /// The control period, in seconds.
    pub control_dt_s: f64,
    /// Simulated seconds per second of one core; not in the trace, so the run that measured it
    /// fills it in.
    pub sim_seconds_per_cpu_second: Option<f64>,
    /// The fingerprint of all recorded signals, see [`crate::trace_hash`].
    pub trace_hash: String,

    /// Rms distance from the desired position over the run, in metres.
    pub position_error_rms_m: Option<f64>,
    /// Largest distance from the desired position, in metres.
    pub position_error_max_m: Option<f64>,
    /// Time of that, in seconds.
    pub position_error_max_at_s: Option<f64>,
    /// Distance from the desired position at the end, in metres.
    pub position_error_final_m: Option<f64>,
    /// Rms heading error over the run, in radians.
    pub heading_error_rms_rad: Option<f64>,
    /// Largest magnitude of the heading error, in radians.
    pub heading_error_max_rad: Option<f64>,
    /// Time of that, in seconds.
    pub heading_error_max_at_s: Option<f64>,
    /// Magnitude of the heading error at the end, in radians.
    pub heading_error_final_rad: Option<f64>,
    /// Time from which on the position error stays below its threshold, in seconds.
    pub position_converged_s: Option<f64>,
    /// Time from which on the heading error stays below its threshold, in seconds.
    pub heading_converged_s: Option<f64>,

    /// Rms distance between the pose that the robot sees and the real one, in metres.
    pub seen_position_error_rms_m: Option<f64>,
    /// Rms difference between the heading that the robot sees and the real one, in radians.
    pub seen_heading_error_rms_rad: Option<f64>,

    /// Rms difference of the commanded wheel rate in force and the real one, over time and all
    /// wheels, in rad/s.
    pub wheel_rate_error_rms_rad_s: Option<f64>,
    /// Largest magnitude of a commanded rate of any wheel, in rad/s.
    pub wheel_rate_command_max_rad_s: Option<f64>,
    /// Largest magnitude of a torque of any wheel, in N m.
    pub wheel_torque_max_n_m: Option<f64>,
    /// How much of the wheels' rates belongs to no one motion, over the run: root mean squares of
    /// [`crate::Record::rate_conflict_share`] weighted by the rates' squares, in [0, 1]; `None`
    /// where no wheel turned.
    pub rate_conflict_share: Option<f64>,
    /// The part of the run in which a limit on wheel rates took anything of the command, in [0, 1];
    /// `None` where a controller of the caller's commands the wheels.
    pub saturated_share: Option<f64>,

    /// Mean of the commanded twist in the body frame, before saturation, within the window of the
    /// means.
    pub twist_asked_mean: Option<Twist>,
    /// Mean real twist in the body frame within the window of the means.
    pub twist_mean: Option<Twist>,
    /// Rms deviation of the real twist from its mean within that window, the ripple of an open-loop
    /// drive; `None` in closed loop, where the twist is meant to change.
    pub twist_ripple: Option<Twist>,
    /// Mean of the twist that Indiveri 2009, eq. (7), gives for the real wheel rates.
    pub twist_ideal_mean: Option<Twist>,
    /// Mean of the twist that the contact kinematics gives for the real wheel rates.
    pub twist_contact_mean: Option<Twist>,
    /// Real over commanded, per component.
    #[serde(default)]
    pub twist_ratio_asked: TwistRatio,
    /// Real over ideal, per component.
    pub twist_ratio_ideal: TwistRatio,
    /// Real over contact kinematics, per component.
    pub twist_ratio_contact: TwistRatio,

    /// Rms sliding speed of all touching contacts over the run, in m/s.
    pub slip_speed_rms_m_s: Option<f64>,
    /// Largest sliding speed, in m/s.
    pub slip_speed_max_m_s: Option<f64>,
    /// Energy lost to sliding, in J: under wheels, at the robot's body, and under bodies that it
    /// pushes.
    pub slip_energy_j: Option<f64>,
    /// The part of that lost under the robot's own wheels, in J.
    pub wheel_slip_energy_j: Option<f64>,
    /// Largest grip utilisation of any wheel: friction force over its limit, in [0, 1] except for
    /// rounding.
    pub friction_used_max: Option<f64>,
    /// Share of the wheels' time spent in the air, in [0, 1].
    pub airborne_share: Option<f64>,
    /// Share of the robot's load on the ground that rests on its chassis instead of its wheels,
    /// over the run, in [0, 1].
    pub chassis_load_share: Option<f64>,
    /// Largest residual of the contact and dry friction laws in any step, in m/s: the speed of a
    /// motion that the laws forbid.
    pub contact_residual_max_m_s: Option<f64>,
    /// Largest rise of a passive wheel law's storage function beyond its supply, checked in every
    /// physics step, in J; `None` under other laws.
    pub storage_rise_j: Option<f64>,
    /// Final distance of dead reckoning by eq. (7) from the truth, per metre travelled.
    pub odometry_drift_m_per_m: Option<f64>,
    /// Final heading error of dead reckoning by eq. (7), per metre travelled, in rad/m, signed.
    pub odometry_drift_rad_per_m: Option<f64>,
    /// Final distance of dead reckoning by eq. (7) from the same with the wheels at their places
    /// under all joints, in metres: the cost of hub motion that the robot does not measure; `None`
    /// without joints between bodies.
    pub odometry_joints_m: Option<f64>,
    /// Largest peak-to-peak change of a hub's height within the window of the means, in metres.
    pub hub_ripple_m: Option<f64>,

    /// World x of the body frame's origin at the last row, in metres.
    pub end_x_m: Option<f64>,
    /// World y of the same, in metres.
    pub end_y_m: Option<f64>,
    /// Heading at the last row, in radians.
    pub end_heading_rad: Option<f64>,
    /// Path length, in metres.
    pub travelled_m: f64,
    /// Sum of all rotations in both directions, in radians.
    pub turned_rad: f64,
    /// Drift of dead reckoning by eq. (7).
    pub odometry_ideal: Drift,
    /// Drift of dead reckoning by contact kinematics.
    pub odometry_contact: Drift,
    /// The error budget: commanded minus real motion, by causes.
    pub ledger: Ledger,
    /// The energy balance.
    pub energy: Energy,
    /// Change of the figures at half the step, if the run was repeated at it.
    #[serde(default, skip_serializing_if = "Convergence::is_empty")]
    pub converge: Convergence,
    /// Effects of the causes, if the run was repeated without them.
    #[serde(default, skip_serializing_if = "Effects::is_empty")]
    pub effects: Effects,
    /// Figures of the robot that need no run; only without a run.
    #[serde(default, skip_serializing_if = "Design::is_unknown")]
    pub design: Design,
    /// Sliding of each wheel's contacts.
    pub wheels: Vec<WheelSlip>,
    /// Travel of each joint between bodies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<JointTravel>,
}

/// What the contacts of one wheel did over the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct WheelSlip {
    /// The wheel's name.
    pub name: String,
    /// Root mean square of the sliding speed over the time in which the wheel touched, in m/s.
    pub speed_rms_m_s: Option<f64>,
    /// The largest sliding speed of any physics step, in m/s.
    pub speed_max_m_s: Option<f64>,
    /// Slip ratio: rms sliding speed over rms rim speed |rho q'|; `None` where the wheel stood
    /// still.
    pub ratio: Option<f64>,
    /// Energy lost to sliding in this wheel's contacts, in J.
    pub energy_j: f64,
    /// Energy that it took to bring this wheel's rollers up to their spin, in J.
    #[serde(default)]
    pub spin_up_energy_j: f64,
    /// Root mean square of the residual of Indiveri 2009, eq. (5), with the nominal roller
    /// direction, in m/s; `None` of a steered wheel.
    pub constraint_residual_rms_m_s: Option<f64>,
    /// Mean normal force over time, in N.
    pub normal_force_mean_n: Option<f64>,
    /// The largest share of the friction cone in use in any physics step; 1 is sliding.
    pub friction_used_max: Option<f64>,
    /// How often another roller came to carry the wheel.
    #[serde(default)]
    pub hand_overs: u64,
    /// Root mean square of the carrying roller's spin against that of rolling without sliding, in
    /// rad/s.
    pub roller_spin_error_rms_rad_s: Option<f64>,
    /// The part of the time in which no roller touched, in [0, 1].
    pub lost_contact: Option<f64>,
    /// The part of the time in which two rollers shared the load, in [0, 1].
    pub shared_contact: Option<f64>,
    /// Peak-to-peak change of the hub's height within the window of the means, in metres.
    pub hub_ripple_m: Option<f64>,
}

/// The travel of a joint between bodies over a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct JointTravel {
    /// Its name.
    pub name: String,
    /// Whether it is prismatic (metres) instead of revolute (radians).
    pub slides: bool,
    /// Smallest position, in m or rad.
    pub least: f64,
    /// Largest position, in m or rad.
    pub most: f64,
    /// Share of the run on a stop, in [0, 1]; `None` without stops, or if unknown.
    pub on_stop: Option<f64>,
}

/// Real over modelled twist; `None` for a component that is not driven.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistRatio {
    /// Of the velocity along x.
    pub vx: Option<f64>,
    /// Of the velocity along y.
    pub vy: Option<f64>,
    /// Of the yaw rate.
    pub omega: Option<f64>,
}

/// The energy balance in J: motor + outside = stored + slip + spin-up + bearing + impact +
/// unexplained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Energy {
    /// Work of all motors.
    pub motor_j: Option<f64>,
    /// The part of that done while they drove, without subtracting braking.
    pub motor_positive_j: Option<f64>,
    /// Work of pushes and payloads.
    pub outside_j: Option<f64>,
    /// All energy put in: by motors while they drove, by pushes and payloads while they did work,
    /// and by the deepest fall. It is the denominator of shares, because nothing in it is offset.
    pub put_in_j: Option<f64>,
    /// The part of that from pushes and payloads.
    pub outside_positive_j: Option<f64>,
    /// The part of that from gravity.
    pub fall_j: Option<f64>,
    /// Gain of kinetic and potential energy.
    pub stored_j: Option<f64>,
    /// Lost to sliding.
    pub slip_j: Option<f64>,
    /// Lost when rollers that touch down are brought to their spin.
    pub spin_up_j: Option<f64>,
    /// Lost in bearings.
    pub bearing_j: Option<f64>,
    /// Lost in inelastic impacts of rollers on the ground.
    pub impact_j: Option<f64>,
    /// The remainder: gain or loss by the solver.
    pub unexplained_j: Option<f64>,
    /// The remainder as a share of the energy turned over: of what motors, pushes, payloads and a
    /// fall put in, or of what brakes, losses and stores took out, whichever is larger. Nothing is
    /// offset. `None` if nothing moved.
    pub unexplained_share: Option<f64>,
}

#[cfg(test)]
mod tests;
