//! The tests of `ilon-web` from outside, one module per subject, in one program.
//!
//! Replies are tested natively. Tests that need the WebAssembly module are skipped with a message
//! unless `ILON_WEB` names the folder of a playground; `.ci/web` makes one.

#[path = "../../../ilon/tests/suite/support/browser.rs"]
mod browser;
mod door;
mod in_browser;
mod in_node;
mod support;
