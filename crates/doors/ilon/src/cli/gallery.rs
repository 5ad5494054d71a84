//! `ilon inspect FOLDER --html FILE`: the robots of a folder side by side.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use ilon_formats::{LoadOptions, LoadRobot, RobotError};
use ilon_robot::Robot;
use ilon_trace::file::write_text;

use super::console;
use super::escape::{one_line, path_in_line};
use super::flags::{Flags, shell};
use super::kind::{Kind, kind};
use crate::cli::failure::Failure;
use crate::control::Kinematics;
use crate::inspect::Inspection;
use crate::pages::gallery::{self, Exhibit};
use crate::sim::remedy::Refusal;

/// Depth to which folders are searched; chosen.
const MOST_DEEP: usize = 16;
/// Largest number of robot files shown; chosen.
const MOST_FILES: usize = 1000;

/// Writes the page and prints the result for each file.
pub(super) fn run(
    place: &Path,
    options: &LoadOptions,
    sandbox: &str,
    html: &Path,
) -> Result<(), Failure> {
    let exhibits: Vec<Exhibit> = files_below(place, options)?
        .iter()
        .map(|file| exhibit(file, place, options, sandbox))
        .collect();
    let title = place.canonicalize().ok();
    let title = title
        .as_deref()
        .and_then(Path::file_name)
        .unwrap_or(place.as_os_str());
    write_text(html, &gallery::html(&title.to_string_lossy(), &exhibits))?;
    let mut text = String::new();
    for exhibit in &exhibits {
        let became = match (&exhibit.robot, exhibit.faults.first()) {
            (Some((loaded, _)), None) => format!("{} wheels", loaded.robot.wheels.len()),
            (Some((loaded, _)), Some(_)) if exhibit.help.is_some() => {
                format!("{} wheels, with options", loaded.robot.wheels.len())
            }
            (_, Some(fault)) => format!("refused: {fault}"),
            (None, None) => String::new(),
        };
        text += &format!("{}: {}\n", one_line(&exhibit.file), one_line(&became));
    }
    console::lines(&format!(
        "{text}\ngallery written to {}\n",
        path_in_line(html)
    ))
}

/// Loads and inspects one file.
fn exhibit(file: &Path, place: &Path, options: &LoadOptions, sandbox: &str) -> Exhibit {
    let shown = file.strip_prefix(place).unwrap_or(file);
    let shown = shown.display().to_string();
    let said = |error: &RobotError| error.to_string();
    let refused = |faults: Vec<String>, help: String| Exhibit {
        file: shown.clone(),
        robot: None,
        faults,
        help: Some(help),
    };
    let (loaded, faults, help) = match Robot::load_with(file, options) {
        Ok(loaded) => (loaded, Vec::new(), None),
        Err(fault) => {
            let named = shell(&file.display().to_string());
            let command = format!("ilon inspect {named}{sandbox}");
            let refusal = Refusal::of(fault, file, options, &Flags { command });
            let faults: Vec<String> = refusal.faults.iter().map(said).collect();
            let mut help: Vec<String> = refusal
                .faults
                .last()
                .map(RobotError::help)
                .into_iter()
                .collect();
            help.extend(refusal.closing);
            match refusal.loaded {
                Some(loaded) => (*loaded, faults, Some(help.join("; "))),
                None => return refused(faults, help.join("; ")),
            }
        }
    };
    // A robot that cannot be controlled is shown too; its page says so.
    match Inspection::of_loaded(&loaded) {
        Ok(inspection) => {
            let uncontrolled = Kinematics::new(&loaded.robot).err();
            let faults = faults
                .into_iter()
                .chain(uncontrolled.map(|e| e.to_string()));
            Exhibit {
                file: shown,
                faults: faults.collect(),
                robot: Some((loaded, inspection)),
                help,
            }
        }
        Err(error) => refused(vec![error.to_string()], String::new()),
    }
}

/// The robot files in a folder and below, in order. Links to folders are not followed, as they can
/// form circles.
fn files_below(folder: &Path, options: &LoadOptions) -> Result<Vec<PathBuf>, Failure> {
    let mut found = BTreeSet::new();
    let mut waiting = vec![(folder.to_owned(), 0)];
    while let Some((folder, depth)) = waiting.pop() {
        let entries = std::fs::read_dir(&folder).map_err(|e| Failure::read(&folder, e))?;
        for entry in entries.flatten() {
            let path = entry.path();
            let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                if !is_hidden && depth < MOST_DEEP {
                    waiting.push((path, depth + 1));
                }
            } else if !is_hidden && kind(&path, &options.files) == Some(Kind::Robot) {
                found.insert(path);
            }
        }
    }
    if found.is_empty() {
        return Err(Failure::usage(
            format!(
                "`{}` holds no robots: no .urdf, .xacro, .sdf, MJCF or description in TOML",
                folder.display()
            ),
            "name a folder of robots",
        ));
    }
    if found.len() > MOST_FILES {
        return Err(Failure::usage(
            format!(
                "`{}` holds {} files of robots, where at most {MOST_FILES} are shown",
                folder.display(),
                found.len()
            ),
            "name a folder with fewer",
        ));
    }
    // A description is not shown beside the URDF that was generated from it.
    let is_shown = |path: &&PathBuf| {
        let is_toml = path.extension().is_some_and(|end| end == "toml");
        !is_toml || !found.contains(&path.with_extension("urdf"))
    };
    Ok(found.iter().filter(is_shown).cloned().collect())
}
