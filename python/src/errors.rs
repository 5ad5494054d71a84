//! Errors as Python exceptions, with the whole text of the command line.

use ilon::Error;
use ilon::cli::explain;
use miette::Diagnostic;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

/// The classes are defined in Python, in `ilon.errors`.
static CLASSES: PyOnceLock<Py<PyModule>> = PyOnceLock::new();

/// Converts errors to Python exceptions.
pub trait OrRaise<T> {
    /// Returns the value, or an exception of the error's class.
    fn or_raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T, E: Into<Error>> OrRaise<T> for Result<T, E> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|error| raised(py, &error.into()))
    }
}

/// The exception of an error.
pub fn raised(py: Python<'_>, error: &Error) -> PyErr {
    let class = match error {
        Error::Read { .. } => "ReadError",
        Error::Robot(_) => "RobotError",
        Error::Control(_) => "ControlError",
        Error::World(_) => "WorldError",
        Error::Trace(_) => "TraceError",
        Error::Diverged { .. } => "DivergedError",
        _ => "ScenarioError",
    };
    explained(py, class, error)
}

/// An exception of a class of `ilon.errors`, with the command's explanation.
pub fn explained(py: Python<'_>, class: &str, error: &dyn Diagnostic) -> PyErr {
    let fault = explain(error);
    instance(
        py,
        class,
        (
            fault.message.as_str(),
            fault.help.as_deref(),
            Some(fault.shown.as_str()),
        ),
    )
}

/// An exception of a class of `ilon.errors`, with a message and how to repair it.
pub fn refused(py: Python<'_>, class: &str, message: &str, help: &str) -> PyErr {
    instance(py, class, (message, Some(help), None))
}

fn instance(py: Python<'_>, class: &str, arguments: (&str, Option<&str>, Option<&str>)) -> PyErr {
    let made = CLASSES
        .get_or_try_init(py, || {
            PyModule::import(py, "ilon.errors").map(Bound::unbind)
        })
        .and_then(|classes| classes.bind(py).getattr(class)?.call1(arguments));
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(fault) => fault,
    }
}
