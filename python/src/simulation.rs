//! A robot that is driven step by step: `ilon.Simulation`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use ilon::robot::{Pose, Twist};
use ilon::simulate::{Driver, JointCommand, Plant, WheelCommand, load_robot, resolve_for};
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

use crate::errors::OrRaise;
use crate::moments::{Body, Desired, FreeBody, Observation, Outcome, Truth, Wheels};
use crate::run::{BETWEEN_LOOKS, Stopped};
use crate::scenario;
use crate::typed::{Dict, Floats};
use crate::values::{as_python, finite_row};

/// Physics steps between checks of the clock, several milliseconds of computation; chosen.
const STEPS_AT_ONCE: f64 = 500.0;

/// The most physics steps of one advance: days of simulated time; chosen. More are a mistake, which
/// the plant refuses.
const MOST_STEPS: f64 = 1e9;

/// A robot in its world with its motors and wheel loops, its sensors and faults, driven step by
/// step.
///
/// `scenario` is the path of a scenario file or a dict of what it would hold; relative paths in a
/// dict start from `folder`, or from where the program runs. `settings` changes keys:
/// `{"world.floor.friction": 0.2}`. Of `[run]`, `duration_s` ends nothing here. With `sandbox`,
/// files are read below these folders alone: for scenarios and robots of people that you do not
/// know.
///
/// Another thread may run Python while it steps; two threads that call the same simulation at once
/// get a RuntimeError. It cannot be pickled. Raises subclasses of `ilon.Error` for what the command
/// line refuses.
#[pyclass(module = "ilon")]
pub struct Simulation {
    plant: Plant,
}

/// A simulation as it was at one moment. It cannot be pickled.
#[pyclass(frozen, module = "ilon")]
pub struct Snapshot(ilon::simulate::Snapshot);

#[pymethods]
impl Snapshot {
    fn __repr__(&self) -> String {
        "<ilon.Snapshot>".to_owned()
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(not_pickled("a snapshot"))
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (scenario: "_Source", *, settings: "_Table | None" = None, folder: "_Path | None" = None, sandbox: "_Sandbox | None" = None))]
    fn new(
        py: Python<'_>,
        scenario: &Bound<'_, PyAny>,
        settings: Option<&Bound<'_, PyAny>>,
        folder: Option<PathBuf>,
        sandbox: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let files = scenario::files(py, sandbox)?;
        let scenario = scenario::read(scenario, settings, folder, &files)?;
        let plant = py.detach(|| {
            let robot = load_robot(&scenario)?;
            Plant::new(&resolve_for(&scenario, &robot, Driver::Own)?, &robot)
        });
        Ok(Self {
            plant: plant.or_raise(py)?,
        })
    }

    /// Begins anew: time zero, the robot at rest. Noise comes from `seed` and the robot stands at
    /// `pose` (x in m, y in m, heading in rad), or both are as the scenario says.
    #[pyo3(signature = (*, seed: "int | None" = None, pose: "_Array | None" = None))]
    fn reset(
        &mut self,
        py: Python<'_>,
        seed: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Observation> {
        let resolved = self.plant.resolved();
        let seed = match seed {
            None => resolved.scenario().sensors.seed,
            Some(seed) => seed.extract().map_err(|fault: PyErr| {
                let what = format!("a seed is a whole number from 0 to 2^64 - 1, not {seed}");
                PyErr::from_type(fault.get_type(py), what)
            })?,
        };
        let pose = match pose {
            None => resolved.start(),
            Some(pose) => {
                let numbers = finite_row(pose, "the numbers of the pose", 3)?;
                Pose {
                    x_m: numbers[0],
                    y_m: numbers[1],
                    heading_rad: numbers[2],
                }
            }
        };
        let plant = &mut self.plant;
        py.detach(|| plant.reset(seed, pose)).or_raise(py)?;
        Ok(self.observe())
    }

    /// What the robot's sensors say now. Asked again at the same moment, they say the same.
    fn observe(&mut self) -> Observation {
        let t_s = self.plant.time_s();
        Observation::new(t_s, self.plant.observe().clone())
    }

    /// Lets the robot act on wheel rates in rad/s, or torques in N m, one a wheel in the robot's
    /// order, for a time in seconds, by default a control period; with sampled or late wheel loops
    /// a whole number of physics steps.
    ///
    /// Raises ValueError or TypeError for numbers that are not finite or of another count, before
    /// anything happens; `ilon.DivergedError` where the robot's motion is no number afterwards;
    /// KeyboardInterrupt between steps of a long time.
    #[pyo3(signature = (wheel_rates: "_Array | None" = None, *, torques: "_Array | None" = None, period_s=None))]
    fn advance(
        &mut self,
        py: Python<'_>,
        wheel_rates: Option<&Bound<'_, PyAny>>,
        torques: Option<&Bound<'_, PyAny>>,
        period_s: Option<f64>,
    ) -> PyResult<Outcome> {
        let wheels = self.plant.robot().wheels.len();
        let rates;
        let command = match (wheel_rates, torques) {
            (Some(given), None) => {
                rates = finite_row(given, "the wheel rates", wheels)?;
                WheelCommand::Rates(&rates)
            }
            (None, Some(given)) => {
                rates = finite_row(given, "the torques", wheels)?;
                WheelCommand::Torques(&rates)
            }
            _ => {
                return Err(PyTypeError::new_err(
                    "give either wheel_rates in rad/s or torques in N m, one a wheel",
                ));
            }
        };
        let period_s = period_s.unwrap_or_else(|| self.plant.resolved().control_dt_s());
        let plant = &mut self.plant;
        py.detach(|| advanced(plant, command, period_s))
            .map_err(|stopped| stopped.fault(py))
    }

    /// Where the robot really is and how it really moves.
    fn truth(&self) -> Truth {
        Truth(self.plant.truth())
    }

    /// A copy of the simulation at this moment, to return to.
    fn snapshot(&self) -> Snapshot {
        Snapshot(self.plant.snapshot())
    }

    /// Goes back to a snapshot, of this simulation or of another of the same scenario and robot:
    /// from there all is as it was, to the bit. Raises `ilon.ScenarioError` for a snapshot of
    /// another scenario or robot.
    #[pyo3(signature = (snapshot: "Snapshot"))]
    fn restore(&mut self, snapshot: &Bound<'_, PyAny>) -> PyResult<()> {
        let Ok(kept) = snapshot.cast::<Snapshot>() else {
            return Err(PyTypeError::new_err("restore what `snapshot()` returned"));
        };
        self.plant.restore(&kept.get().0).or_raise(snapshot.py())
    }

    /// Pushes the chassis from now on with a constant force (x, y, z in N, in the world frame) for
    /// a time in seconds, at a place in the body frame (x, y, z in m); without one, at the
    /// chassis's centre of mass. Pushes add up; a reset ends them.
    #[pyo3(signature = (force_n: "_Array", lasts_s, *, place_m: "_Array | None" = None))]
    fn push(
        &mut self,
        py: Python<'_>,
        force_n: &Bound<'_, PyAny>,
        lasts_s: f64,
        place_m: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let force_n = triple(force_n, "the numbers of the force")?;
        let place_m = maybe_triple(place_m, "the numbers of the place")?;
        self.plant.push(force_n, place_m, lasts_s).or_raise(py)
    }

    /// Lets a force in N and a moment in N m, both x, y, z in the world frame, act on the chassis
    /// from now on until they are set again; the force at a place in the body frame in m, or
    /// without one at the chassis's centre of mass. What is left out is 0.
    #[pyo3(signature = (force_n: "_Array | None" = None, moment_n_m: "_Array | None" = None, *, place_m: "_Array | None" = None))]
    fn set_wrench(
        &mut self,
        py: Python<'_>,
        force_n: Option<&Bound<'_, PyAny>>,
        moment_n_m: Option<&Bound<'_, PyAny>>,
        place_m: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let force_n = maybe_triple(force_n, "the numbers of the force")?;
        let moment_n_m = maybe_triple(moment_n_m, "the numbers of the moment")?;
        let place_m = maybe_triple(place_m, "the numbers of the place")?;
        let (force_n, moment_n_m) = (force_n.unwrap_or_default(), moment_n_m.unwrap_or_default());
        let set = self.plant.set_wrench(force_n, moment_n_m, place_m);
        set.or_raise(py)
    }

    /// Lets the chassis bear from now on the articulated-body inertia of something that another
    /// simulator moves: six rows of six numbers, linear at the body frame's origin before angular,
    /// along the world's axes, in kg, kg m and kg m^2. With `set_wrench` of what that puts on the
    /// chassis where it is not accelerated, both meet without a delay, whatever weighs more. All
    /// zeros end it.
    #[pyo3(signature = (inertia: "_Array"))]
    fn set_articulated_inertia(
        &mut self,
        py: Python<'_>,
        inertia: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let rows: Vec<Bound<'_, PyAny>> = inertia.try_iter()?.collect::<PyResult<_>>()?;
        let mut numbers = [[0.0; 6]; 6];
        if rows.len() != numbers.len() {
            return Err(PyValueError::new_err(format!(
                "an articulated inertia has 6 rows of 6 numbers, and {} rows were given",
                rows.len()
            )));
        }
        for (into, row) in numbers.iter_mut().zip(&rows) {
            into.copy_from_slice(&finite_row(row, "the numbers of the row", 6)?);
        }
        self.plant.set_articulated_inertia(&numbers).or_raise(py)
    }

    /// Puts a mass in kg on the robot, in place of the one put there before; 0 takes it off. It
    /// lies at a place in the body frame in m, or without one at the chassis's centre of mass.
    #[pyo3(signature = (mass_kg, *, place_m: "_Array | None" = None))]
    fn set_payload(
        &mut self,
        py: Python<'_>,
        mass_kg: f64,
        place_m: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let place_m = maybe_triple(place_m, "the numbers of the place")?;
        self.plant.carry_at(mass_kg, place_m).or_raise(py)
    }

    /// Commands the servos of joints between bodies, by name, from now on. `positions` are in rad or
    /// m. `rates` are in rad/s or m/s: beside a position, how fast the target moves on, if both are
    /// given in every control period; without one, how fast the joint moves. `efforts` are torques or
    /// forces in N m or N within the servo's limit, and nothing then holds the joint. All are
    /// commanded, or none.
    /// The scenario's setpoints no longer hold for these joints; a reset brings them back.
    #[pyo3(signature = (positions=None, *, rates=None, efforts=None))]
    fn command_joints(
        &mut self,
        py: Python<'_>,
        positions: Option<BTreeMap<String, f64>>,
        rates: Option<BTreeMap<String, f64>>,
        efforts: Option<BTreeMap<String, f64>>,
    ) -> PyResult<()> {
        let [positions, rates, efforts] =
            [positions, rates, efforts].map(Option::unwrap_or_default);
        let moves = |joint: &String| positions.contains_key(joint) || rates.contains_key(joint);
        if let Some(joint) = efforts.keys().find(|joint| moves(joint)) {
            return Err(PyValueError::new_err(format!(
                "the joint {joint:?} was given an effort, and a position or a rate"
            )));
        }
        let sent = positions.iter().map(|(joint, position)| {
            let (position, rate) = (*position, rates.get(joint).copied().unwrap_or(0.0));
            (joint.as_str(), JointCommand::Position { position, rate })
        });
        let alone = rates
            .iter()
            .filter(|(joint, _)| !positions.contains_key(*joint));
        let run = alone.map(|(joint, rate)| (joint.as_str(), JointCommand::Rate(*rate)));
        let loaded = efforts.iter();
        let loaded = loaded.map(|(joint, effort)| (joint.as_str(), JointCommand::Effort(*effort)));
        let commands: Vec<_> = sent.chain(run).chain(loaded).collect();
        self.plant.command_joints(&commands).or_raise(py)
    }

    /// Where the joints between bodies are now, in rad or m, by name.
    fn joints(&self) -> BTreeMap<String, f64> {
        let joints = &self.plant.robot().joints;
        let at = self.plant.world().robot().joint_positions();
        let names = joints.iter().map(|joint| joint.name.clone());
        names.zip(at.iter().copied()).collect()
    }

    /// Changes Coulomb's coefficient of friction of the floor from now on, but on its patches.
    fn set_friction(&mut self, py: Python<'_>, friction: f64) -> PyResult<()> {
        self.plant.set_friction(friction).or_raise(py)
    }

    /// Lets the rollers of a wheel, counted from 0, find a share of the ground's friction from now
    /// on; 1 for all of it.
    fn set_grip(&mut self, py: Python<'_>, wheel: usize, share: f64) -> PyResult<()> {
        self.plant.set_grip(wheel, share).or_raise(py)
    }

    /// Lets the ground lean from now on: gravity pulls along a direction (x, y, z in the world
    /// frame, of any length); [0, 0, -1] is level ground.
    #[pyo3(signature = (down: "_Array"))]
    fn set_down(&mut self, py: Python<'_>, down: &Bound<'_, PyAny>) -> PyResult<()> {
        let down = triple(down, "the numbers of the direction")?;
        self.plant.set_down(down).or_raise(py)
    }

    /// The body in three dimensions, as it really is.
    fn body(&self) -> Body {
        Body::of(&self.plant)
    }

    /// The wheels and their contacts, as they really are.
    fn wheels(&self) -> Wheels {
        Wheels::of(&self.plant)
    }

    /// The scenario's `[[world.bodies]]` by their names, as they really are.
    #[pyo3(signature = () -> "dict[str, FreeBody]")]
    fn free_bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        FreeBody::all_of(&self.plant).into_py_dict(py)
    }

    /// Where energy is and where it went since the start, in J: `kinetic_j` and `potential_j` now;
    /// the work of the motors `motor_j`, what they did of it while they drove `motor_positive_j`,
    /// and that of wrenches, payloads and leaning ground `outside_j`; and what went into `slip_j`,
    /// `spin_up_j` of rollers that came down, `bearing_j` and `impact_j`.
    #[pyo3(signature = () -> "dict[str, float]")]
    fn energies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (world, now) = (self.plant.world(), self.plant.world().energy());
        let all = [
            ("kinetic_j", now.kinetic_j),
            ("potential_j", now.potential_j),
            ("motor_j", world.motor_energy_j()),
            ("motor_positive_j", world.motor_positive_energy_j()),
            ("outside_j", world.outside_energy_j()),
            ("slip_j", world.slip_energy_j()),
            ("spin_up_j", world.spin_up_energy_j()),
            ("bearing_j", world.bearing_energy_j()),
            ("impact_j", world.impact_energy_j()),
        ];
        all.into_py_dict(py)
    }

    /// Where the scenario's `[reference]` wants the robot at a time in seconds, by default now;
    /// None without a reference.
    #[pyo3(signature = (t_s=None))]
    fn desired(&self, t_s: Option<f64>) -> PyResult<Option<Desired>> {
        let t_s = t_s.unwrap_or_else(|| self.plant.time_s());
        if !t_s.is_finite() {
            return Err(PyValueError::new_err(format!("{t_s} s is no time")));
        }
        let reference = self.plant.resolved().reference();
        Ok(reference.map(|reference| Desired(reference.at(t_s))))
    }

    /// The wheel rates in rad/s for a twist of the body in its own frame (m/s, m/s, rad/s):
    /// Indiveri 2009, eq. (7).
    #[pyo3(signature = (twist: "_Array") -> "_Floats")]
    fn wheel_rates<'py>(
        &self,
        py: Python<'py>,
        twist: &Bound<'_, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let [vx, vy, omega] = triple(twist, "the numbers of the twist")?;
        let mut rates = vec![0.0; self.plant.robot().wheels.len()];
        let kinematics = self.plant.kinematics();
        kinematics.wheel_rates(Twist::new(vx, vy, omega), &mut rates);
        Ok(PyArray1::from_vec(py, rates))
    }

    /// The twist of the body in its own frame (m/s, m/s, rad/s) that fits wheel rates in rad/s
    /// best.
    #[pyo3(signature = (wheel_rates: "_Array") -> "_Floats")]
    fn twist<'py>(
        &self,
        py: Python<'py>,
        wheel_rates: &Bound<'_, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let wheels = self.plant.robot().wheels.len();
        let rates = finite_row(wheel_rates, "the wheel rates", wheels)?;
        let twist = self.plant.kinematics().twist(&rates);
        let numbers = [twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s];
        Ok(PyArray1::from_slice(py, &numbers))
    }

    /// Simulated time since the start or the last reset, in seconds.
    #[getter]
    fn time_s(&self) -> f64 {
        self.plant.time_s()
    }

    /// The period of the control, in seconds.
    #[getter]
    fn control_dt_s(&self) -> f64 {
        self.plant.resolved().control_dt_s()
    }

    /// The step of the physics, in seconds.
    #[getter]
    fn physics_dt_s(&self) -> f64 {
        self.plant.resolved().physics_dt_s()
    }

    /// The names of the wheels' joints, in the robot's order.
    #[getter]
    fn wheel_names(&self) -> Vec<String> {
        let wheels = self.plant.robot().wheels.iter();
        wheels.map(|wheel| wheel.name.clone()).collect()
    }

    /// The rate in rad/s that wheels are held to; infinite where nothing limits it.
    #[getter]
    fn wheel_rate_limit_rad_s(&self) -> f64 {
        self.plant.resolved().wheel_rate_limit_rad_s()
    }

    /// The largest torque of each motor in N m; infinite where nothing limits it.
    #[getter]
    fn torque_limits_n_m<'py>(&self, py: Python<'py>) -> Floats<'py> {
        let wheels = self.plant.robot().wheels.iter();
        PyArray1::from_vec(py, wheels.map(|wheel| wheel.motor.effort_n_m).collect()).into()
    }

    /// The scenario with every default spelled out.
    #[getter]
    fn scenario<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py>> {
        as_python(py, self.plant.resolved().scenario()).map(Dict::from)
    }

    /// What a person should know about the input, although it can be run.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.plant.resolved().warnings().to_vec()
    }

    fn __repr__(&self) -> String {
        format!(
            "<ilon.Simulation of {} at {:.4} s>",
            self.plant.robot().name,
            self.plant.time_s()
        )
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(not_pickled("a simulation"))
    }
}

fn not_pickled(what: &str) -> PyErr {
    PyTypeError::new_err(format!(
        "{what} cannot be pickled: it holds the engine's own state; pickle the scenario and the commands instead, which lead to the \
         same state to the bit"
    ))
}

fn triple(value: &Bound<'_, PyAny>, what: &str) -> PyResult<[f64; 3]> {
    let row = finite_row(value, what, 3)?;
    Ok([row[0], row[1], row[2]])
}

fn maybe_triple(value: Option<&Bound<'_, PyAny>>, what: &str) -> PyResult<Option<[f64; 3]>> {
    value.map(|value| triple(value, what)).transpose()
}

/// Advances a plant; during a long advance it checks for Ctrl-C.
fn advanced(
    plant: &mut Plant,
    command: WheelCommand<'_>,
    period_s: f64,
) -> Result<Outcome, Stopped> {
    let physics_dt_s = plant.resolved().physics_dt_s();
    let at_once_s = STEPS_AT_ONCE * physics_dt_s;
    // A short or invalid period, or one that is no whole number of steps where wheel loops need
    // it, goes to the plant at once, which accepts or refuses it.
    let steps = period_s / physics_dt_s;
    let is_whole = (steps - steps.round()).abs() <= 1e-6 * steps;
    let takes_parts = !(plant.resolved().scenario().wheel_loop).takes_whole_steps();
    if !(period_s > at_once_s && steps <= MOST_STEPS && (is_whole || takes_parts)) {
        let outcome = plant.advance(command, period_s)?;
        return Ok(Outcome {
            torques_n_m: outcome.torques_n_m.clone(),
            contact_residual_m_s: outcome.contact_residual_m_s,
        });
    }
    let steps = if is_whole { steps.round() } else { steps };
    let mut whole = Outcome {
        torques_n_m: vec![0.0; plant.robot().wheels.len()],
        contact_residual_m_s: 0.0,
    };
    let (mut left, mut looked) = (steps, Instant::now());
    while left > 0.0 {
        // The last part is never shorter than one step.
        let now = if left < STEPS_AT_ONCE + 1.0 {
            left
        } else {
            STEPS_AT_ONCE
        };
        let outcome = plant.advance(command, now * physics_dt_s)?;
        for (mean_n_m, torque_n_m) in whole.torques_n_m.iter_mut().zip(&outcome.torques_n_m) {
            *mean_n_m += torque_n_m * (now / steps);
        }
        whole.contact_residual_m_s = whole.contact_residual_m_s.max(outcome.contact_residual_m_s);
        left -= now;
        if looked.elapsed() >= BETWEEN_LOOKS {
            looked = Instant::now();
            Python::attach(|py| py.check_signals()).map_err(Stopped::Raised)?;
        }
    }
    Ok(whole)
}
