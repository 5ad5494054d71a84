//! Logs as tables of text.

use std::borrow::Cow;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use ilon_files::FileAccess;
use ilon_robot::Robot;
use ilon_sim::Error;
use ilon_sim::foreign::{self, is_head_of_log, quoted};
use ilon_sim::scenario::nearest;

use super::format::{Column, ColumnPlace, Format, Measure};
use super::series::{Log, MAX_BYTES, MOST_ROWS, fault};

/// A column that was found.
struct NamedColumn {
    place: usize,
    name: String,
    measure: Measure,
    factor: f64,
    increments: bool,
    /// What it reads where the wheel stands as the robot's file has it, in SI.
    zero: f64,
    /// Whether a comma stands before its decimals.
    decimal_comma: bool,
}

pub(super) fn read(
    path: &Path,
    format: &Format,
    robot: &Robot,
    files: &FileAccess,
) -> Result<Log, Error> {
    let file = files
        .open(path)
        .map_err(|reason| Error::read(path, &reason))?;
    let size = file.metadata().map(|data| data.len()).unwrap_or(0);
    if size > MAX_BYTES {
        let message = format!("it has {size} bytes, where at most {MAX_BYTES} are read");
        return Err(fault(path, message, "cut it into parts"));
    }
    let mut lines = BufReader::new(file.take(MAX_BYTES));
    let header = header(path, format, &mut lines)?;
    let delimiter = delimiter(path, format)?;
    let names: Vec<String> = split(&header, delimiter);
    // Of a file that is no log nothing is shown: a study of a stranger may name any.
    let is_log = lines.fill_buf().is_ok_and(|ahead| {
        let end = ahead.iter().position(|byte| *byte == b'\n');
        let first = String::from_utf8_lossy(&ahead[..end.unwrap_or(ahead.len())]);
        let cells = split(&first, delimiter);
        is_head_of_log(
            names.iter().map(String::as_str),
            cells.iter().map(String::as_str),
        )
    });
    let find = |what: &str, column: &Column| found(path, format, (&names, is_log), what, column);
    let needed = |what: &str, column: &Option<Column>| match column {
        Some(column) => find(what, column),
        None => Err(fault(
            path,
            format!("nothing says which of its columns is `log.{what}`"),
            format!("write `log.{what} = {{ column = ..., unit = ... }}`"),
        )),
    };
    let time = match (&format.time, format.period_s) {
        (Some(column), _) => Some(find("time", column)?),
        (None, Some(_)) => None,
        (None, None) => {
            return Err(fault(
                path,
                "nothing says when its rows were".to_owned(),
                "name the column in `log.time`, or give `log.period_s`",
            ));
        }
    };
    let pose = [
        needed("x", &format.x)?,
        needed("y", &format.y)?,
        needed("heading", &format.heading)?,
    ];
    let of_wheels = |section: &str, known: &std::collections::BTreeMap<String, Column>| {
        let one = |wheel: &ilon_robot::Wheel| {
            let what = format!("{section}.{}", wheel.name);
            needed(&what, &known.get(&wheel.name).cloned())
        };
        robot.wheels.iter().map(one).collect::<Result<Vec<_>, _>>()
    };
    let wheels = of_wheels("wheels", &format.wheels)?;
    let currents = match format.currents.is_empty() {
        true => Vec::new(),
        false => of_wheels("currents", &format.currents)?,
    };

    let mut log = Log::default();
    let mut reader = ::csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(delimiter)
        .flexible(true)
        .from_reader(lines);
    let mut record = ::csv::ByteRecord::new();
    let mut angles = vec![0.0; wheels.len()];
    let mut row = 0_usize;
    loop {
        let more = reader.read_byte_record(&mut record);
        if !more.map_err(|e| {
            fault(
                path,
                e.to_string(),
                "save it as text in UTF-8, a row a line",
            )
        })? {
            break;
        }
        let line = format.header_line + record.position().map_or(row + 1, |at| at.line() as usize);
        row += 1;
        if row > MOST_ROWS {
            let message = format!("it has more than {MOST_ROWS} rows");
            return Err(fault(path, message, "cut it into parts"));
        }
        let number = |column: &NamedColumn| number(path, &record, line, column);
        let must = |column: &NamedColumn| match number(column)? {
            Some(value) => Ok(value),
            None => Err(fault(
                path,
                format!("line {line} has nothing in the column `{}`", column.name),
                "fill the gap, or leave the row out",
            )),
        };
        let t_s = match (&time, format.period_s) {
            (Some(column), _) => must(column)?,
            (None, period_s) => (row - 1) as f64 * period_s.unwrap_or(0.0),
        };
        for (angle, column) in angles.iter_mut().zip(&wheels) {
            let value = must(column)?;
            match (column.measure, column.increments) {
                (Measure::Rate, _) => {
                    let dt_s = log.times_s.last().map_or(0.0, |last| t_s - last);
                    *angle += value * dt_s;
                }
                (_, true) => *angle += value,
                _ => *angle = value - column.zero,
            }
        }
        let mut seen = [f64::NAN; 3];
        for (value, column) in seen.iter_mut().zip(&pose) {
            *value = number(column)?.unwrap_or(f64::NAN);
        }
        if !currents.is_empty() {
            let row: Result<Vec<f64>, Error> = currents.iter().map(must).collect();
            log.currents_a.push(row?);
        }
        log.times_s.push(t_s);
        log.angles_rad.push(angles.clone());
        log.poses.push(seen);
    }
    Ok(log)
}

/// The line of names, and everything before it left behind.
fn header(path: &Path, format: &Format, lines: &mut impl BufRead) -> Result<String, Error> {
    let mut line = Vec::new();
    for _ in 0..format.header_line {
        line.clear();
        let count = lines
            .by_ref()
            .take(1 << 20)
            .read_until(b'\n', &mut line)
            .map_err(|e| Error::read(path, &ilon_files::ReadError::Io(e)))?;
        if count == 0 {
            return Err(fault(
                path,
                format!(
                    "it ends before line {}, which should name its columns",
                    format.header_line
                ),
                "see `log.header_line`",
            ));
        }
    }
    // What some programs write before UTF-8, and what they end lines with.
    let text = String::from_utf8_lossy(&line);
    Ok(text.trim_start_matches('\u{feff}').trim_end().to_owned())
}

fn delimiter(path: &Path, format: &Format) -> Result<u8, Error> {
    match format.delimiter.as_bytes() {
        b"tab" => Ok(b'\t'),
        [one] => Ok(*one),
        _ => Err(fault(
            path,
            format!(
                "`log.delimiter` = \"{}\" is not one character",
                format.delimiter
            ),
            "write \",\", \";\", \" \" or \"tab\"",
        )),
    }
}

fn split(header: &str, delimiter: u8) -> Vec<String> {
    let mut record = ::csv::StringRecord::new();
    let mut reader = ::csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(delimiter)
        .from_reader(header.as_bytes());
    match reader.read_record(&mut record) {
        Ok(true) => record.iter().map(|name| name.trim().to_owned()).collect(),
        _ => Vec::new(),
    }
}

fn found(
    path: &Path,
    format: &Format,
    (names, is_log): (&[String], bool),
    what: &str,
    column: &Column,
) -> Result<NamedColumn, Error> {
    let place = match &column.column {
        ColumnPlace::Number(number) => number.saturating_sub(1),
        ColumnPlace::Name(name) => {
            let mut places = (0..names.len()).filter(|place| names[*place] == *name);
            match (places.next(), places.next()) {
                (Some(place), None) => place,
                (Some(_), Some(_)) => {
                    return Err(fault(
                        path,
                        format!("two of its columns are called `{}`", quoted(name)),
                        format!(
                            "give `log.{what}` the place of the one that is meant, counted from 1"
                        ),
                    ));
                }
                _ => {
                    let near = nearest(name, names.iter().map(String::as_str));
                    let hint = match (near.filter(|_| is_log), names.len()) {
                        (Some(near), _) => format!("is `{}` meant?", quoted(near)),
                        (None, 0 | 1) => format!(
                            "line {} holds one name alone: is `log.delimiter` = \"{}\" right?",
                            format.header_line, format.delimiter
                        ),
                        (None, _) if !is_log => format!(
                            "nothing of it is shown, since no row of numbers follows line {}: see `log.header_line` and `log.delimiter`",
                            format.header_line
                        ),
                        _ => {
                            let listed: Vec<String> =
                                names.iter().take(20).map(|name| quoted(name)).collect();
                            format!("its columns are {}", listed.join(", "))
                        }
                    };
                    return Err(fault(
                        path,
                        format!("it has no column `{}` for `log.{what}`", quoted(name)),
                        hint,
                    ));
                }
            }
        }
    };
    let Some((measure, factor)) = column.si() else {
        return Err(Error::invalid(
            format!("`{}` of `log.{what}` is no unit that is known", column.unit),
            "see `ilon schema`",
        ));
    };
    let name = match &column.column {
        ColumnPlace::Name(name) => name.clone(),
        ColumnPlace::Number(number) => number.to_string(),
    };
    Ok(NamedColumn {
        place,
        name,
        measure,
        factor,
        increments: column.increments,
        zero: column.zero * factor,
        decimal_comma: format.decimal_comma,
    })
}

/// The number of a cell, in SI; `None` of one that is empty or holds no number on purpose.
fn number(
    path: &Path,
    record: &::csv::ByteRecord,
    line: usize,
    column: &NamedColumn,
) -> Result<Option<f64>, Error> {
    let Some(cell) = record.get(column.place) else {
        return Err(fault(
            path,
            format!(
                "line {line} has {} columns, and no column {}",
                record.len(),
                column.place + 1
            ),
            "the row is cut off, or `log.delimiter` is another",
        ));
    };
    let text = String::from_utf8_lossy(cell);
    let text = text.trim_start_matches('\u{feff}').trim();
    if text.is_empty()
        || ["nan", "na", "null", "none"]
            .iter()
            .any(|word| text.eq_ignore_ascii_case(word))
    {
        return Ok(None);
    }
    let text = if column.decimal_comma && !text.contains('.') {
        Cow::Owned(text.replacen(',', ".", 1))
    } else {
        Cow::Borrowed(text)
    };
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && (value * column.factor).abs() <= 1e12 => {
            Ok(Some(value * column.factor))
        }
        _ => {
            let hint = match text.replace(',', ".").parse::<f64>() {
                Ok(_) => "decimals are written with a comma here: `log.decimal_comma = true`",
                Err(_) if line <= 10 => "rows begin after `log.header_line`: is the header longer?",
                Err(_) => "repair the cell, or leave the row out",
            };
            Err(fault(
                path,
                format!(
                    "line {line}, column `{}`: {} is no number",
                    column.name,
                    foreign::cell(&text)
                ),
                hint,
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;
    use std::f64::consts::TAU;

    use super::*;

    /// A log of the Volksbot whose three wheels are in a column each, as the format says of them.
    fn read_wheels(columns: &str, row: impl Fn(f64) -> f64) -> Log {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots");
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

    /// A wheel that turns steadily by its rates has turned by rate times time, whatever the unit.
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

    /// An absolute encoder that reads `zero` where the wheel stands as in the robot's file begins at what it reads less that.
    #[test]
    fn an_absolute_encoder_begins_at_its_reading_less_its_zero() {
        let log = read_wheels("unit = \"deg\", zero = 30", |t_s| 75.0 + 10.0 * t_s);
        // 45 degrees at first, and what it turns is counted from there.
        assert!((log.begun_rad[0] - 45_f64.to_radians()).abs() < 1e-12);
        let (t_s, angles) = (log.times_s[39], &log.angles_rad[39]);
        assert!((angles[0] - (10.0 * t_s).to_radians()).abs() < 1e-12);
    }
}
