//! Options of the task from Python.

use std::collections::BTreeMap;

use ilon::Scenario;
use ilon::robot::Robot;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::task::{Action, Task, Weights};

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

    /// A finite number above 0, or of at least 0.
    fn number(&self, name: &str, may_be_zero: bool) -> PyResult<f64> {
        let number: f64 = self.get(name)?;
        if number.is_finite() && (number > 0.0 || may_be_zero && number == 0.0) {
            return Ok(number);
        }
        let range = if may_be_zero {
            "of at least 0"
        } else {
            "above 0"
        };
        Err(PyValueError::new_err(format!(
            "`{name}` is {number}; give a finite number {range}"
        )))
    }

    /// A task of a scenario, not yet completed.
    ///
    /// # Errors
    /// If an option is of another type, or out of range.
    pub fn task(
        &self,
        scenario: Scenario,
        text: String,
        robot: Robot,
        action: Action,
    ) -> PyResult<Task> {
        let (control_dt_s, duration_s) = (scenario.run.control_dt_s, scenario.run.duration_s);
        let episode_s = self.get::<Option<f64>>("episode_s")?.unwrap_or(duration_s);
        if !(episode_s.is_finite() && episode_s >= control_dt_s) {
            return Err(PyValueError::new_err(format!(
                "`episode_s` is {episode_s}; give at least a control period, {control_dt_s} s"
            )));
        }
        let preview_s: Vec<f64> = self.get("preview_s")?;
        if let Some(wild) = preview_s.iter().find(|s| !(s.is_finite() && **s > 0.0)) {
            return Err(PyValueError::new_err(format!(
                "`preview_s` holds {wild}; give seconds above 0"
            )));
        }
        let start_off = (
            self.number("start_off_m", true)?,
            self.number("start_off_rad", true)?,
        );
        Ok(Task {
            steps: (episode_s / control_dt_s).round().max(1.0) as u64,
            text,
            scenario,
            robot,
            action,
            action_scale: self.get::<Option<_>>("action_scale")?.unwrap_or_default(),
            preview_s,
            weights: self.weights()?,
            fail_at_m: self.number("fail_at_m", false)?,
            start_off,
            any_phase: self.get("any_phase")?,
            drawn: self.drawn()?,
            bounds: Vec::new(),
            rate_limits_rad_s: Vec::new(),
        })
    }

    /// The weights of the reward; the Python package has their defaults.
    fn weights(&self) -> PyResult<Weights> {
        const NAMES: [&str; 6] = [
            "alive",
            "position",
            "heading",
            "action_change",
            "energy",
            "slip",
        ];
        let given: BTreeMap<String, Bound<'py, PyAny>> = self.get("reward")?;
        if let Some(name) = given.keys().find(|name| !NAMES.contains(&name.as_str())) {
            return Err(PyValueError::new_err(format!(
                "there is no reward `{name}`; there are {}",
                NAMES.join(", ")
            )));
        }
        let weight = |name: &str| match given.get(name).map(|of| of.extract::<Option<f64>>()) {
            Some(Ok(Some(weight))) if !weight.is_finite() => Err(PyValueError::new_err(format!(
                "the reward `{name}` is {weight}; give a finite number"
            ))),
            Some(Err(_)) => Err(PyTypeError::new_err(format!(
                "the reward `{name}` is {}; give a number",
                given[name]
            ))),
            weight => Ok(weight.and_then(Result::ok).flatten()),
        };
        let cost = |name: &str| {
            weight(name)?.ok_or_else(|| {
                PyTypeError::new_err(format!(
                    "the reward `{name}` is None, which only `alive` can be; give a number"
                ))
            })
        };
        Ok(Weights {
            alive: weight("alive")?,
            position: cost("position")?,
            heading: cost("heading")?,
            action_change: cost("action_change")?,
            energy: cost("energy")?,
            slip: cost("slip")?,
        })
    }

    /// The keys that are drawn anew for each episode.
    fn drawn(&self) -> PyResult<Vec<(String, f64, f64)>> {
        let given: Bound<'py, PyDict> = self.get("randomise")?;
        let mut drawn = Vec::new();
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
            drawn.push((key, range.0, range.1));
        }
        Ok(drawn)
    }
}
