//! `ilon generate`: a URDF with explicit rollers, or on tyres, from a short description.

use std::path::PathBuf;

use super::outcome::Outcome;
use super::{console, embed, reserve};
use crate::cli::failure::Failure;

/// Arguments of `ilon generate`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The description, in TOML.
    spec: PathBuf,
    /// File of the URDF [default: standard output].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Writes the URDF if it can be read and simulated.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    if arguments.spec.extension().is_some_and(|end| end != "toml") {
        let file = arguments.spec.display();
        return Err(Failure::usage(
            format!("`{file}` is not a description in TOML, of which a URDF is made"),
            "docs/format-robot.md and docs/format-robot-on-tyres.md have its keys, assets/robots examples",
        ));
    }
    let urdf = embed::generated(&arguments.spec)?;
    match &arguments.out {
        Some(path) => {
            let _claim = reserve::file(path, "--out", std::slice::from_ref(&arguments.spec))?;
            ilon_trace::file::write_text(path, &urdf)?;
        }
        None => console::data(&urdf)?,
    }
    Ok(Outcome::Done)
}
