//! Anomalies of a readable log, from its rows alone: gaps, counter resets, trackers that jump or
//! freeze.

use std::f64::consts::{PI, TAU};

use ilon_robot::Robot;

use super::series::Log;
use crate::motion::GAP;

/// Kinds of anomaly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AnomalyKind {
    /// Rows are missing.
    Gap,
    /// The recording was cut short.
    Cut,
    /// The unit of time cannot be right.
    TimeUnit,
    /// A wheel's counter was reset.
    Reset,
    /// The tracker lost the robot, or tracked another object.
    Jump,
    /// The tracker repeated a pose while the wheels turned.
    Frozen,
    /// The robot does not move.
    Still,
    /// A unit or a gear ratio cannot be right.
    Unit,
    /// Wheels are swapped or reversed, or the tracker's axes are.
    Wiring,
    /// Wheels have another handedness than stated.
    Hands,
    /// Poses and wheels have different times.
    Delay,
    /// No wiring of the wheels explains the tracked motion.
    Unexplained,
}

/// An anomaly of a log, with its likely cause.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Anomaly {
    /// Its kind.
    pub kind: AnomalyKind,
    /// Whether nothing can be fitted to the log in this state.
    pub is_fatal: bool,
    /// A description of the anomaly.
    pub message: String,
    /// The likely cause, and how to repair it.
    pub help: String,
}

pub(crate) fn anomaly(
    kind: AnomalyKind,
    is_fatal: bool,
    message: String,
    help: impl Into<String>,
) -> Anomaly {
    Anomaly {
        kind,
        is_fatal,
        message,
        help: help.into(),
    }
}

/// Highest plausible wheel rate, in rad/s.
const FASTEST_RAD_S: f64 = 500.0;

/// Returns the anomalies in the rows of a log.
pub fn of_rows(log: &Log, robot: &Robot) -> Vec<Anomaly> {
    let mut anomalies = Vec::new();
    let period_s = log.period_s();
    if !(2e-5..=5.0).contains(&period_s) {
        let (cause, unit) = match period_s > 5.0 {
            true => ("times are in ms or us", "\"ms\""),
            false => ("times are in s", "\"s\""),
        };
        anomalies.push(anomaly(
            AnomalyKind::TimeUnit,
            true,
            format!("its rows are {} s apart", shown(period_s)),
            format!("such times are impossible: {cause}? Then `log.time` has the unit {unit}"),
        ));
        return anomalies;
    }
    if log.is_cut_short {
        anomalies.push(anomaly(
            AnomalyKind::Cut,
            false,
            format!("a file of the bag was cut short, and messages may be missing: it is read up to {:.2} s", log.duration_s()),
            "the recorder was killed, or the disk was full: record again, or fit what there is",
        ));
    }
    gaps(log, period_s, &mut anomalies);
    resets(log, robot, period_s, &mut anomalies);
    tracker(log, robot, &mut anomalies);
    anomalies
}

fn gaps(log: &Log, period_s: f64, anomalies: &mut Vec<Anomaly>) {
    let mut lost_s = 0.0;
    let mut longest = (0.0, 0.0);
    let mut count = 0;
    for pair in log.times_s.windows(2) {
        let step_s = pair[1] - pair[0];
        if step_s > GAP * period_s {
            count += 1;
            lost_s += step_s - period_s;
            if step_s > longest.0 {
                longest = (step_s, pair[0]);
            }
        }
    }
    if count > 0 {
        let share = lost_s / log.duration_s();
        anomalies.push(anomaly(
            AnomalyKind::Gap,
            share > 0.5,
            format!(
                "{count} gap{} in its times, {} s in all; the longest, {} s, after {} s",
                if count == 1 { "" } else { "s" },
                shown(lost_s),
                shown(longest.0),
                shown(longest.1)
            ),
            "rows were lost on the way to the disk or the radio; stretches with a gap are left out",
        ));
    }
}

fn resets(log: &Log, robot: &Robot, period_s: f64, anomalies: &mut Vec<Anomaly>) {
    for (wheel, known) in robot.wheels.iter().enumerate() {
        let steps: Vec<f64> = log
            .angles_rad
            .windows(2)
            .map(|pair| pair[1][wheel] - pair[0][wheel])
            .collect();
        let mut sizes: Vec<f64> = steps.iter().map(|step| step.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        // Nearly all steps are shorter than this.
        let usual = sizes[(sizes.len() - 1) * 95 / 100].max(1e-6);
        let jumps: Vec<usize> = (0..steps.len())
            .filter(|row| {
                let within_s = (log.times_s[row + 1] - log.times_s[*row]).max(period_s);
                steps[*row].abs() > 12.0 * usual * (within_s / period_s).max(1.0)
                    && steps[*row].abs() > 0.5
            })
            .collect();
        let Some(first) = jumps.first().copied() else {
            continue;
        };
        let step = steps[first];
        let to_start =
            log.angles_rad[first + 1][wheel].abs() < 0.02 * log.angles_rad[first][wheel].abs();
        let sizes_alike = jumps
            .iter()
            .all(|row| (steps[*row].abs() - step.abs()).abs() < 0.02 * step.abs());
        let is_turn =
            (step.abs() / TAU - (step.abs() / TAU).round()).abs() * TAU < 3.0 * usual + 0.05;
        let help = if sizes_alike && is_turn && step.abs() < 1.5 * TAU {
            "the angle is counted within one turn: log the counts, or unwrap them".to_owned()
        } else if sizes_alike && jumps.len() > 1 {
            format!(
                "the counter overflows every {} turns: unwrap it before it is logged",
                shown((step - steps[first.saturating_sub(1)]).abs() / TAU)
            )
        } else if to_start {
            "the counter was set to zero there: use the part before or after, `from_s` and `to_s` of the run".to_owned()
        } else {
            "the counter was set anew or overflowed there: use the part before or after, `from_s` and `to_s` of the run"
                .to_owned()
        };
        anomalies.push(anomaly(
            AnomalyKind::Reset,
            true,
            format!(
                "the angle of `{}` jumps by {} rad at {} s{}",
                known.name,
                shown(step),
                shown(log.times_s[first + 1]),
                and_more(jumps.len())
            ),
            help,
        ));
    }
    let fastest = log
        .angles_rad
        .first()
        .zip(log.angles_rad.last())
        .map_or(0.0, |(a, b)| {
            let turned = a.iter().zip(b).map(|(a, b)| (b - a).abs());
            turned.fold(0.0, f64::max) / log.duration_s().max(period_s)
        });
    if fastest > FASTEST_RAD_S && anomalies.is_empty() {
        anomalies.push(anomaly(
            AnomalyKind::Unit,
            true,
            format!("a wheel turns at {} rad/s on the mean", shown(fastest)),
            "no wheel does: angles in ticks or degrees that are stated as radians or turns, or ticks of the motor and not of the wheel",
        ));
    }
    let most = (0..robot.wheels.len())
        .map(|wheel| {
            let angles = log.angles_rad.iter().map(|row| row[wheel]);
            let (low, high) = angles.fold((0.0_f64, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
            high - low
        })
        .fold(0.0, f64::max);
    if most < 0.1 {
        anomalies.push(anomaly(
            AnomalyKind::Still,
            true,
            format!("no wheel turns by more than {} rad", shown(most)),
            "the robot stood still, or angles in turns or revolutions are stated in a smaller unit",
        ));
    }
}

fn tracker(log: &Log, robot: &Robot, anomalies: &mut Vec<Anomaly>) {
    let unseen = log.unseen.iter().filter(|unseen| **unseen).count();
    if unseen > 0 {
        anomalies.push(anomaly(
            AnomalyKind::Gap,
            unseen * 2 > log.len(),
            format!(
                "the tracker did not see the robot in {unseen} of {} rows",
                log.len()
            ),
            match unseen * 2 > log.len() {
                true => format!(
                    "record where the robot is on its way as well{}",
                    log.as_measured(robot)
                ),
                false => "stretches that begin or end there are left out".to_owned(),
            },
        ));
    }
    let steps: Vec<f64> = log
        .poses
        .windows(2)
        .map(|pair| libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]))
        .collect();
    let mut sizes = steps.clone();
    sizes.sort_by(f64::total_cmp);
    let usual = sizes[(sizes.len() - 1) * 95 / 100];
    let jumps: Vec<usize> = (0..steps.len())
        .filter(|row| {
            steps[*row] > 20.0 * usual
                && log.times_s[row + 1] - log.times_s[*row] <= GAP * log.period_s()
        })
        .collect();
    if let Some(first) = jumps.first() {
        anomalies.push(anomaly(
            AnomalyKind::Jump,
            false,
            format!(
                "the pose jumps by {} m between two rows at {} s{}",
                shown(steps[*first]),
                shown(log.times_s[first + 1]),
                and_more(jumps.len())
            ),
            "the tracker lost the robot, or took another for it; such stretches are left out",
        ));
    }
    // The longest time with exactly the same pose while a wheel turned by more than half a turn.
    let mut first = 0;
    let mut frozen: Option<(f64, f64)> = None;
    for row in 1..=log.len() {
        if row < log.len() && log.poses[row] == log.poses[first] {
            continue;
        }
        let last = row - 1;
        let turned = (0..robot.wheels.len())
            .map(|wheel| (log.angles_rad[last][wheel] - log.angles_rad[first][wheel]).abs())
            .fold(0.0, f64::max);
        let for_s = log.times_s[last] - log.times_s[first];
        if turned > PI && frozen.is_none_or(|(longest, _)| for_s > longest) {
            frozen = Some((for_s, log.times_s[first]));
        }
        first = row;
    }
    if let Some((for_s, from_s)) = frozen {
        anomalies.push(anomaly(
            AnomalyKind::Frozen,
            for_s > 0.5 * log.duration_s(),
            format!(
                "the pose is the same for {} s from {} s on, while wheels turn",
                shown(for_s),
                shown(from_s)
            ),
            "the tracker lost the robot and repeated its last pose, or the wheels spun in the air; such stretches are left out",
        ));
    }
}

/// Formats a number with four digits.
pub(crate) fn shown(x: f64) -> String {
    ilon_trace::number(ilon_trace::significant(x, 4))
}

/// The further ones of so many jumps, of which the first is described.
fn and_more(count: usize) -> String {
    match count {
        1 => String::new(),
        _ => format!(", and {} times more", count - 1),
    }
}
