//! Waypoints from a CSV file.

use std::path::Path;

use ilon_control::{Heading, Reference};
use nalgebra::Vector2;

use crate::Error;

/// The columns that a file of waypoints may have.
const COLUMNS: [&str; 4] = ["t_s", "x_m", "y_m", "heading_deg"];

/// Reads a path. Its times come from the file, or from a mean speed in m/s; its headings from the file where it has
/// them, else from `heading`.
pub(super) fn read(
    path: &Path,
    speed_m_s: Option<f64>,
    heading: Heading,
) -> Result<Reference, Error> {
    let fault = |message: String, help: String| Error::Waypoints {
        path: path.to_owned(),
        message,
        help,
    };
    let text = std::fs::read_to_string(path).map_err(|source| Error::read(path, &source))?;
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let parsing = |error: csv::Error| {
        fault(
            error.to_string(),
            "give every line as many values as the header has names".to_owned(),
        )
    };
    let header = reader.headers().map_err(parsing)?.clone();
    if let Some(unknown) = header.iter().find(|name| !COLUMNS.contains(name)) {
        let near = crate::scenario::nearest(unknown, COLUMNS);
        return Err(fault(
            format!("line 1: unknown column `{unknown}`"),
            match near {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the columns are {}", COLUMNS.join(", ")),
            },
        ));
    }
    let place = |name: &str| header.iter().position(|column| column == name);
    let required = |name: &str| {
        place(name).ok_or_else(|| {
            fault(
                format!("line 1: the column `{name}` is missing"),
                "begin with a header such as `t_s,x_m,y_m,heading_deg`".to_owned(),
            )
        })
    };
    let (x, y) = (required("x_m")?, required("y_m")?);
    let (t, phi) = (place("t_s"), place("heading_deg"));

    let mut times_s = Vec::new();
    let mut points_m = Vec::new();
    let mut headings_rad = Vec::new();
    for row in reader.records() {
        let row = row.map_err(parsing)?;
        let line = row.position().map_or(0, csv::Position::line);
        let number = |index: usize| {
            let text = row.get(index).unwrap_or("");
            match text.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(fault(
                    format!(
                        "line {line}: `{}` is \"{text}\", but must be a finite number",
                        &header[index]
                    ),
                    "write a number with a decimal point".to_owned(),
                )),
            }
        };
        points_m.push(Vector2::new(number(x)?, number(y)?));
        if let Some(t) = t {
            times_s.push(number(t)?);
        }
        if let Some(phi) = phi {
            headings_rad.push(number(phi)?.to_radians());
        }
    }
    let heading = match phi {
        Some(_) => Heading::Waypoints { headings_rad },
        None => heading,
    };
    let made = match (t, speed_m_s) {
        (Some(_), None) => Reference::waypoints(&times_s, points_m, heading),
        (None, Some(speed_m_s)) => Reference::waypoints_at_speed(points_m, speed_m_s, heading),
        (Some(_), Some(_)) => {
            return Err(fault(
                "both the column `t_s` and the key `speed_m_s` say when".to_owned(),
                "leave one of them out".to_owned(),
            ));
        }
        (None, None) => {
            return Err(fault(
                "neither a column `t_s` nor the key `speed_m_s` says when".to_owned(),
                "add one of them".to_owned(),
            ));
        }
    };
    made.map_err(|error| fault(error.to_string(), "mend the waypoints".to_owned()))
}
