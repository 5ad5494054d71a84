//! A robot and a scenario in the form in which the page shows them and offers them for download.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ilon_files::normal;
use ilon_robot::Robot;
use ilon_sim::Scenario;
use ilon_sim::scenario::Tracked;
use serde::Serialize;
use serde_json::{Value, json};

/// A summary of a robot.
pub(super) fn robot(robot: &Robot) -> Value {
    let wheel = |wheel: &ilon_robot::Wheel| json!({ "name": wheel.name, "rollers": wheel.rollers.len(), "radius_m": wheel.radius_m });
    let wheels: Vec<Value> = robot.wheels.iter().map(wheel).collect();
    json!({ "name": robot.name, "mass_kg": robot.mass_kg(), "wheels": wheels })
}

/// The TOML description of a scenario's robot, if there is one beside its file, and the path by
/// which the scenario would name it.
pub(super) fn spec(scenario: &Scenario, files: &BTreeMap<PathBuf, Vec<u8>>) -> Value {
    let named = scenario.robot.file.with_extension("toml");
    let place = normal(&scenario.resolve(&named));
    let text = files
        .get(&place)
        .and_then(|bytes| std::str::from_utf8(bytes).ok());
    let keys = text.and_then(|text| text.parse::<toml::Table>().ok());
    let Some(keys) = keys.filter(|keys| keys.contains_key("chassis")) else {
        return Value::Null;
    };
    json!({ "file": named, "values": said(&keys) })
}

/// The scenario for a folder that also holds all files that it names.
pub(super) fn beside_its_files(scenario: &Scenario) -> Scenario {
    let mut beside = scenario.clone();
    let name = |path: &mut PathBuf| {
        if let Some(name) = path.file_name() {
            *path = PathBuf::from(name);
        }
    };
    name(&mut beside.robot.file);
    if let Some(file) = beside.reference.as_mut().and_then(Tracked::file_mut) {
        name(file);
    }
    if let Some(playback) = &mut beside.playback {
        name(&mut playback.file);
    }
    beside
}

/// A part of a reply as JSON.
pub(super) fn said(part: &impl Serialize) -> Value {
    serde_json::to_value(part).unwrap_or_default()
}
