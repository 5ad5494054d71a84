//! Closed-form results that the simulated robots must reproduce: the sources of slip and shortfall,
//! and their sizes.
//!
//! docs/slip.md explains each with its derivation and its figures.

mod bearings;
mod feedforward;
mod grip;
mod rollers;

use ilon::scenario::Setting;
use ilon::{Run, Scenario};

/// Runs a shipped scenario with changed keys.
fn run(name: &str, settings: &[&str]) -> Run {
    let path = format!(
        "{}/assets/scenarios/{name}.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    let settings: Vec<Setting> = settings
        .iter()
        .map(|setting| setting.parse().expect("KEY=VALUE"))
        .collect();
    let scenario = Scenario::load_with(path, &settings).expect("a shipped scenario");
    ilon::run(&scenario).expect("a shipped scenario runs")
}
