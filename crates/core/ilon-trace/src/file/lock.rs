//! Exclusive locks on outputs.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::atomic::{clear_unfinished, clear_unfinished_of, folder_of, io_error};
use super::passing::{Listing, Passing};
use crate::error::TraceError;

/// The name of a folder's lock, and the ending of a file's lock.
pub(crate) const LOCK: &str = ".ilon-lock";

/// An exclusive lock on a folder or a file, held until it is dropped.
///
/// The lock is the operating system's, on a hidden file that is removed with it. It ends with its
/// process, in whatever way that ends, so a file left by a killed process is not locked. It works
/// between processes and within one.
#[derive(Debug)]
pub struct OutputLock {
    path: PathBuf,
    /// `None` on a file system without locks.
    file: Option<File>,
    _passing: Option<Passing>,
}

impl OutputLock {
    /// Locks an existing folder, and removes unfinished files of killed writers from it.
    ///
    /// # Errors
    /// [`TraceError::InUse`] if the lock is taken, [`TraceError::Io`] if the folder cannot be
    /// written to.
    pub fn of_folder(folder: &Path) -> Result<Self, TraceError> {
        let lock = Self::take(folder.join(LOCK), folder)?;
        clear_unfinished(folder)?;
        Ok(lock)
    }

    /// Locks a file in an existing folder, and removes unfinished files that killed writers left of
    /// it.
    ///
    /// # Errors
    /// Like [`Self::of_folder`].
    pub fn of_file(path: &Path) -> Result<Self, TraceError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let lock = Self::take(folder_of(path).join(format!(".{name}{LOCK}")), path)?;
        clear_unfinished_of(path)?;
        Ok(lock)
    }

    /// Whether the lock is held; always false on a file system without locks.
    pub fn is_held(&self) -> bool {
        self.file.is_some()
    }

    fn take(path: PathBuf, output: &Path) -> Result<Self, TraceError> {
        loop {
            // A link would redirect the lock to another file.
            if fs::symlink_metadata(&path).is_ok_and(|is| !is.is_file()) {
                let stands = io::Error::new(io::ErrorKind::AlreadyExists, "it is no file");
                return Err(io_error("lock", &path)(stands));
            }
            let mut options = OpenOptions::new();
            options.read(true).write(true).create(true).truncate(false);
            let listing = Listing::open();
            let mut file = options.open(&path).map_err(io_error("create", &path))?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(TraceError::InUse {
                        path: output.to_owned(),
                        holder: holder(&mut file),
                    });
                }
                Err(TryLockError::Error(_)) => {
                    return Ok(Self {
                        path,
                        file: None,
                        _passing: None,
                    });
                }
            }
            // Another process may have removed it, with its lock, since it was opened.
            if !is_still_at(&file, &path) {
                continue;
            }
            let name_holder = |mut file: &File| {
                file.set_len(0)?;
                write!(file, "{}", std::process::id())
            };
            // The holder's name is optional, so an error is ignored.
            let _ = name_holder(&file);
            return Ok(Self {
                _passing: Some(listing.add(path.clone())),
                path,
                file: Some(file),
            });
        }
    }
}

impl Drop for OutputLock {
    fn drop(&mut self) {
        // Removed before the lock ends, so that nobody else's file is removed. A file that stays is
        // not locked.
        if self.file.is_some() {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// The process that holds a lock, if the file names it.
fn holder(file: &mut File) -> Option<u32> {
    let mut text = String::new();
    file.seek(SeekFrom::Start(0)).ok()?;
    file.take(20).read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}

/// Whether an open file still has this path.
fn is_still_at(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let of = |is: io::Result<fs::Metadata>| is.map(|is| (is.dev(), is.ino())).ok();
        let (ours, there) = (of(file.metadata()), of(fs::symlink_metadata(path)));
        ours.is_some() && ours == there
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        path.exists()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_writer_at_a_time_and_the_next_after_it() {
        let folder = tempfile::tempdir().unwrap();
        let first = OutputLock::of_folder(folder.path()).unwrap();
        assert!(first.is_held());
        match OutputLock::of_folder(folder.path()) {
            Err(TraceError::InUse { path, holder }) => {
                assert_eq!(path, folder.path());
                assert_eq!(holder, Some(std::process::id()));
            }
            other => panic!("{other:?}"),
        }
        drop(first);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        drop(OutputLock::of_folder(folder.path()).unwrap());
    }

    #[test]
    fn what_a_killed_holder_leaves_locks_nobody_out() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(LOCK), "4294967295").unwrap();
        fs::write(folder.path().join(".a.dead.ilon-partial"), "half").unwrap();
        drop(OutputLock::of_folder(folder.path()).unwrap());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn files_of_one_folder_are_locked_one_by_one() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let _a = OutputLock::of_file(&at("a.html")).unwrap();
        let _b = OutputLock::of_file(&at("b.html")).unwrap();
        let again = OutputLock::of_file(&at("a.html"));
        assert!(matches!(again, Err(TraceError::InUse { .. })));
    }

    #[test]
    #[cfg(unix)]
    fn a_link_in_place_of_a_lock_is_not_written_through() {
        let folder = tempfile::tempdir().unwrap();
        let victim = folder.path().join("victim");
        fs::write(&victim, "mine").unwrap();
        std::os::unix::fs::symlink(&victim, folder.path().join(LOCK)).unwrap();
        let refused = OutputLock::of_folder(folder.path());
        assert!(matches!(refused, Err(TraceError::Io { .. })));
        assert_eq!(fs::read_to_string(&victim).unwrap(), "mine");
    }

    #[test]
    fn of_many_who_ask_at_once_never_two_hold_it() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let folder = tempfile::tempdir().unwrap();
        let (holders, most, times) = (
            AtomicUsize::new(0),
            AtomicUsize::new(0),
            AtomicUsize::new(0),
        );
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..300 {
                        if let Ok(lock) = OutputLock::of_folder(folder.path()) {
                            let now = 1 + holders.fetch_add(1, Ordering::SeqCst);
                            most.fetch_max(now, Ordering::SeqCst);
                            times.fetch_add(1, Ordering::SeqCst);
                            std::thread::yield_now();
                            holders.fetch_sub(1, Ordering::SeqCst);
                            drop(lock);
                        }
                    }
                });
            }
        });
        assert_eq!(most.into_inner(), 1);
        assert!(times.into_inner() >= 8);
    }
}
