//! What kind of file a command was given, so that a file of another kind is sent to its command.

use std::path::Path;

use ilon_files::FileAccess;
use toml::Table;

use super::failure::Failure;
use super::flags::shell;

/// Largest scenario, study or robot that is read to learn its kind, in bytes; chosen.
const MOST_BYTES: u64 = 16 << 20;

/// The kinds of files that commands read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Robot,
    Scenario,
    Study,
    Calibration,
}

impl Kind {
    /// What a file is, and the commands that take it.
    fn words(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Robot => ("a robot", &["run", "inspect"]),
            Self::Scenario => ("a scenario", &["run", "check"]),
            Self::Study => ("a study of many runs", &["sweep"]),
            Self::Calibration => ("a study of logs", &["identify"]),
        }
    }
}

/// The kind of a file, by its name and, in TOML and XML, by its content; `None` if neither shows
/// it.
pub(super) fn kind(path: &Path, files: &FileAccess) -> Option<Kind> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    let text = || files.read_text(path, MOST_BYTES).ok();
    match ending.as_str() {
        "urdf" | "xacro" | "sdf" | "mjcf" => path.is_file().then_some(Kind::Robot),
        "xml" => {
            let roots = ["<mujoco", "<sdf", "<robot"];
            let text = text()?;
            let is_robot = roots.iter().any(|root| text.contains(root));
            is_robot.then_some(Kind::Robot)
        }
        "toml" => {
            let table: Table = text()?.parse().ok()?;
            let has = |key: &str| table.contains_key(key);
            match table.get("robot") {
                Some(robot) if robot.is_table() => Some(Kind::Scenario),
                Some(_) if has("models") || has("runs") => Some(Kind::Calibration),
                None if has("scenario") => Some(Kind::Study),
                None if has("wheels") && has("chassis") => Some(Kind::Robot),
                _ => None,
            }
        }
        _ => None,
    }
}

/// Refuses a file that is certainly of another kind than the wanted ones, and names its command.
pub(super) fn wants(path: &Path, wanted: &[Kind], files: &FileAccess) -> Result<(), Failure> {
    let Some(found) = kind(path, files).filter(|found| !wanted.contains(found)) else {
        return Ok(());
    };
    let names: Vec<&str> = wanted.iter().map(|kind| kind.words().0).collect();
    let (is, commands) = found.words();
    let file = shell(&path.display().to_string());
    let commands = commands.iter().map(|name| format!("`ilon {name} {file}`"));
    let commands: Vec<String> = commands.collect();
    let mut help = format!("read it with {}", commands.join(" or "));
    if wanted.contains(&Kind::Robot)
        && let Some(robot) = robot_of_scenario(path, files)
    {
        help = format!("name its robot, {}; {help}", shell(&robot));
    }
    Err(Failure::usage(
        format!("`{}` is {is}, not {}", path.display(), names.join(" or ")),
        help,
    ))
}

/// The robot's file that a scenario names, from the current folder.
fn robot_of_scenario(path: &Path, files: &FileAccess) -> Option<String> {
    let table: Table = files.read_text(path, MOST_BYTES).ok()?.parse().ok()?;
    let robot = table.get("robot")?.get("file")?.as_str()?;
    let beside = path.parent()?.join(robot);
    // Shortens a path that enters the scenario's folder and leaves it again.
    let here = std::env::current_dir().ok();
    let whole = beside.canonicalize().ok();
    let short = whole.as_ref().zip(here.as_ref());
    let short = short.and_then(|(whole, here)| whole.strip_prefix(here).ok());
    Some(short.unwrap_or(&beside).display().to_string())
}
