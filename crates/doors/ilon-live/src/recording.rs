//! A recorded drive: a log of its commands, and the scenario that repeats it.

use std::path::{Path, PathBuf};

use ilon_robot::Twist;
use ilon_sim::{Error, Scenario};
use ilon_trace::file::write_text;

/// Largest number of rows: at a control period of 10 ms, 2 hours and 47 minutes.
pub(crate) const MOST_ROWS: usize = 1_000_000;

/// Largest number of drives of a scenario in a folder, as any client may record.
const MOST_DRIVES: u32 = 99;

/// The commands of a drive: for each control period its start in seconds, and the commanded twist.
pub(crate) type Drive = Vec<(f64, Twist)>;

/// Writes a drive of a scenario into a folder, under the first free name; returns the file of the
/// scenario that repeats it.
///
/// # Errors
/// If a file cannot be written.
pub(crate) fn write(scenario: &Scenario, drive: &Drive, folder: &Path) -> Result<PathBuf, Error> {
    let path_of = |number: u32, ending: &str| {
        let name = scenario.name.trim_end_matches("_driven");
        folder.join(format!("{name}_{number}_driven.{ending}"))
    };
    let endings = ["toml", "csv"];
    let is_free = |number: &u32| !endings.iter().any(|of| path_of(*number, of).exists());
    let number = (1..=MOST_DRIVES).find(is_free).ok_or_else(|| {
        let message = format!("`{}` holds {MOST_DRIVES} drives", folder.display());
        Error::invalid(message, "remove some of them")
    })?;
    let [path, log_path] = endings.map(|ending| path_of(number, ending));
    let log_name = log_path.file_name().unwrap_or_default();
    let (mut driven, log) = scenario.moved_to(folder).driven(log_name, drive);
    driven.about = format!("{}, driven by hand.", scenario.name);
    write_text(&log_path, &log)?;
    write_text(&path, &driven.to_toml()?)?;
    Ok(path)
}
