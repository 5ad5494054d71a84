//! `ilon schema`: the scenario file's JSON Schema.

use super::Outcome;
use crate::{Error, Scenario};

/// Prints the schema.
pub(super) fn run() -> Result<Outcome, Error> {
    super::print(&format!("{:#}\n", Scenario::json_schema()))?;
    Ok(Outcome::Done)
}
