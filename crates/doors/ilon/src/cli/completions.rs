//! `ilon completions`: completions for shells.

use clap::Command;
use clap_complete::Shell;

use super::console;
use super::outcome::Outcome;
use crate::cli::failure::Failure;

/// Arguments of `ilon completions`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the completion script of a shell.
pub(super) fn run(arguments: &Arguments, mut ilon: Command) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut ilon, "ilon", &mut script);
    console::data(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Done)
}
