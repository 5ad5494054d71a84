//! The figures of a run: what `summary.json` holds.

use ilon_robot::{Twist, wrap_angle};
use serde::{Deserialize, Serialize};

use crate::ledger::Ledger;
use crate::odometry::Drift;
use crate::record::Record;
use crate::slip::WheelSlip;
use crate::trace::{Header, Trace};

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
    #[serde(default)]
    pub position_error_max_m: Option<f64>,
    /// When it was, in seconds.
    #[serde(default)]
    pub position_error_max_at_s: Option<f64>,
    /// Distance from the desired position at the end, in metres.
    pub position_error_final_m: Option<f64>,
    /// Rms heading error over the run, in radians.
    pub heading_error_rms_rad: Option<f64>,
    /// The largest heading error, its magnitude, in radians.
    #[serde(default)]
    pub heading_error_max_rad: Option<f64>,
    /// When it was, in seconds.
    #[serde(default)]
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
    /// The part of the run in which some task gave way, in [0, 1]; `None` without guidance.
    pub saturated_share: Option<f64>,

    /// Mean real twist in the body frame within the window of the means.
    pub twist_mean: Option<Twist>,
    /// Rms deviation of the real twist from its mean within that window: how much an open-loop drive shakes; `None` in
    /// closed loop, where the twist is meant to change.
    pub twist_ripple: Option<Twist>,
    /// Mean of the twist that Indiveri 2009, eq. (7), gives for the real wheel rates.
    pub twist_ideal_mean: Option<Twist>,
    /// Mean of the twist that the contact kinematics gives for the real wheel rates.
    pub twist_contact_mean: Option<Twist>,
    /// Real over ideal, component by component.
    pub twist_ratio_ideal: TwistRatio,
    /// Real over contact kinematics, component by component.
    pub twist_ratio_contact: TwistRatio,

    /// Rms sliding speed of all touching contacts over the run, in m/s.
    pub slip_speed_rms_m_s: Option<f64>,
    /// The largest sliding speed, in m/s.
    pub slip_speed_max_m_s: Option<f64>,
    /// Energy lost to sliding, in J.
    pub slip_energy_j: Option<f64>,
    /// The most grip that any wheel used: the friction force over what the floor can give, in [0, 1] but for rounding.
    #[serde(default)]
    pub friction_used_max: Option<f64>,
    /// The part of the wheels' time that they spent in the air, in [0, 1].
    #[serde(default)]
    pub airborne_share: Option<f64>,
    /// By how much the laws of contact and of dry friction were broken in the worst step, in m/s: the speed at which
    /// something moved that should not.
    #[serde(default)]
    pub contact_residual_max_m_s: Option<f64>,
    /// Distance of dead reckoning by eq. (7) from the truth at the end, per metre travelled.
    pub odometry_drift_m_per_m: Option<f64>,
    /// Heading error of dead reckoning by eq. (7) at the end, per metre travelled, in rad/m, signed.
    pub odometry_drift_rad_per_m: Option<f64>,
    /// The largest peak-to-peak change of any hub's height within the window of the means, in metres.
    pub hub_ripple_m: Option<f64>,

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
    /// The contacts of each wheel.
    pub wheels: Vec<WheelSlip>,
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
pub struct Energy {
    /// Work of all motors.
    pub motor_j: Option<f64>,
    /// Brought by pushes and payloads.
    pub outside_j: Option<f64>,
    /// Gain of kinetic and potential energy.
    pub stored_j: Option<f64>,
    /// Lost to sliding.
    pub slip_j: Option<f64>,
    /// Lost where rollers that come down are brought up to their spin.
    #[serde(default)]
    pub spin_up_j: Option<f64>,
    /// Lost in bearings.
    pub bearing_j: Option<f64>,
    /// Lost where rollers land on the ground and do not bounce.
    pub impact_j: Option<f64>,
    /// What is left: the solver's own loss or gain.
    pub unexplained_j: Option<f64>,
    /// What is left, as a share of the energy turned over: of what motors and pushes put in, or of what was lost,
    /// whichever is more. `None` where less than a millijoule was.
    #[serde(default)]
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
/// Indiveri 2009, eqs. (16)-(17), at every step that has a reference.
pub fn errors(trace: &Trace) -> (Vec<f64>, Vec<f64>) {
    let records = trace.records().iter();
    records
        .filter_map(|record| error(&trace.header, record))
        .unzip()
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
mod tests {
    use super::*;
    use crate::record::{Desired, TaskShare, WheelSample};
    use crate::trace::WheelHeader;
    use ilon_robot::Pose;

    const DT_S: f64 = 0.01;

    /// 10 s of records made from their time; one wheel at (0.3, 0.4), so that the arm is 0.5 m. A robot whose twist is given
    /// moves by it.
    fn run(of_time: impl Fn(f64) -> (Record, WheelSample)) -> Trace {
        let header = Header {
            wheels: vec![WheelHeader {
                position_m: [0.3, 0.4],
                ..WheelHeader::default()
            }],
            task_names: vec!["position".to_owned()],
            physics_dt_s: 0.002,
            control_dt_s: DT_S,
            measure_from_s: 2.0,
            measure_to_s: 8.0,
            ..Header::default()
        };
        let mut trace = Trace::with_capacity(header, 1000);
        let mut pose = Pose::default();
        for step in 0..1000 {
            let t_s = f64::from(step) * DT_S;
            let (mut record, wheel) = of_time(t_s);
            record.t_s = t_s;
            let twist = record.truth.twist_in_body;
            if twist != Twist::default() {
                record.truth.pose = pose;
                pose = pose.moved(twist.scaled(DT_S));
            }
            trace.push(record, &[wheel]);
        }
        trace
    }

    fn summary(of_time: impl Fn(f64) -> (Record, WheelSample)) -> Summary {
        Summary::of(&run(of_time), &Settings::default())
    }

    /// The robot off its reference, which stands at (1 m, 2 m, 0.5 rad), along x and in heading.
    fn tracking(off_x_m: f64, off_rad: f64) -> Record {
        let desired = Pose {
            x_m: 1.0,
            y_m: 2.0,
            heading_rad: 0.5,
        };
        let mut record = Record {
            desired: Some(Desired {
                pose: desired,
                ..Desired::default()
            }),
            ..Record::default()
        };
        record.truth.pose = Pose {
            x_m: desired.x_m + off_x_m,
            heading_rad: desired.heading_rad + off_rad,
            ..desired
        };
        record
    }

    #[test]
    fn the_error_has_converged_from_the_last_time_on_that_it_enters_its_threshold() {
        // exp(-t) m falls below 5 cm at ln 20 = 2.996 s; the heading dips below 3 deg at once, but leaves again until
        // 7 s; the wrap at pi is crossed on the way.
        let heading_rad = |t: f64| if (3.0..7.0).contains(&t) { 6.0 } else { 0.01 };
        let s = summary(|t| (tracking((-t).exp(), heading_rad(t)), WheelSample::default()));
        let entered = s.position_converged_s.unwrap();
        assert!(
            (20.0_f64.ln()..20.0_f64.ln() + DT_S).contains(&entered),
            "{entered}"
        );
        // The times are sums of no more than rounding: within a nanosecond of 7 s.
        assert!((s.heading_converged_s.unwrap() - 7.0).abs() < 1e-9);
        assert!((s.position_error_final_m.unwrap() - (-9.99_f64).exp()).abs() < 1e-12);
        assert!((s.heading_error_final_rad.unwrap() - 0.01).abs() < 1e-15);
        // The mean of exp(-2t) over 1000 steps is a geometric series.
        let q = (-2.0 * DT_S).exp();
        let rms = ((1.0 - q.powi(1000)) / (1.0 - q) / 1000.0).sqrt();
        assert!((s.position_error_rms_m.unwrap() - rms).abs() < 1e-12);

        let trace = run(|t| (tracking((-t).exp(), heading_rad(t)), WheelSample::default()));
        let (errors_m, errors_rad) = errors(&trace);
        assert_eq!((errors_m.len(), errors_rad.len()), (1000, 1000));
        assert_eq!(errors_m.last().copied(), s.position_error_final_m);
        assert_eq!(errors_rad.last().copied(), s.heading_error_final_rad);
    }

    #[test]
    fn an_error_on_its_threshold_is_not_below_it() {
        let trace = run(|_| (tracking(0.5, 0.25), WheelSample::default()));
        let thresholds = |position_threshold_m, heading_threshold_rad| Settings {
            position_threshold_m,
            heading_threshold_rad,
            ..Settings::default()
        };
        // Powers of two: their squares and roots are exact.
        let on = Summary::of(&trace, &thresholds(0.5, 0.25));
        assert_eq!(
            (on.position_converged_s, on.heading_converged_s),
            (None, None)
        );
        let above = Summary::of(&trace, &thresholds(0.5001, 0.2501));
        let start = Some(0.0);
        assert_eq!(
            (above.position_converged_s, above.heading_converged_s),
            (start, start)
        );
    }

    #[test]
    fn the_seen_pose_is_held_against_the_real_one() {
        let s = summary(|_| {
            let mut record = tracking(7.0, 3.0);
            // 3-4-5, and across the cut at pi.
            record.seen_pose = Pose {
                x_m: 8.3,
                y_m: 1.6,
                heading_rad: 3.7 - std::f64::consts::TAU,
            };
            (record, WheelSample::default())
        });
        // Means of equal numbers: a thousand roundings at most.
        assert!((s.seen_position_error_rms_m.unwrap() - 0.5).abs() < 1e-13);
        assert!((s.seen_heading_error_rms_rad.unwrap() - 0.2).abs() < 1e-13);
    }

    #[test]
    fn a_task_gives_way_only_where_it_asks_and_there_is_one() {
        let at_rest = |_| {
            let mut record = Record::default();
            record.tasks[0].weight = 0.0;
            (record, WheelSample::default())
        };
        assert_eq!(summary(at_rest).saturated_share, Some(0.0));
        let mut without = run(at_rest);
        without.header.task_names.clear();
        let s = Summary::of(&without, &Settings::default());
        assert_eq!(s.saturated_share, None);
    }

    #[test]
    fn a_component_is_driven_from_a_hundredth_of_the_speed_at_the_outermost_wheel() {
        // 0.4 rad/s are 0.2 m/s at 0.5 m: 2 mm/s decide.
        let v = Twist::new(0.0021, 0.0019, 0.4);
        let s = summary(|_| {
            let mut record = Record {
                twist_ideal: v,
                ..Record::default()
            };
            record.truth.twist_in_body = v;
            (record, WheelSample::default())
        });
        let TwistRatio { vx, vy, omega } = s.twist_ratio_ideal;
        // 600 roundings of poses of a few units over a way of millimetres.
        assert!((vx.unwrap() - 1.0).abs() < 1e-10 && (omega.unwrap() - 1.0).abs() < 1e-10);
        assert_eq!(vy, None);
    }

    #[test]
    fn an_open_loop_run_shakes_by_its_deviation_from_the_mean() {
        let shaking = |t: f64| {
            let sign = if (t / DT_S).round() % 2.0 == 0.0 {
                1.0
            } else {
                -1.0
            };
            let mut record = Record::default();
            record.truth.twist_in_body =
                Twist::new(0.3 + 0.01 * sign, 0.02 * sign, -0.4 - 0.03 * sign);
            (record, WheelSample::default())
        };
        let mut trace = run(shaking);
        trace.header.open_loop = true;
        let ripple = Summary::of(&trace, &Settings::default())
            .twist_ripple
            .unwrap();
        // As many rows on either side, but 599 ways between them: their mean lies a 599th of the deviation off the middle,
        // which lengthens the root of the squares by half the square of that; and the ways are chords of arcs that bend
        // by 4 mrad, which the mean undoes.
        let is = |is: f64, derived: f64| (is / derived - 1.0).abs() < 0.5 / (598.0 * 598.0);
        assert!(is(ripple.vx_m_s, 0.01));
        assert!(is(ripple.vy_m_s, 0.02));
        assert!(is(ripple.omega_rad_s, 0.03));
        assert_eq!(summary(shaking).twist_ripple, None, "closed loop");
    }

    #[test]
    fn without_a_row_in_the_window_there_is_no_mean_and_without_a_step_no_steps() {
        let mut trace = run(|_| (Record::default(), WheelSample::default()));
        trace.header.measure_from_s = 20.0;
        trace.header.physics_dt_s = 0.0;
        trace.header.open_loop = true;
        let s = Summary::of(&trace, &Settings::default());
        assert_eq!((s.twist_mean, s.twist_ripple, s.steps), (None, None, 0));
        assert_eq!(s.hub_ripple_m, None);
    }

    #[test]
    fn an_error_above_its_threshold_at_the_end_has_not_converged() {
        let s = summary(|t| {
            (
                tracking(if t > 9.9 { 1.0 } else { 0.0 }, 0.0),
                WheelSample::default(),
            )
        });
        assert_eq!(s.position_converged_s, None);
        assert_eq!(s.heading_converged_s, Some(0.0));
    }

    #[test]
    fn without_a_reference_the_errors_are_null_in_json() {
        let s = summary(|_| (Record::default(), WheelSample::default()));
        let json = serde_json::to_value(&s).unwrap();
        for key in [
            "position_error_rms_m",
            "position_error_final_m",
            "heading_error_rms_rad",
            "heading_error_final_rad",
            "position_converged_s",
            "heading_converged_s",
            "odometry_drift_m_per_m",
            "odometry_drift_rad_per_m",
            "slip_speed_rms_m_s",
            "sim_seconds_per_cpu_second",
        ] {
            assert_eq!(json.get(key), Some(&serde_json::Value::Null), "{key}");
        }
        let nothing = serde_json::json!({"vx": null, "vy": null, "omega": null});
        assert_eq!(json["twist_ratio_ideal"], nothing);
        assert_eq!(serde_json::from_value::<Summary>(json).unwrap(), s);
    }

    #[test]
    fn means_leave_out_what_is_outside_their_window() {
        let s = summary(|t| {
            let inside = (1.995..7.995).contains(&t);
            let v = Twist::new(0.0, if inside { 0.3 } else { 77.0 }, 0.002);
            let mut record = Record {
                twist_ideal: v,
                twist_contact: Twist::new(0.0, 0.98 * v.vy_m_s, 0.002),
                ..Record::default()
            };
            record.truth.twist_in_body = Twist::new(1e-4, 0.97 * v.vy_m_s, 0.001);
            (record, WheelSample::default())
        });
        // 600 additions of 0.3: below 1e-13. Poses at 150 m are rounded by 3e-14 m, 600 of them over a way of 1.7 m.
        assert!((s.twist_ideal_mean.unwrap().vy_m_s - 0.3).abs() < 1e-13);
        assert!((s.twist_ratio_ideal.vy.unwrap() - 0.97).abs() < 1e-11);
        assert!((s.twist_ratio_contact.vy.unwrap() - 0.97 / 0.98).abs() < 1e-11);
        // vx is not driven; the yaw rate reaches 0.001 m/s at the wheel, 0.3 % of the speed, below 1 %.
        assert_eq!(
            (s.twist_ratio_ideal.vx, s.twist_ratio_ideal.omega),
            (None, None)
        );
    }

    #[test]
    fn duration_steps_and_extremes_are_those_of_the_run() {
        let s = summary(|t| {
            let wheel = WheelSample {
                target_rad_s: -8.7 * t / 9.99,
                rate_rad_s: -8.7 * t / 9.99 + 0.25,
                torque_n_m: if t == 0.5 { -3.0 } else { 1.0 },
                hub_height_m: 0.05
                    + if t > 8.5 {
                        1.0
                    } else {
                        1e-4 * (10.0 * t).sin()
                    },
                ..WheelSample::default()
            };
            let mut record = Record::default();
            record.tasks[0] = TaskShare {
                asked_rad_s: 1.0,
                weight: if t < 2.495 { 0.5 } else { 1.0 },
                ..TaskShare::default()
            };
            (record, wheel)
        });
        assert!((s.duration_s - 10.0).abs() < 1e-12);
        assert_eq!(s.steps, 5000);
        assert!((s.wheel_rate_command_max_rad_s.unwrap() - 8.7).abs() < 1e-12);
        // A thousand squares of 0.25, each off by a rounding of 8.7.
        assert!((s.wheel_rate_error_rms_rad_s.unwrap() - 0.25).abs() < 1e-14);
        assert_eq!(s.wheel_torque_max_n_m, Some(3.0));
        // A sine of amplitude 0.1 mm; the sampling at 0.1 rad misses its peaks by at most (0.05^2)/2 each.
        assert!((s.hub_ripple_m.unwrap() - 2e-4).abs() < 2e-4 * 0.00125);
        assert_eq!(s.saturated_share, Some(0.25));
    }

    #[test]
    fn the_energy_balance_starts_at_the_first_record() {
        let s = summary(|t| {
            let record = Record {
                motor_energy_j: 10.0 * t,
                slip_energy_j: 2.0 * t,
                bearing_energy_j: 1.0 * t,
                impact_energy_j: 0.25 * t,
                outside_energy_j: 7.0 + 0.5 * t,
                kinetic_energy_j: 3.0 + 4.0 * t,
                potential_energy_j: 2.0 * t,
                ..Record::default()
            };
            (record, WheelSample::default())
        });
        // At 9.99 s.
        assert!((s.energy.stored_j.unwrap() - 59.94).abs() < 1e-12);
        assert!((s.energy.outside_j.unwrap() - 4.995).abs() < 1e-12);
        // 10 + 0.5 - (4 + 2) - 2 - 1 - 0.25 = 1.25 a second.
        assert!((s.energy.unexplained_j.unwrap() - 12.4875).abs() < 1e-12);
        // Of 99.9 J from the motors and 4.995 J from outside; 32.5 J were lost.
        assert!((s.energy.unexplained_share.unwrap() - 12.4875 / 104.895).abs() < 1e-12);
        assert!((s.slip_energy_j.unwrap() - 19.98).abs() < 1e-12);
    }
}
