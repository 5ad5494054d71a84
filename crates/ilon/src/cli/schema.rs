//! `ilon schema`: the scenario file's JSON Schema.

use super::{Outcome, say};
use crate::Scenario;
use crate::cli::failure::Failure;

/// Prints the schema.
pub(super) fn run() -> Result<Outcome, Failure> {
    say::data(&format!("{:#}\n", Scenario::json_schema()))?;
    Ok(Outcome::Done)
}
