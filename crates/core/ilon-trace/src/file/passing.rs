//! Files and folders that must not outlive their process: files under way, and locks. They are listed while they exist, so
//! that an interrupted process can remove them.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

static LISTED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The list, for one thread: while it is held, no other makes such a file, and none is removed by [`discard_unfinished`].
#[derive(Debug)]
pub(crate) struct Listing(MutexGuard<'static, BTreeSet<PathBuf>>);

/// A file, or a folder, on the list until this is dropped.
#[derive(Debug)]
pub(crate) struct Passing(PathBuf);

impl Listing {
    pub fn open() -> Self {
        Self(LISTED.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Adds a file that was made under this listing.
    pub fn add(mut self, path: PathBuf) -> Passing {
        self.0.insert(path.clone());
        Passing(path)
    }
}

impl Drop for Passing {
    fn drop(&mut self) {
        Listing::open().0.remove(&self.0);
    }
}

/// Removes unfinished files, locks, and folders of parts that hold none, for a process that ends now: afterwards, a thread
/// that begins or finishes such a file waits forever.
pub fn discard_unfinished() {
    let listed = Listing::open();
    // A folder after the files in it.
    for path in listed.0.iter().rev() {
        let _ = fs::remove_file(path).or_else(|_| fs::remove_dir(path));
    }
    std::mem::forget(listed);
}
