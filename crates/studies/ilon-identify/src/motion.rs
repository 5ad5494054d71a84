//! Converts a log to displacements over short windows, in the body frame.
//!
//! Because the heading is tracked, the displacement of a body whose wheels turn by dq is linear in
//! the map J from wheel rates to twists. With theta_m the heading in the middle of a window, and
//! dq_k the steps of the wheels in it,
//!
//! `R(-theta_m) dp = sum_k R(theta_k - theta_m) J dq_k`,
//!
//! for which J needs only the sums of `cos(theta_k - theta_m) dq_k` and `sin(theta_k - theta_m)
//! dq_k`. The additional displacement of a point away from the body's origin is linear in its
//! position too.

use nalgebra::Matrix3xX;

use crate::log::Log;

/// The displacement over one window of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The run, counted from 0.
    pub run: usize,
    /// Time of its middle, in seconds from the run's start.
    pub at_s: f64,
    /// sum of cos(theta_k - theta_m) dq_k, of each wheel, in radians.
    pub cos_rad: Vec<f64>,
    /// sum of sin(theta_k - theta_m) dq_k, of each wheel, in radians.
    pub sin_rad: Vec<f64>,
    /// sum of dq_k, of each wheel, in radians.
    pub turned_rad: Vec<f64>,
    /// The displacement of the tracked point in the frame of the heading in the middle, in metres,
    /// and the change of heading, in radians.
    pub seen: [f64; 3],
}

/// Position and direction of the tracker on the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tracker {
    /// The tracked point in the body frame, in metres.
    pub point_m: [f64; 2],
    /// Angle of the tracker's heading behind the body's, in radians.
    pub turned_rad: f64,
}

impl Window {
    /// Returns the displacement predicted by this map from wheel rates to twists, in the convention
    /// of [`Self::seen`].
    pub fn predicted(&self, twist_matrix: &Matrix3xX<f64>, tracker: &Tracker) -> [f64; 3] {
        let [x_m, y_m, turn_rad] = self.of_wheels(twist_matrix);
        // (R(h) - R(-h)) o with h half of the rotation.
        let lever = 2.0 * libm::sin(0.5 * self.seen[2]);
        let [o_x, o_y] = tracker.point_m;
        let (x_m, y_m) = (x_m - lever * o_y, y_m + lever * o_x);
        let (s, c) = libm::sincos(tracker.turned_rad);
        [c * x_m - s * y_m, s * x_m + c * y_m, turn_rad]
    }

    /// Returns the displacement of the body's origin by the wheels alone, in the body frame.
    pub fn of_wheels(&self, twist_matrix: &Matrix3xX<f64>) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (wheel, column) in twist_matrix.column_iter().enumerate() {
            let (cos, sin) = (self.cos_rad[wheel], self.sin_rad[wheel]);
            sum[0] += column[0] * cos - column[1] * sin;
            sum[1] += column[0] * sin + column[1] * cos;
            sum[2] += column[2] * self.turned_rad[wheel];
        }
        sum
    }
}

/// Returns the motion of the body for wheel angles or rates.
pub(crate) fn twist_of(twist_matrix: &Matrix3xX<f64>, wheels: &[f64]) -> [f64; 3] {
    let mut twist = [0.0; 3];
    for (column, wheel) in twist_matrix.column_iter().zip(wheels) {
        (0..3).for_each(|axis| twist[axis] += column[axis] * wheel);
    }
    twist
}

/// Returns the largest absolute value.
pub(crate) fn largest_size(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| f64::max(most, x.abs()))
}

/// Returns the windows of a log, each `window_s` long. Windows with a gap of the log or of the
/// tracker, or without motion, are left out.
pub fn windows(log: &Log, run: usize, window_s: f64) -> Vec<Window> {
    let mut windows = Vec::new();
    let gap_s = GAP * log.period_s();
    let mut first = 0;
    while first + 1 < log.len() {
        let end_s = log.times_s[first] + window_s;
        // Half a row may be missing from a window that is a whole number of rows long.
        let last = log
            .times_s
            .partition_point(|t_s| *t_s < end_s - 0.5 * log.period_s());
        if last >= log.len() {
            break;
        }
        let is_whole = (first..last).all(|row| log.times_s[row + 1] - log.times_s[row] <= gap_s);
        let is_seen = !log.unseen[first] && !log.unseen[last];
        if is_whole && is_seen && last > first {
            let window = window(log, run, first, last);
            if window
                .turned_rad
                .iter()
                .any(|turned| turned.abs() > STILL_RAD)
            {
                windows.push(window);
            }
        }
        first = last.max(first + 1);
    }
    windows
}

/// A time between rows above this multiple of the usual one is a gap.
pub(crate) const GAP: f64 = 3.5;

/// Wheels that turn by less than this in a window stand still, in radians.
const STILL_RAD: f64 = 1e-2;

/// Returns the displacement from one row to another.
pub fn window(log: &Log, run: usize, first: usize, last: usize) -> Window {
    let wheels = log.angles_rad[first].len();
    let (from, to) = (log.poses[first], log.poses[last]);
    let middle_rad = 0.5 * (from[2] + to[2]);
    let (mut cos_rad, mut sin_rad) = (vec![0.0; wheels], vec![0.0; wheels]);
    let mut turned_rad = vec![0.0; wheels];
    for row in first..last {
        let heading_rad = 0.5 * (log.poses[row][2] + log.poses[row + 1][2]);
        let (s, c) = libm::sincos(heading_rad - middle_rad);
        for wheel in 0..wheels {
            let step_rad = log.angles_rad[row + 1][wheel] - log.angles_rad[row][wheel];
            cos_rad[wheel] += c * step_rad;
            sin_rad[wheel] += s * step_rad;
            turned_rad[wheel] += step_rad;
        }
    }
    let (s, c) = libm::sincos(middle_rad);
    let (x_m, y_m) = (to[0] - from[0], to[1] - from[1]);
    Window {
        run,
        at_s: 0.5 * (log.times_s[first] + log.times_s[last]),
        cos_rad,
        sin_rad,
        turned_rad,
        seen: [c * x_m + s * y_m, -s * x_m + c * y_m, to[2] - from[2]],
    }
}

/// Returns the pose after each row by dead reckoning with a map from wheel rates to twists, from
/// the pose at the first row, and with the body's own heading.
pub fn reckoned(log: &Log, twist_matrix: &Matrix3xX<f64>, tracker: &Tracker) -> Vec<[f64; 3]> {
    let mut poses = Vec::with_capacity(log.len());
    let Some(seen) = log.poses.first() else {
        return poses;
    };
    let heading_rad = seen[2] + tracker.turned_rad;
    let (s, c) = libm::sincos(heading_rad);
    let [o_x, o_y] = tracker.point_m;
    let mut body = ilon_robot::Pose {
        x_m: seen[0] - c * o_x + s * o_y,
        y_m: seen[1] - s * o_x - c * o_y,
        heading_rad,
    };
    for row in 0..log.len() {
        if row > 0 {
            let pairs = log.angles_rad[row].iter().zip(&log.angles_rad[row - 1]);
            let turned_rad: Vec<f64> = pairs.map(|(to, from)| to - from).collect();
            let step = twist_of(twist_matrix, &turned_rad);
            // Headings are unwrapped.
            let turned_rad = body.heading_rad + step[2];
            body = body.moved(ilon_robot::Twist::new(step[0], step[1], step[2]));
            body.heading_rad = turned_rad;
        }
        let (s, c) = libm::sincos(body.heading_rad);
        poses.push([
            body.x_m + c * o_x - s * o_y,
            body.y_m + s * o_x + c * o_y,
            body.heading_rad - tracker.turned_rad,
        ]);
    }
    poses
}
