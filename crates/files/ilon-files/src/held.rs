//! Files in memory, for systems without a file system and for untrusted files that must not see it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Files by path; no path contains `.` or `..`. The folders are those of the paths.
#[derive(Clone, PartialEq, Eq)]
pub(super) struct FilesInMemory(Arc<BTreeMap<PathBuf, Arc<[u8]>>>);

impl FilesInMemory {
    pub fn of(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>) -> Self {
        let file = |(path, bytes): (PathBuf, Vec<u8>)| (normal(&path), bytes.into());
        Self(Arc::new(files.into_iter().map(file).collect()))
    }

    /// The content of a file, if it exists.
    pub fn bytes(&self, path: &Path) -> Option<Arc<[u8]>> {
        self.0.get(&normal(path)).cloned()
    }

    /// Whether some file lies below a path.
    pub fn is_folder(&self, path: &Path) -> bool {
        self.below(&normal(path)).next().is_some()
    }

    /// The names in a folder, sorted, at most `most` of them.
    pub fn names_in(&self, folder: &Path, most: usize) -> Vec<String> {
        let folder = normal(folder);
        let names = self.below(&folder).filter_map(|path| {
            let Component::Normal(name) = path.strip_prefix(&folder).ok()?.components().next()?
            else {
                return None;
            };
            name.to_str().map(str::to_owned)
        });
        let names: BTreeSet<String> = names.collect();
        names.into_iter().take(most).collect()
    }

    /// The files below a folder.
    fn below<'a>(&'a self, folder: &'a Path) -> impl Iterator<Item = &'a Path> {
        let paths = self.0.keys().map(PathBuf::as_path);
        paths.filter(move |path| *path != folder && path.starts_with(folder))
    }
}

impl fmt::Debug for FilesInMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.0.keys()).finish()
    }
}

/// A path without `.` and, where the preceding part is known, without `..`. The root is its own
/// parent. Links are not followed.
pub fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match (part, normal.components().next_back()) {
            (Component::CurDir, _) | (Component::ParentDir, Some(Component::RootDir)) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => {
                normal.pop();
            }
            (part, _) => normal.push(part),
        }
    }
    normal
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use crate::{FileAccess, ReadError};

    fn files() -> FileAccess {
        let file = |path: &str| (PathBuf::from(path), path.as_bytes().to_vec());
        FileAccess::of_memory(["/a/one", "/a/b/two", "/c/../c/three"].map(file))
    }

    #[test]
    fn files_in_memory_are_read_by_every_way_of_writing_their_paths() {
        let files = files();
        let read = |path: &str| files.read_text(Path::new(path), 100).ok();
        for path in ["/a/one", "/a/./b/../one", "/../a/one"] {
            assert_eq!(read(path).as_deref(), Some("/a/one"), "{path}");
        }
        assert_eq!(read("/c/three").as_deref(), Some("/c/../c/three"));
        assert!(files.is_file(Path::new("/a/b/two")) && !files.is_file(Path::new("/a/b")));
        assert!(files.is_folder(Path::new("/a/b")) && !files.is_folder(Path::new("/a/one")));
        assert_eq!(files.names_in(Path::new("/a"), 9), ["b", "one"]);
        assert_eq!(files.names_in(Path::new("/"), 1), ["a"]);
        assert!(files.names_in(Path::new("/none"), 9).is_empty());
    }

    #[test]
    fn beside_files_in_memory_nothing_of_the_system_is_seen() {
        let files = files();
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert!(files.is_confined() && !files.is_folder(here));
        assert!(files.names_in(here, 9).is_empty());
        let refused = files.read(&here.join("Cargo.toml"), 1 << 20).unwrap_err();
        assert_eq!(refused.to_string(), "there is no such file");
        assert!(files.open(&here.join("Cargo.toml")).is_err());
    }

    #[test]
    fn files_in_memory_keep_to_sizes_and_are_written_down_as_others_are() {
        let files = files().noting();
        let one = Path::new("/a/one");
        assert!(matches!(files.read(one, 5), Err(ReadError::TooLarge(5))));
        assert_eq!(files.read(one, 6).unwrap(), b"/a/one");
        assert_eq!(files.opened(), [one]);
    }
}
