//! Converts Python values to TOML, and JSON to Python values.

use numpy::{AllowTypeChange, PyArrayLikeDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyMapping, PyString, PyTuple};
use serde_json::Value as Json;
use toml::Value as Toml;

/// Largest depth of nested tables in a scenario; chosen. Deeper nesting is a mistake, such as a
/// dict that contains itself.
const DEEPEST: usize = 32;

/// A Python value as TOML. `None` within a dict leaves its key out.
pub fn to_toml(value: &Bound<'_, PyAny>) -> PyResult<Toml> {
    toml_at(value, "", 0)
}

fn toml_at(value: &Bound<'_, PyAny>, key: &str, depth: usize) -> PyResult<Toml> {
    let named = || match key {
        "" => "a value".to_owned(),
        key => format!("`{key}`"),
    };
    if depth > DEEPEST {
        return Err(PyValueError::new_err(format!(
            "{} lies in more than {DEEPEST} tables or lists",
            named()
        )));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(Toml::Boolean(value.extract()?));
    }
    if value.is_instance_of::<PyInt>() {
        let beyond =
            |_| PyOverflowError::new_err(format!("{} is {value}, beyond 64 bits", named()));
        return Ok(Toml::Integer(value.extract().map_err(beyond)?));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Toml::Float(value.extract()?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Toml::String(text.to_str()?.to_owned()));
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        return Ok(Toml::Table(table_at(mapping, key, depth)?));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let mut items = Vec::new();
        for (index, item) in value.try_iter()?.enumerate() {
            items.push(toml_at(&item?, &join(key, &index.to_string()), depth + 1)?);
        }
        return Ok(Toml::Array(items));
    }
    // Paths, and numpy's numbers and arrays, which convert themselves.
    if value.hasattr("__fspath__")? {
        let text = value.call_method0("__fspath__")?;
        return Ok(Toml::String(text.extract()?));
    }
    if value.hasattr("tolist")? {
        return toml_at(&value.call_method0("tolist")?, key, depth + 1);
    }
    Err(PyTypeError::new_err(format!(
        "{} is a {}, which a scenario cannot hold; give a number, a text, a bool, a list or a dict",
        named(),
        value.get_type().name()?
    )))
}

fn table_at(mapping: &Bound<'_, PyMapping>, key: &str, depth: usize) -> PyResult<toml::Table> {
    let mut table = toml::Table::new();
    for item in mapping.items()?.iter() {
        let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let Ok(name) = name.extract::<String>() else {
            return Err(PyTypeError::new_err(format!(
                "the key {name} of a scenario is no text"
            )));
        };
        if !value.is_none() {
            let within = join(key, &name);
            table.insert(name, toml_at(&value, &within, depth + 1)?);
        }
    }
    Ok(table)
}

fn join(key: &str, name: &str) -> String {
    match key {
        "" => name.to_owned(),
        key => format!("{key}.{name}"),
    }
}

/// JSON as Python values.
pub fn from_json<'py>(py: Python<'py>, value: &Json) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Json::Null => py.None().into_bound(py),
        Json::Bool(truth) => PyBool::new(py, *truth).to_owned().into_any(),
        Json::Number(number) => match number.as_i64() {
            Some(whole) => whole.into_pyobject(py)?.into_any(),
            None => match number.as_u64() {
                Some(whole) => whole.into_pyobject(py)?.into_any(),
                None => PyFloat::new(py, number.as_f64().unwrap_or(f64::NAN)).into_any(),
            },
        },
        Json::String(text) => PyString::new(py, text).into_any(),
        Json::Array(items) => {
            let items: Vec<_> = items
                .iter()
                .map(|item| from_json(py, item))
                .collect::<PyResult<_>>()?;
            PyList::new(py, items)?.into_any()
        }
        Json::Object(members) => {
            let dict = PyDict::new(py);
            for (name, member) in members {
                dict.set_item(name, from_json(py, member)?)?;
            }
            dict.into_any()
        }
    })
}

/// Any serializable value as Python values, such as a summary.
pub fn as_python<'py>(
    py: Python<'py>,
    value: &impl serde::Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    let json = serde_json::to_value(value);
    let json = json.map_err(|fault| PyValueError::new_err(fault.to_string()))?;
    from_json(py, &json)
}

/// Python numbers, in any form that numpy accepts, as a row of `count` finite ones; `what` names
/// them in errors.
pub fn finite_row(value: &Bound<'_, PyAny>, what: &str, count: usize) -> PyResult<Vec<f64>> {
    let array: PyArrayLikeDyn<'_, f64, AllowTypeChange> = value
        .extract()
        .map_err(|_| PyTypeError::new_err(format!("{what} are no array of numbers: {value}")))?;
    if array.shape() != [count] {
        return Err(PyValueError::new_err(format!(
            "{what} have the shape {:?}; give ({count},)",
            array.shape()
        )));
    }
    let row: Vec<f64> = array.as_array().iter().copied().collect();
    match row.iter().find(|number| !number.is_finite()) {
        Some(number) => Err(PyValueError::new_err(format!(
            "{what} hold {number}; give finite numbers"
        ))),
        None => Ok(row),
    }
}
