use super::*;
use crate::header::{Header, WheelHeader};
use crate::ledger::Chain;
use crate::record::{Desired, Record, Support, TaskShare, WheelSample};
use crate::trace::Trace;
use ilon_robot::Pose;

const DT_S: f64 = 0.01;

/// 10 s of records computed from their time; one wheel at (0.3, 0.4), so that the arm is 0.5 m. If
/// a record has a twist, the robot moves by it.
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
    let mut ledger = Ledger::default();
    for step in 0..1000 {
        let t_s = f64::from(step) * DT_S;
        let (mut record, wheel) = of_time(t_s);
        (record.t_s, record.ledger) = (t_s, ledger);
        let twist = record.truth.twist_in_body;
        if twist != Twist::default() {
            record.truth.pose = pose;
            pose = pose.moved(twist.scaled(DT_S));
        }
        let headings_rad = [record.truth.pose.heading_rad, pose.heading_rad];
        ledger.count(&Chain::held(&record, DT_S), headings_rad);
        trace.push(record, &[wheel]);
    }
    trace
}

fn summary(of_time: impl Fn(f64) -> (Record, WheelSample)) -> Summary {
    Summary::of(&run(of_time), &Settings::default())
}

/// In contact over all of every other period at 10 mm/s, and over a quarter of the others at
/// 40 mm/s: (1 + 16/4) / (1 + 1/4) = 4, of which the root is 2.
#[test]
fn sliding_speeds_count_by_the_time_in_contact() {
    let slides = |(slip_speed_rms_m_s, touching_share)| WheelSample {
        slip_speed_rms_m_s,
        touching: true,
        touching_share,
        ..WheelSample::default()
    };
    let found = summary(|t_s| {
        let is_first = ((t_s / DT_S).round() as u32).is_multiple_of(2);
        let of = if is_first { (0.01, 1.0) } else { (0.04, 0.25) };
        (Record::default(), slides(of))
    });
    let rms_m_s = found.slip_speed_rms_m_s.expect("it touched");
    // A row more of the first kind than of the other, of 600: (4 - 1) / 375 of half of the root.
    assert!((rms_m_s - 0.02).abs() < 3e-5, "{rms_m_s}");
}

/// A robot off its reference, which is at (1 m, 2 m, 0.5 rad), along x and in heading.
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
    // exp(-t) m falls below 5 cm at ln 20 = 2.996 s; the heading error is below 3 deg at first, but
    // exceeds it again until 7 s, and crosses the wrap at pi.
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
    let records = trace.records().iter();
    let (errors_m, errors_rad): (Vec<f64>, Vec<f64>) = records
        .filter_map(|record| trace.header.tracking_error(record))
        .unzip();
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
        // 3-4-5, and across the wrap at pi.
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

/// Of a robot that is asked ahead and whose wheels carry it to the left as well.
#[test]
fn a_component_that_was_not_asked_for_beside_one_that_was_has_no_share() {
    let s = summary(|_| {
        let mut record = Record {
            command_twist_in_body: Twist::new(0.3, 0.0, 0.0),
            twist_ideal: Twist::new(0.3, 0.01, 0.0),
            ..Record::default()
        };
        record.truth.twist_in_body = Twist::new(0.3, 0.0082, 0.0);
        (record, WheelSample::default())
    });
    let TwistRatio { vx, vy, omega } = s.twist_ratio_ideal;
    assert!(vx.is_some());
    assert_eq!((vy, omega), (None, None));
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
        record.truth.twist_in_body = Twist::new(0.3 + 0.01 * sign, 0.02 * sign, -0.4 - 0.03 * sign);
        (record, WheelSample::default())
    };
    let mut trace = run(shaking);
    trace.header.open_loop = true;
    let ripple = Summary::of(&trace, &Settings::default())
        .twist_ripple
        .unwrap();
    // Both halves have as many rows, but there are 599 displacements between them: their mean is a
    // 599th of the deviation off the middle, which increases the rms by half the square of that.
    // The displacements are chords of arcs that bend by 4 mrad, which the mean corrects.
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

/// Half of the rates at all times, as a root mean square.
#[test]
fn a_steady_conflict_of_rates_is_its_own_mean() {
    let summary = summary(|_| {
        let record = Record {
            rate_conflict_share: 0.5,
            ..Record::default()
        };
        let wheel = WheelSample {
            rate_rad_s: 2.0,
            ..WheelSample::default()
        };
        (record, wheel)
    });
    // Sums of a thousand rows.
    assert!((summary.rate_conflict_share.unwrap() - 0.5).abs() < 1e-12);
}

#[test]
fn what_was_asked_for_and_what_the_chassis_carried_are_counted() {
    let s = summary(|t| {
        let mut record = Record {
            command_twist_in_body: Twist::new(0.5, 0.0, 0.0),
            twist_ideal: Twist::new(0.1, 0.0, 0.0),
            support: Some(Support {
                wheels_n: 30.0,
                // Half of the time with as much load as the wheels.
                chassis_n: if t < 5.005 { 30.0 } else { 0.0 },
                ..Support::default()
            }),
            ..Record::default()
        };
        record.truth.twist_in_body = Twist::new(0.1, 0.0, 0.0);
        (record, WheelSample::default())
    });
    // 600 sums of numbers below 1 over poses of a metre.
    assert!((s.twist_asked_mean.unwrap().vx_m_s - 0.5).abs() < 1e-12);
    assert!((s.twist_ratio_asked.vx.unwrap() - 0.2).abs() < 1e-11);
    assert_eq!(
        (s.twist_ratio_asked.vy, s.twist_ratio_asked.omega),
        (None, None)
    );
    // 30 N for 5 s against 30 N for 10 s and 30 N for 5 s: a third, to the row at its edge.
    assert!(
        (s.chassis_load_share.unwrap() - 1.0 / 3.0).abs() < 1e-3,
        "{:?}",
        s.chassis_load_share
    );
    let unknown = summary(|_| (Record::default(), WheelSample::default()));
    assert_eq!(unknown.chassis_load_share, None);
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
    // 600 additions of 0.3: below 1e-13. Poses at 150 m are rounded by 3e-14 m, 600 of them over a
    // way of 1.7 m.
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
        }
        .steady();
        let mut record = Record::default();
        record.tasks[0] = TaskShare {
            asked_rad_s: 1.0,
            weight: if t < 2.495 { 0.5 } else { 1.0 },
            ..TaskShare::default()
        };
        record.saturated_share = if t < 2.495 { 1.0 } else { 0.0 };
        (record, wheel)
    });
    assert!((s.duration_s - 10.0).abs() < 1e-12);
    assert_eq!(s.steps, 5000);
    assert!((s.wheel_rate_command_max_rad_s.unwrap() - 8.7).abs() < 1e-12);
    // A thousand squares of 0.25, each off by a rounding of 8.7.
    assert!((s.wheel_rate_error_rms_rad_s.unwrap() - 0.25).abs() < 1e-14);
    assert_eq!(s.wheel_torque_max_n_m, Some(3.0));
    // A sine of amplitude 0.1 mm; the sampling at 0.1 rad misses its peaks by at most (0.05^2)/2
    // each.
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

#[test]
fn a_share_of_the_energy_is_known_of_robots_of_any_size() {
    // A tenth of the size has a thousandth of the mass and, as fast, a thousandth of the energy.
    let share = |scale: f64, turned_over_j: f64| {
        let mut trace = run(|t| {
            let record = Record {
                motor_energy_j: turned_over_j * t / 9.99,
                slip_energy_j: 0.9 * turned_over_j * t / 9.99,
                ..Record::default()
            };
            (record, WheelSample::default())
        });
        trace.header.mass_kg = 10.0 * scale.powi(3);
        trace.header.wheels[0].radius_m = 0.05 * scale;
        Summary::of(&trace, &Settings::default())
            .energy
            .unexplained_share
    };
    for scale in [10.0, 1.0, 0.1, 0.01] {
        let known = share(scale, 0.01 * scale.powi(3)).unwrap();
        assert!((known - 0.1).abs() < 1e-9, "{scale}: {known}");
        // 10 kg x 9.81 m/s^2 x 0.05 m x 1e-6 = 4.9e-6 J at full size.
        assert_eq!(share(scale, 4e-6 * scale.powi(4)), None, "{scale}");
    }
}

/// The unexplained energy is a share of the energy turned over, not of the net energy: 12 J driven
/// and 11.9 J braked again, a push that gave 2 J and took them back, a fall of 3 J from which the
/// robot was lifted again, a bearing that gave 4 J.
#[test]
fn what_was_put_in_and_taken_out_are_not_set_off_against_each_other() {
    // From 0 to 1 in the first half of the run, and back to `back`.
    let there_and_back = |t: f64, back: f64| {
        let half = 9.99 / 2.0;
        if t < half {
            t / half
        } else {
            1.0 - (1.0 - back) * (t - half) / half
        }
    };
    let share = |signals: fn(&mut Record, f64, f64)| {
        let energy = summary(|t| {
            let mut record = Record::default();
            signals(&mut record, there_and_back(t, 0.0), there_and_back(t, 1.0));
            (record, WheelSample::default())
        })
        .energy;
        (
            energy.unexplained_j.unwrap(),
            energy.unexplained_share.unwrap(),
        )
    };
    // Rows every 10 ms miss the turning point by at most half of a row in 500.
    let close = |(open_j, share): (f64, f64), turned_over_j: f64| {
        assert!(
            (share * turned_over_j / open_j - 1.0).abs() < 2e-3,
            "{open_j} J, {share}"
        );
    };
    close(
        share(|record, back, there| {
            record.motor_positive_energy_j = 12.0 * there;
            record.motor_energy_j = 12.0 * there - 11.9 * (there - back);
            record.bearing_energy_j = 0.09 * there;
        }),
        12.0,
    );
    close(
        share(|record, back, there| {
            record.outside_energy_j = 2.0 * back;
            record.slip_energy_j = 1e-3 * there;
        }),
        2.0,
    );
    close(
        share(|record, back, there| {
            record.potential_energy_j = 5.0 - 3.0 * back;
            record.slip_energy_j = 1e-3 * there;
        }),
        3.0,
    );
    close(
        share(|record, _, there| {
            record.motor_energy_j = -3.9 * there;
            record.bearing_energy_j = -4.0 * there;
        }),
        7.9,
    );
}

#[test]
fn rows_that_are_far_apart_come_to_what_close_ones_do() {
    // Steady: 0.2 m/s ahead, commanded 0.3 m/s. 1000 control periods; the last one is always a row.
    let steady = |t_s: f64| {
        let twist = Twist::new(0.2, 0.0, 0.0);
        let record = Record {
            t_s,
            command_twist_in_body: Twist::new(0.3, 0.0, 0.0),
            twist_ideal: twist,
            ..Record::default()
        };
        (record, WheelSample::default())
    };
    let close = run(|t_s| {
        let (mut record, wheel) = steady(t_s);
        record.truth.twist_in_body = Twist::new(0.2, 0.0, 0.0);
        (record, wheel)
    });
    let expected = Summary::of(&close, &Settings::default());
    for every in [1, 7, 300, 400, 999, 1000, 4000] {
        let header = Header {
            record_every: every,
            control_periods: 1000,
            ..close.header.clone()
        };
        let mut far = Trace::with_capacity(header, 0);
        for (row, (record, wheels)) in close.steps().enumerate() {
            if row % every as usize == 0 || row == 999 {
                far.push(*record, wheels);
            }
        }
        let found = Summary::of(&far, &Settings::default());
        assert_eq!(found.duration_s, 10.0, "{every}");
        assert_eq!((found.steps, found.control_dt_s), (5000, DT_S), "{every}");
        assert!(
            (found.travelled_m - expected.travelled_m).abs() < 1e-12,
            "{every}"
        );
        assert!(
            // 0.1 m/s short up to the last row, at 9.99 s.
            (found.ledger.total.x_m - 0.999).abs() < 1e-9,
            "{every}: {:?}",
            found.ledger.total
        );
        if let Some(mean) = found.twist_mean {
            assert!((mean.vx_m_s - 0.2).abs() < 1e-12, "{every}");
        }
    }
}

/// Each row holds the mean of its control periods: the first of one, at the start, and each of ten
/// others of five.
#[test]
fn a_row_counts_by_the_control_periods_that_it_holds() {
    let whole = run(|t_s| {
        let record = Record {
            saturated_share: if t_s == 0.0 { 1.0 } else { 0.0 },
            ..Record::default()
        };
        (record, WheelSample::default())
    });
    let mut rows = Trace::with_capacity(whole.header.clone(), 11);
    for row in 0..11 {
        rows.append(&whole.rows(5 * row..5 * row + 1));
    }
    let share = Summary::of(&rows, &Settings::default()).saturated_share;
    let share = share.expect("a task");
    assert!((share - 1.0 / 51.0).abs() < 1e-12, "{share}");
}
