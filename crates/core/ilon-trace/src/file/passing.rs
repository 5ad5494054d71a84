//! Files and folders that must not outlive their process: files under way, and locks. They are
//! listed while they exist, so that an interrupted process can remove them.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

static LISTED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The list, for one thread: while it is held, no other makes such a file, and none is removed by
/// [`discard_unfinished`].
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
        let path = std::path::absolute(&path).unwrap_or(path);
        self.0.insert(path.clone());
        Passing(path)
    }
}

impl Drop for Passing {
    fn drop(&mut self) {
        Listing::open().0.remove(&self.0);
        // Removes a folder in which nothing is left, and no file.
        let _ = fs::remove_dir(&self.0);
    }
}

/// Removes unfinished files, locks, and folders of parts that hold none, for a process that ends
/// now: afterwards, a thread that begins or finishes such a file waits forever.
pub fn discard_unfinished() {
    let listed = Listing::open();
    remove(&listed.0);
    std::mem::forget(listed);
}

/// Removes the listed files, and then the listed folders if they are empty.
fn remove(listed: &BTreeSet<PathBuf>) {
    for path in listed {
        let _ = fs::remove_file(path);
    }
    // An outer folder sorts before those in it.
    for path in listed.iter().rev() {
        let _ = fs::remove_dir(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A temporary file is listed by its absolute path, its folder perhaps by a relative one, which
    /// sorts elsewhere.
    #[test]
    #[cfg(unix)]
    fn a_folder_is_removed_with_the_file_in_it_however_it_is_named() {
        let place = tempfile::tempdir().unwrap();
        let here = std::env::current_dir().unwrap();
        let up: PathBuf = here.components().skip(1).map(|_| "..").collect();
        for (name, is_relative) in [("a", false), ("b", true)] {
            let folder = place.path().join(name);
            let file = folder.join("unfinished");
            fs::create_dir(&folder).unwrap();
            fs::write(&file, "").unwrap();
            let listed = match is_relative {
                true => up.join(folder.strip_prefix("/").unwrap()),
                false => folder.clone(),
            };
            remove(&BTreeSet::from([listed, file]));
            assert!(!folder.exists(), "{name}");
        }
    }
}
