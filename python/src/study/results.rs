//! The results of a study.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, Int64Array, StringArray};
use arrow_schema::{DataType, Field};
use ilon::cli;
use ilon::sweep::{self, Cells, Findings, Row, Store, columns};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyList};

use crate::trace::{ArrowTable, no_column};
use crate::typed::{Column, Dict};
use crate::values::as_python;

/// What came of a study: one row a run, and what the rows say.
#[pyclass(frozen, module = "ilon._ilon", name = "Sweep", subclass)]
pub struct Sweep {
    study: Arc<sweep::Study>,
    rows: Arc<Vec<Row>>,
    findings: Option<Arc<Findings>>,
    folder: Option<PathBuf>,
}

impl Sweep {
    pub fn new(study: Arc<sweep::Study>, store: &Store, findings: Option<Findings>) -> Self {
        Self {
            study,
            rows: Arc::new(store.rows()),
            findings: findings.map(Arc::new),
            folder: store.folder().map(Into::into),
        }
    }

    fn table(&self) -> PyResult<ArrowTable> {
        let columns = columns(&self.study, &self.rows).into_iter();
        ArrowTable::of(columns.map(|(name, cells)| {
            let (kind, is_nullable, array): (_, _, ArrayRef) = match cells {
                Cells::Whole(all) => (DataType::Int64, false, Arc::new(Int64Array::from(all))),
                Cells::Text(all) => (DataType::Utf8, true, Arc::new(StringArray::from(all))),
                Cells::Number(all) => (DataType::Float64, true, Arc::new(Float64Array::from(all))),
            };
            (Field::new(name, kind, is_nullable), array)
        }))
    }
}

#[pymethods]
impl Sweep {
    /// The same in a derived Python class.
    #[new]
    fn of(sweep: &Bound<'_, Sweep>) -> Self {
        let sweep = sweep.get();
        Self {
            study: Arc::clone(&sweep.study),
            rows: Arc::clone(&sweep.rows),
            findings: sweep.findings.clone(),
            folder: sweep.folder.clone(),
        }
    }

    /// The name of the study.
    #[getter]
    fn name(&self) -> &str {
        self.study.name()
    }

    /// How many runs there are.
    fn __len__(&self) -> usize {
        self.rows.len()
    }

    /// How many of the runs failed.
    #[getter]
    fn failed(&self) -> usize {
        let failed = |row: &&Row| row.status == sweep::Status::Failed;
        self.rows.iter().filter(failed).count()
    }

    /// What was found, as in `findings.json`; None of a shard.
    #[getter]
    fn findings<'py>(&self, py: Python<'py>) -> PyResult<Option<Dict<'py>>> {
        let findings = self.findings.as_deref();
        findings
            .map(|findings| as_python(py, findings).map(Dict::from))
            .transpose()
    }

    /// The folder of the results; None where they are in memory alone.
    #[getter]
    fn folder(&self) -> Option<PathBuf> {
        self.folder.clone()
    }

    /// The names of the columns of `runs.parquet`.
    #[getter]
    fn columns(&self) -> Vec<String> {
        let all = columns(&self.study, &[]).into_iter();
        all.map(|(name, _)| name).collect()
    }

    /// A column: numbers as a numpy array, NaN where they are absent; texts as a list, None where
    /// they are absent.
    fn __getitem__<'py>(&self, name: &Bound<'py, PyAny>) -> PyResult<Column<'py>> {
        let (py, name) = (name.py(), &name.to_string());
        let all = columns(&self.study, &self.rows);
        let Some((_, cells)) = all.iter().find(|(known, _)| known == name) else {
            let names = all.iter().map(|(known, _)| known.as_str());
            return Err(no_column(name, names, "columns"));
        };
        Ok(match cells {
            Cells::Whole(values) => PyArray1::from_slice(py, values).into(),
            Cells::Text(values) => PyList::new(py, values)?.into(),
            Cells::Number(values) => {
                let values = values.iter().map(|value| value.unwrap_or(f64::NAN));
                PyArray1::from_iter(py, values).into()
            }
        })
    }

    /// All rows as a table of Arrow.
    fn to_arrow(&self, py: Python<'_>) -> PyResult<ArrowTable> {
        py.detach(|| self.table())
    }

    /// All rows as a stream of Arrow, for libraries that read its PyCapsule protocol.
    #[pyo3(signature = (requested_schema: "object | None" = None) -> "object")]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.to_arrow(py)?.__arrow_c_stream__(py, requested_schema)
    }

    /// What was found, as the command prints it.
    fn __str__(&self) -> String {
        match &self.findings {
            Some(findings) => cli::study_words(&self.study, findings),
            None => format!("{}: {} runs of a shard", self.study.name(), self.rows.len()),
        }
    }

    /// The page of the study as the text of one HTML file; None of a shard.
    fn report_html(&self, py: Python<'_>) -> Option<String> {
        let findings = self.findings.as_deref()?;
        Some(py.detach(|| cli::study_page(&self.study, &self.rows, findings)))
    }
}
