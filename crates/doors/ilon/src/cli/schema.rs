//! `ilon schema`: the JSON Schema of an input file.

use clap::ValueEnum;
use ilon_formats::{Spec, SpecOnTyres};

use super::console;
use super::outcome::Outcome;
use crate::Scenario;
use crate::cli::failure::Failure;
use crate::sweep::StudyFile;

/// Arguments of `ilon schema`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Which file.
    #[arg(value_enum, default_value_t)]
    file: File,
}

/// A file that a person writes.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum File {
    /// One run, as `ilon run` takes it.
    #[default]
    Scenario,
    /// A robot in short, as `ilon generate` takes it.
    Robot,
    /// A robot on tyres in short, as `ilon generate` takes it.
    RobotOnTyres,
    /// Many runs, as `ilon sweep` takes them.
    Study,
}

/// Prints the schema.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let schema = match arguments.file {
        File::Scenario => Scenario::json_schema(),
        File::Robot => Spec::json_schema(),
        File::RobotOnTyres => SpecOnTyres::json_schema(),
        File::Study => StudyFile::json_schema(),
    };
    console::data(&format!("{schema:#}\n"))?;
    Ok(Outcome::Done)
}
