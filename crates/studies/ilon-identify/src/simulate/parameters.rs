//! Free keys of the scenario, with their ranges.

use ilon_sim::Error;
use toml::Value as Toml;

use crate::study::Simulate;
use ilon_files::toml::flat;

/// A free key with its range.
pub(super) struct Free {
    pub key: String,
    pub low: f64,
    pub high: f64,
    pub is_log: bool,
}
/// Returns the start of the search.
pub(super) fn start_of(free: &Free) -> f64 {
    match free.is_log {
        true => libm::exp(libm::log(free.low) + 0.4 * (libm::log(free.high) - libm::log(free.low))),
        false => free.low + 0.4 * (free.high - free.low),
    }
}

/// Returns the free keys, each `{ from = ..., to = ..., scale = "log" }`.
pub(super) fn free_of(section: &Simulate) -> Result<Vec<Free>, Error> {
    let mut found: Vec<Free> = Vec::new();
    for (key, value) in flat(&section.free) {
        let Some((name, end)) = key.rsplit_once('.') else {
            return Err(unclear(&key));
        };
        let place = match found.iter().position(|free| free.key == name) {
            Some(place) => place,
            None => {
                found.push(Free {
                    key: name.to_owned(),
                    low: f64::NAN,
                    high: f64::NAN,
                    is_log: false,
                });
                found.len() - 1
            }
        };
        let number = match &value {
            Toml::Float(number) => Some(*number),
            Toml::Integer(number) => Some(*number as f64),
            _ => None,
        };
        match (end, number, value.as_str()) {
            ("from", Some(number), _) => found[place].low = number,
            ("to", Some(number), _) => found[place].high = number,
            ("scale", _, Some("log")) => found[place].is_log = true,
            ("scale", _, Some("linear")) => found[place].is_log = false,
            _ => return Err(unclear(&key)),
        }
    }
    for free in &found {
        let is_range = free.low < free.high && free.low.is_finite() && free.high.is_finite();
        if !is_range || (free.is_log && free.low <= 0.0) {
            return Err(unclear(&free.key));
        }
    }
    if found.is_empty() {
        return Err(unclear("free"));
    }
    Ok(found)
}

fn unclear(key: &str) -> Error {
    Error::invalid(
        format!("`simulate.free.{key}` has no range"),
        "write `world.floor.creep = { from = 0.1, to = 3.0 }` below `[simulate.free]`; `scale = \"log\"` needs a range above 0",
    )
}
