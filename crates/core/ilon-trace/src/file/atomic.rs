//! Files that appear complete or not at all, whatever stops their writer: an error, a signal, or a
//! power failure.
//!
//! A file is written under a hidden name in the same folder, synced to the disk, and then renamed,
//! which replaces an older file in one step. Meanwhile its writer holds a lock on it, by which
//! [`clear_unfinished`] distinguishes the files of killed writers from those in use.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::passing::{Listing, Passing};
use crate::error::TraceError;

/// The ending of unfinished files' names.
const ENDING: &str = ".ilon-partial";

/// A file under a temporary name until it is finished; dropping it before removes it.
#[derive(Debug)]
pub(super) struct Unfinished {
    path: PathBuf,
    growing: NamedTempFile,
    _passing: Passing,
}

impl Unfinished {
    /// Begins the file `path` in `folder`, which is on the same file system.
    pub fn create(path: &Path, folder: &Path) -> Result<Self, TraceError> {
        let made = growing_file(path, folder).map_err(io_error("create", path))?;
        let ((growing, passing), path) = (made, path.to_owned());
        Ok(Self {
            path,
            growing,
            _passing: passing,
        })
    }

    /// The final path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A second handle on the file, for writing.
    pub fn file(&self) -> Result<File, TraceError> {
        let file = self.growing.as_file().try_clone();
        file.map_err(io_error("write", &self.path))
    }

    /// Renames the file after it has reached the disk.
    pub fn finish(self) -> Result<(), TraceError> {
        let Self {
            path,
            growing,
            _passing,
        } = self;
        let finish = || {
            // The permissions of the older file are kept.
            if let Ok(older) = fs::metadata(&path) {
                growing.as_file().set_permissions(older.permissions())?;
            }
            growing.as_file().sync_all()?;
            let listing = Listing::open();
            growing.persist(&path).map_err(|error| error.error)?;
            drop(listing);
            sync_folder(folder_of(&path));
            Ok(())
        };
        finish().map_err(io_error("write", &path))
    }
}

/// A hidden file of this writer alone, named after `path`.
fn growing_file(path: &Path, folder: &Path) -> io::Result<(NamedTempFile, Passing)> {
    let prefix = prefix_of(path);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(ENDING);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file; the system applies the umask.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    loop {
        let listing = Listing::open();
        let growing = builder.tempfile_in(folder)?;
        // Before it is locked it may be taken for an abandoned one, and removed. On a file system
        // without locks nobody removes files.
        let is_taken = matches!(growing.as_file().try_lock(), Err(TryLockError::WouldBlock));
        if !is_taken && growing.path().exists() {
            let passing = listing.add(growing.path().to_owned());
            return Ok((growing, passing));
        }
    }
}

fn prefix_of(path: &Path) -> String {
    format!(
        ".{}.",
        path.file_name().unwrap_or_default().to_string_lossy()
    )
}

/// The folder that a file is in.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Syncs the names in a folder to the disk. If a file system cannot, the files themselves are still
/// there.
fn sync_folder(folder: &Path) {
    #[cfg(unix)]
    {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
    #[cfg(not(unix))]
    {
        let _ = folder;
    }
}

/// Writes a file atomically. Something that is not a file, such as `/dev/stdout` or a pipe, is
/// written to directly.
///
/// # Errors
/// The error of `write`, or [`TraceError::Io`]; in both cases `path` is unchanged and nothing is
/// left behind.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut File) -> Result<(), TraceError>,
) -> Result<(), TraceError> {
    if is_stream(path) {
        let file = OpenOptions::new().write(true).open(path);
        return write(&mut file.map_err(io_error("write", path))?);
    }
    let unfinished = Unfinished::create(path, folder_of(path))?;
    write(&mut unfinished.file()?)?;
    unfinished.finish()
}

/// Writes text to a file so that nobody ever sees half of it, see [`write_atomically`].
///
/// # Errors
/// [`TraceError::Io`]; `path` is then as it was.
pub fn write_text(path: &Path, text: &str) -> Result<(), TraceError> {
    write_bytes(path, text.as_bytes())
}

/// Writes bytes to a file so that nobody ever sees half of it, see [`write_atomically`].
///
/// # Errors
/// [`TraceError::Io`]; `path` is then as it was.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), TraceError> {
    write_atomically(path, |file| {
        file.write_all(bytes).map_err(io_error("write", path))
    })
}

/// Whether `path` is neither file nor folder: then it is written to, and not replaced.
pub fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|is| !is.is_file() && !is.is_dir())
}

/// Removes unfinished files of killed writers from a folder; those being written stay.
///
/// # Errors
/// [`TraceError::Io`] if the folder cannot be read or such a file cannot be removed.
pub fn clear_unfinished(folder: &Path) -> Result<(), TraceError> {
    clear(folder, is_unfinished)
}

/// Like [`clear_unfinished`], for the file `path` alone.
pub(super) fn clear_unfinished_of(path: &Path) -> Result<(), TraceError> {
    let prefix = prefix_of(path);
    clear(folder_of(path), |name| {
        name.starts_with(&prefix) && is_unfinished(name)
    })
}

/// Whether a file's name is that of an unfinished one.
pub(crate) fn is_unfinished(name: &str) -> bool {
    name.starts_with('.') && name.ends_with(ENDING)
}

fn clear(folder: &Path, is_meant: impl Fn(&str) -> bool) -> Result<(), TraceError> {
    for entry in fs::read_dir(folder).map_err(io_error("read", folder))? {
        let entry = entry.map_err(io_error("read", folder))?;
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !is_meant(&entry.file_name().to_string_lossy()) {
            continue;
        }
        let path = entry.path();
        // Opened for writing, because some file systems require that for a lock.
        let left = OpenOptions::new().write(true).open(&path);
        if left.is_ok_and(|file| file.try_lock().is_ok()) {
            match fs::remove_file(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(io_error("remove", &path)(error));
                }
                _ => {}
            }
        }
    }
    Ok(())
}

pub(crate) fn io_error(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> TraceError {
    let path = path.to_owned();
    move |source| TraceError::Io {
        doing,
        path,
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_at_once_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_text(&path, "old").unwrap();
        write_atomically(&path, |file| {
            file.write_all(b"new").unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "old");
            Ok(())
        })
        .unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_write_that_fails_leaves_the_file_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_text(&path, "old").unwrap();
        let failed = write_atomically(&path, |file| {
            file.write_all(b"ne").unwrap();
            Err(io_error("write", &path)(io::Error::other(
                "the disk is full",
            )))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn what_a_killed_writer_left_is_cleared_and_what_is_being_written_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let others = [".a.txt.dead.ilon-partial", ".b.txt.dead.ilon-partial"];
        for name in others.iter().chain(&[".mine", "c.ilon-partial"]) {
            fs::write(folder.path().join(name), "half").unwrap();
        }
        write_atomically(&path, |_| {
            let before = names(folder.path()).len();
            clear_unfinished_of(&path)?;
            assert_eq!(names(folder.path()).len(), before - 1);
            clear_unfinished(folder.path())?;
            assert_eq!(names(folder.path()).len(), before - 2);
            Ok(())
        })
        .unwrap();
        assert_eq!(names(folder.path()), [".mine", "a.txt", "c.ilon-partial"]);
    }

    #[test]
    #[cfg(unix)]
    fn a_new_file_is_as_open_as_any_and_a_replaced_one_as_open_as_it_was() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let (ours, any) = (folder.path().join("a"), folder.path().join("b"));
        write_text(&ours, "").unwrap();
        fs::write(&any, "").unwrap();
        assert_eq!(mode(&ours), mode(&any));
        fs::set_permissions(&ours, fs::Permissions::from_mode(0o640)).unwrap();
        write_text(&ours, "new").unwrap();
        assert_eq!(mode(&ours), 0o640);
    }

    #[test]
    #[cfg(unix)]
    fn a_device_is_written_to_and_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("null");
        std::os::unix::fs::symlink("/dev/null", &link).unwrap();
        write_text(&link, "gone").unwrap();
        assert_eq!(fs::read_link(&link).unwrap(), Path::new("/dev/null"));
        assert!(is_stream(Path::new("/dev/null")));
    }
}
