//! The one door through which the library reads: robot files, what they include, meshes, YAML, descriptions.

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Which files may be read.
///
/// Whatever the setting, only regular files are read, up to a size that depends on their kind.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Files {
    /// The folders below which files may be read, links followed; `None` for anywhere.
    pub roots: Option<Vec<PathBuf>>,
    /// Whether `$(env NAME)` and `$(optenv NAME)` of xacro find nothing.
    pub hide_environment: bool,
}

/// Why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileFault {
    /// There is none.
    Missing,
    /// It is a folder, a device or a pipe.
    NotRegular,
    /// It is not below one of the folders that may be read.
    Outside,
    /// It is larger than this many bytes.
    TooLarge(u64),
    /// It is not UTF-8 text; with the first byte that is not.
    NotText(usize),
    /// What the operating system says.
    System(String),
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str("there is no such file"),
            Self::NotRegular => {
                f.write_str("it is not a regular file, but a folder, a device or a pipe")
            }
            Self::Outside => f.write_str("it lies outside the folders that may be read"),
            Self::TooLarge(most) if *most < 1 << 20 => {
                write!(f, "it is larger than {} kB", most >> 10)
            }
            Self::TooLarge(most) => write!(f, "it is larger than {} MB", most >> 20),
            Self::NotText(at) => write!(f, "it is not UTF-8 text, from byte {at} on"),
            Self::System(reason) => f.write_str(reason),
        }
    }
}

impl std::error::Error for FileFault {}

impl Files {
    /// Files below these folders only, and nothing of the environment.
    pub fn below(roots: impl IntoIterator<Item = PathBuf>) -> Self {
        Self {
            roots: Some(roots.into_iter().collect()),
            hide_environment: true,
        }
    }

    /// A file's bytes, at most so many.
    ///
    /// # Errors
    /// Every [`FileFault`] but [`FileFault::NotText`].
    pub fn read(&self, path: &Path, most_bytes: u64) -> Result<Vec<u8>, FileFault> {
        let path = self.admitted(path)?;
        if !fs::metadata(&path).map_err(fault)?.is_file() {
            return Err(FileFault::NotRegular);
        }
        let mut bytes = Vec::new();
        let file = File::open(&path).map_err(fault)?;
        // However much it says that it holds: files grow, and some that are no devices hold nothing and never end.
        file.take(most_bytes + 1)
            .read_to_end(&mut bytes)
            .map_err(fault)?;
        if bytes.len() as u64 > most_bytes {
            return Err(FileFault::TooLarge(most_bytes));
        }
        Ok(bytes)
    }

    /// A file's text without a byte order mark, at most so many bytes.
    ///
    /// # Errors
    /// Every [`FileFault`].
    pub fn read_text(&self, path: &Path, most_bytes: u64) -> Result<String, FileFault> {
        let bytes = self.read(path, most_bytes)?;
        let text = String::from_utf8(bytes)
            .map_err(|e| FileFault::NotText(e.utf8_error().valid_up_to()))?;
        Ok(match text.strip_prefix('\u{feff}') {
            Some(rest) => rest.to_owned(),
            None => text,
        })
    }

    /// Whether there is a file that may be read.
    pub fn is_file(&self, path: &Path) -> bool {
        self.admitted(path).is_ok_and(|path| path.is_file())
    }

    /// Whether there is a folder that may be read.
    pub fn is_folder(&self, path: &Path) -> bool {
        self.admitted(path).is_ok_and(|path| path.is_dir())
    }

    /// The names in a folder, sorted, at most so many; none of a folder that may not be read.
    pub fn names_in(&self, folder: &Path, most: usize) -> Vec<String> {
        let Ok(entries) = self
            .admitted(folder)
            .and_then(|folder| fs::read_dir(folder).map_err(fault))
        else {
            return Vec::new();
        };
        let mut names: Vec<String> = entries
            .flatten()
            .filter_map(|entry| entry.file_name().into_string().ok())
            .take(most)
            .collect();
        names.sort();
        names
    }

    /// A variable of the environment, where it may be seen.
    pub(crate) fn environment(&self, name: &str) -> Option<String> {
        if self.hide_environment || name.is_empty() || name.contains(['=', '\0']) {
            return None;
        }
        std::env::var(name).ok()
    }

    /// The path itself where anything may be read; its true place, links followed, where only some folders may.
    fn admitted(&self, path: &Path) -> Result<PathBuf, FileFault> {
        let Some(roots) = &self.roots else {
            return Ok(path.to_owned());
        };
        let place = fs::canonicalize(path).map_err(|e| match e.kind() {
            // Whether there is one outside is nobody's business.
            io::ErrorKind::NotFound if !lexically_below(path, roots) => FileFault::Outside,
            _ => fault(e),
        })?;
        let inside = roots
            .iter()
            .filter_map(|root| fs::canonicalize(root).ok())
            .any(|root| place.starts_with(root));
        if inside {
            Ok(place)
        } else {
            Err(FileFault::Outside)
        }
    }
}

/// Whether a path that leads nowhere would lie below one of the folders.
fn lexically_below(path: &Path, roots: &[PathBuf]) -> bool {
    let climbs = path
        .components()
        .any(|part| part == std::path::Component::ParentDir);
    let absolute = std::path::absolute(path).unwrap_or_default();
    !climbs
        && roots
            .iter()
            .filter_map(|root| std::path::absolute(root).ok())
            .any(|root| absolute.starts_with(root))
}

fn fault(error: io::Error) -> FileFault {
    match error.kind() {
        io::ErrorKind::NotFound => FileFault::Missing,
        io::ErrorKind::NotADirectory => FileFault::Missing,
        io::ErrorKind::IsADirectory => FileFault::NotRegular,
        io::ErrorKind::PermissionDenied => FileFault::System("permission denied".to_owned()),
        _ => FileFault::System(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Ground {
        folder: tempfile::TempDir,
    }

    impl Ground {
        /// `in/a.txt` to be read, `out/b.txt` not.
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            for (name, text) in [("in/a.txt", "a"), ("out/b.txt", "b")] {
                let path = folder.path().join(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, text).unwrap();
            }
            Self { folder }
        }

        fn path(&self, name: &str) -> PathBuf {
            self.folder.path().join(name)
        }

        fn below_in(&self) -> Files {
            Files::below([self.path("in")])
        }
    }

    #[test]
    fn only_what_lies_below_the_roots_is_read() {
        let ground = Ground::new();
        let files = ground.below_in();
        assert_eq!(files.read(&ground.path("in/a.txt"), 10).unwrap(), b"a");
        for outside in [
            "out/b.txt",
            "in/../out/b.txt",
            "out/none.txt",
            "in/../out/none.txt",
        ] {
            let read = files.read(&ground.path(outside), 10);
            assert_eq!(read, Err(FileFault::Outside), "{outside}");
            assert!(!files.is_file(&ground.path(outside)));
        }
        assert_eq!(
            files.read(&ground.path("in/none.txt"), 10),
            Err(FileFault::Missing)
        );
        assert!(files.names_in(&ground.path("out"), 10).is_empty());
        assert_eq!(files.names_in(&ground.path("in"), 10), ["a.txt"]);
        assert!(Files::default().read(&ground.path("out/b.txt"), 10).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_out_is_not_followed() {
        let ground = Ground::new();
        std::os::unix::fs::symlink(ground.path("out"), ground.path("in/link")).unwrap();
        let through = ground.path("in/link/b.txt");
        assert_eq!(
            ground.below_in().read(&through, 10),
            Err(FileFault::Outside)
        );
        assert_eq!(Files::default().read(&through, 10).unwrap(), b"b");
    }

    #[test]
    fn what_is_no_regular_file_is_not_read() {
        let ground = Ground::new();
        let files = Files::default();
        assert_eq!(
            files.read(&ground.path("in"), 10),
            Err(FileFault::NotRegular)
        );
        #[cfg(unix)]
        assert_eq!(
            files.read(Path::new("/dev/zero"), 10),
            Err(FileFault::NotRegular)
        );
    }

    #[test]
    fn sizes_have_an_end_and_marks_are_no_text() {
        let ground = Ground::new();
        let path = ground.path("in/long.txt");
        fs::write(&path, "\u{feff}four").unwrap();
        let files = ground.below_in();
        assert_eq!(files.read(&path, 6), Err(FileFault::TooLarge(6)));
        assert_eq!(files.read_text(&path, 7).unwrap(), "four");
        fs::write(&path, b"ab\xff").unwrap();
        assert_eq!(files.read_text(&path, 7), Err(FileFault::NotText(2)));
    }

    #[test]
    fn the_environment_can_be_hidden() {
        assert!(Files::default().environment("PATH").is_some());
        assert_eq!(Files::below([]).environment("PATH"), None);
        assert_eq!(Files::default().environment("A=B"), None);
    }
}
