//! `ilon explain`: the causes of a run's deviation, or possible causes of a robot's observed drift.

mod arguments;
mod of_robot;
mod of_scenario;
mod seen;

use super::failure::Failure;
use super::kind::{Kind, kind, wants};
use super::outcome::Outcome;
pub(super) use arguments::Arguments;

/// Explains a scenario's run, or a robot's drift.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let files = arguments.sandbox.files()?;
    wants(&arguments.file, &[Kind::Scenario, Kind::Robot], &files)?;
    if kind(&arguments.file, &files) == Some(Kind::Scenario) {
        if !arguments.seen.is_empty() {
            return Err(Failure::usage(
                "--seen is about a robot, and this is a scenario",
                "name the robot's file",
            ));
        }
        arguments.reading.none_beside(&arguments.file)?;
        return of_scenario::run(arguments, &files);
    }
    if arguments.open || arguments.out.as_os_str() != arguments::OUT {
        return Err(Failure::usage(
            "--out and --open are about a scenario, and this is a robot",
            "leave them out, or name a scenario",
        ));
    }
    of_robot::run(arguments, &files)
}
