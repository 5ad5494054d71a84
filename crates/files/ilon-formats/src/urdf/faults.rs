//! Collects the faults of a file, so that all of them are reported at once.

use crate::error::RobotError;

/// Largest number of collected faults.
const MOST: usize = 50;

/// Faults so far.
#[derive(Debug, Default)]
pub(super) struct Faults(Vec<RobotError>);

impl Faults {
    pub(super) fn push(&mut self, error: RobotError) {
        if self.0.len() < MOST {
            self.0.push(error);
        }
    }

    /// Returns the value of a result, or collects its fault.
    pub(super) fn keep<T>(&mut self, result: Result<T, RobotError>) -> Option<T> {
        result.map_err(|error| self.push(error)).ok()
    }

    /// Whether the limit is reached, so that further search is useless.
    pub(super) fn is_full(&self) -> bool {
        self.0.len() >= MOST
    }

    /// Returns all faults as one error, if there are any.
    pub(super) fn into_result(self) -> Result<(), RobotError> {
        match RobotError::of_all(self.0) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}
