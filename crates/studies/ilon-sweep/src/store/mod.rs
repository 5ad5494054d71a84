//! The folder of a study's results: finished runs are never repeated or lost.
//!
//! Each finished run is a line of `rows.log`, with a checksum, written in one piece: a study that
//! is killed at any moment, or whose disk is full, loses no finished run, and a partial line is cut
//! off when the study continues. `study.json` holds the study and version of the rows.
//! `runs.parquet` is made from them at the end.

mod log;
mod manifest;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ilon_trace::file::OutputLock;

use self::log::Log;
use self::manifest::Manifest;
use crate::row::{Row, Task};
use crate::shard::{self, Shard};
use crate::study::{Question, Study};
use ilon_sim::Error;

/// The files that a study writes besides `study.json`; in a folder without `study.json` they are
/// someone else's.
const RESULTS: [&str; 4] = [LOG, "runs.parquet", "findings.json", "report.html"];

/// The rows of a study, in memory and, unless nothing is kept, in a folder.
#[derive(Debug)]
pub struct Store {
    folder: Option<PathBuf>,
    rows: Mutex<BTreeMap<u64, Row>>,
    log: Option<Mutex<Log>>,
    /// Number of rows that could not be read and are run again.
    damaged: usize,
    _lock: Option<OutputLock>,
}

impl Store {
    /// A store whose rows are lost with the process.
    pub fn in_memory() -> Self {
        Self {
            folder: None,
            rows: Mutex::default(),
            log: None,
            damaged: 0,
            _lock: None,
        }
    }

    /// Opens the folder of a study's results for this process alone, with all existing rows; those
    /// of a shard are in a subfolder. A missing folder is created.
    ///
    /// # Errors
    /// If the folder holds the results of another study, of this one before a change of it or its
    /// scenarios, or of another version of ilon; if another process writes there; and if it cannot
    /// be written.
    pub fn open(folder: &Path, study: &Study, shard: Option<Shard>) -> Result<Self, Error> {
        let own = match shard {
            Some(shard) => folder.join(shard.folder()),
            None => folder.to_owned(),
        };
        for place in [folder, own.as_path()] {
            if let Some(known) = Manifest::read(place)? {
                known.must_be(study, place)?;
            } else if let Some(foreign) = RESULTS.iter().find(|name| place.join(name).exists()) {
                return Err(Error::invalid(
                    format!(
                        "`{}` was not written by a study, and its results would replace it",
                        place.join(foreign).display()
                    ),
                    "choose another folder, or move the file away",
                ));
            }
        }
        fs::create_dir_all(&own).map_err(Error::io("create", &own))?;
        let lock = OutputLock::of_folder(&own)?;
        match Manifest::read(&own)? {
            Some(known) => known.must_be(study, &own)?,
            None => Manifest::of(study).write(&own)?,
        }
        let (log, mut read) = Log::open(&own.join(LOG))?;
        let mut damaged = log.damaged;
        if shard.is_none() {
            for part in shard::folders_in(folder)? {
                let Some(known) = Manifest::read(&part)? else {
                    continue;
                };
                known.must_be(study, &part)?;
                let (rows, more) = log::read(&part.join(LOG))?;
                damaged += more;
                read.extend(rows);
            }
        }
        let mut rows = BTreeMap::new();
        for row in read {
            rows.insert(row.run, row);
        }
        Ok(Self {
            folder: Some(own),
            rows: Mutex::new(rows),
            log: Some(Mutex::new(log)),
            damaged,
            _lock: Some(lock),
        })
    }

    /// Merges the rows of one study from several folders, and from the shards in them, into one.
    ///
    /// # Errors
    /// If a folder holds no rows of a study, or of another one than the first, or of one that
    /// searches; if two hold different rows of one run; if runs are missing; and those of
    /// [`Self::open`].
    pub fn merge(folders: &[PathBuf], out: &Path) -> Result<(Study, Self), Error> {
        let mut sources = Vec::new();
        for folder in folders {
            let before = sources.len();
            for part in shard::folders_in(folder)?
                .into_iter()
                .chain([folder.clone()])
            {
                if let Some(manifest) = Manifest::read(&part)? {
                    sources.push((part, manifest));
                }
            }
            if sources.len() == before {
                return Err(Error::invalid(
                    format!("`{}` holds no results of a study", folder.display()),
                    "name the folders that `ilon sweep` wrote to, or those above their shards",
                ));
            }
        }
        let Some((_, first)) = sources.first() else {
            return Err(Error::invalid(
                "there is nothing to merge",
                "name folders of results",
            ));
        };
        let study = first.study()?;
        let Question::Table { runs } = study.question() else {
            return Err(Error::invalid(
                format!(
                    "`{}` is a study that searches: it has no parts to merge",
                    study.name()
                ),
                "run it whole",
            ));
        };
        let mut rows: BTreeMap<u64, Row> = BTreeMap::new();
        for (part, manifest) in &sources {
            manifest.must_be(&study, part)?;
            for row in log::read(&part.join(LOG))?.0 {
                match rows.get(&row.run) {
                    Some(known) if *known != row => {
                        return Err(Error::invalid(
                            format!(
                                "run {} occurs twice, with different results; once in `{}`",
                                row.run,
                                part.display()
                            ),
                            "leave out one of the folders: equal runs of a study give equal results, so one of them was changed",
                        ));
                    }
                    _ => {
                        rows.insert(row.run, row);
                    }
                }
            }
        }
        let missing: Vec<u64> = (0..runs).filter(|run| !rows.contains_key(run)).collect();
        if let Some(first) = missing.first() {
            return Err(Error::invalid(
                format!(
                    "{} of {runs} runs are missing, the first of them run {first}",
                    missing.len()
                ),
                "run the shards that have not ended, or the study itself, which runs what is missing",
            ));
        }
        let store = Self::open(out, &study, None)?;
        for row in rows.into_values() {
            if store.row(row.run).is_none() {
                store.put(row)?;
            }
        }
        Ok((study, store))
    }

    /// Whether a folder holds this study's results.
    pub(crate) fn holds_rows_of(folder: &Path, study: &Study) -> bool {
        let known = Manifest::read(folder).ok().flatten();
        known.is_some_and(|known| known.must_be(study, folder).is_ok())
    }

    /// Its folder; `None` if in memory.
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// The number of rows that could not be read and are run again.
    pub fn damaged(&self) -> usize {
        self.damaged
    }

    /// Returns the row of a run, if finished.
    pub fn row(&self, run: u64) -> Option<Row> {
        self.locked().get(&run).cloned()
    }

    /// Returns the row of a task, if exactly this task was run.
    pub(crate) fn row_of(&self, task: &Task) -> Option<Row> {
        self.row(task.run).filter(|row| row.values == task.values)
    }

    /// Whether a run is finished.
    pub fn holds(&self, run: u64) -> bool {
        self.locked().contains_key(&run)
    }

    /// The number of finished runs.
    pub fn len(&self) -> usize {
        self.locked().len()
    }

    /// Whether no run is finished.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns all rows, in the order of their runs.
    pub fn rows(&self) -> Vec<Row> {
        self.locked().values().cloned().collect()
    }

    /// Adds the row of a finished run. When this returns, the row outlives the process.
    ///
    /// # Errors
    /// If it cannot be written; earlier rows are kept.
    pub fn put(&self, row: Row) -> Result<(), Error> {
        if let Some(log) = &self.log {
            log.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .append(&row)?;
        }
        self.locked().insert(row.run, row);
        Ok(())
    }

    /// Syncs all rows to the disk.
    pub(crate) fn sync(&self) -> Result<(), Error> {
        match &self.log {
            Some(log) => log.lock().unwrap_or_else(PoisonError::into_inner).sync(),
            None => Ok(()),
        }
    }

    fn locked(&self) -> std::sync::MutexGuard<'_, BTreeMap<u64, Row>> {
        self.rows.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The name of the file of rows.
const LOG: &str = "rows.log";
