//! The delay of the tracker's poses behind the wheels' angles, from two clocks or from the
//! tracker's latency.
//!
//! The wheels are shifted by tau, and the body's displacements over short windows are fitted by a
//! map with one gain per axis, the tracked point and the tracker's heading. The residual is
//! smallest at the delay. Near its minimum it is a parabola in tau, also for each window: the
//! scatter of the windows' slopes there gives the uncertainty of the delay.

use nalgebra::{DMatrix, DVector, Matrix3xX};

use crate::log::Log;
use crate::motion::{GAP, Window, windows};
use crate::scatter::{Interval, Scatter};

/// Longest delay searched for, in seconds.
const LONGEST_S: f64 = 0.5;
/// Step of the first search, in seconds: robots do not change their rates faster.
const APART_S: f64 = 0.02;
/// Length of a window, in seconds: shorter ones determine a delay better, but with more noise.
const WINDOW_S: f64 = 0.5;
/// A delay is accepted only if it reduces the residual to this share or less.
const LEFT: f64 = 0.8;
/// Required reduction, in units of an equation's squared residual: five standard deviations,
/// because the best of many delays was chosen.
const CLEARLY: f64 = 25.0;
/// Gains ahead, sideways and of rotation, the tracker's heading, and its point.
const VALUES: usize = 6;

/// A delay of a series of runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// Delay of the poses behind the wheels, in seconds.
    pub value_s: f64,
    /// Its 95 % interval.
    pub interval: Interval,
    /// Whether the logs show it: its interval excludes 0, and without it the residual is a quarter
    /// larger, and significantly so.
    pub is_shown: bool,
}

/// Returns the delay of logs that share it, for a robot whose map from wheel rates to twists is
/// known up to gains; `None` if the logs are too short or too steady.
pub fn of(logs: &[&Log], twist_matrix: &Matrix3xX<f64>, lever_m: f64) -> Option<Delay> {
    let left = |tau_s: f64| -> Option<Vec<f64>> {
        let mut all = Vec::new();
        for log in logs {
            // The same windows at every delay: rows that the longest delay would push over an end
            // are in none.
            let inner = shifted(log, tau_s).part(LONGEST_S, log.duration_s() - LONGEST_S);
            all.extend(windows(&inner, 0, WINDOW_S));
        }
        left_of(&all, twist_matrix, lever_m)
    };
    let sum = |left: &[f64]| left.iter().sum::<f64>();
    let steps = (LONGEST_S / APART_S) as i32;
    let at_none = sum(&left(0.0)?);
    let tried = (-steps..=steps).filter_map(|step| {
        let tau_s = f64::from(step) * APART_S;
        Some((tau_s, sum(&left(tau_s)?)))
    });
    let (mut value_s, _) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
    if value_s.abs() > LONGEST_S - 1.5 * APART_S {
        return None;
    }
    // Parabolas through three points, each narrower than the one before.
    let mut parts: Option<[Vec<f64>; 3]> = None;
    let mut half_s = APART_S;
    for _ in 0..3 {
        let around = [
            left(value_s - half_s)?,
            left(value_s)?,
            left(value_s + half_s)?,
        ];
        let sums = [0, 1, 2].map(|at| sum(&around[at]));
        value_s += least_of(sums)?.clamp(-1.0, 1.0) * half_s;
        parts = Some(around);
        half_s *= 0.5;
    }
    let around = parts?;
    half_s *= 2.0;
    let count = around.iter().map(Vec::len).min()?;
    if around.iter().any(|part| part.len() != count) || count < 8 {
        return None;
    }
    let [mut slopes, mut bends, mut told] = [0.0; 3];
    for ((before, at), after) in around[0].iter().zip(&around[1]).zip(&around[2]) {
        slopes += (0.5 * (after - before)).powi(2);
        let bend = before - 2.0 * at + after;
        bends += bend;
        told += bend * bend;
    }
    // Effective number of windows, since steady ones do not determine a delay: as many equally
    // informative windows as would give this information.
    let freedoms = (bends * bends / told - 1.0).max(1.0);
    let half_width_s = Scatter::furthest(freedoms) * slopes.sqrt() / bends * half_s;
    if !(bends > 0.0 && half_width_s.is_finite()) {
        return None;
    }
    let at_least = sum(&left(value_s)?);
    let spare = (3.0 * count as f64 - VALUES as f64 - 1.0).max(1.0);
    Some(Delay {
        value_s,
        interval: Interval::around(value_s, half_width_s),
        is_shown: value_s.abs() > half_width_s
            && at_least < LEFT * at_none
            && at_none - at_least > CLEARLY * at_least / spare,
    })
}

/// Returns the position of the minimum of the parabola through values at -1, 0 and 1; `None` if it
/// has none.
fn least_of([before, at, after]: [f64; 3]) -> Option<f64> {
    let bend = before - 2.0 * at + after;
    (bend > 0.0).then(|| 0.5 * (before - after) / bend)
}

/// Returns the squared residual of each window after a fit of a map with gains, in m^2.
fn left_of(windows: &[Window], matrix: &Matrix3xX<f64>, lever_m: f64) -> Option<Vec<f64>> {
    if windows.len() < VALUES {
        return None;
    }
    let mut equations = DMatrix::zeros(3 * windows.len(), VALUES);
    let mut seen = DVector::zeros(3 * windows.len());
    for (index, window) in windows.iter().enumerate() {
        let [x, y, turn] = window.of_wheels(matrix);
        let lever = 2.0 * libm::sin(0.5 * window.seen[2]);
        for (axis, row) in [
            [x, 0.0, 0.0, -y, 0.0, -lever],
            [0.0, y, 0.0, x, lever, 0.0],
            [0.0, 0.0, lever_m * turn, 0.0, 0.0, 0.0],
        ]
        .into_iter()
        .enumerate()
        {
            let place = 3 * index + axis;
            (0..VALUES).for_each(|value| equations[(place, value)] = row[value]);
            seen[place] = window.seen[axis] * if axis == 2 { lever_m } else { 1.0 };
        }
    }
    let solved = equations.clone().svd(true, true).solve(&seen, 1e-9).ok()?;
    let rest = seen - equations * solved;
    Some(
        (0..windows.len())
            .map(|index| rest.rows(3 * index, 3).norm_squared())
            .collect(),
    )
}

/// Returns the log with its wheels shifted to an earlier time by a delay, in seconds: each pose
/// then belongs to the angles at which it was measured. Rows whose wheels are then unknown (before
/// the start, after the end or in a gap) count as unseen.
pub fn shifted(log: &Log, tau_s: f64) -> Log {
    if tau_s == 0.0 {
        return log.clone();
    }
    let mut shifted = log.clone();
    let gap_s = GAP * log.period_s();
    for row in 0..log.len() {
        let at_s = log.times_s[row] - tau_s;
        let after = log.times_s.partition_point(|t_s| *t_s < at_s);
        let (before, after) = (
            after.saturating_sub(1),
            after.min(log.len().saturating_sub(1)),
        );
        let apart_s = log.times_s[after] - log.times_s[before];
        let share = if apart_s > 0.0 {
            ((at_s - log.times_s[before]) / apart_s).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let at_time = |column: &[Vec<f64>], into: &mut Vec<f64>| {
            for (wheel, value) in into.iter_mut().enumerate() {
                let (a, b) = (column[before][wheel], column[after][wheel]);
                *value = a + share * (b - a);
            }
        };
        at_time(&log.angles_rad, &mut shifted.angles_rad[row]);
        if !log.currents_a.is_empty() {
            at_time(&log.currents_a, &mut shifted.currents_a[row]);
        }
        let is_inside = at_s >= 0.0 && at_s <= log.duration_s();
        if !is_inside || apart_s > gap_s {
            shifted.unseen[row] = true;
        }
    }
    shifted
}
