//! ilon inside other people's simulators: a C library that steps a simulated robot.
//!
//! A plant is loaded from a scenario, stepped with wheel rates or torques, pushed and loaded by whatever else is in the world, and read. The
//! header is `include/ilon.h`, made of this crate by cbindgen; `docs/simulators.md` has a first success in C and in C++.
//!
//! | module | answers |
//! |---|---|
//! | [`plant`] | the functions that C calls |
//! | [`state`] | what they give |
//! | [`status`] | how a call ended, and why |
//! | `fmi3` | the functions that an importer of an FMU calls, where addresses have 64 bits |
//! | `table` | what a handle stands for |
//! | `border` | how memory of C is read and written: nearly all that is unsafe |
//!
//! # Rules for who calls
//! - A handle is a number. One that was freed, made up, or is of another kind is refused with a code, for ever.
//! - Any thread may call with any handle. One plant serves one thread at a time: a second one is refused with `ILON_STATUS_BUSY`. Different
//!   plants go on at the same time.
//! - No call unwinds into C. After a fault of ilon itself a plant is in an unknown state, and takes no call but the one that frees it.
//! - Pointers must point at as much memory as the call says. Null and misaligned ones are refused; others cannot be recognised.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod border;
#[cfg(target_pointer_width = "64")]
pub mod fmi3;
pub mod plant;
pub mod state;
pub mod status;
mod table;
