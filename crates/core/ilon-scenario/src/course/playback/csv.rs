//! Logs as CSV files: a header with column names, and rows of numbers.

use ilon_files::FileAccess;
use ilon_robot::JointKind;

use super::joint_log::QUANTITIES;
use super::series::Series;
use super::wanted::{LogContents, Wanted};
use crate::Error;
use crate::foreign::{Column, Table, TableFormat};
use crate::scenario::{Drives, Quantity};

/// The largest log that is read, in bytes. Chosen.
const MAX_BYTES: u64 = 4 << 30;

/// The possible time columns, with the nanoseconds of one of their units.
const TIMES: [(&str, f64); 4] = [("t_s", 1e9), ("time_s", 1e9), ("t_ms", 1e6), ("t_ns", 1.0)];

const PER_MINUTE: f64 = std::f64::consts::TAU / 60.0;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Reads the motion of robot and joints, and the real robot's poses.
pub(super) fn read(wanted: &Wanted<'_>, files: &FileAccess) -> Result<LogContents, Error> {
    let mut table = Table::open(wanted.path, files, MAX_BYTES, TableFormat::default())?;
    let columns = Columns::find(wanted, &table)?;
    wanted.refuse_unused_names()?;

    let mut contents = LogContents {
        driving: Series::new(columns.driving.len()),
        measured: columns.measured.as_ref().map(|_| Series::new(3)),
        joints: vec![Series::new(QUANTITIES.len()); columns.joints.len()],
        is_whole: true,
    };
    let mut first_ns = None;
    while table.next_row()? {
        let time_ns = time_ns(&table, &columns.time)?;
        let since_ns = time_ns - *first_ns.get_or_insert(time_ns);
        columns.take(&table, since_ns as f64 / 1e9, &mut contents)?;
    }
    Ok(contents)
}

/// The columns that are read.
struct Columns {
    time: Column,
    driving: Vec<Column>,
    /// The real robot's pose.
    measured: Option<Vec<Column>>,
    /// For each joint that the log may drive, the existing columns of [`QUANTITIES`].
    joints: Vec<Vec<Option<Column>>>,
}

impl Columns {
    fn find(wanted: &Wanted<'_>, table: &Table<'_>) -> Result<Self, Error> {
        let known = NamedColumns { wanted, table };
        Ok(Self {
            time: known.column(&TIMES.map(owned))?,
            driving: known.driving()?,
            measured: known.measured()?,
            joints: known.joints()?,
        })
    }

    /// Adds the data of a row, at a time.
    fn take(&self, row: &Table<'_>, t_s: f64, contents: &mut LogContents) -> Result<(), Error> {
        if let Some(values) = numbers(row, &self.driving)? {
            contents.driving.push(t_s, values);
        }
        if let (Some(columns), Some(poses)) = (&self.measured, &mut contents.measured)
            && let Some(values) = numbers(row, columns)?
        {
            poses.push(t_s, values);
        }
        for (columns, series) in self.joints.iter().zip(&mut contents.joints) {
            let mut said = [f64::NAN; QUANTITIES.len()];
            for (said, column) in said.iter_mut().zip(columns) {
                // The cells of a joint that is logged less often are empty, or contain NaN.
                if let Some(column) = column {
                    *said = row.number(column)?.unwrap_or(f64::NAN);
                }
            }
            if !said.iter().all(|number| number.is_nan()) {
                series.push(t_s, said);
            }
        }
        Ok(())
    }
}

/// The numbers of columns that belong together; `None` if all are empty, as in a log of a slower
/// signal beside wheels.
fn numbers(row: &Table<'_>, columns: &[Column]) -> Result<Option<Vec<f64>>, Error> {
    let found = columns.iter().map(|column| row.number(column));
    let found: Vec<Option<f64>> = found.collect::<Result<_, _>>()?;
    if found.iter().all(Option::is_none) {
        return Ok(None);
    }
    let numbers = found.into_iter().zip(columns);
    numbers
        .map(|(number, column)| number.map_or_else(|| row.needed(column), Ok))
        .collect::<Result<_, _>>()
        .map(Some)
}

/// The columns of a table, under the names from the scenario.
struct NamedColumns<'a> {
    wanted: &'a Wanted<'a>,
    table: &'a Table<'a>,
}

/// A possible column name, and the factor to SI units.
type Name = (String, f64);

fn owned((name, factor): (&str, f64)) -> Name {
    (name.to_owned(), factor)
}

impl NamedColumns<'_> {
    /// The only column with one of these names, if there is one.
    fn find(&self, names: &[Name]) -> Result<Option<Column>, Error> {
        let mut found = None;
        for (name, factor) in names {
            let column = self.table.find(self.wanted.name(name), *factor)?;
            found = found.or(column);
        }
        Ok(found)
    }

    /// The only column with one of these names.
    fn column(&self, names: &[Name]) -> Result<Column, Error> {
        self.find(names)?.ok_or_else(|| {
            let (first, _) = &names[0];
            let key = format!("playback.names.{first}");
            self.table.missing(self.wanted.name(first), &key)
        })
    }

    /// For each joint that the log may drive, the existing columns of [`QUANTITIES`].
    fn joints(&self) -> Result<Vec<Vec<Option<Column>>>, Error> {
        let by = self.wanted.section.joints_by.unwrap_or(Quantity::Position);
        let column_of = |(joint, kind): &(&str, JointKind), quantity: Quantity| {
            let theirs = self.wanted.name(joint);
            // Named by hand, as in a trace of ilon, or by `playback.names`.
            let mut names: Vec<Name> = Vec::new();
            for (kind, factor) in endings(*kind, quantity) {
                names.push((format!("{theirs}_{kind}"), *factor));
                names.push((format!("joint_{theirs}_{kind}"), *factor));
            }
            if theirs != *joint && quantity == by {
                names.push((theirs.to_owned(), 1.0));
            }
            self.find(&names)
        };
        let joints = self.wanted.joints.iter();
        joints
            .map(|joint| {
                QUANTITIES
                    .into_iter()
                    .map(|quantity| column_of(joint, quantity))
                    .collect()
            })
            .collect()
    }

    fn driving(&self) -> Result<Vec<Column>, Error> {
        match self.wanted.section.drives {
            Drives::WheelRates => self.wheels(&[
                ("rate_rad_s", 1.0),
                ("target_rad_s", 1.0),
                ("rate_deg_s", DEGREE),
                ("rate_rpm", PER_MINUTE),
            ]),
            Drives::WheelAngles => self.wheels(&[("angle_rad", 1.0), ("angle_deg", DEGREE)]),
            Drives::WheelTorques => self.wheels(&[("torque_n_m", 1.0)]),
            Drives::Twist => [
                &[("vx_m_s", 1.0)] as &[_],
                &[("vy_m_s", 1.0)],
                &[("omega_rad_s", 1.0), ("omega_deg_s", DEGREE)],
            ]
            .into_iter()
            .map(|names| self.column(&names.iter().copied().map(owned).collect::<Vec<_>>()))
            .collect(),
            Drives::Path => self.pose(""),
            Drives::Joints => Ok(Vec::new()),
        }
    }

    /// One column per wheel.
    fn wheels(&self, kinds: &[(&str, f64)]) -> Result<Vec<Column>, Error> {
        // Names of wheels that no motor drives are known too.
        self.wanted.all_wheels.iter().for_each(|wheel| {
            self.wanted.name(wheel);
        });
        let columns = self.wanted.wheels.iter().map(|(index, wheel)| {
            let theirs = self.wanted.name(wheel);
            // By the joint's name, as written by hand, or by its index, as in a trace of ilon.
            let mut names: Vec<Name> = Vec::new();
            for (kind, factor) in kinds {
                names.push((format!("{theirs}_{kind}"), *factor));
                names.push((format!("wheel{index}_{kind}"), *factor));
            }
            if self.wanted.section.names.contains_key(*wheel) {
                names.push((theirs.to_owned(), 1.0));
            }
            self.column(&names)
        });
        columns.collect()
    }

    /// The real robot's pose: all three columns, or none.
    fn measured(&self) -> Result<Option<Vec<Column>>, Error> {
        let x = self.wanted.name("measured_x_m");
        let is_known = self.table.names().iter().any(|name| name == x);
        is_known.then(|| self.pose("measured_")).transpose()
    }

    fn pose(&self, prefix: &str) -> Result<Vec<Column>, Error> {
        [
            [("x_m", 1.0), ("x_mm", 1e-3)],
            [("y_m", 1.0), ("y_mm", 1e-3)],
            [("heading_rad", 1.0), ("heading_deg", DEGREE)],
        ]
        .into_iter()
        .map(|names| self.column(&names.map(|(name, factor)| (format!("{prefix}{name}"), factor))))
        .collect()
    }
}

/// The endings of a joint's column names, and the factors to SI units.
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

fn time_ns(row: &Table<'_>, column: &Column) -> Result<i128, Error> {
    nanoseconds(&row.text(column)?, column.factor).ok_or_else(|| {
        row.wrong(
            column,
            "a time",
            "write a number with a decimal point, or leave the line out",
        )
    })
}

/// A time in whole nanoseconds; one unit is `unit_ns`.
///
/// A decimal is read digit by digit: an f64 with seconds since 1970 has no digits left for
/// fractions of a period.
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
            // Beyond this, the difference of two times would overflow.
            (time_ns.abs() < 1e30).then(|| time_ns.round() as i128)
        })
        .filter(|time_ns| time_ns.unsigned_abs() < 1 << 100)
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
            // To the nearest: sums of periods leave such digits.
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
