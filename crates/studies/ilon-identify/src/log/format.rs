//! The format of a log: columns and units.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use ilon_files::defaults::number;
use ilon_robot::Robot;
use ilon_sim::Error;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::steered::steering_joints;

/// How the logs are written. A file that ends in `.csv`, `.tsv`, `.txt` or `.dat` is a table of
/// text; everything else a bag.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "LogSection")]
pub struct Format {
    /// What stands between two columns: one character, or `"tab"`.
    #[serde(default = "comma")]
    pub delimiter: String,
    /// The line that holds the names of the columns, counted from 1; 0 where there is none. Rows
    /// begin after it.
    #[serde(default = "number::<1, usize>")]
    pub header_line: usize,
    /// When a row was.
    pub time: Option<Column>,
    /// The time between rows in seconds, of a table without times.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub period_s: Option<f64>,
    /// By how much the poses come after the wheels, in seconds; `"fit"` of each series by itself.
    pub delay_s: Option<Delayed>,
    /// Whether decimals are written with a comma, as in `0,25`; columns are then parted by
    /// something else.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub decimal_comma: bool,
    /// x of the point that the tracker follows.
    pub x: Option<Column>,
    /// y of the point that the tracker follows; x, y and up are right-handed.
    pub y: Option<Column>,
    /// The robot's heading as the tracker sees it, counter-clockwise from above.
    pub heading: Option<Column>,
    /// Each wheel, by the name of its joint.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub wheels: BTreeMap<String, Column>,
    /// The angle of each joint that steers a wheel, by the joint's name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub steering: BTreeMap<String, Column>,
    /// The current of each wheel's motor, by the name of the wheel's joint.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub currents: BTreeMap<String, Column>,
    /// The topics, of bags and MCAP files.
    pub bag: Option<Bag>,
}

/// By how much the poses come after the wheels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Delayed {
    /// By so many seconds.
    Known(f64),
    /// By what the logs show.
    Fitted(Fitted),
}

/// The word for what is to be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fitted {
    /// It is fitted.
    Fit,
}

/// Which topics of a bag are read.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "BagSection")]
pub struct Bag {
    /// The wheels' angles: `sensor_msgs/JointState`.
    #[serde(default = "joint_states")]
    pub joints: String,
    /// The pose from outside: `nav_msgs/Odometry` or `geometry_msgs/PoseStamped`.
    pub pose: String,
    /// Joints that the bag calls otherwise: on the left the robot's name of it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub names: BTreeMap<String, String>,
}

fn comma() -> String {
    ",".to_owned()
}

fn joint_states() -> String {
    "/joint_states".to_owned()
}

/// A column of a table, and what its numbers mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Its name in the header, or its place, counted from 1.
    pub column: ColumnPlace,
    /// Its unit: `"s"`, `"ms"`, `"us"`, `"ns"`; `"m"`, `"cm"`, `"mm"`, `"in"`; `"rad"`, `"deg"`,
    /// `"turns"`, `"ticks"`; `"rad/s"`, `"deg/s"`, `"rpm"`, `"turns/s"`; `"A"`, `"mA"`.
    pub unit: String,
    /// By what numbers are multiplied beside their unit: -1 of a wheel that counts the other way,
    /// or metres of a pixel.
    #[serde(default = "number::<1, f64>")]
    pub scale: f64,
    /// Ticks of one turn of the wheel, behind its gear; of `"ticks"` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub ticks_per_turn: Option<f64>,
    /// Whether each row holds what was turned since the row before, and not since the beginning.
    #[serde(default)]
    pub increments: bool,
    /// What it reads in its unit where the joint stands as the robot's file has it, of absolute
    /// encoders; that of a wheel counts with `simulate.phases = "log"` alone.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub zero: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Where a column is found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ColumnPlace {
    /// So many columns in, counted from 1.
    Number(usize),
    /// Under this name in the header.
    Name(String),
}

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Measure {
    Time,
    Length,
    Angle,
    Rate,
    Current,
}

impl Column {
    /// Whether its numbers are angles, and not rates.
    pub(crate) fn is_angle(&self) -> bool {
        self.si()
            .is_some_and(|(measure, _)| measure == Measure::Angle)
    }

    /// What it measures, and by what its numbers become SI.
    pub(super) fn si(&self) -> Option<(Measure, f64)> {
        let (measure, factor) = match self.unit.as_str() {
            "s" => (Measure::Time, 1.0),
            "ms" => (Measure::Time, 1e-3),
            "us" => (Measure::Time, 1e-6),
            "ns" => (Measure::Time, 1e-9),
            "m" => (Measure::Length, 1.0),
            "cm" => (Measure::Length, 1e-2),
            "mm" => (Measure::Length, 1e-3),
            "in" => (Measure::Length, 0.0254),
            "rad" => (Measure::Angle, 1.0),
            "deg" => (Measure::Angle, PI / 180.0),
            "turns" => (Measure::Angle, TAU),
            "ticks" => (Measure::Angle, TAU / self.ticks_per_turn?),
            "rad/s" => (Measure::Rate, 1.0),
            "deg/s" => (Measure::Rate, PI / 180.0),
            "rpm" => (Measure::Rate, TAU / 60.0),
            "turns/s" => (Measure::Rate, TAU),
            "A" => (Measure::Current, 1.0),
            "mA" => (Measure::Current, 1e-3),
            _ => return None,
        };
        Some((measure, factor * self.scale))
    }
}

/// Refuses a format that no log of the robot could be read by.
pub(crate) fn check(format: &Format, robot: &Robot) -> Result<(), Error> {
    if let Some(Delayed::Known(delay_s)) = format.delay_s
        && (delay_s.is_nan() || delay_s.abs() > 10.0)
    {
        return invalid(
            format!("`log.delay_s` cannot be {delay_s}"),
            "it is within 10 seconds, or \"fit\"",
        );
    }
    if format.decimal_comma && format.delimiter == "," {
        return invalid(
            "`log.decimal_comma` and columns separated by commas do not go together",
            "name the separator of the columns: `log.delimiter = \";\"`",
        );
    }
    let wheels = wheel_names(robot);
    let steering = steering_names(robot);
    let mut columns: Vec<(String, &Column, &[Measure])> = Vec::new();
    for (name, column, measures) in [
        ("time", &format.time, &[Measure::Time] as &[Measure]),
        ("x", &format.x, &[Measure::Length]),
        ("y", &format.y, &[Measure::Length]),
        ("heading", &format.heading, &[Measure::Angle]),
    ] {
        if let Some(column) = column {
            columns.push((name.to_owned(), column, measures));
        }
    }
    for (section, known, names, measures) in [
        (
            "wheels",
            &format.wheels,
            &wheels,
            &[Measure::Angle, Measure::Rate] as &[Measure],
        ),
        ("steering", &format.steering, &steering, &[Measure::Angle]),
        ("currents", &format.currents, &wheels, &[Measure::Current]),
    ] {
        for (name, column) in known {
            if !names.contains(&name.as_str()) {
                let (what, those) = match (section, names.is_empty()) {
                    ("steering", true) => ("steering joint", "it has none".to_owned()),
                    ("steering", false) => {
                        ("steering joint", format!("they are {}", names.join(", ")))
                    }
                    _ => ("wheel", format!("its wheels are {}", names.join(", "))),
                };
                return invalid(
                    format!("`log.{section}.{name}`: the robot has no such {what}"),
                    those,
                );
            }
            columns.push((format!("{section}.{name}"), column, measures));
        }
    }
    for (name, column, measures) in &columns {
        check_column(name, column, measures, format.header_line)?;
    }
    for (index, (name, column, _)) in columns.iter().enumerate() {
        if let Some((other, _, _)) = columns[..index]
            .iter()
            .find(|(_, other, _)| other.column == column.column)
        {
            return invalid(
                format!("`log.{other}` and `log.{name}` are the same column"),
                "give each its own",
            );
        }
    }
    Ok(())
}

fn check_column(
    name: &str,
    column: &Column,
    measures: &[Measure],
    header_line: usize,
) -> Result<(), Error> {
    if column.unit == "ticks" && column.ticks_per_turn.is_none() {
        return invalid(
            format!("`log.{name}` is in ticks, but their number per turn is missing"),
            "give it `ticks_per_turn`: the ticks of one turn of the wheel, not of the motor",
        );
    }
    let refused = match column.si() {
        Some((measure, factor))
            if measures.contains(&measure) && factor.is_finite() && factor != 0.0 =>
        {
            None
        }
        Some(_) => Some(format!(
            "`log.{name}` cannot be in `{}`, scaled by {}",
            column.unit, column.scale
        )),
        None => Some(format!(
            "`{}` of `log.{name}` is an unknown unit",
            column.unit
        )),
    };
    if let Some(refused) = refused {
        let units: Vec<&str> = measures.iter().map(words).collect();
        return invalid(refused, format!("it is {}", units.join(" or ")));
    }
    if matches!(&column.column, ColumnPlace::Number(0)) {
        return invalid(format!("`log.{name}` is column 0"), "columns count from 1");
    }
    if header_line == 0 && matches!(column.column, ColumnPlace::Name(_)) {
        return invalid(
            format!(
                "`log.{name}` is a column's name, but the table has no header (`log.header_line` = 0)"
            ),
            "give its place, counted from 1",
        );
    }
    let is_steering = name.starts_with("steering.");
    let is_absolute =
        column.is_angle() && !column.increments && (is_steering || name.starts_with("wheels."));
    let is_right = is_zero(&column.zero) || (is_absolute && column.zero.is_finite());
    if !is_right {
        return invalid(
            format!("`log.{name}` has the `zero` {}", column.zero),
            "it is a finite angle of an absolute encoder",
        );
    }
    if column.increments && (is_steering || !column.is_angle()) {
        return invalid(
            format!("`log.{name}` has `increments`, which angles of wheels alone have"),
            "leave it out",
        );
    }
    Ok(())
}

fn invalid(message: impl Into<String>, help: impl Into<String>) -> Result<(), Error> {
    Err(Error::invalid(message, help))
}

/// The names of the joints that steer a robot's wheels, without those that follow others.
pub(super) fn steering_names(robot: &Robot) -> Vec<&str> {
    let joints = steering_joints(robot).into_iter();
    joints
        .map(|joint| robot.joints[joint].name.as_str())
        .collect()
}

/// The names of a robot's wheels, in their order.
pub(crate) fn wheel_names(robot: &Robot) -> Vec<&str> {
    robot
        .wheels
        .iter()
        .map(|wheel| wheel.name.as_str())
        .collect()
}

fn words(measure: &Measure) -> &'static str {
    match measure {
        Measure::Time => "a time, in \"s\", \"ms\", \"us\" or \"ns\"",
        Measure::Length => "a length, in \"m\", \"cm\", \"mm\" or \"in\"",
        Measure::Angle => "an angle, in \"rad\", \"deg\", \"turns\" or \"ticks\"",
        Measure::Rate => "a rate, in \"rad/s\", \"deg/s\", \"rpm\" or \"turns/s\"",
        Measure::Current => "a current, in \"A\" or \"mA\"",
    }
}
