//! `--mcap`: the bag beside a run's other results.

use std::path::PathBuf;

use ilon_formats::describe;
use ilon_messages::bag::{self, BagError};
use ilon_messages::topics::BagSink;

use super::output::OutputFolder;
use super::reserve;
use crate::cli::failure::Failure;
use crate::simulate::Simulation;

/// The bag of a run, in the folder of its results.
#[derive(Debug)]
pub(super) struct Bag {
    folder: PathBuf,
    wanted: bool,
}

impl Bag {
    /// Makes sure, before anything is simulated, that a bag can be written, where one is wanted, and that nothing is lost by it.
    pub fn prepare(out: &OutputFolder, wanted: bool, inputs: &[PathBuf]) -> Result<Self, Failure> {
        let folder = out.path().join("bag");
        // An earlier bag goes with the other results, whether or not this run makes one.
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

    /// Makes room: the bag of an earlier run goes. Gives what rows are written into, where a bag is wanted.
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
        other => Failure::usage(
            other.to_string(),
            "wait for its end, or choose another folder with --out",
        ),
    }
}
