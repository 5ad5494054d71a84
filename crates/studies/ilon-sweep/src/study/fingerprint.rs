//! A hash of everything that a study's rows depend on, so that rows of another study are not
//! mistaken for its own.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;

use crate::check::Draft;
use crate::file::StudyFile;
use crate::hash::Hash;
use ilon_sim::Error;
use ilon_sim::scenario::{Expect, Scenario, Setting, Tracked};
use ilon_sim::simulate::load_file;

/// The fingerprint of a study.
pub(super) fn of(study: &Draft, fixed: &[Setting], files: &FileAccess) -> Result<String, Error> {
    let mut hash = Hash::new();
    hash.feed(env!("CARGO_PKG_VERSION"));
    for base in study.bases {
        let mut scenario = base.with(fixed, files)?;
        scenario.expect = Expect::default();
        hash.feed(&scenario.name);
        hash.feed(&scenario.to_toml()?);
        let mut robots = vec![scenario.robot.file.clone()];
        let mut read = Vec::new();
        read.extend(scenario.reference.as_ref().and_then(Tracked::file).cloned());
        read.extend(scenario.playback.as_ref().map(|log| log.file.clone()));
        let believed = scenario.controller.robot.as_ref();
        read.extend(believed.and_then(|robot| robot.file.clone()));
        let varied = study.axes.iter().filter(|axis| axis.key.ends_with("file"));
        for axis in varied {
            let paths = (0..axis.count().unwrap_or_default()).map(|at| axis.nth(at));
            let paths = paths.filter_map(|path| path.as_str().map(PathBuf::from));
            match axis.key.as_str() {
                "robot.file" => robots.extend(paths),
                _ => read.extend(paths),
            }
        }
        for file in robots {
            scenario.robot.file = file;
            feed_robot(files, &mut hash, &mut scenario);
        }
        for path in read {
            feed(files, &mut hash, &scenario.resolve(&path));
        }
    }
    let StudyFile {
        method,
        points,
        repetitions,
        seed,
        find,
        minimise,
        physics,
        ..
    } = study.file;
    let asked = serde_json::json!([
        study.axes,
        method,
        points,
        repetitions,
        seed,
        find,
        minimise
    ]);
    hash.feed(&asked.to_string());
    if !physics {
        hash.feed("without physics");
    }
    Ok(hash.to_string())
}

/// Feeds the robot of a scenario as loaded, with all its files: included ones, and meshes. A robot
/// that cannot be read gives failed rows.
fn feed_robot(files: &FileAccess, hash: &mut Hash, scenario: &mut Scenario) {
    scenario.files = files.noting();
    // A ROS tool may have expanded it, which opens files by itself.
    hash.feed(&load_file(scenario).map_or(String::new(), |loaded| loaded.urdf.to_string()));
    let one = |path: &PathBuf| {
        let mut hash = Hash::new();
        feed(files, &mut hash, path);
        hash.to_string()
    };
    let mut each: Vec<String> = scenario.files.opened().iter().map(one).collect();
    // Independent of where packages are installed.
    each.sort_unstable();
    each.iter().for_each(|own| hash.feed(own));
}

/// Largest number of files of a folder in a fingerprint; a bag has few.
const MOST_FILES: usize = 10_000;

/// Feeds a file, or the files of a folder such as a bag, to a hash. An unreadable one gives a
/// failed row and does not end the study.
fn feed(files: &FileAccess, hash: &mut Hash, path: &Path) {
    let names = match files.is_folder(path) {
        true => files.names_in(path, MOST_FILES),
        false => Vec::new(),
    };
    let inside = names.iter().map(|name| path.join(name));
    for file in std::iter::once(path.to_owned()).chain(inside) {
        match files.open(&file) {
            Ok(file) => hash.feed_reader(file),
            Err(_) => hash.feed(""),
        }
    }
}
