#[path = "suite/limits.rs"]
mod limits;
