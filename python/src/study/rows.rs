//! The runs of a study: in a folder that outlives the process, or in memory.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ilon::cli;
use ilon::sweep::{self, Options, Progress, Question, Row, Shard, Store};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use super::Study;
use super::results::Sweep;
use crate::errors::{OrRaise, explained, refused};
use crate::run::until_interrupted;

/// The rows of a study, reserved for this process until they are finished or closed.
#[pyclass(frozen, module = "ilon._ilon")]
pub struct Rows {
    study: Arc<sweep::Study>,
    shard: Option<Shard>,
    /// None once they are finished or closed.
    store: Mutex<Option<Store>>,
}

/// Rows as text for transfer between processes.
pub fn text_of(rows: &[Row]) -> PyResult<Vec<u8>> {
    serde_json::to_vec(rows).map_err(|fault| PyValueError::new_err(fault.to_string()))
}

fn closed() -> PyErr {
    PyRuntimeError::new_err("these rows are closed")
}

impl Rows {
    fn locked(&self) -> MutexGuard<'_, Option<Store>> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs `work` on the rows, unless they are closed.
    fn with<T>(&self, work: impl FnOnce(&Store) -> PyResult<T>) -> PyResult<T> {
        work(self.locked().as_ref().ok_or_else(closed)?)
    }
}

#[pymethods]
impl Rows {
    /// The existing rows of a study in a folder, or none in memory; for one shard of it, such as
    /// `"3/8"`, or for all of it.
    #[new]
    #[pyo3(signature = (study, *, folder=None, shard=None))]
    fn new(
        py: Python<'_>,
        study: &Study,
        folder: Option<PathBuf>,
        shard: Option<&str>,
    ) -> PyResult<Self> {
        let study = Arc::clone(&study.0);
        let parsed = shard.map(str::parse::<Shard>).transpose();
        let shard = parsed
            .map_err(|fault| PyValueError::new_err(format!("the shard {shard:?}: {fault}")))?;
        let is_table = matches!(study.question(), Question::Table { .. });
        if shard.is_some() && !is_table {
            return Err(refused(
                py,
                "ScenarioError",
                "a study that searches cannot be divided: each of its runs follows from those before it",
                "run it whole; it uses all cores of a machine",
            ));
        }
        let store = match folder {
            Some(folder) => {
                cli::may_hold_study(&folder, &study)
                    .map_err(|fault| explained(py, "ScenarioError", &fault))?;
                py.detach(|| Store::open(&folder, &study, shard))
                    .or_raise(py)?
            }
            None => Store::in_memory(),
        };
        Ok(Self {
            study,
            shard,
            store: Mutex::new(Some(store)),
        })
    }

    /// The folder of its rows and results.
    #[getter]
    fn folder(&self) -> PyResult<Option<PathBuf>> {
        self.with(|store| Ok(store.folder().map(Into::into)))
    }

    /// The number of rows that could not be read, and are run again.
    #[getter]
    fn damaged(&self) -> PyResult<usize> {
        self.with(|store| Ok(store.damaged()))
    }

    /// The number of existing runs.
    #[getter]
    fn done(&self) -> PyResult<usize> {
        self.with(|store| Ok(store.len()))
    }

    /// The number of runs when complete; for a search, the largest possible.
    #[getter]
    fn most(&self) -> u64 {
        self.study.most_runs(self.shard)
    }

    /// The parts of the study with missing rows.
    fn missing(&self, py: Python<'_>) -> PyResult<Vec<u64>> {
        py.detach(|| self.with(|store| Ok(self.study.missing_parts(store, self.shard))))
    }

    /// Adds rows that were made elsewhere; existing ones are kept.
    fn put(&self, py: Python<'_>, rows: &[u8]) -> PyResult<()> {
        let rows: Vec<Row> = serde_json::from_slice(rows)
            .map_err(|fault| PyValueError::new_err(format!("these are no rows: {fault}")))?;
        let put = |store: &Store| -> Result<(), ilon::Error> {
            for row in rows {
                if !store.holds(row.run) {
                    store.put(row)?;
                }
            }
            Ok(())
        };
        // Python is detached while the rows are locked, so no other thread waits for it.
        let put = py.detach(|| self.with(|store| Ok(put(store))))?;
        put.or_raise(py)
    }

    /// Runs what is missing, computes and writes the findings, and closes the rows. `progress` is
    /// called with the number of existing runs and of all.
    #[pyo3(signature = (*, jobs=None, progress=None))]
    fn finish(
        &self,
        py: Python<'_>,
        jobs: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Sweep> {
        let store = self.locked().take().ok_or_else(closed)?;
        let study = &self.study;
        let findings = until_interrupted(
            py,
            |stop, tell: &(dyn Fn(Progress) + Sync)| {
                let options = Options::new(jobs, self.shard).stopped_by(stop.clone());
                sweep::sweep(study, &store, &options, tell)
            },
            |py, now: Progress| match &progress {
                Some(progress) => progress.call1(py, (now.done, now.likely)).map(drop),
                None => Ok(()),
            },
        )?;
        // A shard alone has no findings.
        let findings = self.shard.is_none().then_some(findings);
        if let Some(findings) = &findings {
            py.detach(|| cli::write_study(study, &store, findings))
                .map_err(|fault| explained(py, "TraceError", &fault))?;
        }
        Ok(Sweep::new(Arc::clone(study), &store, findings))
    }

    /// Releases the rows.
    fn close(&self) {
        self.locked().take();
    }
}

/// Merges the rows of one study from several folders, and from the shards in them, into one.
#[pyfunction]
pub fn merge_sweeps(py: Python<'_>, folders: Vec<PathBuf>, out: PathBuf) -> PyResult<Sweep> {
    let merged = py.detach(|| Store::merge(&folders, &out));
    let (study, store) = merged.or_raise(py)?;
    let findings = sweep::findings(&study, &store);
    py.detach(|| cli::write_study(&study, &store, &findings))
        .map_err(|fault| explained(py, "TraceError", &fault))?;
    Ok(Sweep::new(Arc::new(study), &store, Some(findings)))
}
