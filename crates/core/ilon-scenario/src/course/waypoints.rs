//! Waypoints, listed in a scenario or in a CSV file.

use std::path::Path;

use ilon_control::{Heading, Reference};
use ilon_files::FileAccess;
use nalgebra::Vector2;

use crate::Error;
use crate::foreign::{Table, TableFormat, quoted};
use crate::scenario::is_computable;

/// The possible columns of a waypoint file.
const COLUMNS: [&str; 4] = ["t_s", "x_m", "y_m", "heading_deg"];

/// The largest waypoint file that is read, in bytes: about a million points. Chosen.
const MAX_BYTES: u64 = 64 << 20;

/// Waypoints listed in a scenario.
#[derive(Clone, Copy, Debug)]
pub(super) struct Listed<'a> {
    pub points_m: &'a [[f64; 2]],
    pub times_s: &'a [f64],
    pub headings_deg: &'a [f64],
}

impl Listed<'_> {
    pub fn is_empty(&self) -> bool {
        self.points_m.is_empty() && self.times_s.is_empty() && self.headings_deg.is_empty()
    }

    /// The path through them. Times are the listed ones, or follow from a mean speed in m/s;
    /// headings are the listed ones, else `heading`.
    pub fn path(self, speed_m_s: Option<f64>, heading: Heading) -> Result<Reference, Error> {
        let count = self.points_m.len();
        if count == 0 {
            return Err(Error::invalid(
                "`reference.waypoints` has no points",
                "list them, `points_m = [[0, 0], [1, 0], [1, 1]]`, or name a `file` of them",
            ));
        }
        for (key, found) in [
            ("times_s", self.times_s.len()),
            ("headings_deg", self.headings_deg.len()),
        ] {
            if found != 0 && found != count {
                return Err(Error::invalid(
                    format!("`reference.waypoints.{key}` has {found} numbers for {count} points"),
                    "give each point one, or leave them out",
                ));
            }
        }
        let points_m = self.points_m.iter().map(|[x, y]| Vector2::new(*x, *y));
        let heading = match self.headings_deg {
            [] => heading,
            listed => Heading::Waypoints {
                headings_rad: listed.iter().map(|deg| deg.to_radians()).collect(),
            },
        };
        let times_s = Some(self.times_s).filter(|times_s| !times_s.is_empty());
        let fault = |message: &str, help: &str| {
            Error::invalid(format!("`reference.waypoints`: {message}"), help)
        };
        let points_m = points_m.collect();
        through(points_m, "`times_s`", times_s, speed_m_s, heading, fault)
    }
}

/// The path through points at times, or at a mean speed in m/s. Messages name points by the given
/// name, and `fault` makes an error of a message and a help text.
fn through(
    points_m: Vec<Vector2<f64>>,
    times: &str,
    times_s: Option<&[f64]>,
    speed_m_s: Option<f64>,
    heading: Heading,
    fault: impl Fn(&str, &str) -> Error,
) -> Result<Reference, Error> {
    let made = match (times_s, speed_m_s) {
        (Some(times_s), None) => Reference::waypoints(times_s, points_m, heading),
        (None, Some(speed_m_s)) => Reference::waypoints_at_speed(points_m, speed_m_s, heading),
        (Some(_), Some(_)) => {
            let message = format!("both {times} and `speed_m_s` say when");
            return Err(fault(&message, "leave one of them out"));
        }
        (None, None) => {
            let message = format!("neither {times} nor `speed_m_s` says when");
            return Err(fault(&message, "add one of them"));
        }
    };
    made.map_err(|error| fault(&error.to_string(), "correct the waypoints"))
}

/// Reads a path. Times come from the file, or follow from a mean speed in m/s; headings come from
/// the file if it has them, else from `heading`.
pub(super) fn read(
    path: &Path,
    files: &FileAccess,
    speed_m_s: Option<f64>,
    heading: Heading,
) -> Result<Reference, Error> {
    let mut table = Table::open(path, files, MAX_BYTES, TableFormat::default())?;
    refuse_other_columns(&table)?;
    let needed = |name| {
        table.find(name, 1.0)?.ok_or_else(|| {
            table.fault(
                format!("line 1: the column `{name}` is missing"),
                "begin with a header such as `t_s,x_m,y_m,heading_deg`",
            )
        })
    };
    let (x, y) = (needed("x_m")?, needed("y_m")?);
    let t = table.find("t_s", 1.0)?;
    let phi = table.find("heading_deg", 1_f64.to_radians())?;

    let mut times_s = Vec::new();
    let mut points_m = Vec::new();
    let mut headings_rad = Vec::new();
    while table.next_row()? {
        points_m.push(Vector2::new(table.needed(&x)?, table.needed(&y)?));
        if let Some(t) = &t {
            let t_s = table.needed(t)?;
            if !is_computable(t_s) {
                return Err(table.beyond(t));
            }
            times_s.push(t_s);
        }
        if let Some(phi) = &phi {
            headings_rad.push(table.needed(phi)?);
        }
    }
    let heading = match phi {
        Some(_) => Heading::Waypoints { headings_rad },
        None => heading,
    };
    let times_s = t.map(|_| times_s.as_slice());
    let fault = |message: &str, help: &str| table.fault(message, help);
    through(
        points_m,
        "the column `t_s`",
        times_s,
        speed_m_s,
        heading,
        fault,
    )
}

/// Refuses columns that would be ignored.
fn refuse_other_columns(table: &Table<'_>) -> Result<(), Error> {
    let is_known = |name: &&String| COLUMNS.contains(&name.as_str());
    // Nothing is shown of a file that is not a list of waypoints: an untrusted scenario may name
    // any file.
    if !table.names().iter().any(|name| is_known(&name)) {
        return Err(table.fault(
            "it is not a file of waypoints: its first line has none of their columns",
            format!(
                "begin it with a header of some of these columns: {}",
                COLUMNS.join(", ")
            ),
        ));
    }
    let Some(unknown) = table.names().iter().find(|name| !is_known(name)) else {
        return Ok(());
    };
    Err(table.fault(
        format!("line 1: unknown column `{}`", quoted(unknown)),
        match crate::scenario::nearest(unknown, COLUMNS) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the columns are {}", COLUMNS.join(", ")),
        },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(csv: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("w.csv");
        std::fs::write(&path, csv).unwrap();
        let heading = Heading::Constant { heading_rad: 0.0 };
        match read(&path, &FileAccess::anywhere(), None, heading) {
            Ok(_) => "read".to_owned(),
            Err(Error::Contents { message, .. }) => message,
            Err(other) => other.to_string(),
        }
    }

    #[test]
    fn coordinates_and_times_are_of_a_size_to_compute_with() {
        let with = |t: &str, x: &str| told(&format!("t_s,x_m,y_m\n0,0,0\n{t},{x},0\n2,1,0\n"));
        assert_eq!(with("1", "1e9"), "read");
        assert_eq!(with("1", "-0"), "read");
        // sin(360 deg) is a zero.
        assert_eq!(with("1", "-2.4e-16"), "read");
        for wild in ["1e10", "-1e308"] {
            let expected = format!(
                "line 3: `x_m` is \"{wild}\", but must be 0 or of a size between 1e-12 and 1e9"
            );
            assert_eq!(with("1", wild), expected);
        }
        assert!(with("1e-300", "1").starts_with("line 3: `t_s` is \"1e-300\", but must be 0 or"));
        for (no_number, why) in [
            ("nan", "holds no number"),
            ("inf", "is \"inf\", but must be a number"),
            ("1e400", "is \"1e400\", but must be a number"),
            ("wide", "is text, but must be a number"),
        ] {
            assert_eq!(with("1", no_number), format!("line 3: `x_m` {why}"));
        }
    }

    #[test]
    fn points_that_are_listed_make_the_path_of_a_file_of_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("w.csv");
        let heading = || Heading::Tangent { offset_rad: 0.1 };
        let points_m = [[0.0, 0.0], [1.0, 0.25], [1.5, -0.5]];
        let [none, times_s, headings_deg]: [&[f64]; 3] =
            [&[], &[0.0, 2.0, 5.0], &[0.0, 90.0, 180.0]];
        for (csv, times_s, headings_deg, speed_m_s) in [
            ("x_m,y_m\n0,0\n1,0.25\n1.5,-0.5\n", none, none, Some(0.3)),
            (
                "t_s,x_m,y_m\n0,0,0\n2,1,0.25\n5,1.5,-0.5\n",
                times_s,
                none,
                None,
            ),
            (
                "x_m,y_m,heading_deg\n0,0,0\n1,0.25,90\n1.5,-0.5,180\n",
                none,
                headings_deg,
                Some(0.3),
            ),
        ] {
            std::fs::write(&path, csv).unwrap();
            let listed = Listed {
                points_m: &points_m,
                times_s,
                headings_deg,
            };
            let listed = listed.path(speed_m_s, heading()).unwrap();
            let of_file = read(&path, &FileAccess::anywhere(), speed_m_s, heading()).unwrap();
            for tenth in 0..80 {
                let t_s = 0.1 * f64::from(tenth);
                assert_eq!(listed.at(t_s), of_file.at(t_s), "{csv} at {t_s}");
            }
        }
    }

    #[test]
    fn points_that_say_too_little_or_too_much_are_refused() {
        let points_m = [[0.0, 0.0], [1.0, 0.0]];
        let said = |points_m: &[[f64; 2]], times_s: &[f64], headings_deg: &[f64], speed_m_s| {
            let listed = Listed {
                points_m,
                times_s,
                headings_deg,
            };
            let made = listed.path(speed_m_s, Heading::Constant { heading_rad: 0.0 });
            made.map_or_else(|error| error.to_string(), |_| "fine".to_owned())
        };
        assert_eq!(said(&points_m, &[], &[], Some(0.3)), "fine");
        assert!(said(&[], &[], &[], Some(0.3)).contains("no points"));
        assert!(said(&points_m, &[], &[], None).contains("says when"));
        assert!(said(&points_m, &[0.0, 1.0], &[], Some(0.3)).contains("say when"));
        assert!(said(&points_m, &[0.0], &[], None).contains("1 numbers for 2 points"));
        assert!(said(&points_m, &[], &[0.0; 3], Some(0.3)).contains("3 numbers for 2 points"));
        assert!(said(&points_m, &[1.0, 0.0], &[], None) != "fine");
        assert!(said(&points_m[..1], &[], &[], Some(0.3)) != "fine");
    }

    #[test]
    fn a_column_that_stands_twice_is_refused() {
        let twice = told("t_s,x_m,y_m,x_m\n0,0,0,5\n1,1,1,6\n");
        assert_eq!(twice, "the column `x_m` stands twice");
    }

    #[test]
    fn of_a_file_that_holds_no_waypoints_nothing_is_told() {
        let foreign = told("root:x:0:0:root:/root:/bin/bash\nTOKEN=secret\n");
        assert!(
            !foreign.contains("root:") && !foreign.contains("secret"),
            "{foreign}"
        );
        assert!(
            foreign.starts_with("it is not a file of waypoints"),
            "{foreign}"
        );
        // If it is one, not more than a person needs.
        let long = "a".repeat(10_000);
        let told = told(&format!("x_m,{long}\n"));
        assert!(told.len() < 100, "{told}");
    }
}
