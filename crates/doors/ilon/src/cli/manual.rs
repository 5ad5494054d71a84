//! `ilon completions` and `ilon man`: completions for shells and manual pages.

use clap::Command;
use clap_complete::Shell;

use super::console;
use super::outcome::Outcome;
use crate::cli::failure::Failure;

/// Arguments of `ilon completions`.
#[derive(Debug, clap::Args)]
pub(super) struct CompletionsArguments {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Arguments of `ilon man`.
#[derive(Debug, clap::Args)]
pub(super) struct ManArguments {
    /// The command, such as `run`; without it, the page of ilon as a whole.
    command: Option<String>,
}

/// Prints the completion script of a shell.
pub(super) fn completions(
    arguments: &CompletionsArguments,
    mut ilon: Command,
) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut ilon, "ilon", &mut script);
    console::data(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Done)
}

/// Prints a manual page in roff.
pub(super) fn man(arguments: &ManArguments, mut ilon: Command) -> Result<Outcome, Failure> {
    // Gives each command its full name.
    ilon.build();
    let page = match &arguments.command {
        None => ilon,
        Some(name) => {
            let found = ilon.find_subcommand(name).cloned();
            found.ok_or_else(|| {
                let names: Vec<&str> = ilon
                    .get_subcommands()
                    .filter(|command| !command.is_hide_set())
                    .map(Command::get_name)
                    .collect();
                Failure::usage(
                    format!("there is no command `{name}`"),
                    format!("one of {}", names.join(", ")),
                )
            })?
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut text)
        .map_err(|error| Failure::encode("the page of the manual", &error))?;
    console::data(&String::from_utf8_lossy(&text))?;
    Ok(Outcome::Done)
}
