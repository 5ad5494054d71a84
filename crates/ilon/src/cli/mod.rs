//! The `ilon` command: what it takes, what it prints, and with which code it ends.

mod bench;
mod check;
mod compare;
mod generate;
mod inspect;
mod output;
mod progress;
mod robot;
mod run;
mod schema;
mod table;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::Error;
use crate::scenario::Setting;

/// Simulates omnidirectional robots down to the rollers of their wheels, and explains their slip.
#[derive(Debug, Parser)]
#[command(name = "ilon", version, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 an expectation did not hold; 2 bad input.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate a scenario and write its results.
    Run(run::Arguments),
    /// Print a robot as it is understood: wheels, rollers, kinematics.
    Inspect(inspect::Arguments),
    /// Run scenarios and hold each against its own `[expect]`.
    Check(check::Arguments),
    /// Lay several runs beside each other, as a table and as one page.
    Compare(compare::Arguments),
    /// Write a URDF with explicit rollers from a short description.
    Generate(generate::Arguments),
    /// Measure how right and how fast the simulation is on this machine.
    Bench(bench::Arguments),
    /// Print the JSON Schema of the scenario file.
    Schema,
}

/// How a command that found no fault ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Done.
    Done,
    /// An expectation did not hold.
    Unexpected,
    /// Part of the input was bad, which has been told.
    BadInput,
}

/// Keys of a scenario changed on the command line.
#[derive(Clone, Debug, clap::Args)]
struct Settings {
    /// Change a key of the scenario, such as `world.floor.friction=0.2`.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
}

/// Runs the command of this process's arguments.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    install_printer();
    match dispatch(cli.command) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Unexpected) => ExitCode::from(1),
        Ok(Outcome::BadInput) => ExitCode::from(2),
        Err(error) => {
            tell(error);
            ExitCode::from(2)
        }
    }
}

fn dispatch(command: Command) -> Result<Outcome, Error> {
    match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Schema => schema::run(),
    }
}

/// How faults are shown: with the lines at fault, in colour only on a terminal, and never wrapped, so that a log or a
/// script finds each message whole.
fn install_printer() {
    let print = miette::set_hook(Box::new(|_| {
        Box::new(
            miette::MietteHandlerOpts::new()
                .terminal_links(false)
                .width(usize::MAX)
                .wrap_lines(false)
                .context_lines(1)
                .build(),
        )
    }));
    // A hook set before this one stays, which is what a program that embeds this function wants.
    drop(print);
}

/// Tells a person of a fault.
fn tell(error: Error) {
    eprintln!("{:?}", miette::Report::new(error));
}

/// Writes to standard output. A reader that has gone away, such as `head`, ends the writing without a fault.
fn print(text: &str) -> Result<(), Error> {
    use std::io::{ErrorKind, Write};
    let mut stdout = std::io::stdout().lock();
    let written = stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush());
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::write(&PathBuf::from("standard output"), &error))
        }
        _ => Ok(()),
    }
}
