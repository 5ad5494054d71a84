//! The paper, equation by equation: tests that cross crates.
