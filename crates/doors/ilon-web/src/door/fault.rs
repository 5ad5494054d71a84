//! Errors for the page, in the command's words.

use std::fmt::Display;

use miette::Diagnostic;
use serde::Serialize;

/// An error with its explanation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// The message, in one sentence.
    pub message: String,
    /// How to repair it, if known.
    pub help: Option<String>,
    /// The whole text that the command shows, with the lines at fault.
    pub shown: String,
}

impl Fault {
    /// An error in a page's request, for which the command has no message.
    pub(super) fn of_page(message: impl Display) -> Self {
        let message = message.to_string();
        Self {
            shown: message.clone(),
            message,
            help: None,
        }
    }

    pub(super) fn none_open() -> Self {
        Self::of_page("no scenario is open")
    }

    pub(super) fn none_driven() -> Self {
        Self::of_page("no robot is driven")
    }
}

impl<E: Into<ilon_sim::Error>> From<E> for Fault {
    fn from(error: E) -> Self {
        let error: ilon_sim::Error = error.into();
        let explained = ilon::cli::explain(&error as &dyn Diagnostic);
        Self {
            message: explained.message,
            help: explained.help,
            shown: explained.shown,
        }
    }
}
