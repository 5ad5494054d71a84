//! Checks of a study's section on simulating.

use ilon_robot::Robot;
use ilon_sim::Error;

use super::config::{Logged, Phases, Simulate};
use crate::log::{Column, wheel_names};
use crate::steered::is_steered;
use crate::study_file::StudyFile;

/// Longest simulated drive, in seconds.
const MOST_DRIVE_S: f64 = 600.0;

/// Largest number of sets of wheel angles per drive.
const MOST_PHASES: u32 = 1000;

/// Rejects invalid numbers of the quantities compared besides distances.
fn check_beside(section: &Simulate, file: &StudyFile) -> Result<(), Error> {
    let mut numbers = Vec::new();
    if let Some(heading) = &section.heading {
        let error = heading.least_error_rad_per_m;
        numbers.push(("heading.least_error_rad_per_m", error, true));
    }
    if let Some(currents) = &section.currents {
        if file.log.currents.is_empty() {
            return Err(Error::invalid(
                "`[simulate.currents]` is given, but the log has no currents",
                "name their columns in `[log.currents]`, or leave the section out",
            ));
        }
        let gear_ratio = currents.gear_ratio.unwrap_or(1.0);
        let constant = currents.torque_constant_n_m_a;
        numbers.push(("currents.torque_constant_n_m_a", constant, true));
        numbers.push(("currents.gear_ratio", gear_ratio, true));
        numbers.push(("currents.friction_n_m", currents.friction_n_m, false));
        let error = currents.least_error_n_m;
        numbers.push(("currents.least_error_n_m", error, true));
    }
    let is_bad = |(_, value, positive): &(&str, f64, bool)| {
        !(value.is_finite() && (*value > 0.0 || (!positive && *value == 0.0)))
    };
    if let Some((key, value, positive)) = numbers.into_iter().find(is_bad) {
        let range = if positive { "above 0" } else { "0 or more" };
        return Err(Error::invalid(
            format!("`simulate.{key}` = {value} is out of range"),
            format!("give it a number that is {range}"),
        ));
    }
    for (index, beside) in section.beside.iter().enumerate() {
        let twice = section.beside[..index]
            .iter()
            .any(|b| b.name == beside.name);
        if twice || beside.name.trim().is_empty() {
            return Err(Error::invalid(
                format!(
                    "`[[simulate.beside]]` {} needs a name of its own",
                    index + 1
                ),
                "give each another `name`",
            ));
        }
    }
    Ok(())
}

/// Rejects a section that cannot be simulated.
///
/// # Errors
/// If a number is invalid, or the logs or the robot lack what the section needs.
pub(crate) fn check(section: &Simulate, file: &StudyFile, robot: &Robot) -> Result<(), Error> {
    let invalid = |message: String, help: String| Err(Error::invalid(message, help));
    if is_steered(robot) {
        return invalid(
            "`[simulate]` drives at constant wheel rates, and has no steering angles".to_owned(),
            "leave it out: the kinematics of steered wheels is fitted without it".to_owned(),
        );
    }
    if !(section.drive_s > 0.0 && section.drive_s <= MOST_DRIVE_S) {
        return invalid(
            format!(
                "`simulate.drive_s` = {} is not a valid duration",
                section.drive_s
            ),
            "give it seconds above 0 and up to 600".to_owned(),
        );
    }
    match section.phases {
        Some(Phases::Count(count)) if !(1..=MOST_PHASES).contains(&count) => {
            return invalid(
                format!("`simulate.phases` = {count} is out of range"),
                format!("let it be from 1 to {MOST_PHASES}, or \"log\""),
            );
        }
        Some(Phases::Logged(Logged::Log)) => {
            let relative = |column: &&Column| column.increments || !column.is_angle();
            if let Some((wheel, _)) = file.log.wheels.iter().find(|(_, of)| relative(of)) {
                return invalid(
                    format!(
                        "`simulate.phases` = \"log\", but `log.wheels.{wheel}` has no absolute angle"
                    ),
                    "leave `phases` out, or log the angles of absolute encoders".to_owned(),
                );
            }
        }
        _ => {}
    }
    if !(section.least_error.is_finite() && section.least_error > 0.0) {
        return invalid(
            format!(
                "`simulate.least_error` = {} is not a valid error",
                section.least_error
            ),
            "give it a share of the way above 0, such as 0.003".to_owned(),
        );
    }
    check_beside(section, file)?;
    let Some(ripple) = &section.ripple else {
        return Ok(());
    };
    if !(ripple.stretch_s > 0.0 && ripple.stretch_s < section.drive_s) {
        return invalid(
            format!(
                "`simulate.ripple.stretch_s` = {} does not fit into a drive of {} s",
                ripple.stretch_s, section.drive_s
            ),
            "let it be above 0 and less than `simulate.drive_s`".to_owned(),
        );
    }
    let wheels = wheel_names(robot);
    let mut together = ripple.together.iter().flatten();
    if let Some(name) = together.find(|name| !wheels.contains(&name.as_str())) {
        return invalid(
            format!("`simulate.ripple.together`: the robot has no wheel `{name}`"),
            format!("its wheels are {}", wheels.join(", ")),
        );
    }
    Ok(())
}
