//! The identified robot, ready to run: its description, a scenario, and the drive to play back.

use std::fmt::Write;
use std::path::Path;

use ilon_sim::Error;
use toml::{Table, Value};

use crate::log::Log;
use crate::motion::Tracker;
use crate::outcome::Identified;
use crate::read_logs::read_run;
use crate::study::{Study, flat};

/// All result files; some apply only to some studies.
pub const FILES: [&str; 5] = [
    "identified.json",
    "report.html",
    "robot.toml",
    "scenario.toml",
    "drive.csv",
];

/// Returns the robot with the identified values, a scenario that plays the first run, and that run,
/// each as a file name and its text. If the robot has no description in TOML, the scenario names
/// the robot's own file.
///
/// # Errors
/// If the robot's file or the log cannot be read again.
pub fn files(study: &Study, found: &Identified) -> Result<Vec<(&'static str, String)>, Error> {
    let own = study.resolve(&study.file.robot);
    let run = study.file.runs.iter().position(|run| !run.held_out);
    let run = run.unwrap_or(0);
    let log = read_run(study, run)?;
    let is_description = own.extension().is_some_and(|ending| ending == "toml");
    let mut files = Vec::new();
    let (robot_file, unsaid) = if is_description {
        let (description, unsaid) = fitted_description(study, found, &own)?;
        files.push(("robot.toml", description));
        ("robot.toml".to_owned(), unsaid)
    } else {
        let own = std::path::absolute(&own).unwrap_or(own);
        let names = found.parameters.keys().map(String::as_str);
        let unsaid = names.filter(|name| !is_of_tracker(name)).collect();
        (own.display().to_string(), unsaid)
    };
    let mut scenario = fitted_scenario(study, found, is_description);
    put(&mut scenario, "robot.file", Value::String(robot_file));
    play(&mut scenario, &log);
    let mut text = format!(
        "# The robot as fitted by the study {}, driven by the wheels of {}.\n",
        found.study,
        study.file.runs[run].file.display()
    );
    if !unsaid.is_empty() {
        let _ = writeln!(
            text,
            "# Fitted, but nothing that this robot's file can say: {}. See identified.json.",
            unsaid.join(", ")
        );
    }
    text += &toml::to_string(&scenario).unwrap_or_default();
    files.push(("scenario.toml", text));
    let tracker = fitted_tracker(study, found, run);
    files.push(("drive.csv", drive(study, &log, &tracker)));
    Ok(files)
}

/// Returns the robot's description with the identified values, and the names of those that it
/// cannot express.
fn fitted_description<'a>(
    study: &Study,
    found: &'a Identified,
    own: &Path,
) -> Result<(String, Vec<&'a str>), Error> {
    let text = ilon_sim::scenario::read_text(own, &study.files)?;
    let mut description: Table = toml::from_str(&text)
        .map_err(|error| Error::invalid(format!("{}: {}", own.display(), error.message()), ""))?;
    for (key, value) in spec_of(study) {
        put(&mut description, &key, value);
    }
    let mut unsaid = Vec::new();
    for (name, value) in &found.parameters {
        if let Some(key) = name.strip_prefix("robot.spec.") {
            put(&mut description, key, Value::Float(value.value));
        } else if !apply(&mut description, name, value.value, value.nominal) && !is_of_tracker(name)
        {
            unsaid.push(name.as_str());
        }
    }
    let text = toml::to_string(&description).unwrap_or_default();
    let head = format!(
        "# As fitted by the study {}: identified.json has the intervals.\n",
        found.study
    );
    Ok((head + &text, unsaid))
}

/// Whether a parameter belongs to the measurement and not to the robot.
fn is_of_tracker(name: &str) -> bool {
    name.starts_with("tracker")
}

/// Returns the scenario keys set by the study and those identified, except those in the robot's
/// description.
fn fitted_scenario(study: &Study, found: &Identified, is_description: bool) -> Table {
    let is_described = |key: &str| is_description && key.starts_with("robot.spec.");
    let mut scenario = Table::new();
    let set = flat(&study.file.set).into_iter();
    for (key, value) in set.filter(|(key, _)| !is_described(key)) {
        put(&mut scenario, &key, value);
    }
    let simulated = |name: &String| found.simulated_keys.contains(name) && !is_described(name);
    for (name, value) in found.parameters.iter().filter(|(name, _)| simulated(name)) {
        put(&mut scenario, name, Value::Float(value.value));
    }
    scenario
}

/// Makes a scenario play the wheels of a log, by default to its last whole tenth of a second.
fn play(scenario: &mut Table, log: &Log) {
    for (key, value) in [
        ("playback.file", "drive.csv"),
        ("playback.drives", "wheel_angles"),
    ] {
        put(scenario, key, Value::String(value.to_owned()));
    }
    if !has(scenario, "run.duration_s") {
        let duration_s = (10.0 * log.duration_s()).floor().max(1.0) / 10.0;
        put(scenario, "run.duration_s", Value::Float(duration_s));
    }
}

/// Returns position and direction of the tracker of a run.
fn fitted_tracker(study: &Study, found: &Identified, run: usize) -> Tracker {
    let tracked = |name: &str| {
        let series = &study.file.runs[run].series;
        let of_series = found.parameters.get(&format!("tracker.{name}.{series}"));
        let value = of_series.or_else(|| found.parameters.get(&format!("tracker.{name}")));
        value.map_or(0.0, |value| value.value)
    };
    Tracker {
        point_m: [tracked("x_m"), tracked("y_m")],
        turned_rad: -tracked("heading_deg").to_radians(),
    }
}

/// Returns a log in playback format: the wheels' angles, and the body's poses from the tracker.
fn drive(study: &Study, log: &Log, tracker: &Tracker) -> String {
    let mut csv = "t_s".to_owned();
    for wheel in &study.robot.wheels {
        let _ = write!(csv, ",{}_angle_rad", wheel.name);
    }
    csv.push_str(",measured_x_m,measured_y_m,measured_heading_rad\n");
    for row in 0..log.len() {
        let _ = write!(csv, "{:.4}", log.times_s[row]);
        for angle in &log.angles_rad[row] {
            let _ = write!(csv, ",{angle:.6}");
        }
        let [x, y, heading] = log.poses[row];
        let heading = heading + tracker.turned_rad;
        let (s, c) = libm::sincos(heading);
        let [o_x, o_y] = tracker.point_m;
        let _ = writeln!(
            csv,
            ",{:.6},{:.6},{heading:.6}",
            x - c * o_x + s * o_y,
            y - s * o_x - c * o_y
        );
    }
    csv
}

/// Returns the keys of the robot's description that the study sets.
fn spec_of(study: &Study) -> Vec<(String, Value)> {
    flat(&study.file.set)
        .into_iter()
        .filter_map(|(key, value)| Some((key.strip_prefix("robot.spec.")?.to_owned(), value)))
        .collect()
}

/// Writes a parameter of the kinematics into a description; returns whether that was possible.
fn apply(description: &mut Table, name: &str, value: f64, nominal: f64) -> bool {
    if name == "radius_m" {
        put(description, "wheel.radius_m", Value::Float(value));
        return true;
    }
    if let Some(wheel) = name.strip_prefix("radius_m.") {
        put(
            description,
            &format!("overrides.{wheel}.radius_m"),
            Value::Float(value),
        );
        return true;
    }
    let Some(Value::Table(wheels)) = description.get_mut("wheels") else {
        return false;
    };
    if let (Some((key, wheel)), Some(Value::Array(list))) =
        (name.split_once('.'), wheels.get_mut("list"))
    {
        let is_it = |of: &&mut Value| of.get("name").and_then(Value::as_str) == Some(wheel);
        let entry = match (key, list.iter_mut().find(is_it)) {
            ("axis_deg", Some(of)) => of.get_mut("axis_deg"),
            ("x_m", Some(of)) => of.get_mut("position_m").and_then(|at| at.get_mut(0)),
            ("y_m", Some(of)) => of.get_mut("position_m").and_then(|at| at.get_mut(1)),
            _ => None,
        };
        let Some(entry) = entry else { return false };
        let before = entry
            .as_float()
            .or_else(|| entry.as_integer().map(|whole| whole as f64));
        *entry = Value::Float(before.unwrap_or(nominal) + value - nominal);
        return true;
    }
    let Some(Value::Table(arrangement)) = wheels.iter_mut().next().map(|(_, value)| value) else {
        return false;
    };
    match name {
        "gamma_deg" if arrangement.contains_key("gamma_deg") => {
            arrangement.insert("gamma_deg".to_owned(), Value::Float(value));
            true
        }
        "lever_m" => {
            let factor = value / nominal;
            let mut is_known = false;
            for key in ["distance_m", "half_width_m", "axles_m"] {
                if let Some(length) = arrangement.get_mut(key) {
                    scale(length, factor);
                    is_known = true;
                }
            }
            is_known
        }
        _ => false,
    }
}

fn scale(value: &mut Value, factor: f64) {
    match value {
        Value::Float(number) => *number *= factor,
        Value::Integer(number) => *value = Value::Float(*number as f64 * factor),
        Value::Array(list) => list.iter_mut().for_each(|value| scale(value, factor)),
        _ => {}
    }
}

/// Sets a dotted key.
pub(crate) fn put(table: &mut Table, key: &str, value: Value) {
    match key.split_once('.') {
        None => {
            table.insert(key.to_owned(), value);
        }
        Some((first, rest)) => {
            let inner = table
                .entry(first.to_owned())
                .or_insert_with(|| Value::Table(Table::new()));
            if let Value::Table(inner) = inner {
                put(inner, rest, value);
            }
        }
    }
}

fn has(table: &Table, key: &str) -> bool {
    match key.split_once('.') {
        None => table.contains_key(key),
        Some((first, rest)) => table
            .get(first)
            .and_then(Value::as_table)
            .is_some_and(|inner| has(inner, rest)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(text: &str, name: &str, value: f64, nominal: f64) -> Option<Table> {
        let mut description: Table = text.parse().unwrap();
        apply(&mut description, name, value, nominal).then_some(description)
    }

    /// A lever that is half as long again scales every length that it consists of by 1.5, and
    /// nothing else.
    #[test]
    fn a_lever_scales_the_lengths_of_the_arrangement() {
        let text =
            "[wheels.rectangle]\nhalf_width_m = 0.2\naxles_m = [0.1, -0.1]\ngamma_deg = 45\n";
        let found = after(text, "lever_m", 0.45, 0.3).unwrap();
        let arrangement = &found["wheels"]["rectangle"];
        let number = |value: &Value| value.as_float().unwrap();
        assert!((number(&arrangement["half_width_m"]) - 0.3).abs() < 1e-15);
        assert!((number(&arrangement["axles_m"][0]) - 0.15).abs() < 1e-15);
        assert!((number(&arrangement["axles_m"][1]) + 0.15).abs() < 1e-15);
        assert_eq!(arrangement["gamma_deg"].as_integer(), Some(45));
        // An arrangement without lengths cannot be scaled.
        assert_eq!(
            after("[wheels.listed]\ngamma_deg = 45\n", "lever_m", 0.45, 0.3),
            None
        );
    }

    #[test]
    fn radii_and_angles_are_written_as_they_were_found() {
        let found = after("", "radius_m", 0.051, 0.05).unwrap();
        assert_eq!(found["wheel"]["radius_m"].as_float(), Some(0.051));
        let found = after("", "radius_m.rear_left", 0.049, 0.05).unwrap();
        let own = &found["overrides"]["rear_left"]["radius_m"];
        assert_eq!(own.as_float(), Some(0.049));
        let found = after("[wheels.star]\ngamma_deg = 45\n", "gamma_deg", 44.0, 45.0).unwrap();
        assert_eq!(found["wheels"]["star"]["gamma_deg"].as_float(), Some(44.0));
    }
}
