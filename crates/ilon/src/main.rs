//! The `ilon` command.
fn main() {}
