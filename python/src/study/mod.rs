//! Studies: many runs of a scenario with varied keys.
//!
//! | class | is |
//! |---|---|
//! | `Study` | a study that was read; it can simulate a part of itself in any process |
//! | `Rows` | the runs of a study so far, in a folder or in memory, for this process alone |
//! | `Sweep` | the results of a study |

mod results;
mod rows;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ilon::files::FileAccess;
use ilon::sweep::{self, Options};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::OrRaise;
use crate::run::until_interrupted;
use crate::scenario::{self, Named};

pub use results::Sweep;
pub use rows::{Rows, merge_sweeps};

/// The name of a study that is not a file.
const NAMELESS: &str = "study";

/// A study that was read.
#[pyclass(frozen, module = "ilon._ilon")]
pub struct Study(Arc<sweep::Study>);

/// Reads a study from a path or a dict; relative paths of a dict start from `folder`, or from the
/// working directory.
fn read(
    source: &Bound<'_, PyAny>,
    folder: Option<PathBuf>,
    files: &FileAccess,
) -> PyResult<sweep::Study> {
    let py = source.py();
    match scenario::named(source, folder, "study", "studies")? {
        Named::Text(text, folder) => of_text(py, text, &folder.join(NAMELESS), files),
        Named::File(path) => py
            .detach(|| sweep::Study::load_within(path, files))
            .or_raise(py),
    }
}

fn of_text(
    py: Python<'_>,
    text: String,
    path: &Path,
    files: &FileAccess,
) -> PyResult<sweep::Study> {
    py.detach(|| sweep::Study::from_toml(text, path, files))
        .or_raise(py)
}

#[pymethods]
impl Study {
    #[new]
    #[pyo3(signature = (study: "_Source", *, folder: "_Path | None" = None, sandbox: "_Sandbox | None" = None))]
    fn new(
        study: &Bound<'_, PyAny>,
        folder: Option<PathBuf>,
        sandbox: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let files = scenario::files(study.py(), sandbox)?;
        Ok(Self(Arc::new(read(study, folder, &files)?)))
    }

    /// A study from the text of a file that need not be there; the paths in it start from `path`.
    #[staticmethod]
    #[pyo3(signature = (text, path: "_Path", *, sandbox: "_Sandbox | None" = None))]
    fn of_text(
        py: Python<'_>,
        text: String,
        path: PathBuf,
        sandbox: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let files = scenario::files(py, sandbox)?;
        Ok(Self(Arc::new(of_text(py, text, &path, &files)?)))
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// Its file.
    #[getter]
    fn path(&self) -> &Path {
        self.0.path()
    }

    /// The text of its file.
    #[getter]
    fn text(&self) -> &str {
        self.0.text()
    }

    /// A hash of all that its rows depend on.
    #[getter]
    fn fingerprint(&self) -> &str {
        self.0.fingerprint()
    }

    /// Makes parts of the study, so many runs at a time; their rows, as text. `folder` is that of
    /// its results.
    #[pyo3(signature = (parts: "Sequence[int]", *, jobs, folder: "_Path | None" = None) -> "bytes")]
    fn make<'py>(
        &self,
        py: Python<'py>,
        parts: Vec<u64>,
        jobs: usize,
        folder: Option<PathBuf>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let rows = until_interrupted(
            py,
            |stop, _| {
                let options = Options::new(Some(jobs), None).stopped_by(stop.clone());
                self.0.run_parts(&parts, &options, folder.as_deref())
            },
            |_, ()| Ok(()),
        )?;
        Ok(PyBytes::new(py, &rows::text_of(&rows)?))
    }
}
