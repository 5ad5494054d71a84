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

/// What was run of a study, for this process alone until it is finished or closed.
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
    #[pyo3(signature = (study, *, folder: "_Path | None" = None, shard=None))]
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
                cli::refuse_study_inputs(&folder, &study, "another path")
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

    /// The folder that its rows and results are in.
    #[getter]
    fn folder(&self) -> PyResult<Option<PathBuf>> {
        self.with(|store| Ok(store.folder().map(Into::into)))
    }

    /// How many rows could not be read again, and are run anew.
    #[getter]
    fn damaged(&self) -> PyResult<usize> {
        self.with(|store| Ok(store.damaged()))
    }

    /// How many runs are there.
    #[getter]
    fn done(&self) -> PyResult<usize> {
        self.with(|store| Ok(store.len()))
    }

    /// How many there will be; of a search, at most.
    #[getter]
    fn most(&self) -> u64 {
        self.study.most_runs(self.shard)
    }

    /// The parts of the study of which rows are missing.
    fn missing(&self, py: Python<'_>) -> PyResult<Vec<u64>> {
        py.detach(|| self.with(|store| Ok(self.study.missing_parts(store, self.shard))))
    }

    /// Adds rows that were made elsewhere; those that are there already are left as they are.
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

    /// Runs what is missing, says what came of it and writes it; the rows are closed then.
    #[pyo3(signature = (*, jobs=None, progress: "Callable[[int, int], object] | None" = None))]
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

    /// Closes the rows, so that other processes may use them.
    fn close(&self) {
        self.locked().take();
    }
}

/// Merges the rows of one study from several folders, and from the shards in them, into one.
#[pyfunction]
#[pyo3(signature = (folders: "Sequence[_Path]", out: "_Path"))]
pub fn merge_sweeps(py: Python<'_>, folders: Vec<PathBuf>, out: PathBuf) -> PyResult<Sweep> {
    let merged = py.detach(|| Store::merge(&folders, &out));
    let (study, store) = merged.or_raise(py)?;
    let findings = sweep::findings(&study, &store);
    py.detach(|| cli::write_study(&study, &store, &findings))
        .map_err(|fault| explained(py, "TraceError", &fault))?;
    Ok(Sweep::new(Arc::new(study), &store, Some(findings)))
}
