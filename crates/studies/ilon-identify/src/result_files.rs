//! The identified robot, ready to run: its description, a scenario, and the drive to play back.

use std::fmt::Write;
use std::path::Path;

use ilon_robot::Wheel;
use ilon_sim::Error;
use nalgebra::Vector3;
use toml::{Table, Value};

use crate::log::Log;
use crate::motion::Tracker;
use crate::outcome::Identified;
use crate::read_logs::read_run;
use crate::steered::{has_column, steering_joints};
use crate::study::Study;
use ilon_files::toml::flat;

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
        let unsaid = names.filter(|name| !is_of_log(study, name)).collect();
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
    files.push(("drive.csv", drive(study, found, &log, &tracker)));
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
        } else if !apply(&mut description, name, value.value, value.nominal)
            && !is_of_log(study, name)
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

/// Whether a parameter belongs to the measurement and not to the robot: to the tracker, or to a
/// steering angle that the drive has with its zero.
fn is_of_log(study: &Study, name: &str) -> bool {
    let wheel = name.strip_prefix("steering_deg.");
    let joints = steering_joints(&study.robot).into_iter();
    let mut read = joints.filter_map(|joint| steers(study, joint));
    name.starts_with("tracker") || wheel.is_some_and(|wheel| read.any(|of| of.name == wheel))
}

/// Returns the first wheel that a joint steers.
fn steers(study: &Study, joint: usize) -> Option<&Wheel> {
    let mut wheels = study.robot.wheels.iter();
    wheels.find(|wheel| study.robot.steering_of(wheel) == Some(joint))
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
fn drive(study: &Study, found: &Identified, log: &Log, tracker: &Tracker) -> String {
    let robot = &study.robot;
    let is_logged = |at: &usize| has_column(robot, &robot.wheels[*at], &study.file.log.wheels);
    let wheels: Vec<usize> = (0..robot.wheels.len()).filter(is_logged).collect();
    let steering = match log.steering_rad.is_empty() {
        true => Vec::new(),
        false => steering_joints(robot),
    };
    // By how much the log reads too little.
    let zero_rad = |joint: &usize| {
        let wheel = steers(study, *joint);
        let found = wheel.and_then(|of| found.parameters.get(&format!("steering_deg.{}", of.name)));
        let axis = robot.joints[*joint].body_from_joint.rotation * Vector3::z();
        found.map_or(0.0, |of| axis.z.signum() * of.value.to_radians())
    };
    let zeros_rad: Vec<f64> = steering.iter().map(zero_rad).collect();
    let mut csv = "t_s".to_owned();
    for wheel in &wheels {
        let _ = write!(csv, ",{}_angle_rad", robot.wheels[*wheel].name);
    }
    for joint in &steering {
        let _ = write!(csv, ",{}_position_rad", robot.joints[*joint].name);
    }
    csv.push_str(",measured_x_m,measured_y_m,measured_heading_rad\n");
    for row in 0..log.len() {
        let _ = write!(csv, "{:.4}", log.times_s[row]);
        for wheel in &wheels {
            let _ = write!(csv, ",{:.6}", log.angles_rad[row][*wheel]);
        }
        for (joint, zero_rad) in steering.iter().zip(&zeros_rad) {
            let _ = write!(csv, ",{:.6}", log.steering_rad[row][*joint] + zero_rad);
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
    if description.contains_key("tyres") {
        return apply_on_tyres(description, name, value, nominal).is_some();
    }
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
        *entry = Value::Float(number(entry).unwrap_or(nominal) + value - nominal);
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

/// The same for a robot on tyres; `None` if that was not possible.
fn apply_on_tyres(description: &mut Table, name: &str, value: f64, nominal: f64) -> Option<()> {
    if name == "radius_m" {
        // The mean of all, so that each scales alike.
        let all = description.get_mut("tyres")?.get_mut("radius_m")?;
        scale(all, value / nominal);
    }
    let Some(Value::Array(wheels)) = description.get_mut("wheels") else {
        return None;
    };
    if name == "radius_m" {
        let own = wheels
            .iter_mut()
            .filter_map(|wheel| wheel.get_mut("radius_m"));
        own.for_each(|own| scale(own, value / nominal));
        return Some(());
    }
    if name == "lever_m" {
        return widen(wheels, value / nominal);
    }
    let (key, of) = name.split_once('.')?;
    let is_it = |wheel: &&mut Value| wheel.get("name").and_then(Value::as_str) == Some(of);
    let wheel = wheels.iter_mut().find(is_it)?.as_table_mut()?;
    let at = |place: usize, wheel: &mut Table| {
        let place = wheel.get_mut("position_m")?.get_mut(place)?;
        *place = Value::Float(number(place)? + value - nominal);
        Some(())
    };
    match key {
        "radius_m" => {
            wheel.insert(key.to_owned(), Value::Float(value));
            Some(())
        }
        "axis_deg" => {
            let before = wheel.get(key).and_then(number).unwrap_or(90.0);
            wheel.insert(key.to_owned(), Value::Float(before + value - nominal));
            Some(())
        }
        "x_m" => at(0, wheel),
        "y_m" => at(1, wheel),
        _ => None,
    }
}

/// Moves wheels on tyres along their axles, away from the middle of all; where some are steered,
/// straight away from it.
fn widen(wheels: &mut [Value], factor: f64) -> Option<()> {
    let place = |wheel: &Value| {
        let at = wheel.get("position_m")?;
        Some([number(at.get(0)?)?, number(at.get(1)?)?])
    };
    let places: Option<Vec<[f64; 2]>> = wheels.iter().map(place).collect();
    let places = places?;
    let is_steered = |wheel: &Value| wheel.get("steered").and_then(Value::as_bool) == Some(true);
    let steers: Vec<bool> = wheels.iter().map(is_steered).collect();
    // As the lever of a model counts: from the wheels that are not steered, if there are any.
    let mut among: Vec<(&[f64; 2], &bool)> = places
        .iter()
        .zip(&steers)
        .filter(|(_, steers)| !**steers)
        .collect();
    if among.is_empty() {
        among = places.iter().zip(&steers).collect();
    }
    let sum = |i: usize| among.iter().map(|(at, _)| at[i]).sum::<f64>();
    let middle = [0, 1].map(|i| sum(i) / among.len() as f64);
    for (wheel, at) in wheels.iter_mut().zip(places) {
        let axis_deg = wheel.get("axis_deg").and_then(number).unwrap_or(90.0);
        let (sin, cos) = libm::sincos(axis_deg.to_radians());
        let arm_m = cos * (at[0] - middle[0]) + sin * (at[1] - middle[1]);
        let moved = match steers.contains(&true) {
            true => [0, 1].map(|i| (factor - 1.0) * (at[i] - middle[i])),
            false => [cos, sin].map(|part| part * (factor - 1.0) * arm_m),
        };
        // To a picometre: an axle along y moves by no more than rounding along x.
        let moved = [at[0] + moved[0], at[1] + moved[1]].map(|x_m| (1e12 * x_m).round() / 1e12);
        let moved = moved.map(Value::Float);
        wheel
            .as_table_mut()?
            .insert("position_m".to_owned(), Value::Array(moved.into()));
    }
    Some(())
}

fn number(value: &Value) -> Option<f64> {
    let whole = value.as_integer().map(|whole| whole as f64);
    value.as_float().or(whole)
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

    /// A robot on tyres has a list of wheels: a wider track moves each along its own axle, away
    /// from the middle of all.
    #[test]
    fn robots_on_tyres_are_written_in_their_own_keys() {
        let wheels = "[[wheels]]\nname = \"l\"\nposition_m = [0.1, 0.3]\n[[wheels]]\nname = \"r\"\nposition_m = [0.1, -0.1]\naxis_deg = 90\n";
        let text = format!("[tyres]\nradius_m = 0.05\n{wheels}");
        let number = |value: &Value| number(value).unwrap();
        let wider = after(&text, "lever_m", 0.25, 0.2).unwrap();
        for (wheel, y_m) in [(0, 0.35), (1, -0.15)] {
            let at = &wider["wheels"][wheel]["position_m"];
            assert!((number(&at[0]) - 0.1).abs() < 1e-12);
            assert!((number(&at[1]) - y_m).abs() < 1e-12);
        }
        let all = after(&text, "radius_m", 0.051, 0.05).unwrap();
        assert!((number(&all["tyres"]["radius_m"]) - 0.051).abs() < 1e-12);
        let own = text.replace("axis_deg = 90", "radius_m = 0.06");
        // Wheels of 50 and 60 mm have a mean of 55.
        let all = after(&own, "radius_m", 0.0561, 0.055).unwrap();
        assert!((number(&all["tyres"]["radius_m"]) - 0.051).abs() < 1e-12);
        assert!((number(&all["wheels"][1]["radius_m"]) - 0.0612).abs() < 1e-12);
        let one = after(&text, "radius_m.r", 0.049, 0.05).unwrap();
        assert_eq!(number(&one["wheels"][1]["radius_m"]), 0.049);
        let turned = after(&text, "axis_deg.l", 91.0, 90.0).unwrap();
        assert_eq!(number(&turned["wheels"][0]["axis_deg"]), 91.0);
        let moved = after(&text, "y_m.r", -0.12, -0.1).unwrap();
        assert!((number(&moved["wheels"][1]["position_m"][1]) + 0.12).abs() < 1e-12);
        assert_eq!(after(&text, "gamma_deg", 44.0, 45.0), None);
    }
}
