//! What `ilon explain` is asked.

use std::path::PathBuf;

use super::seen::Seen;
use crate::cli::options::{Sandbox, Settings};
use crate::cli::robot::Reading;

/// Arguments of `ilon explain`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A scenario, of which every cause is left out in turn; or a robot's file, of which the usual suspects are tried in five standard motions.
    pub file: PathBuf,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub sandbox: Sandbox,
    /// Where to write the page and the results of a scenario.
    #[arg(long, value_name = "DIR", default_value = "out/explain/<scenario>")]
    pub out: PathBuf,
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long)]
    pub json: bool,
    /// Open the page of a scenario in the browser.
    #[arg(long)]
    pub open: bool,
    /// What you see of a real robot, such as "left 20 mm/m, turn 1 deg/m" when it should go ahead, or "turn: left 5 mm/turn" when it turns on the spot; may
    /// be given once for each motion: ahead, left, diagonal, arc, turn. Of a robot's file only: the suspects that would look like it come first.
    #[arg(long, value_name = "DRIFT")]
    pub(super) seen: Vec<Seen>,
    #[command(flatten)]
    pub reading: Reading,
}
