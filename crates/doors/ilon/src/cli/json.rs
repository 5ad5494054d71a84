//! Results as JSON.

use serde::Serialize;

use super::failure::Failure;

/// Formats a result as indented JSON; `what` names it in the error.
pub(super) fn pretty(what: &'static str, result: &impl Serialize) -> Result<String, Failure> {
    let json = serde_json::to_string_pretty(result);
    Ok(json.map_err(|error| Failure::encode(what, &error))? + "\n")
}
