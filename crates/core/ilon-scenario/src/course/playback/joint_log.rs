//! The commands of a log to the servo of a joint between bodies.

use super::series::{Series, usual_interval_s};
use super::wanted::Wanted;
use crate::Error;
use crate::course::command::JointCommand;
use crate::scenario::Quantity;

/// The quantities that a row of a log may have for a joint, in order of precedence: the first one
/// given drives it. NaN stands for a missing one.
pub(super) const QUANTITIES: [Quantity; 3] = [Quantity::Position, Quantity::Rate, Quantity::Effort];

/// The commands of a log to the servo of a joint, in rad and N m for a revolute joint, in m and N
/// for a prismatic one.
#[derive(Clone, Debug, PartialEq)]
pub struct JointLog {
    /// The joint's position at the start of the run; `None` for a log without its positions.
    starts: Option<f64>,
    /// Times in seconds of the run, increasing, and the command from each on. At least one.
    rows: Vec<(f64, Quantity, f64)>,
}

impl JointLog {
    /// From rows of [`QUANTITIES`] in times of the run; `None` if they do not drive the joint.
    ///
    /// # Errors
    /// For a single row that is not a position: its duration is unknown.
    pub(super) fn new(
        wanted: &Wanted<'_>,
        joint: &str,
        said: &Series,
    ) -> Result<Option<Self>, Error> {
        let by = wanted.section.joints_by;
        let drives = |(t_s, row): (f64, &[f64])| {
            let mut said = QUANTITIES.into_iter().zip(row);
            let (quantity, number) = said.find(|(quantity, number)| {
                by.is_none_or(|by| by == *quantity) && !number.is_nan()
            })?;
            Some((t_s, quantity, *number))
        };
        let rows: Vec<_> = said.rows().filter_map(drives).collect();
        if let [(_, Quantity::Rate | Quantity::Effort, _)] = rows[..] {
            return Err(wanted.fault(
                format!(
                    "it has only one row for the joint `{joint}`, and no time at which it ends"
                ),
                "add a row at the time at which it ends",
            ));
        }
        let mut positions = Series::new(1);
        let known = said.rows().filter(|(_, row)| !row[0].is_nan());
        known.for_each(|(t_s, row)| positions.push(t_s, [row[0]]));
        let starts = (positions.len() > 0).then(|| positions.between(0.0, 0));
        Ok((!rows.is_empty()).then_some(Self { starts, rows }))
    }

    /// The joint's position at the start of the run, in rad or m; `None` for a log without its
    /// positions.
    pub fn starts(&self) -> Option<f64> {
        self.starts
    }

    /// The target positions, with their times in seconds.
    pub fn positions(&self) -> impl Iterator<Item = (f64, f64)> {
        let rows = self.rows.iter();
        rows.filter_map(|(t_s, quantity, number)| {
            (*quantity == Quantity::Position).then_some((*t_s, *number))
        })
    }

    /// The fastest target rate, in rad/s or m/s, and its start, in seconds of the run.
    pub fn fastest(&self) -> (f64, f64) {
        let rate = |(index, row): (usize, &(f64, Quantity, f64))| {
            let next = self.rows.get(index + 1);
            match (row, next) {
                ((_, Quantity::Rate, rate), _) => (rate.abs(), row.0),
                ((from_s, Quantity::Position, from), Some((to_s, Quantity::Position, to))) => {
                    ((to - from).abs() / (to_s - from_s), *from_s)
                }
                _ => (0.0, row.0),
            }
        };
        let rates = self.rows.iter().enumerate().map(rate);
        rates.fold((0.0, 0.0), |most, of| if of.0 > most.0 { of } else { most })
    }

    /// The end, in seconds of the run: the time of the last position, or the time at which the last
    /// rate, torque or force has lasted for the usual interval of rows.
    pub fn end_s(&self) -> f64 {
        let (last_s, quantity, _) = self.rows[self.rows.len() - 1];
        match quantity {
            Quantity::Position => last_s,
            _ => last_s + usual_interval_s(self.rows.len(), |row| self.rows[row].0),
        }
    }

    /// The command at a time in seconds. Positions are interpolated linearly, and constant before
    /// the first and after the last. A rate, torque or force holds until the next row; before the
    /// first and after the last the servo holds the joint's position.
    pub fn command_at(&self, t_s: f64) -> JointCommand {
        let next = self.rows.partition_point(|row| row.0 <= t_s);
        let stands = |position| JointCommand::Position {
            position,
            rate: 0.0,
        };
        let Some(last) = next.checked_sub(1) else {
            return match self.rows[0] {
                (_, Quantity::Position, first) => stands(first),
                _ => JointCommand::Rate(0.0),
            };
        };
        let is_over = next == self.rows.len() && t_s > self.end_s();
        let (from_s, quantity, number) = self.rows[last];
        match (quantity, self.rows.get(next)) {
            (Quantity::Position, Some((to_s, Quantity::Position, to))) => {
                let rate = (to - number) / (to_s - from_s);
                JointCommand::Position {
                    position: number + (t_s - from_s) / (to_s - from_s) * (to - number),
                    rate,
                }
            }
            (Quantity::Position, _) => stands(number),
            _ if is_over => JointCommand::Rate(0.0),
            (Quantity::Rate, _) => JointCommand::Rate(number),
            (Quantity::Effort, _) => JointCommand::Effort(number),
        }
    }
}
