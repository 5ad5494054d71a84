//! A time series from a log.

use std::f64::consts::{PI, TAU};

use ilon_robot::{Pose, wrap_angle};

use crate::scenario::TIME_SLACK_S;

/// A time series: rows of `width` numbers with increasing times from about zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Series {
    /// Times, in seconds.
    pub times_s: Vec<f64>,
    /// The values, row by row.
    pub values: Vec<f64>,
    /// Numbers per row.
    pub width: usize,
}

/// How long the last of the rows of a log lasts, which have these times: the mean interval, or, where
/// a few gaps make that long, the median of the last ones; 0 for fewer than two rows.
pub(super) fn usual_interval_s(rows: usize, time_s: impl Fn(usize) -> f64) -> f64 {
    /// A mean of more medians than this is one of gaps, and the intervals of the median. Chosen.
    const MOST: f64 = 1.5;
    const LAST: usize = 64;
    let Some(last) = rows.checked_sub(1).filter(|last| *last > 0) else {
        return 0.0;
    };
    let counted = last.saturating_sub(LAST)..last;
    let mut intervals_s: Vec<f64> = counted.map(|row| time_s(row + 1) - time_s(row)).collect();
    intervals_s.sort_by(f64::total_cmp);
    let median_s = intervals_s[(intervals_s.len() - 1) / 2];
    let mean_s = (time_s(last) - time_s(0)) / last as f64;
    match mean_s > MOST * median_s {
        true => median_s,
        false => mean_s,
    }
}

/// The beginning and end, in seconds, of the longest interval without rows, if it is far longer than
/// usual.
pub(super) fn longest_gap_s(times_s: &[f64]) -> Option<[f64; 2]> {
    /// Shorter gaps, in intervals and in seconds, are those of a radio or a busy computer. Chosen.
    const INTERVALS: f64 = 10.0;
    const LEAST_S: f64 = 0.5;
    let gaps = times_s.windows(2).map(|pair| [pair[0], pair[1]]);
    let longest = gaps.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    let is_gap = longest[1] - longest[0]
        > LEAST_S.max(INTERVALS * usual_interval_s(times_s.len(), |row| times_s[row]));
    is_gap.then_some(longest)
}

impl Series {
    pub fn new(width: usize) -> Self {
        Self {
            width,
            ..Self::default()
        }
    }

    pub fn push(&mut self, t_s: f64, values: impl IntoIterator<Item = f64>) {
        self.times_s.push(t_s);
        self.values.extend(values);
    }

    pub fn len(&self) -> usize {
        self.times_s.len()
    }

    pub fn row(&self, index: usize) -> &[f64] {
        &self.values[index * self.width..(index + 1) * self.width]
    }

    pub fn rows(&self) -> impl Iterator<Item = (f64, &[f64])> {
        let times = self.times_s.iter().enumerate();
        times.map(|(index, t_s)| (*t_s, self.row(index)))
    }

    /// The last row at or before a time; `None` before the first.
    pub fn before(&self, t_s: f64) -> Option<usize> {
        let after = self
            .times_s
            .partition_point(|time_s| *time_s <= t_s + TIME_SLACK_S);
        after.checked_sub(1)
    }

    /// The mean of a column from one time to another, in seconds, where each row holds until the
    /// next, and the last for the usual interval; 0 before and after. A row that holds for all of it
    /// has its own value, to the bit.
    pub fn mean(&self, column: usize, from_s: f64, to_s: f64) -> f64 {
        let (mut t_s, mut sum) = (from_s, 0.0);
        let mut row = self.before(from_s);
        loop {
            let next = row.map_or(0, |row| row + 1);
            let (value, until_s) = match row {
                Some(_) if next == self.len() && t_s > self.end_s() - TIME_SLACK_S => {
                    (0.0, f64::INFINITY)
                }
                Some(row) if next == self.len() => (self.row(row)[column], self.end_s()),
                Some(row) => (self.row(row)[column], self.times_s[next]),
                None => (0.0, self.times_s.first().copied().unwrap_or(f64::INFINITY)),
            };
            let is_last = until_s >= to_s - TIME_SLACK_S;
            if is_last && t_s == from_s {
                return value;
            }
            let until_s = until_s.min(to_s);
            sum += value * (until_s - t_s);
            if is_last {
                return sum / (to_s - from_s);
            }
            (t_s, row) = (until_s, Some(next.min(self.len() - 1)));
        }
    }

    /// The time at which the last row has lasted for the usual interval.
    pub fn end_s(&self) -> f64 {
        self.times_s.last().map_or(0.0, |last| {
            last + usual_interval_s(self.len(), |row| self.times_s[row])
        })
    }

    /// A linearly interpolated value; constant beyond the first and last row.
    pub fn between(&self, t_s: f64, column: usize) -> f64 {
        let value = |row: usize| self.row(row)[column];
        match self.before(t_s) {
            None => value(0),
            Some(row) if row + 1 == self.len() => value(row),
            Some(row) => {
                let (from_s, to_s) = (self.times_s[row], self.times_s[row + 1]);
                let share = ((t_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0);
                value(row) + share * (value(row + 1) - value(row))
            }
        }
    }

    /// Removes all rows after a time, and adds an interpolated one at that time.
    pub fn cut(&mut self, t_s: f64) {
        let kept = self.times_s.partition_point(|time_s| *time_s < t_s);
        if kept == 0 {
            self.times_s.clear();
            self.values.clear();
            return;
        }
        let at: Vec<f64> = (0..self.width)
            .map(|column| self.between(t_s, column))
            .collect();
        self.times_s.truncate(kept);
        self.values.truncate(kept * self.width);
        self.push(t_s, at);
    }

    /// Removes the last row.
    pub fn pop(&mut self) {
        self.times_s.pop();
        self.values.truncate(self.times_s.len() * self.width);
    }

    pub fn shift_times(&mut self, by_s: f64) {
        self.times_s.iter_mut().for_each(|time_s| *time_s += by_s);
    }
}

/// Whether angles are wrapped to one turn, with jumps.
pub(super) fn is_wrapped(series: &Series, column: usize) -> bool {
    // Rounding of a turn in degrees with three decimals.
    const ROUNDING_RAD: f64 = 1e-4;
    let angles = || series.rows().map(|(_, row)| row[column]);
    let least = angles().fold(f64::INFINITY, f64::min);
    let most = angles().fold(f64::NEG_INFINITY, f64::max);
    let jumps = angles()
        .zip(angles().skip(1))
        .any(|(a, b)| (b - a).abs() > PI);
    jumps && most - least <= TAU + ROUNDING_RAD
}

/// Removes jumps of whole turns from angles.
pub(super) fn unwrap(series: &mut Series, column: usize) {
    let width = series.width;
    for row in 1..series.len() {
        let before = series.values[(row - 1) * width + column];
        let angle = &mut series.values[row * width + column];
        *angle = before + wrap_angle(*angle - before);
    }
}

/// Moves poses so that the one at the start of the run becomes `start`.
pub(super) fn place(series: &mut Series, start: Pose) {
    let [x_m, y_m, heading_rad] = [0, 1, 2].map(|column| series.between(0.0, column));
    let placing = Placing {
        from: Pose {
            x_m,
            y_m,
            heading_rad,
        },
        to: start,
    };
    for row in series.values.chunks_exact_mut(series.width) {
        let placed = placing.of(Pose {
            x_m: row[0],
            y_m: row[1],
            heading_rad: row[2],
        });
        row.copy_from_slice(&[placed.x_m, placed.y_m, placed.heading_rad]);
    }
}

/// A rigid motion from the frame of a log to the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// A pose in the frame of the log.
    pub from: Pose,
    /// The same pose in the world.
    pub to: Pose,
}

impl Placing {
    /// A pose of the log in the world. Its heading is not wrapped.
    pub fn of(&self, pose: Pose) -> Pose {
        let turned_rad = self.to.heading_rad - self.from.heading_rad;
        let (sin, cos) = libm::sincos(turned_rad);
        let (x_m, y_m) = (pose.x_m - self.from.x_m, pose.y_m - self.from.y_m);
        Pose {
            x_m: self.to.x_m + cos * x_m - sin * y_m,
            y_m: self.to.y_m + sin * x_m + cos * y_m,
            heading_rad: pose.heading_rad + turned_rad,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(rows: &[(f64, f64)]) -> Series {
        let mut series = Series::new(1);
        rows.iter()
            .for_each(|(t_s, value)| series.push(*t_s, [*value]));
        series
    }

    /// Rows of 1, 2 and 3 that hold for 0.1 s each, from 0 to 0.3 s.
    #[test]
    fn a_command_holds_until_the_next_and_the_last_as_long_as_the_others() {
        let series = series(&[(0.0, 1.0), (0.1, 2.0), (0.2, 3.0)]);
        let at = |t_s: f64| series.mean(0, t_s, t_s + 0.01);
        assert_eq!(
            [at(-0.02), at(0.0), at(0.05), at(0.1)],
            [0.0, 1.0, 1.0, 2.0]
        );
        // A sum of periods, a rounding error below the intended time.
        assert_eq!(at(0.1 - 1e-12), 2.0);
        assert_eq!([at(0.29), at(0.31)], [3.0, 0.0]);
    }

    /// No row between two control instants is lost: periods longer than rows have their mean.
    #[test]
    fn a_period_over_several_rows_has_their_mean() {
        let series = series(&[(0.0, 1.0), (0.1, 2.0), (0.2, 3.0)]);
        let is = |from_s, to_s, expected: f64| {
            let mean = series.mean(0, from_s, to_s);
            assert!(
                (mean - expected).abs() < 1e-12,
                "{from_s} to {to_s}: {mean}"
            );
        };
        is(0.0, 0.2, 1.5);
        is(0.05, 0.15, 1.5);
        is(0.0, 0.3, 2.0);
        is(-0.1, 0.1, 0.5);
        // 0.1 s of 3 and 0.1 s of nothing.
        is(0.2, 0.4, 1.5);
        is(-0.1, 0.5, 6.0 * 0.1 / 0.6);
    }

    #[test]
    fn between_rows_lies_a_line_and_beyond_them_nothing_changes() {
        let series = series(&[(0.0, 1.0), (0.2, 3.0)]);
        let at = |t_s| series.between(t_s, 0);
        assert_eq!([at(-1.0), at(0.0), at(0.2), at(9.0)], [1.0, 1.0, 3.0, 3.0]);
        assert!((at(0.05) - 1.5).abs() < 1e-12);
    }

    #[test]
    fn angles_within_a_turn_that_jump_are_wrapped_and_others_are_not() {
        let turning = |angle: fn(f64) -> f64| {
            let rows: Vec<(f64, f64)> = (0..200)
                .map(|row| (0.01 * f64::from(row), angle(0.1 * f64::from(row))))
                .collect();
            series(&rows)
        };
        let steady = turning(|angle| angle);
        for wrapped in [turning(wrap_angle), turning(|angle| angle.rem_euclid(TAU))] {
            assert!(is_wrapped(&wrapped, 0));
            let mut whole = wrapped;
            unwrap(&mut whole, 0);
            let mut pairs = whole.values.iter().zip(&steady.values);
            assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-9));
        }
        assert!(!is_wrapped(&steady, 0));
        // A log with few rows turns by more than half a turn between two.
        assert!(!is_wrapped(
            &series(&[(0.0, 0.0), (1.0, 5.0), (2.0, 10.0)]),
            0
        ));
    }

    #[test]
    fn poses_are_placed_at_the_start_with_their_shape() {
        let mut poses = Series::new(3);
        // A quarter of a turn to the left on the way from (1, 1) to (1, 2), across the wrap of
        // angles.
        poses.push(0.0, [1.0, 1.0, 3.0]);
        poses.push(1.0, [1.0, 2.0, 3.0 + 1.5 - std::f64::consts::TAU]);
        unwrap(&mut poses, 2);
        let start = Pose {
            x_m: -1.0,
            y_m: 0.5,
            heading_rad: 3.0 - std::f64::consts::FRAC_PI_2,
        };
        place(&mut poses, start);
        let near = |row: usize, wanted: [f64; 3]| {
            poses
                .row(row)
                .iter()
                .zip(wanted)
                .all(|(a, b)| (a - b).abs() < 1e-12)
        };
        // After a quarter turn to the right, the way along y leads along x.
        assert!(near(0, [-1.0, 0.5, start.heading_rad]), "{poses:?}");
        assert!(near(1, [0.0, 0.5, start.heading_rad + 1.5]), "{poses:?}");
    }
}
