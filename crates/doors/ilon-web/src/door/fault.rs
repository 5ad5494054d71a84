//! A fault as the page shows it: in the command's words.

use std::fmt::Display;

use miette::Diagnostic;
use serde::Serialize;

/// What is wrong, and how to repair it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// What is wrong, in one sentence.
    pub message: String,
    /// How to repair it, where that is known.
    pub help: Option<String>,
    /// All of it as the command shows it, with the lines at fault.
    pub shown: String,
}

impl Fault {
    /// Of what the page asks, where the command has no word for it.
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
