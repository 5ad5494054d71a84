//! `ilon schema`: the scenario file's JSON Schema.

use super::{Outcome, say};
use crate::{Error, Scenario};

/// Prints the schema.
pub(super) fn run() -> Result<Outcome, Error> {
    say::data(&format!("{:#}\n", Scenario::json_schema()))?;
    Ok(Outcome::Done)
}
