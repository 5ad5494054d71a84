//! Reserves outputs of a command before it begins: an output is no input of the command, no other
//! command writes to it, and it is writable.

use std::path::{Path, PathBuf};

use ilon_trace::TraceError;
use ilon_trace::file::{OutputLock, is_stream};

use super::console;
use crate::cli::failure::Failure;

/// An output that is reserved until this value is dropped.
#[derive(Debug)]
pub(super) struct ReservedOutput {
    _lock: Option<OutputLock>,
}

/// Reserves a file named by an option.
pub(super) fn file(
    path: &Path,
    option: &str,
    inputs: &[PathBuf],
) -> Result<ReservedOutput, Failure> {
    not_an_input(path, option, inputs)?;
    if is_stream(path) {
        return Ok(ReservedOutput { _lock: None });
    }
    if path.is_dir() {
        return Err(Failure::usage(
            format!(
                "`{}` is a folder, where a file shall be written",
                path.display()
            ),
            format!("name a file with {option}"),
        ));
    }
    locked(OutputLock::of_file(path), path, option)
}

/// Reserves a folder named by an option; it is created if missing.
pub(super) fn folder(path: &Path, option: &str) -> Result<ReservedOutput, Failure> {
    std::fs::create_dir_all(path).map_err(|source| cannot_write(path, &source, option))?;
    locked(OutputLock::of_folder(path), path, option)
}

fn locked(
    lock: Result<OutputLock, TraceError>,
    path: &Path,
    option: &str,
) -> Result<ReservedOutput, Failure> {
    match lock {
        Ok(lock) => {
            if !lock.is_held() {
                console::note(&format!(
                    "note: the file system of `{}` has no locks; let no other run write there",
                    path.display()
                ));
            }
            Ok(ReservedOutput { _lock: Some(lock) })
        }
        Err(TraceError::Io { source, .. }) => Err(cannot_write(path, &source, option)),
        Err(in_use @ TraceError::InUse { .. }) => Err(Failure::usage(
            in_use.to_string(),
            format!("wait until it ends, or choose another place with {option}"),
        )),
        Err(other) => Err(other.into()),
    }
}

fn cannot_write(path: &Path, source: &std::io::Error, option: &str) -> Failure {
    Failure::usage(
        format!(
            "cannot write `{}`: {}",
            path.display(),
            ilon_sim::reason(source)
        ),
        format!("choose another place with {option}; nothing was left half-written"),
    )
}

/// Refuses an output that is also an input, under any name or link: it would be replaced.
pub(super) fn not_an_input(output: &Path, option: &str, inputs: &[PathBuf]) -> Result<(), Failure> {
    match inputs.iter().find(|input| is_same_file(output, input)) {
        None => Ok(()),
        Some(input) => Err(Failure::usage(
            format!(
                "`{}` would be written over `{}`, which is read",
                output.display(),
                input.display()
            ),
            format!("choose another place with {option}"),
        )),
    }
}

/// Whether two paths, also through links, lead to the same file.
pub(super) fn is_same_file(a: &Path, b: &Path) -> bool {
    let resolved = |path: &Path| path.canonicalize().ok();
    if resolved(a).is_some_and(|a| resolved(b) == Some(a)) {
        return true;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let file = |path: &Path| std::fs::metadata(path).ok().map(|is| (is.dev(), is.ino()));
        file(a).is_some_and(|a| file(b) == Some(a))
    }
    #[cfg(not(unix))]
    {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn one_file_is_known_by_all_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("sub")).unwrap();
        std::fs::write(at("a"), "").unwrap();
        std::fs::write(at("b"), "").unwrap();
        std::os::unix::fs::symlink(at("a"), at("sub/link")).unwrap();
        std::fs::hard_link(at("a"), at("hard")).unwrap();
        for name in ["a", "sub/../a", "./a", "sub/link", "hard"] {
            assert!(is_same_file(&at("a"), &at(name)), "{name}");
        }
        for name in ["b", "sub", "nowhere"] {
            assert!(!is_same_file(&at("a"), &at(name)), "{name}");
        }
        assert!(!is_same_file(&at("nowhere"), &at("nowhere")));
    }
}
