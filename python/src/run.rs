//! Whole runs: `ilon.run` and its result.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use ilon::files::FileAccess;
use ilon::simulate::{Commanded, Controller, Moment, Simulation};
use ilon::sweep::Stop;
use ilon::trace::{Summary, quantities};
use ilon::{Causes, Error, Scenario};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::{OrRaise, explained, raised};
use crate::moments::{Desired, Observation};
use crate::scenario;
use crate::trace::Recorded;
use crate::typed::Dict;
use crate::values::{as_python, finite_row};

/// Interval in which a long run checks for Ctrl-C; chosen.
pub const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// A finished run.
#[pyclass(frozen, module = "ilon._ilon", name = "Run", subclass)]
pub struct Run {
    run: Arc<ilon::Run>,
    /// The equivalent call, for the report.
    called: String,
    recorded: Py<Recorded>,
}

impl Run {
    fn new(py: Python<'_>, run: ilon::Run, called: String) -> PyResult<Self> {
        let run = Arc::new(run);
        let recorded = Py::new(py, Recorded::of(Arc::clone(&run)))?;
        Ok(Self {
            run,
            called,
            recorded,
        })
    }

    /// The run itself.
    pub fn inner(&self) -> &Arc<ilon::Run> {
        &self.run
    }
}

/// Simulates a scenario to its end; `called` is the equivalent call, for the report.
#[pyfunction]
#[pyo3(signature = (
    scenario: "_Source", *, called, settings: "_Table | None" = None, controller: "_Controller | None" = None, folder: "_Path | None" = None,
    sandbox: "_Sandbox | None" = None, converge=false, causes: "Literal['named', 'all'] | None" = None,
))]
#[expect(clippy::too_many_arguments, reason = "they are those of `ilon.run`")]
pub fn run(
    py: Python<'_>,
    scenario: &Bound<'_, PyAny>,
    called: String,
    settings: Option<&Bound<'_, PyAny>>,
    controller: Option<Py<PyAny>>,
    folder: Option<PathBuf>,
    sandbox: Option<&Bound<'_, PyAny>>,
    converge: bool,
    causes: Option<&str>,
) -> PyResult<Run> {
    let causes = match causes {
        None => Causes::None,
        Some("named") => Causes::Named,
        Some("all") => Causes::All,
        Some(other) => {
            return Err(PyValueError::new_err(format!(
                "causes is \"named\", \"all\" or None, not {other:?}"
            )));
        }
    };
    let files = scenario::files(py, sandbox)?;
    let mut scenario = scenario::read(scenario, settings, folder, &files)?;
    scenario.run.converge |= converge;
    let begun_again = [
        (
            converge,
            "a run under a controller of your own cannot be repeated at half the step: the controller cannot be started again",
            "leave out `converge`, and run it twice with `run.physics_dt_s` set",
        ),
        (
            causes != Causes::None,
            "causes cannot be left out of a run under a controller of your own: the controller cannot be started again",
            "leave out `causes`, and run it twice, with the cause and without it",
        ),
    ];
    if let Some((_, what, help)) = begun_again
        .iter()
        .find(|(asked, ..)| controller.is_some() && *asked)
    {
        return Err(raised(py, &Error::invalid(*what, *help)));
    }
    let fault = Fault::default();
    let run = py.detach(|| simulated(&scenario, controller, causes, &fault));
    match run {
        Ok(run) => Run::new(py, run, called),
        Err(stopped) => Err(stopped.fault(py)),
    }
}

/// Runs `work` on other threads until it ends. If Ctrl-C is pressed or `seen` raises, the work is
/// stopped and the exception is raised. `work` reports progress from any thread; `seen` receives
/// the newest report on the calling thread, which alone can check for Ctrl-C.
pub fn until_interrupted<T: Send, P: Send>(
    py: Python<'_>,
    work: impl FnOnce(&Stop, &(dyn Fn(P) + Sync)) -> Result<T, Error> + Send,
    mut seen: impl FnMut(Python<'_>, P) -> PyResult<()> + Send,
) -> PyResult<T> {
    let stop = Stop::default();
    let newest: Mutex<Option<P>> = Mutex::new(None);
    let newest_of = || newest.lock().unwrap_or_else(PoisonError::into_inner).take();
    let mut raised_meanwhile = None;
    let result = py.detach(|| {
        thread::scope(|scope| {
            let (ends, ended) = channel::<()>();
            let (stop, newest) = (&stop, &newest);
            let worker = scope.spawn(move || {
                let _ends = ends;
                work(stop, &|progress| {
                    *newest.lock().unwrap_or_else(PoisonError::into_inner) = Some(progress);
                })
            });
            loop {
                let has_ended = ended.recv_timeout(BETWEEN_LOOKS) != Err(RecvTimeoutError::Timeout);
                if raised_meanwhile.is_none() {
                    let looked = Python::attach(|py| {
                        newest_of().map_or(Ok(()), |progress| seen(py, progress))?;
                        py.check_signals()
                    });
                    if let Err(fault) = looked {
                        stop.ask();
                        raised_meanwhile = Some(fault);
                    }
                }
                if has_ended {
                    return worker.join();
                }
            }
        })
    });
    if let Some(fault) = raised_meanwhile {
        return Err(fault);
    }
    match result {
        Ok(result) => result.map_err(|error| raised(py, &error)),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

/// The exception raised by a Python controller.
type Fault = Arc<Mutex<Option<PyErr>>>;

/// Why a run was stopped.
pub enum Stopped {
    /// Python raised an exception: a controller, or Ctrl-C.
    Raised(PyErr),
    /// The simulation failed.
    Refused(Error),
}

impl Stopped {
    /// The exception to raise.
    pub fn fault(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Raised(fault) => fault,
            Self::Refused(error) => raised(py, &error),
        }
    }
}

impl<E: Into<Error>> From<E> for Stopped {
    fn from(error: E) -> Self {
        Self::Refused(error.into())
    }
}

fn simulated(
    scenario: &Scenario,
    controller: Option<Py<PyAny>>,
    causes: Causes,
    fault: &Fault,
) -> Result<ilon::Run, Stopped> {
    let simulation = match controller {
        None => Simulation::new(scenario)?.explaining(causes),
        Some(callable) => {
            let controller = OwnController {
                callable,
                fault: Arc::clone(fault),
            };
            Simulation::with_controller(scenario, controller)?
        }
    };
    let mut looked = Instant::now();
    let run = simulation.run_watched(|_| {
        if let Some(fault) = fault.lock().unwrap_or_else(PoisonError::into_inner).take() {
            return Err(Stopped::Raised(fault));
        }
        if looked.elapsed() >= BETWEEN_LOOKS {
            looked = Instant::now();
            Python::attach(|py| py.check_signals()).map_err(Stopped::Raised)?;
        }
        Ok(())
    })?;
    run.trace.check_finite()?;
    Ok(run)
}

/// A controller written in Python.
struct OwnController {
    callable: Py<PyAny>,
    fault: Fault,
}

impl Controller for OwnController {
    fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded {
        let commanded = Python::attach(|py| {
            let seen = Py::new(py, Observation::new(now.t_s, now.seen.clone()))?;
            let desired = now.desired.copied().map(Desired);
            let answer = self.callable.bind(py).call1((seen, desired))?;
            let (commanded, numbers) = match answer.cast::<Torques>() {
                Ok(torques) => (Commanded::Torques, torques.get().0.bind(py).clone()),
                Err(_) => (Commanded::Rates, answer),
            };
            let what = match commanded {
                Commanded::Rates => "the wheel rates of the controller",
                Commanded::Torques => "the torques of the controller",
            };
            wheels.copy_from_slice(&finite_row(&numbers, what, wheels.len())?);
            Ok(commanded)
        });
        commanded.unwrap_or_else(|fault: PyErr| {
            // The run ends before the next control period; until then the wheels are held.
            *self.fault.lock().unwrap_or_else(PoisonError::into_inner) = Some(fault);
            Commanded::Rates
        })
    }
}

/// Torques in N m, one a wheel, which a controller returns in place of wheel rates.
#[pyclass(frozen, module = "ilon")]
pub struct Torques(Py<PyAny>);

#[pymethods]
impl Torques {
    #[new]
    #[pyo3(signature = (torques_n_m: "_Array"))]
    fn new(torques_n_m: Py<PyAny>) -> Self {
        Self(torques_n_m)
    }
}

#[pymethods]
impl Run {
    /// The same run in a derived Python class.
    #[new]
    fn of(py: Python<'_>, run: &Bound<'_, Run>) -> Self {
        let run = run.get();
        Self {
            run: Arc::clone(&run.run),
            called: run.called.clone(),
            recorded: run.recorded.clone_ref(py),
        }
    }

    /// The figures of the run, as in `summary.json`.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py>> {
        as_python(py, &self.run.summary).map(Dict::from)
    }

    /// The numbers of the summary by their dotted names, such as `twist_ratio_ideal.vy`; those that
    /// do not apply are left out.
    #[getter]
    fn figures(&self) -> BTreeMap<&'static str, f64> {
        let figures = quantities::all().map(|figure| (figure.key, figure.value(&self.run.summary)));
        figures
            .filter_map(|(key, value)| Some((key, value?)))
            .collect()
    }

    /// What was recorded, to be read by column.
    #[getter]
    fn recorded(&self, py: Python<'_>) -> Py<Recorded> {
        self.recorded.clone_ref(py)
    }

    /// The scenario as it was run, every default spelled out.
    #[getter]
    fn scenario<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py>> {
        as_python(py, &self.run.scenario).map(Dict::from)
    }

    /// The same as the text of a scenario file.
    #[getter]
    fn scenario_toml(&self, py: Python<'_>) -> PyResult<String> {
        self.run.scenario.to_toml().or_raise(py)
    }

    /// The scenario's name.
    #[getter]
    fn name(&self) -> &str {
        &self.run.scenario.name
    }

    /// What a person should know about the input, although it could be run.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.run.warnings.clone()
    }

    /// The report as the text of one HTML page.
    fn report_html(&self, py: Python<'_>) -> String {
        py.detach(|| ilon::cli::report_html(&self.run, &self.called))
    }

    /// Writes what `ilon run --out` writes into a folder: summary.json, trace.parquet, report.html,
    /// scenario.toml.
    #[pyo3(signature = (folder: "_Path"))]
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        py.detach(|| ilon::cli::write_results(&folder, &self.run, &self.called))
            .map_err(|fault| explained(py, "TraceError", &fault))
    }

    /// The parts from which a run is rebuilt in another process: trace, summary, scenario, name,
    /// folder, sandbox, warnings, call.
    #[pyo3(signature = () -> "tuple[bytes, str, str, str, Path, list[Path] | None, list[str], str]")]
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Parts<'py>> {
        let bytes = py.detach(|| -> Result<_, Error> {
            let folder = tempfile::tempdir().map_err(no_room)?;
            let path = folder.path().join("trace.parquet");
            self.run.trace.write_parquet(&path)?;
            std::fs::read(&path).map_err(no_room)
        });
        let bytes = bytes.or_raise(py)?;
        let summary = serde_json::to_string(&self.run.summary);
        let summary = summary.map_err(|fault| PyValueError::new_err(fault.to_string()))?;
        let scenario = &self.run.scenario;
        Ok((
            PyBytes::new(py, &bytes),
            summary,
            scenario.to_toml().or_raise(py)?,
            scenario.name.clone(),
            scenario.folder.clone(),
            scenario.files.folders().map(<[PathBuf]>::to_vec),
            self.run.warnings.clone(),
            self.called.clone(),
        ))
    }

    /// Rebuilds a run from its parts.
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "they are what `parts` gives")]
    #[pyo3(signature = (trace: "bytes", summary, scenario, name, folder: "_Path", sandbox: "list[Path] | None", warnings, called))]
    fn of_parts(
        py: Python<'_>,
        trace: &Bound<'_, PyBytes>,
        summary: &str,
        scenario: &str,
        name: &str,
        folder: PathBuf,
        sandbox: Option<Vec<PathBuf>>,
        warnings: Vec<String>,
        called: String,
    ) -> PyResult<Self> {
        let read = || -> Result<_, Error> {
            let temporary = tempfile::tempdir().map_err(no_room)?;
            let path = temporary.path().join("trace.parquet");
            std::fs::write(&path, trace.as_bytes()).map_err(no_room)?;
            Ok(ilon::trace::Trace::read_parquet(&path)?)
        };
        let trace = read().or_raise(py)?;
        let summary: Summary = serde_json::from_str(summary)
            .map_err(|fault| PyValueError::new_err(fault.to_string()))?;
        let files = match sandbox {
            None => FileAccess::anywhere(),
            // Folders that do not exist contain no readable files.
            Some(folders) => FileAccess::below(folders.iter().filter(|folder| folder.exists()))
                .map_err(no_room)
                .or_raise(py)?,
        };
        let scenario =
            Scenario::from_toml_with(scenario, name, folder, &[], &files).or_raise(py)?;
        let run = ilon::Run {
            scenario,
            trace,
            summary,
            warnings,
        };
        Self::new(py, run, called)
    }
}

/// The pickled parts of a run.
type Parts<'py> = (
    Bound<'py, PyBytes>,
    String,
    String,
    String,
    PathBuf,
    Option<Vec<PathBuf>>,
    Vec<String>,
    String,
);

fn no_room(fault: std::io::Error) -> Error {
    let reason = ilon::sim::reason(&fault);
    Error::invalid(
        format!("a run cannot be handed to another process: {reason}"),
        "make room in the folder for temporary files",
    )
}
