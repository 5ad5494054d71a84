//! Reads logs from text tables.

use std::collections::BTreeMap;
use std::path::Path;

use ilon_files::FileAccess;
use ilon_robot::{Robot, Wheel};
use ilon_sim::Error;
use ilon_sim::foreign::{self, Table, TableFormat};

use super::format::{Column, ColumnPlace, Format};
use super::series::Log;
use crate::steered::{has_column, steering_joints};

/// Largest file size of a log, in bytes.
const MAX_BYTES: u64 = 1 << 30;
/// The largest number, in SI units: seconds since 1970 exceed what a scenario allows.
const LARGEST: f64 = 1e12;

/// The columns to read.
struct Columns {
    /// Time of the row; absent for rows at a fixed period.
    time: Option<foreign::Column>,
    /// x, y and heading.
    pose: [foreign::Column; 3],
    /// `None` of a wheel that the log does not have.
    wheels: Vec<Option<WheelColumn>>,
    steering: Vec<SteeringColumn>,
    currents: Vec<foreign::Column>,
}

/// The column of a wheel.
struct WheelColumn {
    column: foreign::Column,
    holds: Holds,
}

/// The column of a joint that steers, by its index in the robot.
struct SteeringColumn {
    joint: usize,
    column: foreign::Column,
    zero_rad: f64,
}

/// Content of a wheel's column.
enum Holds {
    Rates,
    /// Angle since the row before.
    Increments,
    /// Angles, relative to this angle of the robot's file, in radians.
    AnglesFrom(f64),
}

pub(super) fn read(
    path: &Path,
    format: &Format,
    robot: &Robot,
    files: &FileAccess,
) -> Result<Log, Error> {
    let layout = TableFormat {
        delimiter: delimiter(path, format)?,
        header_line: format.header_line,
        decimal_comma: format.decimal_comma,
        largest: LARGEST,
        section: Some("log"),
    };
    let mut table = Table::open(path, files, MAX_BYTES, layout)?;
    let columns = Columns::find(&table, format, robot)?;
    let mut log = Log::default();
    let mut angles = vec![0.0; columns.wheels.len()];
    while table.next_row()? {
        let t_s = match &columns.time {
            Some(column) => table.needed(column)?,
            None => log.times_s.len() as f64 * format.period_s.unwrap_or(0.0),
        };
        let dt_s = log.times_s.last().map_or(0.0, |last| t_s - last);
        for (angle, wheel) in angles.iter_mut().zip(&columns.wheels) {
            if let Some(wheel) = wheel {
                wheel.turn(angle, &table, dt_s)?;
            }
        }
        if !columns.steering.is_empty() {
            let mut positions = vec![0.0; robot.joints.len()];
            for steering in &columns.steering {
                let read = table.needed(&steering.column)?;
                positions[steering.joint] = read - steering.zero_rad;
            }
            robot.couple(&mut positions);
            log.steering_rad.push(positions);
        }
        let mut seen = [f64::NAN; 3];
        for (value, column) in seen.iter_mut().zip(&columns.pose) {
            *value = table.number(column)?.unwrap_or(f64::NAN);
        }
        if !columns.currents.is_empty() {
            let currents = columns.currents.iter().map(|column| table.needed(column));
            log.currents_a.push(currents.collect::<Result<_, _>>()?);
        }
        log.times_s.push(t_s);
        log.angles_rad.push(angles.clone());
        log.poses.push(seen);
    }
    Ok(log)
}

impl WheelColumn {
    /// Advances the angle of a wheel to that of the next row.
    fn turn(&self, angle_rad: &mut f64, table: &Table<'_>, dt_s: f64) -> Result<(), Error> {
        let value = table.needed(&self.column)?;
        match self.holds {
            Holds::Rates => *angle_rad += value * dt_s,
            Holds::Increments => *angle_rad += value,
            Holds::AnglesFrom(zero_rad) => *angle_rad = value - zero_rad,
        }
        Ok(())
    }
}

impl Columns {
    fn find(table: &Table<'_>, format: &Format, robot: &Robot) -> Result<Self, Error> {
        let stated = |what: &str, column: Option<&Column>| match column {
            Some(column) => found(table, what, column),
            None => Err(table.fault(
                format!("the study does not name the column of `log.{what}`"),
                format!("write `log.{what} = {{ column = ..., unit = ... }}`"),
            )),
        };
        let named = |section: &str, name: &str, known: &BTreeMap<String, Column>| {
            stated(&format!("{section}.{name}"), known.get(name))
        };
        let time = match (&format.time, format.period_s) {
            (None, None) => {
                return Err(table.fault(
                    "nothing says when its rows were",
                    "name the column in `log.time`, or give `log.period_s`",
                ));
            }
            (column, _) => column.as_ref(),
        };
        let wheel = |wheel: &Wheel| -> Result<_, Error> {
            if !has_column(robot, wheel, &format.wheels) {
                return Ok(None);
            }
            let column = named("wheels", &wheel.name, &format.wheels)?;
            Ok(Some(WheelColumn {
                holds: match &format.wheels[&wheel.name] {
                    stated if !stated.is_angle() => Holds::Rates,
                    stated if stated.increments => Holds::Increments,
                    stated => Holds::AnglesFrom(stated.zero * column.factor),
                },
                column,
            }))
        };
        let steering = |joint: usize| -> Result<_, Error> {
            let name = &robot.joints[joint].name;
            let column = named("steering", name, &format.steering)?;
            Ok(SteeringColumn {
                joint,
                zero_rad: format.steering[name].zero * column.factor,
                column,
            })
        };
        let currents = robot.wheels.iter();
        let currents = currents.map(|wheel| named("currents", &wheel.name, &format.currents));
        Ok(Self {
            time: time
                .map(|column| found(table, "time", column))
                .transpose()?,
            pose: [
                stated("x", format.x.as_ref())?,
                stated("y", format.y.as_ref())?,
                stated("heading", format.heading.as_ref())?,
            ],
            wheels: robot.wheels.iter().map(wheel).collect::<Result<_, _>>()?,
            steering: (steering_joints(robot).into_iter())
                .map(steering)
                .collect::<Result<_, _>>()?,
            currents: match format.currents.is_empty() {
                true => Vec::new(),
                false => currents.collect::<Result<_, _>>()?,
            },
        })
    }
}

/// Returns the column of the table that the format names in `log.{what}`.
fn found(table: &Table<'_>, what: &str, stated: &Column) -> Result<foreign::Column, Error> {
    let Some((_, factor)) = stated.si() else {
        return Err(Error::invalid(
            format!("`{}` of `log.{what}` is an unknown unit", stated.unit),
            "see `ilon schema`",
        ));
    };
    match &stated.column {
        ColumnPlace::Number(number) => Ok(table.column_at(number.saturating_sub(1), factor)),
        ColumnPlace::Name(name) => {
            let column = table.find(name, factor)?;
            column.ok_or_else(|| table.missing(name, &format!("log.{what}.column")))
        }
    }
}

fn delimiter(path: &Path, format: &Format) -> Result<u8, Error> {
    match format.delimiter.as_bytes() {
        b"tab" => Ok(b'\t'),
        [one] => Ok(*one),
        _ => Err(Error::contents(
            path,
            format!(
                "`log.delimiter` = \"{}\" is not one character",
                format.delimiter
            ),
            "write \",\", \";\", \" \" or \"tab\"",
        )),
    }
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;
    use std::f64::consts::TAU;

    use super::*;

    /// A log of the Volksbot with one column per wheel, in the given format.
    fn read_wheels(columns: &str, row: impl Fn(f64) -> f64) -> Log {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
        let robot = Robot::load(assets.join("volksbot.urdf")).expect("a shipped robot");
        let mut text = "t,x,y,heading,wheel\n".to_owned();
        for k in 0..40 {
            let t_s = 0.05 * f64::from(k);
            text += &format!("{t_s},0,0,0,{}\n", row(t_s));
        }
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.csv");
        std::fs::write(&path, text).expect("written");
        let wheel = |name: &str| format!("wheels.{name} = {{ column = \"wheel\", {columns} }}\n");
        let wheels: String = robot.wheels.iter().map(|one| wheel(&one.name)).collect();
        let format: Format = toml::from_str(&format!(
            "time = {{ column = \"t\", unit = \"s\" }}\nx = {{ column = \"x\", unit = \"m\" }}\n\
             y = {{ column = \"y\", unit = \"m\" }}\nheading = {{ column = \"heading\", unit = \"rad\" }}\n{wheels}"
        ))
        .expect("a format");
        Log::read(&path, &format, &robot, &FileAccess::anywhere()).expect("a log")
    }

    /// A wheel with a steady rate turns by rate times time, whatever the unit.
    #[test]
    fn rates_are_summed_to_angles() {
        for (unit, of_rad_s) in [("rad/s", 1.0), ("rpm", TAU / 60.0)] {
            let log = read_wheels(&format!("unit = \"{unit}\""), |_| 3.0);
            for (t_s, angles) in log.times_s.iter().zip(&log.angles_rad) {
                // 40 sums of numbers below 10.
                assert!(
                    (angles[0] - 3.0 * of_rad_s * t_s).abs() < 1e-12,
                    "{unit} {t_s}"
                );
            }
        }
    }

    /// An absolute encoder that reads `zero` at the wheel's angle in the robot's file starts at its
    /// reading less `zero`.
    #[test]
    fn an_absolute_encoder_begins_at_its_reading_less_its_zero() {
        let log = read_wheels("unit = \"deg\", zero = 30", |t_s| 75.0 + 10.0 * t_s);
        // 45 degrees at first; rotation is counted from there.
        assert!((log.begun_rad[0] - 45_f64.to_radians()).abs() < 1e-12);
        let (t_s, angles) = (log.times_s[39], &log.angles_rad[39]);
        assert!((angles[0] - (10.0 * t_s).to_radians()).abs() < 1e-12);
    }
}
