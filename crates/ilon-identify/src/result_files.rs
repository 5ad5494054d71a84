//! The robot as it was found, ready to run: its description, a scenario, and the drive that it is played.

use std::fmt::Write;
use std::path::Path;

use ilon_sim::Error;
use toml::{Table, Value};

use crate::motion::Tracker;
use crate::outcome::Identified;
use crate::read_logs::read_run;
use crate::study::{Study, flat};

/// All files of the results; some are there only where they apply.
pub const FILES: [&str; 5] = [
    "identified.json",
    "report.html",
    "robot.toml",
    "scenario.toml",
    "drive.csv",
];

/// A robot with the values that were found, a scenario that plays the first run to it, and that run, each as the name of a file and
/// its text. Of a robot that has no description in TOML the scenario names the robot's own file.
///
/// # Errors
/// Where the robot's file or the log cannot be read again.
pub fn files(
    study: &Study,
    found: &Identified,
    out: &Path,
) -> Result<Vec<(&'static str, String)>, Error> {
    let mut files = Vec::new();
    let own = study.resolve(&study.file.robot);
    let is_description = own.extension().is_some_and(|ending| ending == "toml");
    let mut robot_file = "robot.toml".to_owned();
    let mut unsaid: Vec<&str> = Vec::new();
    if is_description {
        let text = study
            .files
            .read_text(&own, ilon_sim::scenario::MAX_BYTES)
            .map_err(|fault| Error::read(&own, &fault))?;
        let mut description: Table = toml::from_str(&text).map_err(|error| {
            Error::invalid(format!("{}: {}", own.display(), error.message()), "")
        })?;
        for (key, value) in spec_of(study) {
            put(&mut description, &key, value);
        }
        for (name, value) in &found.parameters {
            if let Some(key) = name.strip_prefix("robot.spec.") {
                put(&mut description, key, Value::Float(value.value));
            } else if !apply(&mut description, name, value.value, value.nominal)
                && !name.starts_with("tracker")
            {
                unsaid.push(name);
            }
        }
        let text = toml::to_string(&description).unwrap_or_default();
        files.push((
            "robot.toml",
            format!(
                "# As fitted by the study {}: identified.json has the intervals.\n{text}",
                found.study
            ),
        ));
    } else {
        unsaid.extend(
            found
                .parameters
                .keys()
                .map(String::as_str)
                .filter(|name| !name.starts_with("tracker")),
        );
        robot_file = std::path::absolute(&own)
            .unwrap_or(own)
            .display()
            .to_string();
    }

    let run = study
        .file
        .runs
        .iter()
        .position(|run| !run.held_out)
        .unwrap_or(0);
    let log = read_run(study, run)?;
    let tracked = |name: &str| {
        let series = &study.file.runs[run].series;
        let of_series = format!("tracker.{name}.{series}");
        let value = found
            .parameters
            .get(&of_series)
            .or_else(|| found.parameters.get(&format!("tracker.{name}")));
        value.map_or(0.0, |value| value.value)
    };
    let tracker = Tracker {
        point_m: [tracked("x_m"), tracked("y_m")],
        turned_rad: -tracked("heading_deg").to_radians(),
    };
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

    let mut scenario = Table::new();
    for (key, value) in flat(&study.file.set) {
        let is_spec = is_description && key.starts_with("robot.spec.");
        if !is_spec {
            put(&mut scenario, &key, value);
        }
    }
    for (name, value) in &found.parameters {
        if found.simulated_keys.contains(name)
            && !(is_description && name.starts_with("robot.spec."))
        {
            put(&mut scenario, name, Value::Float(value.value));
        }
    }
    put(&mut scenario, "robot.file", Value::String(robot_file));
    put(
        &mut scenario,
        "playback.file",
        Value::String("drive.csv".to_owned()),
    );
    put(
        &mut scenario,
        "playback.drives",
        Value::String("wheel_angles".to_owned()),
    );
    if !has(&scenario, "run.duration_s") {
        put(
            &mut scenario,
            "run.duration_s",
            Value::Float((10.0 * log.duration_s()).floor().max(1.0) / 10.0),
        );
    }
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
    let _ = out;
    files.push(("scenario.toml", text));
    files.push(("drive.csv", csv));
    Ok(files)
}

/// What the study sets of the robot's description.
fn spec_of(study: &Study) -> Vec<(String, Value)> {
    flat(&study.file.set)
        .into_iter()
        .filter_map(|(key, value)| Some((key.strip_prefix("robot.spec.")?.to_owned(), value)))
        .collect()
}

/// Writes a parameter of the kinematics into a description; whether it could be.
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

    /// A lever that is half as long again makes every length half as long again that it is made of, and nothing else.
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
        // An arrangement that names no length cannot be told.
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
