//! `ilon generate`: a URDF with explicit rollers from a short description.

use std::path::PathBuf;

use ilon_robot::{Robot, Spec};

use super::Outcome;
use crate::Error;

/// Arguments of `ilon generate`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The description, in TOML.
    spec: PathBuf,
    /// Where to write the URDF; without it, standard output.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes the URDF, if it is one that can be read.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let spec = Spec::load(&arguments.spec)?;
    let urdf = ilon_robot::generate(&spec)?;
    Robot::from_urdf_str(&urdf, &format!("the URDF of {}", arguments.spec.display()))?;
    match &arguments.out {
        Some(path) => ilon_trace::file::write_text(path, &urdf)?,
        None => super::print(&urdf)?,
    }
    Ok(Outcome::Done)
}
