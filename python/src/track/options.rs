//! Options of the task from Python.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::task::{Task, Weights};

/// Options of the task, by name; the Python package passes all of them.
pub struct Options<'a, 'py>(pub &'a Bound<'py, PyDict>);

impl<'py> Options<'_, 'py> {
    /// An option in its required type.
    ///
    /// # Errors
    /// If it is missing or of another type.
    pub fn get<T: for<'a> FromPyObject<'a, 'py>>(&self, name: &str) -> PyResult<T> {
        let value = self.0.get_item(name)?;
        let value = value.ok_or_else(|| PyTypeError::new_err(format!("`{name}` is not given")))?;
        value
            .extract()
            .map_err(|_| PyTypeError::new_err(format!("`{name}` is {value}, which it cannot be")))
    }

    /// A finite number that is at least `least`.
    fn number(&self, name: &str, least: f64) -> PyResult<f64> {
        let number: f64 = self.get(name)?;
        if number.is_finite() && number >= least {
            return Ok(number);
        }
        Err(PyValueError::new_err(format!(
            "`{name}` is {number}; give a finite number of at least {least}"
        )))
    }

    /// Applies all options to a task except those of its constructor.
    ///
    /// # Errors
    /// If an option is of another type, or out of range.
    pub fn apply(&self, task: &mut Task) -> PyResult<()> {
        let control_dt_s = task.scenario.run.control_dt_s;
        if let Some(episode_s) = self.get::<Option<f64>>("episode_s")? {
            if !(episode_s.is_finite() && episode_s >= control_dt_s) {
                return Err(PyValueError::new_err(format!(
                    "`episode_s` is {episode_s}; give at least a control period, {control_dt_s} s"
                )));
            }
            task.steps = (episode_s / control_dt_s).round() as u64;
        }
        task.preview_s = self.get("preview_s")?;
        if let Some(wild) = task
            .preview_s
            .iter()
            .find(|s| !(s.is_finite() && **s > 0.0))
        {
            return Err(PyValueError::new_err(format!(
                "`preview_s` holds {wild}; give seconds above 0"
            )));
        }
        if let Some(scale) = self.get::<Option<Vec<f64>>>("action_scale")? {
            task.action_scale = scale;
        }
        task.fail_at_m = self.number("fail_at_m", f64::MIN_POSITIVE)?;
        task.start_off = (
            self.number("start_off_m", 0.0)?,
            self.number("start_off_rad", 0.0)?,
        );
        task.any_phase = self.get("any_phase")?;
        self.weights(&mut task.weights)?;
        self.drawn(&mut task.drawn)?;
        Ok(())
    }

    /// The weights of the reward; the Python package has their defaults.
    fn weights(&self, into: &mut Weights) -> PyResult<()> {
        let given: Bound<'py, PyDict> = self.get("reward")?;
        for (name, value) in given.iter() {
            let name: String = name.extract()?;
            let weight: Option<f64> = value.extract().map_err(|_| {
                PyTypeError::new_err(format!("the reward `{name}` is {value}; give a number"))
            })?;
            let slot = match name.as_str() {
                "alive" => {
                    into.alive = weight.map(|weight| finite(&name, weight)).transpose()?;
                    continue;
                }
                "position" => &mut into.position,
                "heading" => &mut into.heading,
                "action_change" => &mut into.action_change,
                "energy" => &mut into.energy,
                "slip" => &mut into.slip,
                _ => {
                    return Err(PyValueError::new_err(format!(
                        "there is no reward `{name}`; there are alive, position, heading, action_change, energy and slip"
                    )));
                }
            };
            let weight = weight.ok_or_else(|| {
                PyTypeError::new_err(format!(
                    "the reward `{name}` is None, which only `alive` can be; give a number"
                ))
            })?;
            *slot = finite(&name, weight)?;
        }
        Ok(())
    }

    /// The keys that are drawn anew for each episode.
    fn drawn(&self, into: &mut Vec<(String, f64, f64)>) -> PyResult<()> {
        let given: Bound<'py, PyDict> = self.get("randomise")?;
        for (key, range) in given.iter() {
            let key: String = key.extract()?;
            let range: (f64, f64) = range.extract().map_err(|_| {
                PyTypeError::new_err(format!(
                    "`randomise` gives `{key}` {range}; give (low, high)"
                ))
            })?;
            if !(range.0.is_finite() && range.1.is_finite() && range.0 <= range.1) {
                return Err(PyValueError::new_err(format!(
                    "`randomise` gives `{key}` {range:?}; give two finite numbers, the smaller first"
                )));
            }
            into.push((key, range.0, range.1));
        }
        Ok(())
    }
}

/// A finite weight of the reward.
fn finite(name: &str, weight: f64) -> PyResult<f64> {
    if weight.is_finite() {
        return Ok(weight);
    }
    Err(PyValueError::new_err(format!(
        "the reward `{name}` is {weight}; give a finite number"
    )))
}
