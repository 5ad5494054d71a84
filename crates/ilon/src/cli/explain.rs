//! `ilon explain`: what makes a difference to a run, or what would look like what a robot does.

mod of_robot;
mod of_scenario;
mod seen;

use std::path::PathBuf;

use super::failure::Failure;
use super::options::{Sandbox, Settings};
use super::outcome::Outcome;
use super::robot::Reading;
use seen::Seen;

/// Arguments of `ilon explain`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// A scenario, of which every cause is left out in turn; or a robot's file, of which the usual suspects are tried in five standard motions.
    file: PathBuf,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    sandbox: Sandbox,
    /// Where to write the page and the results of a scenario.
    #[arg(long, value_name = "DIR", default_value = "out/explain/<scenario>")]
    out: PathBuf,
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long)]
    json: bool,
    /// Open the page of a scenario in the browser.
    #[arg(long)]
    open: bool,
    /// What you see of a real robot, such as "left 20 mm/m, turn 1 deg/m" when it should go ahead, or "turn: left 5 mm/turn" when it turns on the spot; may
    /// be given once for each motion: ahead, left, diagonal, arc, turn. Of a robot's file only: the suspects that would look like it come first.
    #[arg(long, value_name = "DRIFT")]
    seen: Vec<Seen>,
    #[command(flatten)]
    reading: Reading,
}

/// Explains a scenario's run, or a robot's drift.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let files = arguments.sandbox.files()?;
    if super::robot::is_scenario(&arguments.file, &files) {
        if !arguments.seen.is_empty() {
            return Err(Failure::usage(
                "--seen is about a robot, and this is a scenario",
                "name the robot's file",
            ));
        }
        return of_scenario::run(arguments, &files);
    }
    of_robot::run(arguments, &files)
}
