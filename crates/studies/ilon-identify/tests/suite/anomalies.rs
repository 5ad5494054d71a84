//! Reported anomalies of a log, with their numbers: how many, how long, where, and the limit beyond
//! which nothing can be fitted.

use crate::support;

use ilon_identify::Log;
use ilon_identify::delay::shifted;
use ilon_identify::log::anomalies::of_rows;
use ilon_identify::log::{Anomaly, AnomalyKind};
use support::robot;

/// Ten seconds at 100 rows per second, ahead at 0.1 m/s, each wheel at 2 rad/s.
fn steady() -> Log {
    let rows = 0..=1000;
    let at_s = |row: usize| row as f64 * 0.01;
    Log {
        times_s: rows.clone().map(at_s).collect(),
        angles_rad: rows.clone().map(|row| vec![2.0 * at_s(row); 4]).collect(),
        begun_rad: vec![0.0; 4],
        poses: rows
            .clone()
            .map(|row| [0.1 * at_s(row), 0.0, 0.0])
            .collect(),
        currents_a: rows.clone().map(|row| vec![0.3 * at_s(row); 4]).collect(),
        unseen: rows.map(|_| false).collect(),
        ..Log::default()
    }
}

/// The log without the rows strictly between two.
fn without(mut log: Log, from: usize, to: usize) -> Log {
    let gone = from + 1..to;
    log.times_s.drain(gone.clone());
    log.angles_rad.drain(gone.clone());
    log.poses.drain(gone.clone());
    log.currents_a.drain(gone.clone());
    log.unseen.drain(gone);
    log
}

fn doubts(log: &Log) -> Vec<Anomaly> {
    of_rows(log, &robot("mecanum4.toml"))
}

/// The only doubt.
fn doubt(log: &Log) -> (AnomalyKind, bool, String) {
    let found = doubts(log);
    let [only] = &found[..] else {
        panic!("{found:?}");
    };
    (only.kind, only.is_fatal, only.message.clone())
}

#[test]
fn a_steady_log_is_not_doubted() {
    assert_eq!(doubts(&steady()), []);
}

#[test]
fn a_recording_that_was_cut_short_is_said() {
    let mut log = steady();
    log.is_cut_short = true;
    let (kind, is_fatal, said) = doubt(&log);
    assert_eq!((kind, is_fatal), (AnomalyKind::Cut, false));
    assert!(said.contains("read up to 10.00 s"), "{said}");
}

#[test]
fn gaps_are_counted_summed_and_placed() {
    let (kind, is_fatal, said) = doubt(&without(steady(), 200, 205));
    assert_eq!((kind, is_fatal), (AnomalyKind::Gap, false));
    // Five periods instead of one.
    assert_eq!(
        said,
        "1 gap in its times, 0.04 s in all; the longest, 0.05 s, after 2 s"
    );
    let two = without(without(steady(), 500, 511), 200, 205);
    let said = doubt(&two).2;
    assert_eq!(
        said,
        "2 gaps in its times, 0.14 s in all; the longest, 0.11 s, after 5 s"
    );
    // Three periods are jitter, four are a gap.
    assert_eq!(doubts(&without(steady(), 200, 203)), []);
    assert_eq!(doubt(&without(steady(), 200, 204)).0, AnomalyKind::Gap);
    // Up to half of ten seconds may be missing: 4.99 s, 5.01 s.
    assert!(!doubt(&without(steady(), 200, 700)).1);
    assert!(doubt(&without(steady(), 200, 702)).1);
}

#[test]
fn periods_that_no_logger_has_are_units_of_time() {
    let at = |factor: f64| {
        let mut log = steady();
        log.times_s.iter_mut().for_each(|t_s| *t_s *= factor);
        doubts(&log)
    };
    let [slow, fast] = [&at(501.0)[..], &at(1e-3)[..]].map(|found| match found {
        [only] if only.kind == AnomalyKind::TimeUnit && only.is_fatal => only.clone(),
        other => panic!("{other:?}"),
    });
    assert_eq!(slow.message, "its rows are 5.01 s apart");
    assert!(slow.help.contains("\"ms\""));
    assert_eq!(fast.message, "its rows are 1e-5 s apart");
    assert!(fast.help.contains("\"s\""));
    // 2e-5 s is accepted, if the wheels turn accordingly slowly.
    let mut quick = steady();
    for (t_s, row) in quick.times_s.iter_mut().zip(&mut quick.angles_rad) {
        *t_s *= 2.1e-3;
        row.iter_mut().for_each(|angle| *angle *= 0.1);
    }
    assert_eq!(doubts(&quick), []);
}

#[test]
fn jumps_of_an_angle_are_measured_and_counted() {
    let jumping = |at: &[usize], by: f64| {
        let mut log = steady();
        for row in at {
            log.angles_rad[*row..]
                .iter_mut()
                .for_each(|row| row[2] += by);
        }
        log
    };
    let (kind, is_fatal, said) = doubt(&jumping(&[300], -20.02));
    assert_eq!((kind, is_fatal), (AnomalyKind::Reset, true));
    assert_eq!(said, "the angle of `rear_left` jumps by -20 rad at 3 s");
    let said = doubt(&jumping(&[300, 400, 450], -20.02)).2;
    assert_eq!(
        said,
        "the angle of `rear_left` jumps by -20 rad at 3 s, and 2 times more"
    );
    // Half a radian within a row is no jump, nor is a value close to the wheel's usual motion.
    assert_eq!(doubts(&jumping(&[300], 0.4)), []);
    // The wheel keeps turning during a gap: 1 s at 2 rad/s.
    assert_eq!(doubt(&without(steady(), 300, 400)).0, AnomalyKind::Gap);
}

#[test]
fn a_fast_wheel_and_one_that_stands_are_doubted_from_their_bounds_on() {
    let turning = |rate_rad_s: f64| {
        let mut log = steady();
        for (row, t_s) in log.angles_rad.iter_mut().zip(&log.times_s) {
            row[1] = rate_rad_s * t_s;
        }
        log
    };
    assert_eq!(doubts(&turning(-499.0)), []);
    let (kind, is_fatal, said) = doubt(&turning(-501.0));
    assert_eq!((kind, is_fatal), (AnomalyKind::Unit, true));
    assert_eq!(said, "a wheel turns at 501 rad/s on the mean");
    let slow = |rad: f64| {
        let mut log = steady();
        for (row, t_s) in log.angles_rad.iter_mut().zip(&log.times_s) {
            *row = vec![0.0, 0.0, -0.1 * rad * t_s, 0.0];
        }
        log
    };
    assert_eq!(doubts(&slow(0.11)), []);
    let (kind, is_fatal, said) = doubt(&slow(0.09));
    assert_eq!((kind, is_fatal), (AnomalyKind::Still, true));
    assert_eq!(said, "no wheel turns by more than 0.09 rad");
}

#[test]
fn what_the_tracker_missed_is_counted_and_ends_the_fit_from_one_half_on() {
    let unseen = |count: usize| {
        let mut log = steady();
        log.unseen[..count].fill(true);
        doubt(&log)
    };
    let said = "the tracker did not see the robot in 500 of 1001 rows".to_owned();
    assert_eq!(unseen(500), (AnomalyKind::Gap, false, said));
    assert!(unseen(501).1);
}

#[test]
fn a_pose_that_jumps_or_stands_is_measured_and_placed() {
    let moved = |at: &[usize]| {
        let mut log = steady();
        for row in at {
            log.poses[*row..].iter_mut().for_each(|pose| {
                pose[0] += 0.299;
                pose[1] += 0.4;
            });
        }
        doubt(&log)
    };
    // 0.3 m and 0.4 m, together with the motion of one row.
    let said = "the pose jumps by 0.5 m between two rows at 7 s".to_owned();
    assert_eq!(moved(&[700]), (AnomalyKind::Jump, false, said));
    assert!(moved(&[700, 800]).2.ends_with(", and 1 times more"));
    let frozen = |from: usize, until: usize| {
        let mut log = steady();
        let at = log.poses[from];
        log.poses[from..=until].fill(at);
        // The missed path is not made up at once.
        let missed_m = 0.1 * (log.times_s[until] - log.times_s[from]);
        log.poses[until + 1..]
            .iter_mut()
            .for_each(|pose| pose[0] -= missed_m);
        log
    };
    // A wheel turns by 4 rad in two seconds.
    let said = "the pose is the same for 2 s from 7 s on, while wheels turn".to_owned();
    assert_eq!(doubt(&frozen(700, 900)), (AnomalyKind::Frozen, false, said));
    // Half a turn takes 1.571 s.
    assert_eq!(doubts(&frozen(700, 857)), []);
    assert_eq!(doubt(&frozen(700, 858)).0, AnomalyKind::Frozen);
    // Half of ten seconds may be frozen.
    assert!(!doubt(&frozen(100, 600)).1);
    assert!(doubt(&frozen(100, 601)).1);
}

/// Each pose is paired with the wheels' state at its time, also between rows; rows without known
/// wheels at that time are unseen.
#[test]
fn a_shift_takes_each_value_from_a_delay_earlier() {
    for tau_s in [0.037, -0.024, 0.05, -0.05] {
        let log = steady();
        let shifted = shifted(&log, tau_s);
        let known = |t_s: f64| (-1e-12..=10.0 + 1e-12).contains(&(t_s - tau_s));
        for (row, t_s) in log.times_s.iter().enumerate() {
            let within_s = (t_s - tau_s).clamp(0.0, 10.0);
            let (angle, current) = (shifted.angles_rad[row][3], shifted.currents_a[row][0]);
            assert!((angle - 2.0 * within_s).abs() < 1e-12, "{row}: {angle}");
            assert!((current - 0.3 * within_s).abs() < 1e-12, "{row}: {current}");
        }
        // If the rows' times are whole multiples of the delay, rounding decides at the ends: one
        // row each.
        let unseen = shifted.unseen.iter().filter(|unseen| **unseen).count();
        let expected = log.times_s.iter().filter(|t_s| !known(**t_s)).count();
        assert!(
            unseen.abs_diff(expected) <= 1,
            "{tau_s}: {unseen} {expected}"
        );
        assert_eq!(
            (&shifted.poses, &shifted.times_s),
            (&log.poses, &log.times_s)
        );
    }
    // Rows 200 and 300 have a gap of 1 s between them: 0.5 s later no row has known neighbours.
    let gap = without(steady(), 200, 300);
    let shifted = shifted(&gap, 0.5);
    for (row, t_s) in gap.times_s.iter().enumerate() {
        let in_gap = (2.005..2.995).contains(&(t_s - 0.5));
        let before = *t_s < 0.495;
        let known = *t_s > 0.505 && !(1.995..3.005).contains(&(t_s - 0.5));
        assert!(!(in_gap || before) || shifted.unseen[row], "{t_s}");
        assert!(!known || !shifted.unseen[row], "{t_s}");
    }
}
