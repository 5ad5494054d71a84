//! The faults of a file, gathered so that all of them are reported at once.

use crate::error::RobotError;

/// Most faults of one file that are kept.
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

    /// The value of a result, or nothing and one more fault.
    pub(super) fn keep<T>(&mut self, result: Result<T, RobotError>) -> Option<T> {
        result.map_err(|error| self.push(error)).ok()
    }

    /// Whether there are as many as are kept, so that looking further is of no use.
    pub(super) fn is_full(&self) -> bool {
        self.0.len() >= MOST
    }

    /// Nothing, or all faults as one error.
    pub(super) fn into_result(self) -> Result<(), RobotError> {
        match RobotError::of_all(self.0) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}
