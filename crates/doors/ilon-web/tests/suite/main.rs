//! The tests of `ilon-web` from outside, one module for each subject, in one program.
//!
//! What the door answers is asked of it as it is. What needs the simulator as WebAssembly is skipped with a word where `ILON_WEB` does not
//! name the folder of a playground; `.ci/web` makes one.

#[path = "../../../ilon/tests/suite/support/browser.rs"]
mod browser;
mod door;
mod in_browser;
mod in_node;
mod support;
