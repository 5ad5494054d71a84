//! `ilon generate`: a URDF with explicit rollers, or on tyres, from a short description.

use std::path::{Path, PathBuf};

use ilon_formats::{LoadRobot, Spec, SpecOnTyres};
use ilon_robot::Robot;

use super::outcome::Outcome;
use super::{console, reserve};
use crate::cli::failure::Failure;
use crate::simulate::Simulation;
use crate::{Error, Scenario};

/// The smallest scenario of a robot.
const STANDING: &str = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 0.1\n";

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
    let urdf = generated(&arguments.spec)?;
    match &arguments.out {
        Some(path) => {
            let _claim = reserve::file(path, "--out", std::slice::from_ref(&arguments.spec))?;
            ilon_trace::file::write_text(path, &urdf)?;
        }
        None => console::data(&urdf)?,
    }
    Ok(Outcome::Done)
}

/// The URDF of a robot description, if it can be read and simulated.
///
/// # Errors
/// [`Error`] if the description is impossible, or its robot cannot be simulated.
pub fn generated(spec: &Path) -> Result<String, Error> {
    let urdf = match SpecOnTyres::load(spec)? {
        Some(spec) => ilon_formats::generate_on_tyres(&spec),
        None => ilon_formats::generate(&Spec::load(spec)?)?,
    };
    let robot = Robot::from_urdf_str(&urdf, &format!("{} (generated)", spec.display()))?;
    Simulation::with_robot(&Scenario::from_toml(STANDING, "standing", "")?, &robot)?;
    Ok(urdf)
}
