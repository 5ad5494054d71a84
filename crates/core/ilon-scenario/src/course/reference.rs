//! The reference of a scenario, as `ilon-control` tracks it.

use ilon_control::{Heading, Reference};
use ilon_robot::Pose;
use nalgebra::Vector2;

use crate::Error;
use crate::course::waypoints;
use crate::scenario::{self, Scenario};

/// The reference of a scenario, if it has one.
///
/// # Errors
/// If it is impossible, or its waypoints cannot be read.
pub fn reference_of(scenario: &Scenario) -> Result<Option<Reference>, Error> {
    let section = scenario.reference.as_ref();
    section
        .map(|section| reference(section, scenario))
        .transpose()
}

fn reference(section: &scenario::Tracked, scenario: &Scenario) -> Result<Reference, Error> {
    use scenario::Reference as Section;
    let reference = match &section.path {
        Section::Line {
            from_x_m,
            from_y_m,
            to_x_m,
            to_y_m,
            speed_m_s,
            heading,
        } => Reference::line(
            Vector2::new(*from_x_m, *from_y_m),
            Vector2::new(*to_x_m, *to_y_m),
            *speed_m_s,
            heading_of(heading),
        ),
        Section::Circle {
            center_x_m,
            center_y_m,
            radius_m,
            speed_m_s,
            start_deg,
            heading,
        } => Reference::circle(
            Vector2::new(*center_x_m, *center_y_m),
            *radius_m,
            *speed_m_s,
            start_deg.to_radians(),
            heading_of(heading),
        ),
        Section::FigureEight {
            center_x_m,
            center_y_m,
            half_width_m,
            axis_deg,
            period_s,
            heading,
        } => Reference::figure_eight(
            Vector2::new(*center_x_m, *center_y_m),
            *half_width_m,
            axis_deg.to_radians(),
            *period_s,
            heading_of(heading),
        ),
        Section::Waypoints {
            points_m,
            times_s,
            headings_deg,
            file,
            speed_m_s,
            heading,
        } => {
            let heading = heading_of(heading);
            // A path that gets a new timing still needs some times.
            let untimed = section.timing.is_some() && times_s.is_empty() && file.is_none();
            let speed_m_s = &speed_m_s.or(untimed.then_some(1.0));
            let listed = waypoints::Listed {
                points_m,
                times_s,
                headings_deg,
            };
            return match file {
                Some(file) if listed.is_empty() => {
                    let path = scenario.resolve(file);
                    waypoints::read(&path, &scenario.files, *speed_m_s, heading)
                }
                Some(_) => Err(Error::invalid(
                    "`reference.waypoints` has a `file` and points of its own",
                    "leave one of them out",
                )),
                None => listed.path(*speed_m_s, heading),
            };
        }
        Section::HoldPose {
            x_m,
            y_m,
            heading_deg,
        } => Reference::hold(Pose {
            x_m: *x_m,
            y_m: *y_m,
            heading_rad: heading_deg.to_radians(),
        }),
    };
    Ok(reference?)
}

fn heading_of(section: &scenario::Heading) -> Heading {
    match *section {
        scenario::Heading::ConstantDeg(heading_deg) => Heading::Constant {
            heading_rad: heading_deg.to_radians(),
        },
        scenario::Heading::AlongPath => Heading::Tangent { offset_rad: 0.0 },
        scenario::Heading::FromPathDeg(offset_deg) => Heading::Tangent {
            offset_rad: offset_deg.to_radians(),
        },
        scenario::Heading::Turning {
            from_deg,
            rate_deg_s,
        } => Heading::Rate {
            start_rad: from_deg.to_radians(),
            rate_rad_s: rate_deg_s.to_radians(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMED: &str = "reference.timing = \"as fast as grip allows\"\n";
    const POINTS: &str = "reference.waypoints.points_m = [[0, 0], [1, 0], [1, 1]]\n";
    const TIMES: &str = "reference.waypoints.times_s = [0, 2, 5]\n";
    const FILE: &str = "reference.waypoints.file = \"path.csv\"\n";

    fn made(keys: &str) -> Result<Reference, Error> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("path.csv");
        std::fs::write(path, "t_s,x_m,y_m\n0,0,0\n2,1,0\n5,1,1\n").expect("it is written");
        let text = format!("robot.file = \"mecanum4.urdf\"\n{keys}run.duration_s = 5\n");
        let scenario = Scenario::from_toml(&text, "reference", folder.path()).expect("a scenario");
        Ok(reference_of(&scenario)?.expect("it has one"))
    }

    /// Waypoints need times, from the list, a file or a speed. A default speed replaces them only
    /// if the path gets a new timing anyway, and never beside times of the path.
    #[test]
    fn a_speed_stands_in_only_for_times_that_have_no_effect() {
        let untimed = made(POINTS).unwrap_err().to_string();
        assert!(untimed.contains("says when"), "{untimed}");
        for keys in [
            format!("{POINTS}{TIMES}"),
            FILE.to_owned(),
            format!("{POINTS}reference.waypoints.speed_m_s = 0.5\n"),
            format!("{POINTS}{TIMED}"),
            format!("{POINTS}{TIMES}{TIMED}"),
            format!("{FILE}{TIMED}"),
            format!("{POINTS}reference.waypoints.speed_m_s = 0.5\n{TIMED}"),
        ] {
            let reference = made(&keys).unwrap_or_else(|error| panic!("{error}: {keys}"));
            // The same path in any timing: from rest at the first point.
            let start = reference.at(0.0).pose.position_m();
            assert!(start.norm() < 1e-9, "{start}: {keys}");
        }
    }
}
