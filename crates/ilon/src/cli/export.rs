//! `ilon export`: a robot for other people's simulators.

use std::path::PathBuf;

use ilon_fmi::package::platform;

use super::options::{Sandbox, Settings};
use super::outcome::Outcome;
use super::{console, reserve};
use crate::cli::failure::Failure;

/// Arguments of `ilon export`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Write the robot and world of a scenario as a functional mock-up unit (FMI 3.0, co-simulation).
    #[arg(long, value_name = "SCENARIO", required = true)]
    fmu: PathBuf,
    /// Where to write it [default: the scenario's name and `.fmu`].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// The shared library of ilon-c that goes into it [default: the one beside this command].
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    sandbox: Sandbox,
}

/// Writes the FMU, once it is known that what is in it can be run.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let path = &arguments.fmu;
    let library = match &arguments.library {
        Some(library) => library.clone(),
        None => beside_this_command()?,
    };
    let out = match &arguments.out {
        Some(out) => out.clone(),
        None => {
            let mut name = path.file_stem().unwrap_or_default().to_owned();
            name.push(".fmu");
            name.into()
        }
    };
    let _claim = reserve::file(&out, "--out", &[path.clone(), library.clone()])?;
    let settings = &arguments.settings.settings;
    let files = arguments.sandbox.files()?;
    let bytes = ilon_fmi::package(path, settings, &files, &library)?;
    ilon_trace::file::write_bytes(&out, &bytes)?;
    console::lines(&format!("an FMU for {}: {}\n", platform().0, out.display()))?;
    Ok(Outcome::Done)
}

/// The shared library as cargo and releases put it: beside the command.
fn beside_this_command() -> Result<PathBuf, Failure> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let name = format!("{DLL_PREFIX}ilon_c{DLL_SUFFIX}");
    let command = std::env::current_exe().and_then(|path| path.canonicalize());
    let beside = command.ok().map(|path| path.with_file_name(&name));
    beside.filter(|path| path.is_file()).ok_or_else(|| {
        Failure::usage(
            format!("there is no `{name}` beside this command, and an FMU holds it"),
            "build it with `cargo build --release -p ilon-c`, or name it with --library",
        )
    })
}
