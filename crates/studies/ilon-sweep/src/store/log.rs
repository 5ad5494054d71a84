//! An append-only file of rows.

use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ilon_trace::file::write_text;

use crate::hash::Hash;
use crate::row::Row;
use ilon_sim::Error;

/// Time between syncs to the disk, the possible loss at a power failure. Killing the process loses
/// nothing.
const BETWEEN_SYNCS: Duration = Duration::from_secs(2);

/// Hexadecimal digits of a line's checksum.
const DIGITS: usize = 16;

/// A file of rows, open at its end.
#[derive(Debug)]
pub(super) struct Log {
    path: PathBuf,
    file: File,
    /// Bytes of complete lines.
    length: u64,
    /// Why a line could not be written: none is written after it.
    broken: Option<String>,
    /// Number of damaged lines.
    pub damaged: usize,
    synced: Instant,
}

impl Log {
    /// Opens or creates a log, and reads its rows. An incomplete last line is cut off; damaged
    /// lines are removed, so that they are found once.
    pub fn open(path: &Path) -> Result<(Self, Vec<Row>), Error> {
        let open = || {
            let mut options = OpenOptions::new();
            options.read(true).write(true).create(true).truncate(false);
            options.open(path).map_err(Error::io("create", path))
        };
        let mut file = open()?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)
            .map_err(Error::io("read", path))?;
        let Lines {
            rows,
            damaged,
            mut whole,
        } = lines(&bytes);
        if damaged > 0 {
            let kept = rows.iter().map(line).collect::<Result<String, Error>>()?;
            write_text(path, &kept)?;
            whole = kept.len() as u64;
            file = open()?;
        }
        file.set_len(whole).map_err(Error::io("write", path))?;
        file.seek(SeekFrom::End(0))
            .map_err(Error::io("write", path))?;
        let log = Self {
            path: path.to_owned(),
            file,
            length: whole,
            broken: None,
            damaged,
            synced: Instant::now(),
        };
        Ok((log, rows))
    }

    /// Adds a row.
    pub fn append(&mut self, row: &Row) -> Result<(), Error> {
        let line = line(row)?;
        if let Some(why) = &self.broken {
            let error = std::io::Error::other(why.clone());
            return Err(Error::io("write", &self.path)(error));
        }
        if let Err(error) = self.file.write_all(line.as_bytes()) {
            self.broken = Some(error.to_string());
            // The partly written line is removed if possible; otherwise it is cut off at the next
            // reading.
            let _ = self.file.set_len(self.length);
            return Err(Error::io("write", &self.path)(error));
        }
        self.length += line.len() as u64;
        if self.synced.elapsed() > BETWEEN_SYNCS {
            self.sync()?;
        }
        Ok(())
    }

    /// Syncs all rows to the disk.
    pub fn sync(&mut self) -> Result<(), Error> {
        self.synced = Instant::now();
        self.file
            .sync_data()
            .map_err(Error::io("write", &self.path))
    }
}

/// Reads the rows of a log, and the number of its damaged lines; a missing log has none.
pub(super) fn read(path: &Path) -> Result<(Vec<Row>, usize), Error> {
    let bytes = match std::fs::read(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok((Vec::new(), 0)),
        bytes => bytes.map_err(Error::io("read", path))?,
    };
    let Lines { rows, damaged, .. } = lines(&bytes);
    Ok((rows, damaged))
}

struct Lines {
    rows: Vec<Row>,
    damaged: usize,
    /// Bytes up to the end of the last complete line.
    whole: u64,
}

fn lines(bytes: &[u8]) -> Lines {
    let whole = bytes
        .iter()
        .rposition(|byte| *byte == b'\n')
        .map_or(0, |at| at + 1);
    let mut rows = Vec::new();
    let mut damaged = 0;
    for line in bytes[..whole]
        .split(|byte| *byte == b'\n')
        .filter(|line| !line.is_empty())
    {
        match row(line) {
            Some(row) => rows.push(row),
            None => damaged += 1,
        }
    }
    Lines {
        rows,
        damaged,
        whole: whole as u64,
    }
}

/// Returns a row as a line of the log.
fn line(row: &Row) -> Result<String, Error> {
    let json = serde_json::to_string(row).map_err(|error| Error::encode("a row", &error))?;
    Ok(format!("{} {json}\n", checksum(&json)))
}

fn row(line: &[u8]) -> Option<Row> {
    let (sum, json) = std::str::from_utf8(line).ok()?.split_once(' ')?;
    (sum == checksum(json)).then(|| serde_json::from_str(json).ok())?
}

fn checksum(json: &str) -> String {
    let mut digits = Hash::of(&[json]);
    digits.truncate(DIGITS);
    digits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Status;
    use toml::Value;

    fn row(run: u64) -> Row {
        Row {
            run,
            key: "k".to_owned(),
            status: Status::Done,
            error: None,
            scenario: "s".to_owned(),
            point: run,
            repetition: 0,
            // Values without a short decimal, and values that look like another type.
            values: vec![
                Value::Float(0.1 + 0.2),
                Value::Integer(9),
                Value::Float(3.0),
                Value::from("near"),
            ],
            trace_hash: Some("h".to_owned()),
            notes: vec!["a note".to_owned()],
            figures: vec![Some(1.0 / 3.0), None, Some(5e-324), Some(-0.0)],
        }
    }

    #[test]
    fn rows_come_back_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.log");
        let (mut log, before) = Log::open(&path).unwrap();
        assert!(before.is_empty());
        for run in 0..3 {
            log.append(&row(run)).unwrap();
        }
        drop(log);
        let (_, rows) = Log::open(&path).unwrap();
        assert_eq!(rows, [row(0), row(1), row(2)]);
        assert_eq!(
            rows[0].figures[3].map(f64::to_bits),
            Some((-0.0_f64).to_bits())
        );
    }

    #[test]
    fn a_log_cut_anywhere_keeps_its_whole_rows_and_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.log");
        let (mut log, _) = Log::open(&path).unwrap();
        for run in 0..3 {
            log.append(&row(run)).unwrap();
        }
        drop(log);
        let whole = std::fs::read(&path).unwrap();
        let line = whole.len() / 3;
        for cut in 0..whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            let (mut log, rows) = Log::open(&path).unwrap();
            assert_eq!((rows.len(), log.damaged), (cut / line, 0), "cut at {cut}");
            log.append(&row(7)).unwrap();
            let (_, rows) = Log::open(&path).unwrap();
            assert_eq!(rows.last(), Some(&row(7)));
        }
    }

    #[test]
    fn a_row_with_a_changed_byte_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.log");
        let (mut log, _) = Log::open(&path).unwrap();
        log.append(&row(0)).unwrap();
        drop(log);
        let whole = std::fs::read(&path).unwrap();
        for at in 0..whole.len() - 1 {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            std::fs::write(&path, &changed).unwrap();
            let (rows, damaged) = read(&path).unwrap();
            assert!(rows.is_empty() && damaged > 0, "byte {at}");
        }
    }

    #[test]
    fn damaged_lines_are_found_once_and_the_rows_around_them_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.log");
        let (mut log, _) = Log::open(&path).unwrap();
        (0..3).for_each(|run| log.append(&row(run)).unwrap());
        drop(log);
        let mut bytes = std::fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        std::fs::write(&path, &bytes).unwrap();
        let (mut log, rows) = Log::open(&path).unwrap();
        assert_eq!((log.damaged, rows), (1, vec![row(0), row(2)]));
        log.append(&row(1)).unwrap();
        drop(log);
        let (log, rows) = Log::open(&path).unwrap();
        assert_eq!((log.damaged, rows), (0, vec![row(0), row(2), row(1)]));
    }
}
