//! ilon in the browser: an interface through which a page simulates, and the page itself, the
//! playground.
//!
//! The compiled WebAssembly module has no imports. A worker passes files and JSON requests in, and
//! takes replies and bytes out ([`abi`]); all files are in memory. Results, messages and drawings
//! are those of the command, because the same functions make them.
//!
//! | module | answers |
//! |---|---|
//! | [`door`] | requests and replies |
//! | [`abi`] | how a request and its reply are passed from and to JavaScript |
//! | [`playground`] | the static page, assembled from parts of the report |

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod abi;
pub mod door;
pub mod playground;
