//! Logs as CSV files: a header with the names of columns, and numbers.

use ilon_robot::FileAccess;

use super::{MAX_BYTES, MOST_ROWS, Series, Wanted};
use crate::Error;
use crate::scenario::{Drives, is_computable, nearest};

/// A column that is needed, and what makes its numbers those of ilon.
struct Column {
    place: usize,
    factor: f64,
}

/// What drives the robot, and where the real one was.
pub(super) fn read(
    wanted: &Wanted<'_>,
    files: &FileAccess,
) -> Result<(Series, Option<Series>), Error> {
    let file = files
        .open(wanted.path)
        .map_err(|fault| Error::read(wanted.path, &fault))?;
    if file.metadata().is_ok_and(|about| about.len() > MAX_BYTES) {
        return Err(wanted.fault("it is larger than 4 GiB", "cut it into parts"));
    }
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
    let time = column(
        wanted,
        &header,
        &[
            ("t_s", 1.0),
            ("time_s", 1.0),
            ("t_ms", 1e-3),
            ("t_ns", 1e-9),
        ],
    )?;
    let driving = driving(wanted, &header)?;
    let measured = measured(wanted, &header)?;

    let mut driven = Series::new(driving.len());
    let mut poses = Series::new(3);
    for row in reader.records() {
        let row = row.map_err(parsing)?;
        let line = row.position().map_or(0, ::csv::Position::line);
        let number = |column: &Column| {
            let text = row.get(column.place).unwrap_or("");
            match text.parse::<f64>().map(|number| number * column.factor) {
                Ok(number) if number.is_finite() && (is_computable(number) || number.abs() < 1.0) => Ok(number),
                _ => Err(wanted.fault(
                    format!(
                        "line {line}: `{}` is \"{}\", but must be a number that can be computed with",
                        quoted(&header[column.place]),
                        quoted(text)
                    ),
                    "write a number with a decimal point, or leave the line out",
                )),
            }
        };
        let t_s = number(&time)?;
        // A log of something slower beside wheels leaves what it does not know empty.
        let is_there = |columns: &[Column]| {
            columns
                .iter()
                .all(|c| row.get(c.place).is_some_and(|text| !text.is_empty()))
        };
        if is_there(&driving) {
            let values: Vec<f64> = driving.iter().map(&number).collect::<Result<_, _>>()?;
            driven.push(t_s, values);
        }
        if let Some(columns) = measured
            .as_ref()
            .filter(|columns| is_there(columns.as_slice()))
        {
            let values: Vec<f64> = columns.iter().map(&number).collect::<Result<_, _>>()?;
            poses.push(t_s, values);
        }
        if driven.len() > MOST_ROWS {
            return Err(wanted.fault(
                format!("it has more than {MOST_ROWS} rows"),
                "cut it into parts",
            ));
        }
    }
    Ok((driven, measured.map(|_| poses)))
}

fn driving(wanted: &Wanted<'_>, header: &[String]) -> Result<Vec<Column>, Error> {
    const PER_MINUTE: f64 = std::f64::consts::TAU / 60.0;
    const DEGREE: f64 = std::f64::consts::PI / 180.0;
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
    }
}

/// Where the real robot was: all three columns, or none.
fn measured(wanted: &Wanted<'_>, header: &[String]) -> Result<Option<Vec<Column>>, Error> {
    let known = header
        .iter()
        .any(|name| name == wanted.name("measured_x_m"));
    known.then(|| pose(wanted, header, "measured_")).transpose()
}

fn pose(wanted: &Wanted<'_>, header: &[String], prefix: &str) -> Result<Vec<Column>, Error> {
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

/// The one column that is called by any of these names.
fn column(wanted: &Wanted<'_>, header: &[String], names: &[(&str, f64)]) -> Result<Column, Error> {
    let mut found = None;
    for (name, factor) in names {
        let theirs = wanted.name(name);
        let places: Vec<usize> = (0..header.len())
            .filter(|place| header[*place] == theirs)
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
                factor: *factor,
            });
        }
    }
    found.ok_or_else(|| {
        let (first, _) = names[0];
        let near = nearest(first, header.iter().map(String::as_str));
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

/// As a short text on one line.
fn quoted(text: &str) -> String {
    text.chars()
        .filter(|letter| !letter.is_control())
        .take(40)
        .collect()
}
