//! Other commands for Python: inspect, generate, compare, judge.

use std::path::PathBuf;

use ilon::compare::{CompareError, ComparedRun, Comparison};
use ilon::control::Kinematics;
use ilon::files::FileAccess;
use ilon::formats::{LoadRobot, Loaded};
use ilon::inspect::Inspection;
use ilon::robot::Robot;
use ilon::sim::remedy::{self, Keys};
use ilon::{Error, Scenario, drawing, judge};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use toml::{Table, Value};

use crate::errors::{OrRaise, raised, refused};
use crate::run::Run;
use crate::scenario::{self, Settings};
use crate::values::{as_python, to_toml};

/// A scenario of a standing robot.
const STANDING: &str = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 0.1\n";

/// Inspects a robot's file: the dict that `ilon inspect --json` prints, a drawing from above in
/// SVG, and the URDF that was read; with `limits` also the speeds and accelerations that it can
/// reach, and a drawing of them. `options` are keys of a scenario's `[robot]`, `limits` any of its
/// keys.
#[pyfunction]
#[pyo3(signature = (path: "_Path", options: "_Table", *, limits: "_Table | None" = None, sandbox: "_Sandbox | None" = None) -> "tuple[_Dict, str, str, str | None]")]
pub fn inspect<'py>(
    py: Python<'py>,
    path: PathBuf,
    options: &Bound<'py, PyMapping>,
    limits: Option<&Bound<'py, PyAny>>,
    sandbox: Option<&Bound<'py, PyAny>>,
) -> PyResult<Seen<'py>> {
    let robot = table_of(options)?;
    let files = scenario::files(py, sandbox)?;
    let settings = limits.map(scenario::read_settings).transpose()?;
    let inspected = py.detach(|| inspected(&path, robot, settings.as_ref(), &files));
    let (inspection, svg, urdf) = inspected.or_raise(py)?;
    let limits_svg = drawing::limits(&inspection);
    Ok((as_python(py, &inspection)?, svg, urdf, limits_svg))
}

/// The inspection of a robot, its drawing, the file's text, and the drawing of its limits.
type Seen<'py> = (Bound<'py, PyAny>, String, String, Option<String>);

/// The effects of common suspects on the robot of a file in standard motions. `options` are keys of
/// a scenario's `[robot]`, `settings` any of its keys.
#[pyfunction]
#[pyo3(signature = (path: "_Path", options: "_Table", *, settings: "_Table | None" = None, sandbox: "_Sandbox | None" = None) -> "list[_Dict]")]
pub fn suspects<'py>(
    py: Python<'py>,
    path: PathBuf,
    options: &Bound<'py, PyMapping>,
    settings: Option<&Bound<'py, PyAny>>,
    sandbox: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let robot = table_of(options)?;
    let files = scenario::files(py, sandbox)?;
    let settings = settings.map(scenario::read_settings).transpose()?;
    let settings = settings
        .as_ref()
        .map(scenario::as_settings)
        .unwrap_or_default();
    let found = py.detach(|| {
        let (_, loaded) = read(&path, robot, &files)?;
        let (_, robot) = ilon::inspect::conditions(&settings, &loaded.robot, &files)?;
        ilon::sim::causes::suspects(&robot, &settings, &files)
    });
    as_python(py, &found.or_raise(py)?)
}

fn table_of(options: &Bound<'_, PyMapping>) -> PyResult<Table> {
    match to_toml(options.as_any())? {
        Value::Table(robot) => Ok(robot),
        _ => Err(PyTypeError::new_err("the options of a robot are a dict")),
    }
}

/// The robot of a file, and a scenario in which it stands.
fn read(
    path: &std::path::Path,
    mut robot: Table,
    files: &FileAccess,
) -> Result<(Scenario, Loaded), Error> {
    let mut table: Table = STANDING
        .parse()
        .map_err(|fault: toml::de::Error| Error::invalid(fault.to_string(), ""))?;
    let file = path.display().to_string();
    robot.insert("file".to_owned(), Value::String(file));
    table.insert("robot".to_owned(), Value::Table(robot));
    let scenario = Scenario::from_toml(&table.to_string(), "the options of the robot", "")?;
    let options = scenario.robot.load_options(&scenario.folder, files);
    let loaded = Robot::load_with(path, &options)
        .map_err(|fault| remedy::diagnosed(fault, path, &options, &Keys))?;
    Ok((scenario, loaded))
}

fn inspected(
    path: &std::path::Path,
    robot: Table,
    limits: Option<&Settings>,
    files: &FileAccess,
) -> Result<(Inspection, String, String), Error> {
    let (scenario, loaded) = read(path, robot, files)?;
    let mut inspection = Inspection::of_standing(&loaded, &scenario)?;
    if let Some(settings) = limits {
        let settings = scenario::as_settings(settings);
        inspection = inspection.with_limits_under(&settings, &loaded.robot, files)?;
    }
    Kinematics::new(&loaded.robot)?;
    let point_m = inspection.decoupling_point_m.map(Into::into);
    let svg = drawing::svg(&loaded.robot, point_m);
    Ok((inspection, svg, loaded.urdf.to_string()))
}

/// A URDF with explicit rollers from the file of a robot description.
#[pyfunction]
#[pyo3(signature = (spec: "_Path"))]
pub fn generate(py: Python<'_>, spec: PathBuf) -> PyResult<String> {
    py.detach(|| ilon::cli::generated(&spec)).or_raise(py)
}

/// Compares runs: names and summaries, the keys that differ, and the page.
#[pyfunction]
#[pyo3(signature = (runs: "list[Any]") -> "tuple[list[_Dict], list[_Dict], str]")]
pub fn compare<'py>(
    py: Python<'py>,
    runs: Vec<Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, String)> {
    let mut compared = Vec::new();
    let mut paths = Vec::new();
    for run in runs {
        if let Ok(run) = run.cast::<Run>() {
            let run = run.get().inner();
            compared.push(ComparedRun::new(
                run.scenario.name.clone(),
                run.trace.clone(),
                run.summary.clone(),
            ));
            paths.push(PathBuf::from(&run.scenario.name));
        } else {
            let path: PathBuf = run.extract().map_err(|_| {
                PyTypeError::new_err(
                    "compare runs, or paths of folders that runs wrote, or of traces",
                )
            })?;
            let loaded = py.detach(|| ComparedRun::load(&path));
            compared.push(loaded.map_err(|fault| not_comparable(py, fault))?);
            paths.push(path);
        }
    }
    let comparison = py.detach(|| Comparison::of(compared, &paths));
    let comparison = comparison.map_err(|fault| not_comparable(py, fault))?;
    let page = py.detach(|| ilon::report::compare::html(&comparison));
    Ok((
        as_python(py, &comparison.summaries())?,
        as_python(py, &comparison.differences)?,
        page,
    ))
}

fn not_comparable(py: Python<'_>, fault: CompareError) -> PyErr {
    match fault {
        CompareError::Read { path, source } => {
            let source = ilon::files::ReadError::Io(source);
            raised(py, &Error::read(&path, &source))
        }
        fault => refused(
            py,
            "TraceError",
            &fault.to_string(),
            "give at least two runs, folders that `ilon run` or `Run.write` wrote, or trace files",
        ),
    }
}

/// Checks a run against its scenario's `[expect]`: quantity, bound, measured, at_s, held, and a
/// sentence, for each expectation.
#[pyfunction]
#[pyo3(signature = (run) -> "list[_Dict]")]
pub fn judged<'py>(py: Python<'py>, run: &Run) -> PyResult<Bound<'py, PyAny>> {
    let verdicts = judge::judge(run.inner());
    let verdicts: Vec<_> = verdicts
        .iter()
        .map(|verdict| {
            serde_json::json!({
                "quantity": verdict.quantity,
                "bound": verdict.bound,
                "measured": verdict.measured,
                "at_s": verdict.at_s,
                "held": verdict.held,
                "words": verdict.to_string(),
            })
        })
        .collect();
    as_python(py, &verdicts)
}

/// The JSON Schema of the scenario file.
#[pyfunction]
#[pyo3(signature = () -> "_Dict")]
pub fn schema(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    as_python(py, &Scenario::json_schema())
}

/// Runs the `ilon` command; returns its exit code.
#[cfg(feature = "command")]
#[pyfunction]
#[pyo3(signature = (arguments: "list[str]"))]
pub fn command(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
    ilon::cli::end_on_signals();
    py.detach(|| ilon::cli::run_arguments(arguments))
}
