//! ilon in the browser: a thin door through which a page simulates, and the page itself, the playground.
//!
//! Compiled to WebAssembly the crate imports nothing. A worker hands in files and requests in JSON, and takes out replies and bytes
//! ([`abi`]); all files lie in memory. What is computed, said and drawn is what the command computes, says and draws: the door calls the
//! same functions, and adds nothing of its own.
//!
//! | module | answers |
//! |---|---|
//! | [`door`] | what can be asked, and what comes of it |
//! | [`abi`] | how a request and its reply pass the border to JavaScript |
//! | [`playground`] | the static page, put together from the parts of the report |

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod abi;
pub mod door;
pub mod playground;
