//! The learning task, stepped for many robots at once on all cores.

mod episode;
mod options;
mod task;

use std::path::PathBuf;

use ilon::simulate::{Driver, load_robot, resolve_for};
use numpy::{
    AllowTypeChange, PyArray1, PyArray2, PyArrayLikeDyn, PyArrayMethods, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use toml::Value;

use self::episode::{Episode, Stepped};
use self::options::Options;
use self::task::{Action, Off, Task};
use crate::errors::{OrRaise, raised};
use crate::scenario;
use crate::typed::{Floats, Singles};

/// What happens after an episode has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Autoreset {
    /// The next step begins a new episode and ignores its action.
    NextStep,
    /// The same step begins a new episode.
    SameStep,
    /// Nothing, until a reset.
    Disabled,
}

/// The result of a reset: observations, one row per robot; each robot's position error in m; and
/// its heading error in rad.
type Begun<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

/// Robots that follow paths, each in its own episode.
#[pyclass(module = "ilon._ilon")]
pub struct Track {
    task: Task,
    episodes: Vec<Episode>,
    autoreset: Autoreset,
    threads: usize,
    /// The thread pool, and the process that it belongs to: a fork has none of its threads.
    pool: Option<(u32, ThreadPool)>,
}

/// The result of a step for all robots: observations, rewards, failed, time is up, position errors
/// in m, heading errors in rad. If some episodes ended and began anew in this step, also their last
/// observations and errors.
type StepOutput<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Option<Final<'py>>,
);

/// Last observations, position errors and heading errors, one row per robot.
type Final<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

/// A picture of a robot from above: two poses, a path, and wheels.
type Above<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// One robot's part of a step.
#[derive(Default)]
struct Part {
    stepped: Stepped,
    /// The deviation in the current episode.
    off: Off,
    /// The last observation of an episode that ended, if a new one began in the same step.
    last: Option<Vec<f32>>,
}

#[pymethods]
impl Track {
    #[new]
    #[pyo3(signature = (scenario: "_Source", options: "_Dict"))]
    fn new(
        py: Python<'_>,
        scenario: &Bound<'_, PyAny>,
        options: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let options = Options(options);
        let settings = options.get::<Option<Bound<'_, PyAny>>>("settings")?;
        let folder = options.get::<Option<PathBuf>>("folder")?;
        let sandbox = options.get::<Option<Bound<'_, PyAny>>>("sandbox")?;
        let files = scenario::files(py, sandbox.as_ref())?;
        let mut scenario = scenario::read(scenario, settings.as_ref(), folder, &files)?;
        let robot = py.detach(|| load_robot(&scenario)).or_raise(py)?;
        let action = match options.get::<String>("action")?.as_str() {
            "twist" => Action::Twist,
            "wheel_rates" => Action::WheelRates,
            "wheel_torques" => Action::WheelTorques,
            other => {
                return Err(PyValueError::new_err(format!(
                    "`action` is {other:?}; give \"twist\", \"wheel_rates\" or \"wheel_torques\""
                )));
            }
        };
        let autoreset = match options.get::<String>("autoreset")?.as_str() {
            "next_step" => Autoreset::NextStep,
            "same_step" => Autoreset::SameStep,
            _ => Autoreset::Disabled,
        };
        let resolved = resolve_for(&scenario, &robot, Driver::Own).or_raise(py)?;
        scenario.run.duration_s = resolved.scenario().run.duration_s;
        let text = scenario.to_toml().or_raise(py)?;
        let task = options.task(scenario, text, robot, action)?;
        let task = task.completed(&resolved).or_raise(py)?;
        let count = options.get::<usize>("num_envs")?;
        if count == 0 {
            return Err(PyValueError::new_err("`num_envs` is 0; give 1 or more"));
        }
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = options.get::<Option<usize>>("threads")?.unwrap_or(cores);
        let seed = options.get::<u64>("seed")?;
        let episodes = py.detach(|| {
            // The bounds of the drawn keys are tried now, so that an invalid one is not found hours
            // later.
            for (key, low, high) in &task.drawn {
                for end in [low, high] {
                    task.plant(&vec![(key.clone(), Value::Float(*end))])?;
                }
            }
            let plant = task.plant(&Vec::new())?;
            (0..count)
                .map(|index| Episode::new(&task, &plant, seed.wrapping_add(index as u64)))
                .collect::<Result<Vec<_>, _>>()
        });
        Ok(Self {
            episodes: episodes.or_raise(py)?,
            task,
            autoreset,
            threads: threads.clamp(1, count),
            pool: None,
        })
    }

    /// Begins new episodes, all or those of a mask, each from its own seed or with its continued
    /// random numbers.
    #[pyo3(signature = (seeds: "Sequence[int | None]", mask: "Sequence[bool] | None" = None) -> "_Begun")]
    fn reset<'py>(
        &mut self,
        py: Python<'py>,
        seeds: Vec<Option<u64>>,
        mask: Option<Vec<bool>>,
    ) -> PyResult<Begun<'py>> {
        let count = self.episodes.len();
        let mask = mask.unwrap_or_else(|| vec![true; count]);
        if seeds.len() != count || mask.len() != count {
            return Err(PyValueError::new_err(format!(
                "{} seeds and a mask of {} were given for {count} robots",
                seeds.len(),
                mask.len()
            )));
        }
        for ((episode, seed), _) in self
            .episodes
            .iter_mut()
            .zip(&seeds)
            .zip(&mask)
            .filter(|(_, on)| **on)
        {
            if let Some(seed) = seed {
                episode.seed(*seed);
            }
        }
        let width = self.task.observations();
        let mut observations = vec![0.0_f32; count * width];
        let offs = py.detach(|| {
            self.each(&mut observations, |task, index, episode, observation| {
                if mask[index] {
                    episode.begin(task, observation)
                } else {
                    Ok(Off::default())
                }
            })
        })?;
        let (position_m, heading_rad): (Vec<_>, Vec<_>) = offs
            .iter()
            .map(|off| (off.position_m, off.heading_rad))
            .unzip();
        Ok((
            PyArray1::from_vec(py, observations).reshape([count, width])?,
            PyArray1::from_vec(py, position_m),
            PyArray1::from_vec(py, heading_rad),
        ))
    }

    /// Steps all robots by a control period; `actions` has one row of numbers per robot, clipped to
    /// [-1, 1].
    #[pyo3(signature = (actions: "_Array") -> "tuple[_Singles, _Floats, _Flags, _Flags, _Floats, _Floats, _Begun | None]")]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        actions: &Bound<'py, PyAny>,
    ) -> PyResult<StepOutput<'py>> {
        let (count, width) = (self.episodes.len(), self.task.observations());
        let actions = self.actions(actions)?;
        if self.autoreset == Autoreset::Disabled
            && let Some(index) = self.episodes.iter().position(Episode::is_over)
        {
            return Err(PyRuntimeError::new_err(format!(
                "the episode of robot {index} is over; begin another by reset(options={{\"reset_mask\": ...}})"
            )));
        }
        let mut observations = vec![0.0_f32; count * width];
        let autoreset = self.autoreset;
        let per = self.task.actions();
        let parts = py.detach(|| {
            self.each(&mut observations, |task, index, episode, observation| {
                if episode.is_over() && autoreset == Autoreset::NextStep {
                    let off = episode.begin(task, observation)?;
                    return Ok(Part {
                        off,
                        ..Part::default()
                    });
                }
                let action = &actions[index * per..(index + 1) * per];
                let stepped = episode.step(task, action, observation)?;
                let (mut off, mut last) = (stepped.off, None);
                if episode.is_over() && autoreset == Autoreset::SameStep {
                    last = Some(observation.to_vec());
                    off = episode.begin(task, observation)?;
                }
                Ok(Part { stepped, off, last })
            })
        })?;
        let of =
            |number: fn(&Part) -> f64| PyArray1::from_vec(py, parts.iter().map(number).collect());
        let flag =
            |flag: fn(&Part) -> bool| PyArray1::from_vec(py, parts.iter().map(flag).collect());
        let last = if parts.iter().any(|part| part.last.is_some()) {
            let nothing = vec![0.0; width];
            let rows = parts
                .iter()
                .map(|part| part.last.as_ref().unwrap_or(&nothing));
            let rows: Vec<f32> = rows.flatten().copied().collect();
            Some((
                PyArray1::from_vec(py, rows).reshape([count, width])?,
                of(|part| part.stepped.off.position_m),
                of(|part| part.stepped.off.heading_rad),
            ))
        } else {
            None
        };
        Ok((
            PyArray1::from_vec(py, observations).reshape([count, width])?,
            of(|part| part.stepped.reward),
            flag(|part| part.stepped.failed),
            flag(|part| part.stepped.time_is_up),
            of(|part| part.off.position_m),
            of(|part| part.off.heading_rad),
            last,
        ))
    }

    /// A robot from above, for a picture: its pose and the desired one (x and y in m, heading in
    /// rad), points of its path (x and y in m), and one row per wheel in the body frame (x and y in
    /// m, direction of its axis in rad, radius and half its width in m).
    #[pyo3(signature = (robot) -> "tuple[_Floats, _Floats, _Floats, _Floats]")]
    fn above<'py>(&self, py: Python<'py>, robot: usize) -> PyResult<Above<'py>> {
        let episode = self.episodes.get(robot).ok_or_else(|| {
            PyValueError::new_err(format!("there are {} robots", self.episodes.len()))
        })?;
        let above = episode.above();
        let path = PyArray1::from_slice(py, above.path.as_flattened());
        let wheels = PyArray1::from_slice(py, above.wheels.as_flattened());
        Ok((
            PyArray1::from_slice(py, &above.pose),
            PyArray1::from_slice(py, &above.desired),
            path.reshape([above.path.len(), 2])?,
            wheels.reshape([above.wheels.len(), 5])?,
        ))
    }

    /// Each observation lies between minus and plus this.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> Singles<'py> {
        PyArray1::from_slice(py, &self.task.bounds).into()
    }

    /// Names of the observations, with their units.
    #[getter]
    fn observation_names(&self) -> Vec<String> {
        self.task.observation_names()
    }

    /// Names of the numbers of an action.
    #[getter]
    fn action_names(&self) -> Vec<String> {
        self.task.action_names()
    }

    /// The value of an action of 1: in m/s, m/s and rad/s for a twist, in rad/s for wheel rates, in
    /// N m for torques.
    #[getter]
    fn action_scale<'py>(&self, py: Python<'py>) -> Floats<'py> {
        PyArray1::from_slice(py, &self.task.action_scale).into()
    }

    /// The time between actions, in seconds.
    #[getter]
    fn control_dt_s(&self) -> f64 {
        self.task.scenario.run.control_dt_s
    }

    /// The reward per second without any cost.
    #[getter]
    fn alive_per_s(&self) -> f64 {
        self.task.weights.alive_per_s(self.task.fail_at_m)
    }

    /// Steps of an episode that does not fail.
    #[getter]
    fn steps(&self) -> u64 {
        self.task.steps
    }
}

impl Track {
    /// Actions from numpy, one row per robot, checked to be finite and clipped to [-1, 1].
    fn actions(&self, actions: &Bound<'_, PyAny>) -> PyResult<Vec<f32>> {
        let shape = [self.episodes.len(), self.task.actions()];
        let array: PyArrayLikeDyn<'_, f32, AllowTypeChange> = actions
            .extract()
            .map_err(|_| PyTypeError::new_err("actions are an array of numbers"))?;
        if array.shape() != shape {
            return Err(PyValueError::new_err(format!(
                "actions have the shape {:?}; give ({}, {})",
                array.shape(),
                shape[0],
                shape[1]
            )));
        }
        let mut numbers: Vec<f32> = array.as_array().iter().copied().collect();
        if let Some(wild) = numbers.iter().find(|number| !number.is_finite()) {
            return Err(PyValueError::new_err(format!(
                "actions hold {wild}; give finite numbers, from -1 to 1"
            )));
        }
        for number in &mut numbers {
            *number = number.clamp(-1.0, 1.0);
        }
        Ok(numbers)
    }

    /// Applies `act` to each episode and its row of observations, in parallel if there are several
    /// threads.
    fn each<T: Send>(
        &mut self,
        observations: &mut [f32],
        act: impl Fn(&Task, usize, &mut Episode, &mut [f32]) -> Result<T, ilon::Error> + Sync,
    ) -> PyResult<Vec<T>> {
        let width = self.task.observations();
        let (task, episodes) = (&self.task, &mut self.episodes);
        let one = |((index, episode), row): ((usize, &mut Episode), &mut [f32])| {
            act(task, index, episode, row)
        };
        let done: Result<Vec<T>, ilon::Error> = if self.threads == 1 {
            let rows = observations.chunks_mut(width);
            episodes.iter_mut().enumerate().zip(rows).map(one).collect()
        } else {
            let pool = pool(&mut self.pool, self.threads)?;
            pool.install(|| {
                let rows = observations.par_chunks_mut(width);
                episodes
                    .par_iter_mut()
                    .enumerate()
                    .zip(rows)
                    .map(one)
                    .collect()
            })
        };
        done.map_err(|error| Python::attach(|py| raised(py, &error)))
    }
}

/// The thread pool of this process, made on first use and again after a fork.
fn pool(slot: &mut Option<(u32, ThreadPool)>, threads: usize) -> PyResult<&ThreadPool> {
    let process = std::process::id();
    if let Some((owner, _)) = slot
        && *owner != process
    {
        // After a fork its threads do not exist in this process, and joining them would wait
        // forever.
        std::mem::forget(slot.take());
    }
    if slot.is_none() {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("ilon-{index}"))
            .build()
            .map_err(|fault| PyRuntimeError::new_err(fault.to_string()))?;
        *slot = Some((process, pool));
    }
    match slot {
        Some((_, pool)) => Ok(pool),
        None => Err(PyRuntimeError::new_err("there are no threads")),
    }
}
