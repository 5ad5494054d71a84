//! A C library that steps a simulated robot inside other simulators.
//!
//! A plant is loaded from a scenario, stepped with wheel rates or torques, subjected to external
//! forces and payloads, and read. cbindgen generates the header `include/ilon.h` from this crate.
//! `docs/simulators.md` has first examples in C and C++.
//!
//! | module | answers |
//! |---|---|
//! | [`plant`] | the functions that C calls |
//! | [`state`] | the structs that they return |
//! | [`status`] | status codes and error messages |
//! | `fmi3` | the functions that an FMU importer calls, on 64-bit systems |
//! | `table` | the objects behind handles |
//! | `border` | reading and writing C memory, with nearly all unsafe code |
//!
//! # Rules for callers
//! - A handle is a number. A handle that was freed, made up, or is of another kind is always
//!   refused with a status code.
//! - Any thread may call with any handle. One plant serves one thread at a time: a second one is
//!   refused with `ILON_STATUS_BUSY`. Different plants run in parallel.
//! - No call unwinds into C. After an internal error a plant is in an unknown state, and only the
//!   call that frees it is accepted.
//! - A pointer must point at as much memory as the function requires. Null and misaligned pointers
//!   are refused; other invalid ones cannot be detected.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod border;
#[cfg(target_pointer_width = "64")]
pub mod fmi3;
pub mod plant;
pub mod state;
pub mod status;
mod table;
