//! Finds the scenarios to check, and names them.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use ilon_files::FileAccess;

use crate::cli::escape::one_line;
use crate::cli::failure::Failure;
use crate::cli::kind::{Kind, kind};
use crate::cli::output::holds_results;

/// A scenario to check, or a named path without one.
#[derive(Debug)]
pub(super) struct CheckedFile {
    /// The file, by the path that was given.
    pub path: PathBuf,
    /// Its name: the path below the given folder, without its extension; for a given file the file
    /// name alone. Baselines and kept results use this name.
    pub name: PathBuf,
    /// Its name in the output: the name if it is unique, otherwise the whole path.
    pub label: String,
    /// Why it cannot be run.
    pub refused: Option<Failure>,
}

/// Finds the given scenarios and those in and below the given folders, in the order of their names,
/// each file once. A path without a scenario is included as refused.
///
/// # Errors
/// If a given path cannot be read, or nothing is left to check.
pub(super) fn find(
    paths: &[PathBuf],
    filter: Option<&str>,
    files: &FileAccess,
) -> Result<Vec<CheckedFile>, Failure> {
    let mut search = Search::default();
    for path in paths {
        let is = fs::metadata(path).map_err(|source| Failure::read(path, source))?;
        if !is.is_dir() {
            search.add(path.clone(), path.file_stem().unwrap_or_default().into());
            continue;
        }
        let before = search.found.len();
        let root = path.canonicalize();
        let root = root.map_err(|source| Failure::read(path, source))?;
        search.walk(path, Path::new(""), &root)?;
        if search.found.len() == before && !search.met {
            let refused = Failure::usage(
                format!("`{}` holds no scenario", path.display()),
                "name a folder with `.toml` files in it or below it",
            );
            search.refuse(path.clone(), path.clone(), refused);
        }
        search.met = false;
    }
    let mut found = search.found;
    // Robots among the scenarios are no tests; one that is named explicitly is a mistake.
    let is_named = |one: &CheckedFile| paths.contains(&one.path);
    found.retain(|one| is_named(one) || kind(&one.path, files) != Some(Kind::Robot));
    let meets = |name: &Path| filter.is_none_or(|text| name.to_string_lossy().contains(text));
    let first = found.first().map(|one| one.name.display().to_string());
    found.retain(|one| one.refused.is_some() || meets(&one.name));
    if let (true, Some(text), Some(first)) = (found.is_empty(), filter, first) {
        return Err(Failure::usage(
            format!("no scenario's name contains `{}`", one_line(text)),
            format!(
                "give --filter a part of a name, such as `{}`",
                one_line(&first)
            ),
        ));
    }
    if found.is_empty() {
        return Err(Failure::usage(
            "there is no scenario to check",
            "name a scenario file, or a folder with `.toml` files, which are no robots",
        ));
    }
    label(&mut found);
    Ok(found)
}

/// Refuses scenarios with equal names, if files are written or read by name.
///
/// # Errors
/// With the files, and what to name instead.
pub(super) fn refuse_equal_names(found: &[CheckedFile], option: &str) -> Result<(), Failure> {
    for (index, one) in found.iter().enumerate() {
        if let Some(other) = found[..index].iter().find(|other| other.name == one.name) {
            return Err(Failure::usage(
                format!(
                    "`{}` and `{}` are both called `{}`, and would share their files below {option}",
                    other.path.display(),
                    one.path.display(),
                    one.name.display()
                ),
                "name the folder that holds both, whose subfolders set them apart, or rename one",
            ));
        }
    }
    Ok(())
}

/// The names of all baselines in a folder and below it.
///
/// # Errors
/// Where a folder cannot be read.
pub(super) fn baselines(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let (mut names, mut folders) = (Vec::new(), vec![PathBuf::new()]);
    while let Some(below) = folders.pop() {
        let at = folder.join(&below);
        let read = |source| Failure::read(&at, source);
        for entry in fs::read_dir(&at).map_err(read)? {
            let entry = entry.map_err(read)?;
            let name = below.join(entry.file_name());
            if entry.file_type().map_err(read)?.is_dir() {
                folders.push(name);
            } else if name.extension().is_some_and(|ending| ending == "parquet") {
                names.push(name.with_extension(""));
            }
        }
    }
    names.sort();
    Ok(names)
}

fn label(found: &mut [CheckedFile]) {
    let labels: Vec<String> = found
        .iter()
        .enumerate()
        .map(|(index, one)| {
            let mut others = found.iter().enumerate();
            let is_shared = others.any(|(other, it)| other != index && it.name == one.name);
            let shown = if is_shared { &one.path } else { &one.name };
            one_line(&shown.display().to_string()).into_owned()
        })
        .collect();
    for (one, label) in found.iter_mut().zip(labels) {
        one.label = label;
    }
}

#[derive(Debug, Default)]
struct Search {
    found: Vec<CheckedFile>,
    /// Visited files and folders, without links.
    seen: HashSet<PathBuf>,
    /// Whether the current folder holds a scenario that was found before.
    met: bool,
}

impl Search {
    fn add(&mut self, path: PathBuf, name: PathBuf) {
        let resolved = path.canonicalize().unwrap_or_else(|_| path.clone());
        if !self.seen.insert(resolved) {
            self.met = true;
            return;
        }
        self.found.push(CheckedFile {
            path,
            name,
            label: String::new(),
            refused: None,
        });
    }

    fn refuse(&mut self, path: PathBuf, name: PathBuf, refused: Failure) {
        self.found.push(CheckedFile {
            path,
            name,
            label: String::new(),
            refused: Some(refused),
        });
    }

    /// Searches a folder, `below` the given one, which is `root` without links.
    fn walk(&mut self, folder: &Path, below: &Path, root: &Path) -> Result<(), Failure> {
        let read = |source| Failure::read(folder, source);
        let mut entries = Vec::new();
        for entry in fs::read_dir(folder).map_err(read)? {
            entries.push(entry.map_err(read)?);
        }
        entries.sort_by_key(fs::DirEntry::file_name);
        for entry in entries {
            let (path, file_name) = (entry.path(), entry.file_name());
            let is_hidden = file_name.as_encoded_bytes().starts_with(b".");
            // The target of a link, if it exists.
            let is_folder = fs::metadata(&path).is_ok_and(|is| is.is_dir());
            let ending = path.extension().unwrap_or_default();
            let is_toml = ending.eq_ignore_ascii_case("toml");
            // Results of runs contain their scenario, which is no test of its own.
            if is_hidden || !(is_toml || is_folder) || (is_folder && holds_results(&path)) {
                continue;
            }
            let name = below.join(if is_folder {
                file_name.as_os_str()
            } else {
                path.file_stem().unwrap_or_default()
            });
            let is_link = entry.file_type().is_ok_and(|kind| kind.is_symlink());
            let resolved = path.canonicalize().unwrap_or_else(|_| path.clone());
            if is_link && !resolved.starts_with(root) {
                let refused = Failure::usage(
                    format!(
                        "`{}` is a link that leads out of its folder",
                        path.display()
                    ),
                    "give the target of the link as a path, if it shall be checked",
                );
                self.refuse(path, name, refused);
            } else if !is_folder {
                self.add(path, name);
            } else if self.seen.insert(resolved) {
                self.walk(&path, &name, root)?;
            }
        }
        Ok(())
    }
}
