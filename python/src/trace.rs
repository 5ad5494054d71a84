//! A trace as columns for numpy and for Arrow.

use std::sync::Arc;

use arrow_array::{ArrayRef, BooleanArray, Float64Array, RecordBatch, UInt32Array};
use arrow_schema::{DataType, Field, Schema};
use ilon::scenario::nearest;
use ilon::trace::{self, ColumnType, Signal};
use numpy::PyArray1;
use pyo3::exceptions::{PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use pyo3_arrow::PyTable;

use crate::typed::Dict;
use crate::values::as_python;

/// What a run recorded, one row a control period; `ilon.Trace` is the mapping of it.
#[pyclass(frozen, module = "ilon._ilon")]
pub struct Recorded {
    run: Arc<ilon::Run>,
    signals: Vec<Signal>,
}

impl Recorded {
    /// The trace of a run.
    pub fn of(run: Arc<ilon::Run>) -> Self {
        Self {
            signals: run.trace.header.signals(),
            run,
        }
    }

    fn trace(&self) -> &trace::Trace {
        &self.run.trace
    }

    fn values<'t>(&'t self, signal: &'t Signal) -> impl Iterator<Item = Option<f64>> + 't {
        let rows = 0..self.trace().records().len();
        rows.map(move |row| signal.get(self.trace(), row))
    }

    /// A column as a read-only numpy array.
    fn array<'py>(&self, py: Python<'py>, signal: &Signal) -> PyResult<Bound<'py, PyAny>> {
        let present = || self.values(signal).map(Option::unwrap_or_default);
        let array = match signal.kind {
            ColumnType::Flag => {
                let flags: Vec<bool> = present().map(|flag| flag != 0.0).collect();
                PyArray1::from_vec(py, flags).into_any()
            }
            ColumnType::Count => {
                let counts: Vec<u32> = present().map(|count| count as u32).collect();
                PyArray1::from_vec(py, counts).into_any()
            }
            ColumnType::Real => {
                let reals = self.values(signal).map(|real| real.unwrap_or(f64::NAN));
                PyArray1::from_vec(py, reals.collect()).into_any()
            }
        };
        array.call_method1("setflags", (false,))?;
        Ok(array)
    }

    /// A column as an Arrow array.
    fn arrow(&self, signal: &Signal) -> (Field, ArrayRef) {
        let present = || self.values(signal).map(Option::unwrap_or_default);
        let (kind, array): (_, ArrayRef) = match signal.kind {
            ColumnType::Flag => {
                let flags: Vec<bool> = present().map(|flag| flag != 0.0).collect();
                (DataType::Boolean, Arc::new(BooleanArray::from(flags)))
            }
            ColumnType::Count => {
                let counts = UInt32Array::from_iter_values(present().map(|count| count as u32));
                (DataType::UInt32, Arc::new(counts))
            }
            ColumnType::Real => {
                let reals: Float64Array = self.values(signal).collect();
                (DataType::Float64, Arc::new(reals))
            }
        };
        (Field::new(&signal.name, kind, signal.nullable), array)
    }

    fn table(&self) -> PyResult<ArrowTable> {
        ArrowTable::of(self.signals.iter().map(|signal| self.arrow(signal)))
    }
}

#[pymethods]
impl Recorded {
    /// A column by its name, such as `truth_x_m`: an array that cannot be written to, NaN where it
    /// is absent.
    #[pyo3(signature = (name: "str") -> "npt.NDArray[Any]")]
    fn column<'py>(
        &self,
        py: Python<'py>,
        name: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let found = |signal: &&Signal| name.eq(&signal.name).unwrap_or_default();
        match self.signals.iter().find(found) {
            Some(signal) => self.array(py, signal),
            None => {
                let names = self.signals.iter().map(|signal| signal.name.as_str());
                Err(no_column(&name.to_string(), names, "list(trace)"))
            }
        }
    }

    /// The names of all columns, in the order of the file's.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.signals
            .iter()
            .map(|signal| signal.name.as_str())
            .collect()
    }

    /// How many rows there are.
    #[getter]
    fn rows(&self) -> usize {
        self.trace().records().len()
    }

    /// What the run was: wheels, steps, the robot's URDF, the ground.
    #[getter]
    fn header<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py>> {
        as_python(py, &self.trace().header).map(Dict::from)
    }

    /// All columns as a table of Arrow.
    fn to_arrow(&self, py: Python<'_>) -> PyResult<ArrowTable> {
        py.detach(|| self.table())
    }
}

/// The error for a missing column, with the most similar name, or how to list all names.
pub fn no_column<'n>(name: &str, names: impl Iterator<Item = &'n str>, all: &str) -> PyErr {
    let hint = match nearest(name, names) {
        Some(near) => format!("; did you mean `{near}`?"),
        None => format!("; `{all}` has all names"),
    };
    PyKeyError::new_err(format!("no column `{name}`{hint}"))
}

/// Columns of Arrow, to hand over by its PyCapsule protocol: `polars.DataFrame(table)`,
/// `pyarrow.table(table)`, `pandas.DataFrame.from_arrow(table)`, or by name in a query of DuckDB.
#[pyclass(frozen, module = "ilon")]
pub struct ArrowTable {
    batch: RecordBatch,
}

impl ArrowTable {
    /// A table with one batch of rows.
    pub fn of(columns: impl Iterator<Item = (Field, ArrayRef)>) -> PyResult<Self> {
        let (fields, arrays): (Vec<Field>, Vec<ArrayRef>) = columns.unzip();
        let batch = RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
            .map_err(|fault| PyRuntimeError::new_err(fault.to_string()))?;
        Ok(Self { batch })
    }

    fn handed_over<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let table = PyTable::try_new(vec![self.batch.clone()], self.batch.schema())?;
        Ok(table.into_pyobject(py)?.into_any())
    }
}

#[pymethods]
impl ArrowTable {
    /// The columns as a stream of Arrow.
    #[pyo3(signature = (requested_schema: "object | None" = None) -> "object")]
    pub fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.handed_over(py)?
            .call_method1("__arrow_c_stream__", (requested_schema,))
    }

    /// The names and types of the columns, for Arrow.
    #[pyo3(signature = () -> "object")]
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.handed_over(py)?.call_method0("__arrow_c_schema__")
    }

    /// How many rows there are.
    #[getter]
    fn num_rows(&self) -> usize {
        self.batch.num_rows()
    }

    /// The names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        let schema = self.batch.schema();
        schema
            .fields()
            .iter()
            .map(|field| field.name().clone())
            .collect()
    }

    fn __repr__(&self) -> String {
        format!(
            "<ilon.ArrowTable: {} columns, {} rows>",
            self.batch.num_columns(),
            self.batch.num_rows()
        )
    }
}
