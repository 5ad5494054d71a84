//! Options with the same meaning in all commands: what is printed, where results go, and whether
//! their page is opened.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;

use super::{console, flags, open};
use crate::Causes;
use crate::cli::failure::Failure;
use crate::scenario::Setting;

/// What a command prints.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(super) struct Printing {
    /// Print the answer as JSON, and nothing else, on standard output.
    #[arg(long)]
    pub json: bool,
}

impl Printing {
    /// Prints the answer to standard output: as JSON if requested, otherwise as text unless quiet.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn answer(self, json: &str, words: impl FnOnce() -> String) -> Result<(), Failure> {
        if self.json {
            console::data(json)
        } else {
            console::lines(&words())
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
    /// Folder of the results [default: out/NAME].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

impl Out {
    /// The requested folder, or the default folder of a name.
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
    /// Opens the page if requested.
    pub fn page(self, path: &Path) {
        if self.open {
            open::page(path);
        }
    }
}

/// Keys of a scenario changed on the command line.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct Settings {
    /// Change a key of the scenario, such as `world.floor.friction=0.2`; repeatable. A path starts
    /// from the scenario's folder; with a robot instead of a scenario, from the current folder.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<Setting>,
}

impl Settings {
    /// The options as a shell takes them, each behind a space.
    pub fn words(&self) -> String {
        let word = |setting: &Setting| format!(" --set {}", flags::shell(&setting.to_string()));
        self.settings.iter().map(word).collect()
    }
}

/// Whether a run is repeated without what its scenario names.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct Twins {
    /// Skip the runs without each fault, patch, box, slope, body and sensor error: faster, but no
    /// effects of causes.
    #[arg(long)]
    no_twins: bool,
}

impl Twins {
    /// Which causes are left out one by one.
    pub fn causes(self) -> Causes {
        match self.no_twins {
            true => Causes::None,
            false => Causes::Named,
        }
    }
}

/// What files of strangers may read.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct Sandbox {
    /// Read files only below this folder, also through links, and hide the environment from xacro;
    /// repeatable.
    #[arg(long = "sandbox", value_name = "DIR")]
    pub folders: Vec<PathBuf>,
}

impl Sandbox {
    /// The flags as text, each after a space.
    pub fn words(&self) -> String {
        let word = |folder: &PathBuf| flags::shell(&folder.display().to_string());
        let flag = |folder| format!(" --sandbox {}", word(folder));
        self.folders.iter().map(flag).collect()
    }

    /// Which files may be read.
    pub fn files(&self) -> Result<FileAccess, Failure> {
        if self.folders.is_empty() {
            return Ok(FileAccess::anywhere());
        }
        FileAccess::below(&self.folders).map_err(|error| {
            Failure::usage(
                format!("--sandbox cannot be the folder {error}"),
                "name a folder that is there",
            )
        })
    }
}
