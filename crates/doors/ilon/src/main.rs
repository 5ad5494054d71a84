//! The `ilon` command.

#![warn(clippy::print_stderr, clippy::print_stdout)]

fn main() -> std::process::ExitCode {
    ilon::cli::main()
}
