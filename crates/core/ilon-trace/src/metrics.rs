//! The figures of a run: what `summary.json` holds.

use ilon_robot::{Twist, wrap_angle};
use serde::{Deserialize, Serialize};

use crate::design::Design;
use crate::effect::Effects;
use crate::header::Header;
use crate::ledger::Ledger;
use crate::odometry::Drift;
use crate::record::Record;
use crate::slip::WheelSlip;
use crate::trace::Trace;
use crate::twin::Convergence;

/// Thresholds of the metrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The position has converged where its error stays below this, in metres.
    pub position_threshold_m: f64,
    /// The heading has converged where its error stays below this, in radians.
    pub heading_threshold_rad: f64,
    /// A component of the twist counts as driven, so that a ratio of it makes sense, where its ideal mean is at least
    /// this part of the rms speed; the yaw rate counts at the outermost wheel.
    pub driven_share: f64,
}

impl Default for Settings {
    /// 5 cm, 3 deg, 1 %.
    fn default() -> Self {
        Self {
            position_threshold_m: 0.05,
            heading_threshold_rad: 3.0_f64.to_radians(),
            driven_share: 0.01,
        }
    }
}

/// The figures of a run. A quantity that does not apply is `None`, null in JSON.
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
    /// Simulated seconds per second of one core; not in the trace, so that a run which measured it fills it in.
    pub sim_seconds_per_cpu_second: Option<f64>,
    /// The fingerprint of all recorded signals, see [`crate::trace_hash`].
    pub trace_hash: String,

    /// Rms distance from the desired position over the run, in metres.
    pub position_error_rms_m: Option<f64>,
    /// The largest distance from the desired position, in metres.
    pub position_error_max_m: Option<f64>,
    /// When it was, in seconds.
    pub position_error_max_at_s: Option<f64>,
    /// Distance from the desired position at the end, in metres.
    pub position_error_final_m: Option<f64>,
    /// Rms heading error over the run, in radians.
    pub heading_error_rms_rad: Option<f64>,
    /// The largest heading error, its magnitude, in radians.
    pub heading_error_max_rad: Option<f64>,
    /// When it was, in seconds.
    pub heading_error_max_at_s: Option<f64>,
    /// Heading error at the end, its magnitude, in radians.
    pub heading_error_final_rad: Option<f64>,
    /// The time from which on the position error stays below its threshold, in seconds.
    pub position_converged_s: Option<f64>,
    /// The time from which on the heading error stays below its threshold, in seconds.
    pub heading_converged_s: Option<f64>,

    /// Rms distance of the pose that the robot takes for its own from the real one, in metres.
    pub seen_position_error_rms_m: Option<f64>,
    /// Rms difference of the heading that the robot takes for its own from the real one, in radians.
    pub seen_heading_error_rms_rad: Option<f64>,

    /// Rms difference of commanded and real wheel rate, over all wheels, in rad/s.
    pub wheel_rate_error_rms_rad_s: Option<f64>,
    /// The largest commanded wheel rate of any wheel, its magnitude, in rad/s.
    pub wheel_rate_command_max_rad_s: Option<f64>,
    /// The largest wheel torque of any wheel, its magnitude, in N m.
    pub wheel_torque_max_n_m: Option<f64>,
    /// How much of the wheels' rates belongs to no one motion, over the run: root mean squares of [`Record::rate_conflict_share`] weighted by the
    /// rates' squares, in [0, 1]; `None` where no wheel turned.
    pub rate_conflict_share: Option<f64>,
    /// The part of the run in which a limit on wheel rates took anything of the command, in [0, 1]; `None` where a controller of the caller's commands the wheels.
    pub saturated_share: Option<f64>,

    /// Mean of the twist asked for in the body frame, before any saturation, within the window of the means.
    pub twist_asked_mean: Option<Twist>,
    /// Mean real twist in the body frame within the window of the means.
    pub twist_mean: Option<Twist>,
    /// Rms deviation of the real twist from its mean within that window: how much an open-loop drive shakes; `None` in
    /// closed loop, where the twist is meant to change.
    pub twist_ripple: Option<Twist>,
    /// Mean of the twist that Indiveri 2009, eq. (7), gives for the real wheel rates.
    pub twist_ideal_mean: Option<Twist>,
    /// Mean of the twist that the contact kinematics gives for the real wheel rates.
    pub twist_contact_mean: Option<Twist>,
    /// Real over asked for, component by component.
    #[serde(default)]
    pub twist_ratio_asked: TwistRatio,
    /// Real over ideal, component by component.
    pub twist_ratio_ideal: TwistRatio,
    /// Real over contact kinematics, component by component.
    pub twist_ratio_contact: TwistRatio,

    /// Rms sliding speed of all touching contacts over the run, in m/s.
    pub slip_speed_rms_m_s: Option<f64>,
    /// The largest sliding speed, in m/s.
    pub slip_speed_max_m_s: Option<f64>,
    /// Energy lost to sliding anywhere, in J: under wheels, where the robot's body rubs, and under what it pushes.
    pub slip_energy_j: Option<f64>,
    /// Of that, what was lost under the robot's own wheels, in J.
    pub wheel_slip_energy_j: Option<f64>,
    /// The most grip that any wheel used: the friction force over what the floor can give, in [0, 1] but for rounding.
    pub friction_used_max: Option<f64>,
    /// The part of the wheels' time that they spent in the air, in [0, 1].
    pub airborne_share: Option<f64>,
    /// The share of all that the ground carries of the robot that rests on its chassis and not on its wheels, over the run, in [0, 1].
    pub chassis_load_share: Option<f64>,
    /// By how much the laws of contact and of dry friction were broken in the worst step, in m/s: the speed at which
    /// something moved that should not.
    pub contact_residual_max_m_s: Option<f64>,
    /// The largest rise, beyond what it was supplied with, of the storage function of a passive wheel law, looked at in every physics step,
    /// in J; `None` under any other.
    pub storage_rise_j: Option<f64>,
    /// Distance of dead reckoning by eq. (7) from the truth at the end, per metre travelled.
    pub odometry_drift_m_per_m: Option<f64>,
    /// Heading error of dead reckoning by eq. (7) at the end, per metre travelled, in rad/m, signed.
    pub odometry_drift_rad_per_m: Option<f64>,
    /// How far dead reckoning by eq. (7) is at the end from what it is with the wheels where all joints have them, in metres: what hub motion costs that the
    /// robot does not measure; `None` of a robot without joints between bodies.
    pub odometry_joints_m: Option<f64>,
    /// The largest peak-to-peak change of any hub's height within the window of the means, in metres.
    pub hub_ripple_m: Option<f64>,

    /// Where the body frame's origin was at the last row, along the world's x axis, in metres.
    pub end_x_m: Option<f64>,
    /// The same along the world's y axis, in metres.
    pub end_y_m: Option<f64>,
    /// The heading at the last row, in radians.
    pub end_heading_rad: Option<f64>,
    /// Length of the way travelled, in metres.
    pub travelled_m: f64,
    /// How much the robot turned, back and forth both counted, in radians.
    pub turned_rad: f64,
    /// Dead reckoning by eq. (7) against the truth.
    pub odometry_ideal: Drift,
    /// Dead reckoning by the contact kinematics against the truth.
    pub odometry_contact: Drift,
    /// Where the difference between asked and real motion went.
    pub ledger: Ledger,
    /// Where the motors' work went.
    pub energy: Energy,
    /// How far the figures move at half the step, where the run was repeated at it.
    #[serde(default, skip_serializing_if = "Convergence::is_empty")]
    pub converge: Convergence,
    /// What made a difference to the run and by how much, where it was repeated without it.
    #[serde(default, skip_serializing_if = "Effects::is_empty")]
    pub effects: Effects,
    /// What is known of the robot without a run, where there was none.
    #[serde(default, skip_serializing_if = "Design::is_unknown")]
    pub design: Design,
    /// The contacts of each wheel.
    pub wheels: Vec<WheelSlip>,
    /// How far each joint between bodies moved.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<JointTravel>,
}

/// How far a joint between bodies moved over a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct JointTravel {
    /// Its name.
    pub name: String,
    /// Whether it slides, in metres, or turns, in radians.
    pub slides: bool,
    /// The least position, in m or rad.
    pub least: f64,
    /// The largest.
    pub most: f64,
    /// The part of the run in which it was on a stop, in [0, 1]; `None` where it has none, or that is not known.
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

/// Where the motors' work went, and what came from outside, in J:
/// motor + outside = stored + slip + spin-up + bearing + impact + unexplained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Energy {
    /// Work of all motors.
    pub motor_j: Option<f64>,
    /// Of that, the work done while they drove: what braking took back is not subtracted.
    pub motor_positive_j: Option<f64>,
    /// Brought by pushes and payloads.
    pub outside_j: Option<f64>,
    /// All that was put in: by motors while they drove, by pushes and payloads while they did work, and by the deepest fall. Shares are of this,
    /// as nothing is set off against anything in it.
    pub put_in_j: Option<f64>,
    /// Of that, what pushes and payloads did.
    pub outside_positive_j: Option<f64>,
    /// Of that, what gravity did.
    pub fall_j: Option<f64>,
    /// Gain of kinetic and potential energy.
    pub stored_j: Option<f64>,
    /// Lost to sliding.
    pub slip_j: Option<f64>,
    /// Lost where rollers that come down are brought up to their spin.
    pub spin_up_j: Option<f64>,
    /// Lost in bearings.
    pub bearing_j: Option<f64>,
    /// Lost where rollers land on the ground and do not bounce.
    pub impact_j: Option<f64>,
    /// What is left: the solver's own loss or gain.
    pub unexplained_j: Option<f64>,
    /// What is left, as a share of the energy turned over: of what motors, pushes, payloads and a fall put in, or of what brakes, losses and
    /// stores took out, whichever is more. Nothing is set off against anything. `None` where nothing moved.
    pub unexplained_share: Option<f64>,
}

impl Summary {
    /// The figures of a trace.
    pub fn of(trace: &Trace, settings: &Settings) -> Self {
        let Ok(summary) = Self::of_rows(trace, settings);
        summary
    }
}

/// Distance of the reference point from the desired position in metres and magnitude of the heading error in radians,
/// Indiveri 2009, eqs. (16)-(17); `None` without a reference.
pub fn error(header: &Header, record: &Record) -> Option<(f64, f64)> {
    let desired = record.desired?.pose;
    let truth = header.reference_point_at(record.truth.pose);
    let e_r = desired.position_m() - truth.position_m();
    let e_phi = wrap_angle(desired.heading_rad - truth.heading_rad);
    Some((e_r.norm(), e_phi.abs()))
}

#[cfg(test)]
mod tests;
