//! The `ilon` command: what it takes, what it prints, and with which code it ends.

mod bag;
mod bench;
mod check;
mod claim;
mod compare;
mod context;
mod demo;
mod embed;
mod escape;
mod failure;
mod fault;
mod flags;
mod gallery;
mod generate;
mod identify;
mod inspect;
#[cfg(feature = "live")]
mod live;
mod manual;
mod open;
mod options;
mod output;
mod progress;
mod report;
mod robot;
mod ros2;
mod run;
mod say;
mod schema;
mod sweep;
mod table;

pub(crate) use flags::shell;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use ilon_robot::FileAccess;

use crate::cli::failure::Failure;
use crate::scenario::Setting;
pub use embed::{
    Explained, explain, may_hold_identified, may_hold_study, report_html, run_arguments,
    study_words, write_identified, write_results, write_study,
};

/// Simulates omnidirectional robots down to the rollers of their wheels, and explains their slip.
#[derive(Debug, Parser)]
#[command(name = "ilon", version, after_help = EXIT_CODES)]
struct Cli {
    /// Print nothing but faults, scenarios that failed, and data that is asked for.
    #[arg(long, short, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 an expectation did not hold; 2 bad input.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Write example robots and scenarios beside you, and say what to run.
    Demo(demo::Arguments),
    /// Simulate scenarios and write their results.
    Run(run::Arguments),
    /// Make the page of a run again from its folder.
    Report(report::Arguments),
    /// Print a robot as it is understood: wheels, rollers, kinematics.
    Inspect(inspect::Arguments),
    /// Run scenarios and hold each against its own `[expect]`.
    Check(check::Arguments),
    /// Run a scenario many times under keys that vary, and say what comes of it.
    Sweep(sweep::Arguments),
    /// Fit what a robot really is to logs of its drives: radii, levers, gains, and keys of its simulation.
    Identify(identify::Arguments),
    /// Lay several runs beside each other, as a table and as one page.
    Compare(compare::Arguments),
    /// Write a URDF with explicit rollers from a short description.
    Generate(generate::Arguments),
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

/// How a command that found no fault ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Done.
    Done,
    /// An expectation did not hold.
    Unexpected,
    /// Part of the input was bad, which has been shown.
    BadInput,
}

/// Keys of a scenario changed on the command line.
#[derive(Clone, Debug, clap::Args)]
struct Settings {
    /// Change a key of the scenario, such as `world.floor.friction=0.2`; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
}

/// What files of strangers may read.
#[derive(Clone, Debug, clap::Args)]
struct Sandbox {
    /// Read no scenario, robot, mesh or file of waypoints outside of this folder, whatever the files name; may be given
    /// several times. Links are followed first. xacro files see nothing of the environment.
    #[arg(long = "sandbox", value_name = "DIR")]
    folders: Vec<PathBuf>,
}

impl Sandbox {
    /// The flags of it, each after a space.
    fn words(&self) -> String {
        let word = |folder: &PathBuf| flags::shell(&folder.display().to_string());
        let flag = |folder| format!(" --sandbox {}", word(folder));
        self.folders.iter().map(flag).collect()
    }

    /// Which files may be read.
    fn files(&self) -> Result<FileAccess, Failure> {
        if self.folders.is_empty() {
            return Ok(FileAccess::anywhere());
        }
        FileAccess::below(&self.folders).map_err(|error| {
            Failure::usage(
                format!("--sandbox cannot be the folder {error}"),
                "name a folder that is there",
            )
        })
    }
}

/// Runs the command of this process's arguments.
pub fn main() -> ExitCode {
    ExitCode::from(run_arguments(std::env::args_os()))
}

fn dispatch(command: Command) -> Result<Outcome, Failure> {
    match command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        #[cfg(feature = "live")]
        Command::Live(arguments) => live::run(&arguments),
        #[cfg(not(feature = "live"))]
        Command::Live { .. } => Err(Failure::usage(
            "this ilon was built without live runs, which keeps it small",
            "build it with its default features",
        )),
        Command::Schema(arguments) => schema::run(&arguments),
        Command::Completions(arguments) => manual::completions(&arguments),
        Command::Man(arguments) => manual::man(&arguments),
    }
}
