//! The FMU from inside: an instance gives the command's results, and refuses invalid calls.

mod instance;
mod package;
