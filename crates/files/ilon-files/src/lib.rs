//! Reads files that input files name. It limits which files may be read, of which kind, and how
//! large they may be. [`toml`] decodes TOML documents, and [`keys`] finds all faults of their keys.
//!
//! A scenario names a robot, a robot names meshes, and either may come from an untrusted source. A
//! file's stated size and type are not trusted: devices and pipes may never end or may block, and a
//! file can grow while it is read.

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod defaults;
mod held;
pub mod keys;
pub mod toml;

use std::collections::BTreeSet;
use std::fmt;
use std::fs::{self, File, FileType};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use held::FilesInMemory;
pub use held::normal;

/// Which files may be read: all, those below certain folders, or those in memory.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileAccess {
    /// Files in memory, in place of the file system.
    held: Option<FilesInMemory>,
    /// The folders, with links resolved; `None` if any file may be read.
    roots: Option<Vec<PathBuf>>,
    /// Records which files are opened, if requested.
    opened: Option<Opened>,
}

/// Opened files, shared between copies of an access.
#[derive(Clone, Default)]
struct Opened(Arc<Mutex<BTreeSet<PathBuf>>>);

/// Why a file was not read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system reported an error.
    #[error("{}", refused(.0))]
    Io(#[from] io::Error),
    /// It is not a regular file: reading it may block or never end.
    #[error("it is {0}, not a file")]
    NotAFile(&'static str),
    /// It exceeds the size limit.
    #[error("it is larger than {}, the most that is read", size(*.0))]
    TooLarge(u64),
    /// It lies outside the permitted folders, or a link in its path leads out of them.
    #[error("it lies outside of what may be read here, {}", listed(.0))]
    Outside(Vec<PathBuf>),
    /// It is not UTF-8 text.
    #[error("it is not UTF-8 text, as which an editor can save it")]
    NotText,
}

impl ReadError {
    /// Whether the file does not exist.
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Io(error) if error.kind() == io::ErrorKind::NotFound)
    }
}

impl FileAccess {
    /// Any file may be read.
    pub fn anywhere() -> Self {
        Self::default()
    }

    /// Only files below these folders may be read, with links resolved.
    ///
    /// # Errors
    /// If a folder does not exist; the message names it.
    pub fn below<P: AsRef<Path>>(folders: impl IntoIterator<Item = P>) -> io::Result<Self> {
        let resolved = |folder: P| {
            let folder = folder.as_ref();
            folder.canonicalize().map_err(|error| {
                io::Error::new(error.kind(), format!("`{}`: {error}", folder.display()))
            })
        };
        let roots = folders
            .into_iter()
            .map(resolved)
            .collect::<io::Result<_>>()?;
        Ok(Self {
            roots: Some(roots),
            ..Self::default()
        })
    }

    /// Only these files may be read, each a path with its bytes. They are held in memory; the file
    /// system is never accessed.
    pub fn of_memory(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>) -> Self {
        Self {
            held: Some(FilesInMemory::of(files)),
            ..Self::default()
        }
    }

    /// A copy that records, together with its own copies, which files are opened from now on.
    #[must_use]
    pub fn noting(&self) -> Self {
        Self {
            opened: Some(Opened::default()),
            ..self.clone()
        }
    }

    /// The files opened since [`Self::noting`], sorted; empty without recording.
    pub fn opened(&self) -> Vec<PathBuf> {
        let Some(Opened(paths)) = &self.opened else {
            return Vec::new();
        };
        let paths = paths.lock().unwrap_or_else(PoisonError::into_inner);
        paths.iter().cloned().collect()
    }

    /// The folders below which files may be read, with links resolved; `None` if any file may be
    /// read.
    pub fn folders(&self) -> Option<&[PathBuf]> {
        self.roots.as_deref()
    }

    /// Whether only some files may be read.
    pub fn is_confined(&self) -> bool {
        self.roots.is_some() || self.held.is_some()
    }

    /// Reads a file of at most `most_bytes`.
    ///
    /// # Errors
    /// [`ReadError`]; a file whose stated size is larger is refused before reading.
    pub fn read(&self, path: &Path, most_bytes: u64) -> Result<Vec<u8>, ReadError> {
        let mut bytes = Vec::new();
        // The limit holds whatever size is stated: files in /proc state 0.
        self.reader(path, most_bytes)?
            .take(most_bytes.saturating_add(1))
            .read_to_end(&mut bytes)?;
        if bytes.len() as u64 > most_bytes {
            return Err(ReadError::TooLarge(most_bytes));
        }
        Ok(bytes)
    }

    /// Reads a text file of at most `most_bytes`, without its byte order mark.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn read_text(&self, path: &Path, most_bytes: u64) -> Result<String, ReadError> {
        let text =
            String::from_utf8(self.read(path, most_bytes)?).map_err(|_| ReadError::NotText)?;
        Ok(match text.strip_prefix('\u{feff}') {
            Some(rest) => rest.to_owned(),
            None => text,
        })
    }

    /// Opens a file whose stated size is at most `most_bytes`, for sequential reading.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn reader(&self, path: &Path, most_bytes: u64) -> Result<Box<dyn Read>, ReadError> {
        let (length, reader): (_, Box<dyn Read>) = match &self.held {
            Some(held) => {
                let bytes = held.bytes(path).ok_or(io::ErrorKind::NotFound);
                let bytes = bytes.map_err(io::Error::from)?;
                self.note(path.to_owned());
                (bytes.len() as u64, Box::new(io::Cursor::new(bytes)))
            }
            None => {
                let file = self.open(path)?;
                (file.metadata()?.len(), Box::new(file))
            }
        };
        if length > most_bytes {
            return Err(ReadError::TooLarge(most_bytes));
        }
        Ok(reader)
    }

    /// Opens a file of the file system for random access.
    ///
    /// # Errors
    /// [`ReadError`]; always for files in memory, which are not in the file system.
    pub fn open(&self, path: &Path) -> Result<File, ReadError> {
        if self.held.is_some() {
            return Err(io::Error::from(io::ErrorKind::Unsupported).into());
        }
        let path = self.admitted(path)?;
        // Checked before opening, as opening a pipe waits for a writer.
        let about = fs::metadata(&path)?;
        let kind = about.file_type();
        if !kind.is_file() {
            return Err(ReadError::NotAFile(kind_in_words(kind)));
        }
        if is_of_the_kernel(&about) {
            return Err(ReadError::NotAFile("a view into the kernel"));
        }
        let file = File::open(&path)?;
        self.note(path);
        Ok(file)
    }

    /// Records that a file was opened.
    fn note(&self, path: PathBuf) {
        if let Some(Opened(paths)) = &self.opened {
            let mut paths = paths.lock().unwrap_or_else(PoisonError::into_inner);
            paths.insert(path);
        }
    }

    /// Whether a file exists and may be read.
    pub fn is_file(&self, path: &Path) -> bool {
        if let Some(held) = &self.held {
            return held.bytes(path).is_some();
        }
        self.admitted(path).is_ok_and(|path| path.is_file())
    }

    /// Whether a folder exists and may be read.
    pub fn is_folder(&self, path: &Path) -> bool {
        if let Some(held) = &self.held {
            return held.is_folder(path);
        }
        self.admitted(path).is_ok_and(|path| path.is_dir())
    }

    /// The names in a folder, sorted, at most `most` of them; empty for a folder that may not be
    /// read.
    pub fn names_in(&self, folder: &Path, most: usize) -> Vec<String> {
        if let Some(held) = &self.held {
            return held.names_in(folder, most);
        }
        let entries = self
            .admitted(folder)
            .ok()
            .and_then(|path| fs::read_dir(path).ok());
        let mut names: Vec<String> = entries
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(|entry| entry.file_name().into_string().ok())
            .take(most)
            .collect();
        names.sort();
        names
    }

    /// Returns the path itself if any file may be read, otherwise its place with links resolved if
    /// that is permitted.
    fn admitted(&self, path: &Path) -> Result<PathBuf, ReadError> {
        let Some(roots) = &self.roots else {
            return Ok(path.to_owned());
        };
        let outside = || ReadError::Outside(roots.clone());
        let below = |place: &Path| roots.iter().any(|root| place.starts_with(root));
        match path.canonicalize() {
            Ok(place) if below(&place) => Ok(place),
            Ok(_) => Err(outside()),
            // Whether a file exists outside is not revealed.
            Err(_) if !leads(path).is_some_and(|place| below(&place)) => Err(outside()),
            Err(error) => Err(error.into()),
        }
    }
}

/// Equality covers what may be read, not what was opened.
impl PartialEq for Opened {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Opened {}

impl fmt::Debug for Opened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Opened")
    }
}

/// The place of a path whose end does not exist: its existing folder with links resolved, and the
/// rest. A rest that contains `..` is not permitted.
fn leads(path: &Path) -> Option<PathBuf> {
    let absolute = std::path::absolute(path).ok()?;
    absolute.ancestors().skip(1).find_map(|above| {
        let place = above.canonicalize().ok()?;
        let rest = absolute.strip_prefix(above).ok()?;
        let climbs = rest.components().any(|part| part == Component::ParentDir);
        Some(if climbs {
            PathBuf::new()
        } else {
            place.join(rest)
        })
    })
}

fn refused(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
            "there is no such file".to_owned()
        }
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        _ => error.to_string(),
    }
}

/// Whether a file lies in a file system with kernel state. Its files claim to be regular, but
/// reading some of them, such as `/proc/kmsg`, waits forever, and none of them is a robot.
#[cfg(unix)]
fn is_of_the_kernel(about: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    let device = |folder: &str| fs::metadata(folder).map(|about| about.dev());
    let root = device("/").ok();
    ["/proc", "/sys"].into_iter().any(|folder| {
        // Without a mount it is an ordinary folder.
        device(folder).is_ok_and(|of_kernel| Some(of_kernel) != root && of_kernel == about.dev())
    })
}

#[cfg(not(unix))]
fn is_of_the_kernel(_: &fs::Metadata) -> bool {
    false
}

fn kind_in_words(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    if kind.is_dir() {
        "a folder"
    } else {
        "something else"
    }
}

/// A size in the largest binary unit in which it is a whole number.
fn size(bytes: u64) -> String {
    match bytes {
        0 => "0 bytes".to_owned(),
        b if b.is_multiple_of(1 << 30) => format!("{} GB", b >> 30),
        b if b.is_multiple_of(1 << 20) => format!("{} MB", b >> 20),
        b if b.is_multiple_of(1 << 10) => format!("{} KB", b >> 10),
        b => format!("{b} bytes"),
    }
}

fn listed(folders: &[PathBuf]) -> String {
    let quoted: Vec<_> = folders
        .iter()
        .map(|folder| format!("`{}`", folder.display()))
        .collect();
    quoted.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_opened_is_written_down_by_whoever_asks_for_it() {
        let folder = tempfile::tempdir().unwrap();
        let [first, second] = ["a", "b"].map(|name| folder.path().join(name));
        fs::write(&first, "1").unwrap();
        fs::write(&second, "2").unwrap();
        let noting = FileAccess::anywhere().noting();
        let copy = noting.clone();
        copy.read(&second, 1).unwrap();
        noting.open(&first).unwrap();
        copy.open(&folder.path().join("none")).unwrap_err();
        assert_eq!(noting.opened(), [first, second]);
        // A new recording starts empty, separate from other recordings.
        assert!(noting.noting().opened().is_empty());
        assert!(FileAccess::anywhere().opened().is_empty());
    }

    #[test]
    fn a_file_is_read_up_to_its_last_byte_and_refused_one_byte_beyond() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, [7; 10]).unwrap();
        let access = FileAccess::anywhere();
        assert_eq!(access.read(&path, 10).unwrap(), [7; 10]);
        let refused = access.read(&path, 9).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "it is larger than 9 bytes, the most that is read"
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn what_is_no_file_or_only_says_so_is_refused_at_once() {
        let access = FileAccess::anywhere();
        let told = |path: &str| {
            access
                .read(Path::new(path), 1 << 20)
                .unwrap_err()
                .to_string()
        };
        assert_eq!(told("/dev/zero"), "it is a device, not a file");
        assert_eq!(told("/proc"), "it is a folder, not a file");
        // It claims to be a regular file, and reading it waits for the next kernel message.
        assert_eq!(
            told("/proc/kmsg"),
            "it is a view into the kernel, not a file"
        );
        assert_eq!(
            told("/proc/self/environ"),
            "it is a view into the kernel, not a file"
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        assert!(made.unwrap().success());
        // Opening it would wait for a writer forever.
        let refused = access.read(&path, 1 << 20).unwrap_err();
        assert_eq!(refused.to_string(), "it is a pipe, not a file");
    }

    #[test]
    #[cfg(unix)]
    fn neither_dots_nor_links_lead_out_of_the_folders_that_may_be_read() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["in", "in/deep", "out"] {
            fs::create_dir(at(name)).unwrap();
        }
        for name in ["in/a", "in/deep/b", "out/secret", "inside"] {
            fs::write(at(name), name).unwrap();
        }
        std::os::unix::fs::symlink(at("out/secret"), at("in/link")).unwrap();
        std::os::unix::fs::symlink(at("out"), at("in/folder")).unwrap();
        std::os::unix::fs::symlink(at("in/a"), at("out/back")).unwrap();
        let access = FileAccess::below([at("in")]).unwrap();
        let read = |name: &str| access.read_text(&at(name), 100);
        assert_eq!(read("in/a").unwrap(), "in/a");
        assert_eq!(read("in/deep/../deep/b").unwrap(), "in/deep/b");
        // It is below the folder once the link is resolved.
        assert_eq!(read("out/back").unwrap(), "in/a");
        for outside in ["in/../out/secret", "in/link", "in/folder/secret", "inside"] {
            assert!(
                matches!(read(outside), Err(ReadError::Outside(_))),
                "{outside}"
            );
        }
        assert!(FileAccess::below([at("nowhere")]).is_err());
        assert!(
            access.is_file(&at("in/link").with_file_name("a")) && access.is_folder(&at("in/deep"))
        );
        assert!(!access.is_file(&at("in/link")) && !access.is_folder(&at("in/folder")));
        assert_eq!(
            access.names_in(&at("in"), 10),
            ["a", "deep", "folder", "link"]
        );
        assert!(access.names_in(&at("out"), 10).is_empty());
    }

    #[test]
    #[cfg(unix)]
    fn whether_there_is_a_file_outside_is_not_found_out() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("in")).unwrap();
        fs::write(at("secret"), "").unwrap();
        std::os::unix::fs::symlink(folder.path(), at("in/up")).unwrap();
        let access = FileAccess::below([at("in")]).unwrap();
        for name in [
            "secret",
            "none",
            "in/../none",
            "in/none/../../secret",
            "in/up/secret",
            "in/up/none",
        ] {
            let refused = access.read(&at(name), 10).unwrap_err();
            assert!(
                matches!(refused, ReadError::Outside(_)),
                "{name}: {refused}"
            );
        }
        let missing = access.read(&at("in/none"), 10).unwrap_err();
        assert!(matches!(missing, ReadError::Io(e) if e.kind() == io::ErrorKind::NotFound));
    }

    #[test]
    fn a_byte_order_mark_is_no_text_and_bytes_that_are_no_text_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let access = FileAccess::anywhere();
        fs::write(&path, "\u{feff}four").unwrap();
        assert_eq!(access.read_text(&path, 7).unwrap(), "four");
        fs::write(&path, b"ab\xff").unwrap();
        assert!(matches!(
            access.read_text(&path, 7),
            Err(ReadError::NotText)
        ));
    }
}
