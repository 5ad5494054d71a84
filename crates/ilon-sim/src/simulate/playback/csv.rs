//! Logs as CSV files: a header with the names of columns, and numbers.

use ilon_files::{FileAccess, ReadError};

use ilon_robot::JointKind;

use super::joint_log::QUANTITIES;
use super::series::Series;
use super::wanted::{LogContents, MAX_BYTES, MOST_ROWS, Wanted};
use crate::Error;
use crate::foreign::{cell, is_head_of_log, quoted};
use crate::scenario::{Drives, Quantity, is_computable, nearest};

/// The columns that may say when, and how many nanoseconds one of their units has.
const TIMES: [(&str, f64); 4] = [("t_s", 1e9), ("time_s", 1e9), ("t_ms", 1e6), ("t_ns", 1.0)];

/// The names of the columns.
struct Header<'a> {
    names: &'a [String],
    /// Whether numbers stand below them: of other files no name is shown.
    is_log: bool,
}

/// A column that is needed, and what makes its numbers those of ilon.
struct Column {
    place: usize,
    factor: f64,
}

const PER_MINUTE: f64 = std::f64::consts::TAU / 60.0;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// What drives the robot and its joints, and where the real one was.
pub(super) fn read(wanted: &Wanted<'_>, files: &FileAccess) -> Result<LogContents, Error> {
    let file = files
        .reader(wanted.path, MAX_BYTES)
        .map_err(|fault| match fault {
            ReadError::TooLarge(_) => wanted.fault("it is larger than 4 GiB", "cut it into parts"),
            fault => Error::read(wanted.path, &fault),
        })?;
    let mut reader = ::csv::ReaderBuilder::new()
        .trim(::csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(std::io::BufReader::new(file));
    let parsing = |error: ::csv::Error| {
        wanted.fault(
            error.to_string(),
            "give every line as many values as the header has names, as plain text",
        )
    };
    let header = reader.headers().map_err(parsing)?;
    // Other programs begin a text with the mark of its byte order.
    let header: Vec<String> = header
        .iter()
        .map(|name| name.trim_start_matches('\u{feff}').to_owned())
        .collect();
    refuse_other_separators(wanted, &header)?;
    let mut rows = reader.into_records().peekable();
    let is_log = match rows.peek() {
        Some(Ok(row)) => is_head_of_log(header.iter().map(String::as_str), row.iter()),
        _ => false,
    };
    let header = Header {
        names: &header,
        is_log,
    };
    let columns = Columns::find(wanted, &header)?;
    wanted.refuse_unused_names()?;

    let mut contents = LogContents {
        driving: Series::new(columns.driving.len()),
        measured: columns.measured.as_ref().map(|_| Series::new(3)),
        joints: vec![Series::new(QUANTITIES.len()); columns.joints.len()],
    };
    let mut first_ns = None;
    for (index, row) in rows.enumerate() {
        let row = Row {
            wanted,
            header: &header,
            cells: &row.map_err(parsing)?,
        };
        let time_ns = row.time_ns(&columns.time)?;
        let since_ns = time_ns - *first_ns.get_or_insert(time_ns);
        row.take(&columns, since_ns as f64 / 1e9, &mut contents)?;
        if index >= MOST_ROWS {
            return Err(wanted.fault(
                format!("it has more than {MOST_ROWS} rows"),
                "cut it into parts",
            ));
        }
    }
    Ok(contents)
}

/// The columns that are needed.
struct Columns {
    time: Column,
    driving: Vec<Column>,
    /// Where the real robot was.
    measured: Option<Vec<Column>>,
    /// Of each joint that the log may drive, those of [`QUANTITIES`] that there are.
    joints: Vec<Vec<Option<Column>>>,
}

impl Columns {
    fn find(wanted: &Wanted<'_>, header: &Header<'_>) -> Result<Self, Error> {
        Ok(Self {
            time: column(wanted, header, &TIMES)?,
            driving: driving(wanted, header)?,
            measured: measured(wanted, header)?,
            joints: joints(wanted, header)?,
        })
    }
}

/// A line of numbers.
struct Row<'a> {
    wanted: &'a Wanted<'a>,
    header: &'a Header<'a>,
    cells: &'a ::csv::StringRecord,
}

impl Row<'_> {
    /// Adds what it holds, at a time.
    fn take(&self, columns: &Columns, t_s: f64, contents: &mut LogContents) -> Result<(), Error> {
        if let Some(values) = self.numbers(&columns.driving)?
            && !columns.driving.is_empty()
        {
            contents.driving.push(t_s, values);
        }
        if let (Some(columns), Some(poses)) = (&columns.measured, &mut contents.measured)
            && let Some(values) = self.numbers(columns)?
        {
            poses.push(t_s, values);
        }
        for (columns, series) in columns.joints.iter().zip(&mut contents.joints) {
            let mut said = [f64::NAN; QUANTITIES.len()];
            for (said, column) in said.iter_mut().zip(columns) {
                // A joint that is logged less often leaves its cells empty, or writes that it knows no number.
                if let Some(column) = column
                    && !["", "nan"].contains(&self.text(column).to_ascii_lowercase().as_str())
                {
                    *said = self.number(column)?;
                }
            }
            if !said.iter().all(|number| number.is_nan()) {
                series.push(t_s, said);
            }
        }
        Ok(())
    }

    fn text(&self, column: &Column) -> &str {
        self.cells.get(column.place).unwrap_or("")
    }

    fn time_ns(&self, column: &Column) -> Result<i128, Error> {
        nanoseconds(self.text(column), column.factor).ok_or_else(|| {
            self.fault(
                column,
                "a time",
                "write a number with a decimal point, or leave the line out",
            )
        })
    }

    fn number(&self, column: &Column) -> Result<f64, Error> {
        let number = self.text(column).parse::<f64>();
        match number.map(|number| number * column.factor) {
            Ok(number) if number.is_finite() && (is_computable(number) || number.abs() < 1.0) => {
                Ok(number)
            }
            _ => Err(self.fault(
                column,
                "a number that can be computed with",
                "write a number with a decimal point, or leave the line out",
            )),
        }
    }

    /// The numbers of columns that belong together; `None` where all are empty, as a log of something slower beside wheels leaves them.
    fn numbers(&self, columns: &[Column]) -> Result<Option<Vec<f64>>, Error> {
        let is_empty = |column: &&Column| self.text(column).is_empty();
        match columns.iter().find(is_empty) {
            None => {
                let numbers = columns.iter().map(|column| self.number(column));
                numbers.collect::<Result<_, _>>().map(Some)
            }
            Some(_) if columns.iter().all(|column| is_empty(&column)) => Ok(None),
            Some(empty) => Err(self.fault(
                empty,
                "a number, since the line holds some of the numbers that belong to it",
                "fill all of them in, or leave all of them empty",
            )),
        }
    }

    fn fault(&self, column: &Column, must: &str, help: &str) -> Error {
        let line = self.cells.position().map_or(0, ::csv::Position::line);
        let name = quoted(&self.header.names[column.place]);
        let text = cell(self.text(column));
        self.wanted.fault(
            format!("line {line}: `{name}` is {text}, but must be {must}"),
            help,
        )
    }
}

/// Of each joint that the log may drive, the columns of [`QUANTITIES`] that there are.
fn joints(wanted: &Wanted<'_>, header: &Header<'_>) -> Result<Vec<Vec<Option<Column>>>, Error> {
    let by = wanted.section.joints_by.unwrap_or(Quantity::Position);
    let column_of = |(joint, kind): &(&str, JointKind), quantity: Quantity| {
        let theirs = wanted.name(joint);
        // As a person writes it, or as in a trace of ilon; or as `playback.names` says.
        let mut names: Vec<(String, f64)> = Vec::new();
        for (kind, factor) in endings(*kind, quantity) {
            names.push((format!("{theirs}_{kind}"), *factor));
            names.push((format!("joint_{theirs}_{kind}"), *factor));
        }
        if theirs != *joint && quantity == by {
            names.push((theirs.to_owned(), 1.0));
        }
        find(
            wanted,
            header,
            names.iter().map(|(name, factor)| (name.as_str(), *factor)),
        )
    };
    let joints = wanted.joints.iter();
    joints
        .map(|joint| {
            QUANTITIES
                .into_iter()
                .map(|quantity| column_of(joint, quantity))
                .collect()
        })
        .collect()
}

/// How the names of columns end that say something of a joint, and what makes their numbers SI.
fn endings(kind: JointKind, quantity: Quantity) -> &'static [(&'static str, f64)] {
    match (kind, quantity) {
        (JointKind::Turns, Quantity::Position) => {
            &[("position_rad", 1.0), ("position_deg", DEGREE)]
        }
        (JointKind::Slides, Quantity::Position) => &[("position_m", 1.0), ("position_mm", 1e-3)],
        (JointKind::Turns, Quantity::Rate) => &[("rate_rad_s", 1.0), ("rate_deg_s", DEGREE)],
        (JointKind::Slides, Quantity::Rate) => &[("rate_m_s", 1.0), ("rate_mm_s", 1e-3)],
        (JointKind::Turns, Quantity::Effort) => &[("torque_n_m", 1.0), ("force_n_m", 1.0)],
        (JointKind::Slides, Quantity::Effort) => &[("force_n", 1.0)],
    }
}

fn driving(wanted: &Wanted<'_>, header: &Header<'_>) -> Result<Vec<Column>, Error> {
    let wheels = |kinds: &[(&str, f64)]| -> Result<Vec<Column>, Error> {
        let wheels = wanted.wheels.iter().enumerate();
        let columns = wheels.map(|(index, wheel)| {
            // By the joint's name, as a person writes it, or by its number, as in a trace of ilon.
            let names: Vec<(String, f64)> = kinds
                .iter()
                .flat_map(|(kind, factor)| {
                    [
                        (format!("{}_{kind}", wanted.name(wheel)), *factor),
                        (format!("wheel{index}_{kind}"), *factor),
                    ]
                })
                .chain(
                    wanted
                        .section
                        .names
                        .get(*wheel)
                        .map(|own| (own.clone(), 1.0)),
                )
                .collect();
            let names: Vec<(&str, f64)> = names
                .iter()
                .map(|(name, factor)| (name.as_str(), *factor))
                .collect();
            column(wanted, header, &names)
        });
        columns.collect()
    };
    match wanted.section.drives {
        Drives::WheelRates => wheels(&[
            ("rate_rad_s", 1.0),
            ("target_rad_s", 1.0),
            ("rate_deg_s", DEGREE),
            ("rate_rpm", PER_MINUTE),
        ]),
        Drives::WheelAngles => wheels(&[("angle_rad", 1.0), ("angle_deg", DEGREE)]),
        Drives::WheelTorques => wheels(&[("torque_n_m", 1.0)]),
        Drives::Twist => ["vx_m_s", "vy_m_s"]
            .map(|name| column(wanted, header, &[(name, 1.0)]))
            .into_iter()
            .chain([column(
                wanted,
                header,
                &[("omega_rad_s", 1.0), ("omega_deg_s", DEGREE)],
            )])
            .collect(),
        Drives::Path => pose(wanted, header, ""),
        Drives::Joints => Ok(Vec::new()),
    }
}

/// Where the real robot was: all three columns, or none.
fn measured(wanted: &Wanted<'_>, header: &Header<'_>) -> Result<Option<Vec<Column>>, Error> {
    let known = header
        .names
        .iter()
        .any(|name| name == wanted.name("measured_x_m"));
    known.then(|| pose(wanted, header, "measured_")).transpose()
}

fn pose(wanted: &Wanted<'_>, header: &Header<'_>, prefix: &str) -> Result<Vec<Column>, Error> {
    let one = |names: &[(&str, f64)]| {
        let names: Vec<(String, f64)> = names
            .iter()
            .map(|(name, factor)| (format!("{prefix}{name}"), *factor))
            .collect();
        let names: Vec<(&str, f64)> = names
            .iter()
            .map(|(name, factor)| (name.as_str(), *factor))
            .collect();
        column(wanted, header, &names)
    };
    Ok(vec![
        one(&[("x_m", 1.0), ("x_mm", 1e-3)])?,
        one(&[("y_m", 1.0), ("y_mm", 1e-3)])?,
        one(&[
            ("heading_rad", 1.0),
            ("heading_deg", std::f64::consts::PI / 180.0),
        ])?,
    ])
}

/// The one column that is called by any of these names, if there is one.
fn find<'n>(
    wanted: &Wanted<'_>,
    header: &Header<'_>,
    names: impl IntoIterator<Item = (&'n str, f64)>,
) -> Result<Option<Column>, Error> {
    let mut found = None;
    for (name, factor) in names {
        let theirs = wanted.name(name);
        let places: Vec<usize> = (0..header.names.len())
            .filter(|place| header.names[*place] == theirs)
            .collect();
        if places.len() > 1 {
            return Err(wanted.fault(
                format!("the column `{}` stands twice", quoted(theirs)),
                "keep the one that is meant",
            ));
        }
        if let (None, Some(place)) = (&found, places.first()) {
            found = Some(Column {
                place: *place,
                factor,
            });
        }
    }
    Ok(found)
}

/// The one column that is called by any of these names.
fn column(
    wanted: &Wanted<'_>,
    header: &Header<'_>,
    names: &[(&str, f64)],
) -> Result<Column, Error> {
    find(wanted, header, names.iter().copied())?.ok_or_else(|| {
        let (first, _) = names[0];
        let shown = header.names.iter().filter(|_| header.is_log);
        let near = nearest(first, shown.map(String::as_str));
        let hint = match near {
            Some(near) => format!(
                "if `{}` is meant, say so: `playback.names.{first} = \"{0}\"`",
                quoted(near)
            ),
            None => format!("name it by `playback.names.{first}`"),
        };
        wanted.fault(format!("the column `{first}` is missing"), hint)
    })
}

/// A time in whole nanoseconds, of which its unit has `unit_ns`.
///
/// A decimal is read digit by digit: seconds since 1970 leave an f64 no digits for what happens within a period.
fn nanoseconds(text: &str, unit_ns: f64) -> Option<i128> {
    let places = unit_ns.log10().round() as usize;
    let exact = || {
        let (sign, digits) = match text.strip_prefix('-') {
            Some(digits) => (-1, digits),
            None => (1, text),
        };
        let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
        let are_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        if !are_digits(whole) || !are_digits(part) || whole.len() + part.len() == 0 {
            return None;
        }
        let kept: String = part
            .chars()
            .chain(std::iter::repeat('0'))
            .take(places)
            .collect();
        let up = i128::from(
            part.as_bytes()
                .get(places)
                .is_some_and(|digit| *digit >= b'5'),
        );
        let magnitude: i128 = format!("{whole}{kept}").parse().ok()?;
        Some(sign * magnitude.checked_add(up)?)
    };
    exact()
        .or_else(|| {
            let time_ns = text.parse::<f64>().ok()? * unit_ns;
            // Beyond this, the difference of two would not fit.
            (time_ns.abs() < 1e30).then(|| time_ns.round() as i128)
        })
        .filter(|time_ns| time_ns.unsigned_abs() < 1 << 100)
}

/// A file whose values are not divided by commas has one column, named by the whole line.
fn refuse_other_separators(wanted: &Wanted<'_>, header: &[String]) -> Result<(), Error> {
    let [only] = header else {
        return Ok(());
    };
    match only
        .chars()
        .find(|letter| [';', '\t', '|'].contains(letter))
    {
        None => Ok(()),
        Some(separator) => Err(wanted.fault(
            format!("line 1: its columns are divided by {separator:?}"),
            "divide them by commas, and write numbers with decimal points",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_since_1970_keep_their_nanoseconds() {
        for (text, unit_ns, time_ns) in [
            ("1732255000.010000001", 1e9, 1_732_255_000_010_000_001),
            ("1732255000.01", 1e9, 1_732_255_000_010_000_000),
            ("1732255000010.5", 1e6, 1_732_255_000_010_500_000),
            ("1732255000010000001", 1.0, 1_732_255_000_010_000_001),
            // To the nearest, of digits that a sum of periods leaves behind.
            ("0.06999999999999999", 1e9, 70_000_000),
            ("-0.25", 1e9, -250_000_000),
            (".5", 1e9, 500_000_000),
            ("2.", 1e9, 2_000_000_000),
            ("1e-3", 1e9, 1_000_000),
        ] {
            assert_eq!(nanoseconds(text, unit_ns), Some(time_ns), "{text}");
        }
        for wrong in ["", ".", "-", "1,5", "nan", "inf", "1e300", "12:00"] {
            assert_eq!(nanoseconds(wrong, 1e9), None, "{wrong}");
        }
    }
}
