//! `ilon demo`: writes example robots and scenarios, which are embedded in the program.

use std::path::{Path, PathBuf};

use super::escape::{one_line, path_in_line};
use super::outcome::Outcome;
use super::{console, flags};
use crate::bench::ROBOTS;
use crate::cli::failure::Failure;

/// The scenarios, each with a description.
const SCENARIOS: [(&str, &str, &str); 4] = [
    (
        "mecanum4_lateral",
        "sideways, 2 % short of the ideal kinematics, and not by slip",
        include_str!("demo/mecanum4_lateral.toml"),
    ),
    (
        "mecanum4_wet_floor",
        "a figure eight on a floor that is wet for three seconds",
        include_str!("demo/mecanum4_wet_floor.toml"),
    ),
    (
        "mecanum4_kerb",
        "over a threshold of 5 mm that lies askew",
        include_str!("demo/mecanum4_kerb.toml"),
    ),
    (
        "volksbot_position_first",
        "the experiment of the paper: position before heading",
        include_str!("demo/volksbot_position_first.toml"),
    ),
];

/// Arguments of `ilon demo`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The folder to write into.
    #[arg(default_value = "ilon-demo", value_name = "DIR")]
    folder: PathBuf,
}

/// Writes robots and scenarios and prints which commands to try. Existing files that differ are not
/// overwritten.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let folder = &arguments.folder;
    let robots = ROBOTS.map(|(name, text)| (format!("robots/{name}.urdf"), text));
    let scenarios = SCENARIOS.map(|(name, _, text)| (format!("scenarios/{name}.toml"), text));
    let files: Vec<(PathBuf, &str)> = robots
        .into_iter()
        .chain(scenarios)
        .map(|(name, text)| (folder.join(name), text))
        .collect();
    // All are checked before the first is written, so that nothing is written partially.
    for (path, text) in &files {
        refuse_loss(path, text)?;
    }
    for (path, text) in &files {
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(|source| Failure::write(parent, &source))?;
        }
        ilon_trace::file::write_text(path, text)?;
    }
    let mut lines = format!(
        "{} robots and {} scenarios written to {}\n\n",
        ROBOTS.len(),
        SCENARIOS.len(),
        path_in_line(folder)
    );
    for (name, shows, _) in SCENARIOS {
        let path = folder.join(format!("scenarios/{name}.toml"));
        let path = flags::shell(&path.display().to_string());
        lines += &format!("ilon run {}    # {shows}\n", one_line(&path));
    }
    console::lines(&lines)?;
    Ok(Outcome::Done)
}

/// Refuses to replace an existing file with another content.
fn refuse_loss(path: &Path, text: &str) -> Result<(), Failure> {
    match std::fs::read(path) {
        Ok(there) if there != text.as_bytes() => Err(Failure::usage(
            format!("`{}` is there already and is another", path.display()),
            "name another folder, or move it elsewhere",
        )),
        Ok(_) => Ok(()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(Failure::read(path, error)),
    }
}
