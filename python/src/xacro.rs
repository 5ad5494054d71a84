//! The xacro of ROS, which is a package of Python's: `ilon._xacro` asks it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ilon::robot::{FindPackage, use_ros_xacro};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::{PyCFunction, PyTuple};

/// Has it asked about files that ilon's own expander refuses.
pub fn ask_from_now_on() {
    use_ros_xacro(expand);
}

fn expand(
    path: &Path,
    arguments: &BTreeMap<String, String>,
    find: FindPackage,
) -> Option<(String, String)> {
    Python::attach(|py| match asked(py, path, arguments, find) {
        Ok(expanded) => expanded,
        Err(fault) => {
            if fault.is_instance_of::<PyKeyboardInterrupt>(py) {
                // Ctrl-C is for whoever called, who looks for it.
                let _ = py
                    .import("_thread")
                    .and_then(|threads| threads.call_method0("interrupt_main"));
            }
            None
        }
    })
}

fn asked(
    py: Python<'_>,
    path: &Path,
    arguments: &BTreeMap<String, String>,
    find: FindPackage,
) -> PyResult<Option<(String, String)>> {
    let find = PyCFunction::new_closure(py, None, None, move |names: &Bound<'_, PyTuple>, _| {
        let name: String = names.get_item(0)?.extract()?;
        Ok::<Option<PathBuf>, PyErr>(find(&name))
    })?;
    PyModule::import(py, "ilon._xacro")?
        .getattr("expand")?
        .call1((path, arguments.clone(), find))?
        .extract()
}
