//! Arguments of `ilon explain`.

use std::path::PathBuf;

use super::seen::Seen;
use crate::cli::options::{Sandbox, Settings};
use crate::cli::robot::Reading;

/// The default of `--out`.
pub(super) const OUT: &str = "out/explain/<scenario>";

/// Arguments of `ilon explain`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A scenario, run without each cause in turn; or a robot's file, tried with the usual causes
    /// in five standard motions.
    pub file: PathBuf,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub sandbox: Sandbox,
    /// Folder of the results of a scenario.
    #[arg(long, value_name = "DIR", default_value = OUT)]
    pub out: PathBuf,
    /// Print as JSON, and nothing else, on standard output.
    #[arg(long)]
    pub json: bool,
    /// Open the page of a scenario in the browser.
    #[arg(long)]
    pub open: bool,
    /// The drift of your real robot: "left 20 mm/m, turn 1 deg/m" of a drive of 1 m ahead, "left 60
    /// mm over 3 m" of a longer one, "turn: left 5 mm/turn" for another motion (ahead, left,
    /// diagonal, arc, turn; once each). Ranks the causes that look like it.
    #[arg(long, value_name = "DRIFT")]
    pub(super) seen: Vec<Seen>,
    #[command(flatten)]
    pub reading: Reading,
}
