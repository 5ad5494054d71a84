//! The time series of a log.

use std::path::Path;

use ilon_robot::Robot;
use ilon_sim::Error;

/// Smallest number of rows of a usable log.
pub(super) const FEWEST_ROWS: usize = 10;

/// A log: rows with increasing times, the angle of each wheel, and the robot's tracked pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Time of each row, in seconds from the first.
    pub times_s: Vec<f64>,
    /// Angle of each wheel (in the robot's order) at each row, relative to the first row, in
    /// radians.
    pub angles_rad: Vec<Vec<f64>>,
    /// Angle of each wheel at the first row in the log's own count, in radians.
    pub begun_rad: Vec<f64>,
    /// Angle of each joint between bodies (in the robot's order) at each row, in radians; empty
    /// for a robot without steered wheels.
    pub steering_rad: Vec<Vec<f64>>,
    /// x and y in metres and the heading in radians, unwrapped, at each row, from the tracker.
    pub poses: Vec<[f64; 3]>,
    /// Current of each wheel's motor at each row, in A; empty if not logged.
    pub currents_a: Vec<Vec<f64>>,
    /// Rows without a tracked pose: their poses are interpolated.
    pub unseen: Vec<bool>,
    /// Whether its recording was cut short: it is read as far as it goes.
    pub is_cut_short: bool,
}

impl Log {
    /// Returns how to give this log's start and end as a row of `measured`, after the other help;
    /// nothing if they are unknown.
    pub(super) fn as_measured(&self, robot: &Robot) -> String {
        let is_known = |pose: &&[f64; 3]| pose.iter().all(|value| value.is_finite());
        let mut known = self.poses.iter().filter(is_known);
        let (Some(from), Some(to)) = (known.next(), known.next_back()) else {
            return String::new();
        };
        let turned = |wheel: usize| {
            let angle = |row: Option<&Vec<f64>>| row.map_or(0.0, |angles| angles[wheel]);
            angle(self.angles_rad.last()) - angle(self.angles_rad.first())
        };
        let wheels = robot.wheels.iter().enumerate();
        let wheels: Vec<String> = wheels
            .map(|(place, wheel)| format!("{} = {:.4}", wheel.name, turned(place)))
            .collect();
        let (sin, cos) = libm::sincos(from[2]);
        let [x_m, y_m] = [to[0] - from[0], to[1] - from[1]];
        format!(
            "; or, if only its start and end are known, give it as a row of `measured`, without `[log]`: \
             {{ wheels = {{ {} }}, x_m = {:.4}, y_m = {:.4}, heading_deg = {:.3} }}",
            wheels.join(", "),
            cos * x_m + sin * y_m,
            cos * y_m - sin * x_m,
            (to[2] - from[2]).to_degrees()
        )
    }

    /// The number of its rows.
    pub fn len(&self) -> usize {
        self.times_s.len()
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.times_s.is_empty()
    }

    /// Its duration, in seconds.
    pub fn duration_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or(0.0)
    }

    /// The median time between rows, in seconds.
    pub fn period_s(&self) -> f64 {
        let mut steps: Vec<f64> = self
            .times_s
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .collect();
        middle(&mut steps)
    }

    /// Returns the rows between two times in seconds, with times and angles relative to the first
    /// of them.
    pub fn part(&self, from_s: f64, to_s: f64) -> Self {
        let first = self.times_s.partition_point(|t_s| *t_s < from_s);
        let end = self.times_s.partition_point(|t_s| *t_s <= to_s).max(first);
        let part_of = |rows: &[Vec<f64>]| rows.get(first..end).unwrap_or_default().to_vec();
        let mut part = Self {
            times_s: self.times_s[first..end].to_vec(),
            angles_rad: self.angles_rad[first..end].to_vec(),
            begun_rad: self.begun_rad.clone(),
            poses: self.poses[first..end].to_vec(),
            steering_rad: part_of(&self.steering_rad),
            currents_a: part_of(&self.currents_a),
            unseen: self.unseen[first..end].to_vec(),
            is_cut_short: self.is_cut_short,
        };
        part.count_from_zero();
        part
    }

    /// Makes times and wheel angles relative to the first row.
    pub(super) fn count_from_zero(&mut self) {
        let Some(first_s) = self.times_s.first().copied() else {
            return;
        };
        self.times_s.iter_mut().for_each(|t_s| *t_s -= first_s);
        let first = self.angles_rad[0].clone();
        self.begun_rad.resize(first.len(), 0.0);
        self.begun_rad
            .iter_mut()
            .zip(&first)
            .for_each(|(begun, first)| *begun += first);
        for row in &mut self.angles_rad {
            row.iter_mut()
                .zip(&first)
                .for_each(|(angle, first)| *angle -= first);
        }
    }

    /// Unwraps headings, and interpolates missing poses linearly.
    pub(super) fn fill_unseen(&mut self, path: &Path) -> Result<(), Error> {
        let seen: Vec<usize> = (0..self.len())
            .filter(|row| self.poses[*row].iter().all(|value| value.is_finite()))
            .collect();
        if seen.len() < FEWEST_ROWS {
            return Err(Error::contents(
                path,
                format!(
                    "the robot was seen in {} of its {} rows",
                    seen.len(),
                    self.len()
                ),
                "check `log.x`, `log.y` and `log.heading`, and that the tracker saw the robot",
            ));
        }
        let mut last = self.poses[seen[0]][2];
        for row in &seen {
            let turn = std::f64::consts::TAU;
            let heading = &mut self.poses[*row][2];
            *heading -= ((*heading - last) / turn).round() * turn;
            last = *heading;
        }
        self.unseen = vec![false; self.len()];
        for pair in seen.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            for row in from + 1..to {
                let share = (self.times_s[row] - self.times_s[from])
                    / (self.times_s[to] - self.times_s[from]);
                for column in 0..3 {
                    let (a, b) = (self.poses[from][column], self.poses[to][column]);
                    self.poses[row][column] = a + share * (b - a);
                }
                self.unseen[row] = true;
            }
        }
        // Before the first and after the last pose nothing is known.
        let (first, last) = (seen[0], seen[seen.len() - 1]);
        if first > 0 || last + 1 < self.len() {
            *self = self.part(self.times_s[first], self.times_s[last]);
        }
        Ok(())
    }
}

/// Returns the median of values, which are reordered; 0 for none.
pub(crate) fn middle(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let place = values.len() / 2;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}
