//! The `ilon` command.

fn main() -> std::process::ExitCode {
    ilon::cli::main()
}
