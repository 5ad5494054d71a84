//! `--mcap`: the MCAP bag of a run.

use std::path::PathBuf;

use ilon_formats::describe;
use ilon_messages::bag::{self, BagError};
use ilon_messages::topics::BagSink;

use super::output::OutputFolder;
use super::reserve;
use crate::cli::failure::Failure;
use crate::simulate::Simulation;

/// The bag of a run, in the results folder.
#[derive(Debug)]
pub(super) struct Bag {
    folder: PathBuf,
    wanted: bool,
}

impl Bag {
    /// Checks before simulation that a requested bag can be written and replaces nothing but an
    /// earlier bag.
    pub fn prepare(out: &OutputFolder, wanted: bool, inputs: &[PathBuf]) -> Result<Self, Failure> {
        let folder = out.path().join("bag");
        // An earlier bag is replaced with the other results, even if this run writes none.
        if wanted || bag::is_own(&folder) {
            for file in ["bag_0.mcap", "bag_0.mcap.ilon-partial", "metadata.yaml"] {
                reserve::not_an_input(&folder.join(file), "--out", inputs)?;
            }
        }
        let is_empty = folder
            .read_dir()
            .is_ok_and(|mut entries| entries.next().is_none());
        if wanted && folder.exists() && !is_empty && !bag::is_own(&folder) {
            return Err(Failure::usage(
                format!(
                    "`{}` was not written by a run, and a bag would replace it",
                    folder.display()
                ),
                "move it elsewhere, or choose another folder with --out",
            ));
        }
        Ok(Self { folder, wanted })
    }

    /// Removes the bag of an earlier run. Returns the sink for rows, if a bag is requested.
    pub fn begin(&self, simulation: &Simulation) -> Result<Option<BagSink>, Failure> {
        bag::remove_own(&self.folder).map_err(failure)?;
        let robot = simulation.plant().robot();
        let described = || describe(robot, &simulation.trace().header.urdf);
        let sink = || BagSink::create(&self.folder, robot, described());
        self.wanted.then(sink).transpose().map_err(failure)
    }
}

fn failure(error: BagError) -> Failure {
    match error {
        BagError::Io { path, source } => Failure::write(&path, &source),
        other => Failure::usage(other.to_string(), "choose another folder with --out"),
    }
}
