//! Fits a robot's parameters to logs of its drives.

use std::panic::resume_unwind;
use std::path::PathBuf;

use ilon::cli;
use ilon::identify::tape::Tape;
use ilon::identify::{Progress, Study};
use pyo3::prelude::*;

use crate::errors::{OrRaise, explained};
use crate::run::until_interrupted;
use crate::scenario::{self, Named};
use crate::values::as_python;

/// Fits all free parameters of a study of logs, or of runs measured by tape; returns the content of
/// `identified.json`, and writes it with its page into a folder, if one is given.
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
    let (text, path) = match scenario::named(study, folder, "study", "studies")? {
        Named::Text(text, folder) => (text, folder.join("study")),
        Named::File(path) => {
            let text = ilon::scenario::read_text(&path, &files);
            (text.or_raise(py)?, path)
        }
    };
    if let Some(tape) = Tape::from_toml(&text, &path, &files).or_raise(py)? {
        let found = match &out {
            None => tape.fit().or_raise(py)?,
            Some(out) => {
                py.detach(|| cli::fit_tape(&tape, out, "another path"))
                    .map_err(|fault| explained(py, "ScenarioError", &fault))?
                    .0
            }
        };
        return as_python(py, &found);
    }
    let study = py
        .detach(|| Study::from_toml(&text, &path, &files))
        .or_raise(py)?;
    if let Some(out) = &out {
        cli::refuse_identify_inputs(out, &study, "another path")
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
        py.detach(|| cli::claim_and_write_identified(&study, &found, out))
            .map_err(|fault| explained(py, "TraceError", &fault))?;
    }
    as_python(py, &found)
}
