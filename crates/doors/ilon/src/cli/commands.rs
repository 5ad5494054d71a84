//! All commands and their dispatch.

use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue};
use clap::{CommandFactory, Parser, Subcommand};
use ilon_sim::scenario::nearest;

#[cfg(feature = "live")]
use super::live;
use super::outcome::Outcome;
use super::{
    bench, check, compare, console, demo, explain, export, export_arguments, fault, flags,
    generate, identify, inspect, interrupt, manual, report, run, schema, sweep,
};
use crate::cli::escape::path_in_line;
use crate::cli::failure::Failure;

/// Simulates omnidirectional robots down to the rollers of their wheels, and explains their slip.
#[derive(Debug, Parser)]
#[command(name = "ilon", version, after_help = EXIT_CODES)]
struct Cli {
    /// Print only errors, failures and requested data.
    #[arg(long, short, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 an expectation did not hold (`check`); 2 bad input; 3 nothing was expected; 129, 130, 143 interrupted.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Write example robots and scenarios into a folder, to start with.
    Demo(demo::Arguments),
    /// Simulate a scenario, or a robot in five standard motions, and write a report.
    Run(run::Arguments),
    /// Explain a run by its causes, or rank the causes of a drift that you measured on a robot.
    Explain(explain::Arguments),
    /// Write the report of a run again, from its folder.
    Report(report::Arguments),
    /// Check a robot file: wheels, rollers, kinematics, limits.
    Inspect(inspect::Arguments),
    /// Test scenarios against their `[expect]` bounds, for CI.
    Check(check::Arguments),
    /// Run a parameter study and summarise it.
    Sweep(sweep::Arguments),
    /// Calibrate a robot model from logs of real drives.
    Identify(identify::Arguments),
    /// Compare runs: a table and a page.
    Compare(compare::Arguments),
    /// Write a URDF with explicit rollers from a short description.
    Generate(generate::Arguments),
    /// Write a robot for other simulators: a functional mock-up unit, or a planar base that is
    /// fitted to it.
    Export(export_arguments::Arguments),
    /// Measure how accurate and how fast the simulation is on this machine.
    Bench(bench::Arguments),
    /// Drive a robot while it is simulated, from a page in the browser.
    #[cfg(feature = "live")]
    Live(live::Arguments),
    /// Drive a robot while it is simulated: left out of this build.
    #[cfg(not(feature = "live"))]
    #[command(hide = true)]
    Live {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        _arguments: Vec<std::ffi::OsString>,
    },
    /// Print the JSON Schema of a file that you write: a scenario, a robot in short, a study.
    Schema(schema::Arguments),
    /// Print the script that completes ilon's commands in a shell.
    Completions(manual::CompletionsArguments),
    /// Print a page of the manual: `ilon man run | man -l -`.
    Man(manual::ManArguments),
}

/// Runs the command in this process's arguments.
pub fn main() -> ExitCode {
    interrupt::end_on_signals();
    ExitCode::from(run_arguments(std::env::args_os()))
}

fn dispatch(command: Command) -> Result<Outcome, Failure> {
    match command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        #[cfg(feature = "live")]
        Command::Live(arguments) => live::run(&arguments),
        #[cfg(not(feature = "live"))]
        Command::Live { .. } => Err(Failure::usage(
            "this ilon was built without live runs, which keeps it small",
            "build it with its default features",
        )),
        Command::Schema(arguments) => schema::run(&arguments),
        Command::Completions(arguments) => manual::completions(&arguments, Cli::command()),
        Command::Man(arguments) => manual::man(&arguments, Cli::command()),
    }
}

/// The error for a word in the place of the command: `ilon robot.urdf`, `ilon rn`.
fn no_command(error: &clap::Error) -> Option<Failure> {
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidSubcommand) else {
        return None;
    };
    let shown = path_in_line(Path::new(given));
    if Path::new(given).is_file() {
        return Some(Failure::usage(
            format!("`{shown}` is a file, and a command belongs in its place"),
            format!(
                "write a command first, such as `ilon run {}`; `ilon --help` lists them",
                flags::shell(given)
            ),
        ));
    }
    let cli = Cli::command();
    let commands = cli
        .get_subcommands()
        .filter(|command| !command.is_hide_set());
    let near = nearest(given, commands.map(clap::Command::get_name));
    let near = near
        .map(|near| format!("did you mean `ilon {near}`? "))
        .unwrap_or_default();
    Some(Failure::usage(
        format!("ilon has no command `{shown}`"),
        format!("{near}`ilon --help` lists the commands"),
    ))
}

/// Runs the command in the arguments and returns its exit code. The first argument is the program's
/// name.
pub fn run_arguments(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            if let Some(failure) = no_command(&error) {
                fault::show(failure);
                return 2;
            }
            let printed = error.print();
            // Help is a result and must be written; an error that cannot be written still has its
            // exit code.
            if !error.use_stderr()
                && let Err(failure) = console::written(printed)
            {
                fault::show(failure);
                return 2;
            }
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    console::be_quiet(cli.quiet);
    match dispatch(cli.command) {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Unexpected) => 1,
        Ok(Outcome::BadInput) => 2,
        Ok(Outcome::NothingChecked) => 3,
        Err(error) => {
            fault::show(error);
            2
        }
    }
}
