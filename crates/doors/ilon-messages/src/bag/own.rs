//! Recognises bags written by ilon.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::BagError;
use super::files::{FILE, FILES, UNFINISHED_FILE, remove_if_there};

/// The first bytes of an MCAP file.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Start of the library name in its first record, for any version.
const LIBRARY: &[u8] = b"ilon ";

/// Whether a folder contains only a bag written by ilon, finished or not. False for an empty or
/// unreadable folder.
pub fn is_own(folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(folder) else {
        return false;
    };
    let mut entries = entries.peekable();
    entries.peek().is_some()
        && entries.all(|entry| {
            entry.is_ok_and(|entry| FILES.iter().any(|name| entry.file_name() == *name))
        })
        && [FILE, UNFINISHED_FILE]
            .iter()
            .any(|name| begins_as_own(&folder.join(name)).unwrap_or(false))
}

/// Whether a file names ilon at its head. An empty file of a killed writer counts as well: nothing
/// in it can be lost.
fn begins_as_own(path: &Path) -> io::Result<bool> {
    if !fs::metadata(path)?.is_file() {
        return Ok(false);
    }
    let mut head = Vec::new();
    File::open(path)?.take(256).read_to_end(&mut head)?;
    // Magic, then a record: one byte of kind, eight of length, profile and library, each after its
    // length of four bytes.
    let library = head.windows(LIBRARY.len()).any(|bytes| bytes == LIBRARY);
    Ok(head.is_empty() || head.starts_with(MAGIC) && library)
}

/// Removes a bag written by ilon, and its folder. Any other or missing folder is left alone.
///
/// # Errors
/// A file of it cannot be removed.
pub fn remove_own(folder: &Path) -> Result<(), BagError> {
    if !is_own(folder) {
        return Ok(());
    }
    for name in FILES {
        remove_if_there(&folder.join(name))?;
    }
    fs::remove_dir(folder).map_err(BagError::io(folder))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bag::BagWriter;

    #[test]
    fn only_bags_of_ilon_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        BagWriter::create(&at("own")).unwrap().finish().unwrap();
        drop(BagWriter::create(&at("unfinished")).unwrap());
        for name in ["own", "unfinished"] {
            assert!(is_own(&at(name)), "{name}");
            remove_own(&at(name)).unwrap();
            assert!(!at(name).exists(), "{name}");
        }

        BagWriter::create(&at("with_notes"))
            .unwrap()
            .finish()
            .unwrap();
        fs::write(at("with_notes/notes.txt"), "").unwrap();
        fs::create_dir(at("empty")).unwrap();
        fs::create_dir(at("other")).unwrap();
        fs::write(at("other").join(FILE), b"\x89MCAP0\r\nrosbag2").unwrap();
        for name in ["with_notes", "empty", "other", "none"] {
            assert!(!is_own(&at(name)), "{name}");
            remove_own(&at(name)).unwrap();
            assert_eq!(at(name).exists(), name != "none", "{name}");
        }
    }
}
