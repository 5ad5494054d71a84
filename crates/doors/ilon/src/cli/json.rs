//! Results as JSON.

use serde::Serialize;

use super::failure::Failure;

/// A result as lines of JSON; `what` it is, for the failure of what cannot be written so.
pub(super) fn pretty(what: &'static str, result: &impl Serialize) -> Result<String, Failure> {
    let json = serde_json::to_string_pretty(result);
    Ok(json.map_err(|error| Failure::encode(what, &error))? + "\n")
}
