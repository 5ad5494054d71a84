//! Errors for the page, in the command's words.

use std::fmt::Display;

pub use ilon::cli::Explained as Fault;

/// An error in a page's request, for which the command has no message.
pub(super) fn of_page(message: impl Display) -> Fault {
    let message = message.to_string();
    Fault {
        shown: message.clone(),
        message,
        help: None,
    }
}

pub(super) fn none_open() -> Fault {
    of_page("no scenario is open")
}

pub(super) fn none_driven() -> Fault {
    of_page("no robot is driven")
}
