//! Logs of drives: the wheels' angles, and the robot's pose from an external tracker.

pub mod anomalies;
mod bag;
mod csv;
mod format;
mod guess;
mod hands;
mod series;
pub mod wiring;

use std::path::Path;

use ilon_files::FileAccess;
use ilon_robot::Robot;
use ilon_sim::Error;

use self::series::FEWEST_ROWS;

pub use anomalies::{Anomaly, AnomalyKind};
pub use format::{Bag, Column, ColumnPlace, Delayed, Fitted, Format};
pub(crate) use format::{check, wheel_names};
pub use series::Log;
pub(crate) use series::middle;

impl Log {
    /// Reads a log in a format, for a robot.
    ///
    /// # Errors
    /// [`Error::Contents`] if it does not have the format, with the likely cause.
    pub fn read(
        path: &Path,
        format: &Format,
        robot: &Robot,
        files: &FileAccess,
    ) -> Result<Self, Error> {
        let is_table = path.extension().is_some_and(|ending| {
            ["csv", "tsv", "txt", "dat"]
                .iter()
                .any(|known| ending.eq_ignore_ascii_case(known))
        });
        let mut log = match is_table {
            true => csv::read(path, format, robot, files)?,
            false => bag::read(path, format, robot, files)?,
        };
        if log.len() < FEWEST_ROWS {
            return Err(Error::contents(
                path,
                format!("it has {} rows, which are too few for a drive", log.len()),
                format!("record at least some seconds{}", log.as_measured(robot)),
            ));
        }
        if let Some(row) = log.times_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            let (at, next) = (log.times_s[row], log.times_s[row + 1]);
            return Err(Error::contents(
                path,
                format!(
                    "its times do not increase: row {} is at {at} s and the next at {next} s",
                    row + 1
                ),
                "the clock was set back, the rows are not in order, or another column is the time: see `log.time`",
            ));
        }
        log.count_from_zero();
        log.fill_unseen(path)?;
        Ok(log)
    }
}
