//! Fits a robot's parameters to logs of its drives.

use std::panic::resume_unwind;
use std::path::PathBuf;

use ilon::cli;
use ilon::identify::{Progress, Study};
use pyo3::prelude::*;

use crate::errors::{OrRaise, explained};
use crate::run::until_interrupted;
use crate::scenario::{self, Named};
use crate::values::as_python;

/// Fits all free parameters of a study; returns the content of `identified.json`, and writes it
/// with its page into a folder, if one is given.
#[pyfunction]
#[pyo3(signature = (study: "_Source", *, out: "_Path | None" = None, folder: "_Path | None" = None, sandbox: "_Sandbox | None" = None) -> "_Dict")]
pub fn identify<'py>(
    py: Python<'py>,
    study: &Bound<'py, PyAny>,
    out: Option<PathBuf>,
    folder: Option<PathBuf>,
    sandbox: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let files = scenario::files(py, sandbox)?;
    let study = match scenario::named(study, folder, "study", "studies")? {
        Named::Text(text, folder) => Study::from_toml(&text, &folder.join("study"), &files),
        Named::File(path) => py.detach(|| Study::load_within(path, &files)),
    };
    let study = study.or_raise(py)?;
    if let Some(out) = &out {
        cli::may_hold_identified(out, &study)
            .map_err(|fault| explained(py, "ScenarioError", &fault))?;
    }
    let found = until_interrupted(
        py,
        |stop, _: &(dyn Fn(()) + Sync)| {
            ilon::identify::identify(&study, &|_: Progress| {
                if stop.is_asked() {
                    // A fit cannot be stopped otherwise; the waiting thread raises the exception
                    // that stopped it.
                    resume_unwind(Box::new("stopped"));
                }
            })
        },
        |_, ()| Ok(()),
    )?;
    if let Some(out) = &out {
        py.detach(|| cli::write_identified(out, &study, &found))
            .map_err(|fault| explained(py, "TraceError", &fault))?;
    }
    as_python(py, &found)
}
