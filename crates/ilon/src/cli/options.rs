//! Options with one meaning in all commands: what is printed, where results go, and whether their page is opened.

use std::path::{Path, PathBuf};

use super::{open, say};
use crate::cli::failure::Failure;

/// What a command prints.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(super) struct Printing {
    /// Print the answer as JSON, and nothing else, on standard output.
    #[arg(long)]
    pub json: bool,
}

impl Printing {
    /// The answer on standard output, as it was asked for: as JSON, or in words unless the command is quiet.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn answer(self, json: &str, words: impl FnOnce() -> String) -> Result<(), Failure> {
        if self.json {
            say::data(json)
        } else {
            say::lines(&words())
        }
    }
}

/// How much of the answer is printed.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(super) struct Detail {
    /// Print all tables below the answer.
    #[arg(long)]
    pub table: bool,
}

/// Where results go.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct Out {
    /// Where to write results [default: `out/` and the name of what they are of].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

impl Out {
    /// The folder that was asked for, or that of a name.
    pub fn or_of(&self, name: &str) -> PathBuf {
        let named = || Path::new("out").join(name);
        self.out.clone().unwrap_or_else(named)
    }
}

/// Whether the page of the results is opened.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(super) struct Open {
    /// Open the page of the results in the browser.
    #[arg(long)]
    open: bool,
}

impl Open {
    /// Opens it if that was asked for.
    pub fn page(self, path: &Path) {
        if self.open {
            open::page(path);
        }
    }
}
