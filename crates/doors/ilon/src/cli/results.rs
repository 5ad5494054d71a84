//! The files that a study and an identification write, and the inputs that they must not replace.

use std::path::{Path, PathBuf};

use ilon_identify::Identified;
use ilon_identify::tape::{Tape, TapeFit};
use ilon_report::pages;
use ilon_sweep::{Findings, Store, Study};
use ilon_trace::file::write_text;

use super::failure::Failure;
use super::json::pretty;
use super::{again, reserve};

/// Refuses a folder, named by an option, in which the results of `ilon sweep` would replace an input
/// of the study.
///
/// # Errors
/// If they would.
pub fn refuse_study_inputs(out: &Path, study: &Study, option: &str) -> Result<(), Failure> {
    let scenarios = (0..study.scenario_names().count()).map(|index| study.scenario_path(index));
    let inputs: Vec<PathBuf> = std::iter::once(study.path())
        .chain(scenarios)
        .map(Path::to_owned)
        .collect();
    for name in ["runs.parquet", "findings.json", "report.html", "study.json"] {
        reserve::not_an_input(&out.join(name), option, &inputs)?;
    }
    Ok(())
}

/// Writes the findings of a study and their page as `ilon sweep` does, if the store has a folder.
///
/// # Errors
/// If they cannot be written.
pub fn write_study(study: &Study, store: &Store, findings: &Findings) -> Result<(), Failure> {
    ilon_sweep::write_results(study, store, findings)?;
    if let Some(folder) = store.folder() {
        let rows = store.rows();
        let again = |run| again::command(study, &rows, run);
        let page = pages::sweep::html(study, &rows, findings, &again);
        write_text(&folder.join("report.html"), &page)?;
    }
    Ok(())
}

/// Refuses a folder, named by an option, in which the results of `ilon identify` would replace an
/// input of the study.
///
/// # Errors
/// If they would.
pub fn refuse_identify_inputs(
    out: &Path,
    study: &ilon_identify::Study,
    option: &str,
) -> Result<(), Failure> {
    let mut inputs = study.inputs();
    inputs.push(study.path.clone());
    for name in ilon_identify::FILES {
        reserve::not_an_input(&out.join(name), option, &inputs)?;
    }
    Ok(())
}

/// Reserves a folder and writes all results into it, as `ilon identify` does.
///
/// # Errors
/// If the folder is in use or cannot be written to.
pub fn claim_and_write_identified(
    study: &ilon_identify::Study,
    found: &Identified,
    out: &Path,
) -> Result<(), Failure> {
    let _claim = reserve::folder(out, "another path")?;
    write_identified(study, found, out).map(drop)
}

/// Fits runs measured by tape, and writes what was found into a folder that `named` gave, as `ilon
/// identify` does; returns it with its JSON.
///
/// # Errors
/// Those of the fit; if the folder is in use or cannot be written to.
pub fn fit_tape(tape: &Tape, out: &Path, named: &str) -> Result<(TapeFit, String), Failure> {
    let file = out.join("identified.json");
    reserve::not_an_input(&file, named, &tape.inputs())?;
    let _claim = reserve::folder(out, named)?;
    let found = tape.fit()?;
    let json = pretty("what was found", &found)?;
    write_text(&file, &json)?;
    Ok((found, json))
}

/// Writes all result files, `identified.json` last; returns its text.
pub(super) fn write_identified(
    study: &ilon_identify::Study,
    found: &Identified,
    out: &Path,
) -> Result<String, Failure> {
    let json = pretty("what was found", found)?;
    for (name, text) in ilon_identify::files(study, found)? {
        write_text(&out.join(name), &text)?;
    }
    write_text(&out.join("report.html"), &pages::identify::html(found))?;
    write_text(&out.join("identified.json"), &json)?;
    Ok(json)
}
