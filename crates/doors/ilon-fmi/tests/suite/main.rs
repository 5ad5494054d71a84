//! The FMU from inside: an instance does what the command does, and refuses what makes no sense.

mod instance;
mod package;
