"""The compiled half of ilon."""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Self, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "ArrowTable",
    "Body",
    "Desired",
    "FreeBody",
    "Imu",
    "Observation",
    "Outcome",
    "Rows",
    "Run",
    "Simulation",
    "Snapshot",
    "Study",
    "Sweep",
    "Torques",
    "Recorded",
    "Track",
    "Truth",
    "Wheels",
    "__version__",
    "command",
    "compare",
    "generate",
    "identify",
    "inspect",
    "judged",
    "merge_sweeps",
    "run",
    "schema",
    "suspects",
]

__version__: str

_Floats = npt.NDArray[np.float64]
_Sandbox = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]

@final
class Observation:
    """What a robot's sensors say at one moment."""

    @property
    def t_s(self) -> float:
        """Simulated time in seconds."""
    @property
    def pose(self) -> _Floats:
        """The newest pose that has arrived, in the world frame: x in m, y in m, heading in rad."""
    @property
    def wheel_rates_rad_s(self) -> _Floats:
        """The wheels' rates in rad/s, in the robot's order."""
    @property
    def wheel_angles_rad(self) -> _Floats:
        """The wheels' angles since the start in rad, as the encoders counted them."""
    @property
    def imu(self) -> Imu | None:
        """What the inertial measurement unit said last; None without ``[sensors.imu]``."""

@final
class Imu:
    """What an inertial measurement unit says, in the body frame."""

    @property
    def rate_rad_s(self) -> _Floats:
        """The rate of turn about x, y and z in rad/s."""
    @property
    def specific_force_m_s2(self) -> _Floats:
        """The specific force along x, y and z in m/s^2: acceleration less gravity, upwards at rest."""
    @property
    def roll_rad(self) -> float:
        """Roll against gravity in rad, by the robot's filter."""
    @property
    def pitch_rad(self) -> float:
        """Pitch against gravity in rad, by the robot's filter."""

@final
class Truth:
    """Where the robot really is and how it really moves, whatever its sensors say."""

    @property
    def pose(self) -> _Floats:
        """The body's pose in the world frame: x in m, y in m, heading in rad."""
    @property
    def twist_in_body(self) -> _Floats:
        """The body's twist in its own frame: vx in m/s, vy in m/s, yaw rate in rad/s."""
    @property
    def height_m(self) -> float:
        """Height of the body's origin above the floor, in m."""
    @property
    def roll_rad(self) -> float:
        """Roll in rad."""
    @property
    def pitch_rad(self) -> float:
        """Pitch in rad."""

@final
class Body:
    """The robot's body in three dimensions, as it really is."""

    @property
    def position_m(self) -> _Floats:
        """The body frame's origin in the world: x, y, z in m."""
    @property
    def quaternion_wxyz(self) -> _Floats:
        """How the body is turned in the world: a unit quaternion w, x, y, z."""
    @property
    def velocity_in_world_m_s(self) -> _Floats:
        """Velocity of the body frame's origin, in the world frame, in m/s."""
    @property
    def angular_in_body_rad_s(self) -> _Floats:
        """Rates about the axes of the body frame, in rad/s."""
    @property
    def acceleration_in_world_m_s2(self) -> _Floats:
        """Acceleration of the body frame's origin in the world frame, in m/s^2: the mean over the last advance."""
    @property
    def gravity_in_world_m_s2(self) -> _Floats:
        """The acceleration of gravity in the world frame, in m/s^2. On a slope it leans."""

@final
class Wheels:
    """The robot's wheels and their contacts, as they really are, in the robot's order."""

    @property
    def angles_rad(self) -> _Floats:
        """Angles about the wheels' axes since the start, in rad, not wrapped."""
    @property
    def rates_rad_s(self) -> _Floats:
        """Rates about the wheels' axes, in rad/s."""
    @property
    def loads_n(self) -> _Floats:
        """The ground's normal forces in N: means over the last advance."""
    @property
    def friction_used_max(self) -> _Floats:
        """The largest share of its friction limit that each wheel used in the last advance; 1 where it slid."""
    @property
    def slip_speed_max_m_s(self) -> _Floats:
        """The largest sliding speed of each wheel in the last advance, in m/s."""
    @property
    def forces_in_body_n(self) -> _Floats:
        """The ground's tangential forces: a row of x and y in the body frame for each wheel, in N: means over the last advance."""
    @property
    def slip_in_body_m_s(self) -> _Floats:
        """Velocities of the rollers' surfaces over the ground: a row of x and y in the body frame for each wheel, in m/s: means
        over the time of the last advance in which the wheel touched."""

@final
class FreeBody:
    """A free body of the scenario, as it really is."""

    @property
    def position_m(self) -> _Floats:
        """Its middle in the world: x, y, z in m."""
    @property
    def quaternion_wxyz(self) -> _Floats:
        """How it is turned in the world: a unit quaternion w, x, y, z."""
    @property
    def velocity_in_world_m_s(self) -> _Floats:
        """Velocity of its middle, in the world frame, in m/s."""
    @property
    def angular_in_world_rad_s(self) -> _Floats:
        """Its angular velocity, in the world frame, in rad/s."""
    @property
    def force_of_robot_n(self) -> _Floats:
        """The robot's force on it in the world frame, in N: the mean over the last physics step."""
    @property
    def work_of_robot_j(self) -> float:
        """Work that the robot has done on it since the start, in J: less what it did on the robot."""
    @property
    def sleeps(self) -> bool:
        """Whether it rests, and is left alone until something comes near."""

@final
class Desired:
    """Where a reference wants the robot, and how fast."""

    @property
    def pose(self) -> _Floats:
        """The pose in the world frame: x in m, y in m, heading in rad, which is not wrapped."""
    @property
    def velocity_in_world(self) -> _Floats:
        """Its time derivative in the world frame: in m/s, m/s and rad/s."""

@final
class Outcome:
    """What came of an advance."""

    @property
    def torques_n_m(self) -> _Floats:
        """The torques that the motors put on the wheels in N m: the mean over the time."""
    @property
    def contact_residual_m_s(self) -> float:
        """By how much the laws of contact were broken at worst, in m/s: the speed of what moves and should not."""

@final
class Torques:
    """Torques in N m, one a wheel, which a controller of one's own gives back in place of wheel rates."""

    def __new__(cls, torques_n_m: npt.ArrayLike) -> Self: ...

@final
class Snapshot:
    """A simulation as it was at one moment. It cannot be pickled."""

@final
class Simulation:
    """A robot in its world with its motors and wheel loops, its sensors and faults, driven step by step.

    `scenario` is the path of a scenario file or a dict of what it would hold; relative paths in a dict start from `folder`, or from
    where the program runs. `settings` changes keys: `{"world.floor.friction": 0.2}`. Of `[run]`, `duration_s` ends nothing here. With
    `sandbox`, files are read below these folders alone: for scenarios and robots of people that you do not know.

    Another thread may run Python while it steps; two threads that call the same simulation at once get a RuntimeError. It cannot be
    pickled. Raises subclasses of `ilon.Error` for what the command line refuses.
    """

    def __new__(
        cls,
        scenario: str | os.PathLike[str] | Mapping[str, Any],
        *,
        settings: Mapping[str, Any] | None = None,
        folder: str | os.PathLike[str] | None = None,
        sandbox: _Sandbox | None = None,
    ) -> Self: ...
    def reset(self, *, seed: int | None = None, pose: npt.ArrayLike | None = None) -> Observation:
        """Begins anew: time zero, the robot at rest. Noise comes from `seed` and the robot stands at `pose` (x in m, y in m, heading in
        rad), or both are as the scenario says."""
    def observe(self) -> Observation:
        """What the robot's sensors say now. Asked again at the same moment, they say the same."""
    def advance(
        self,
        wheel_rates: npt.ArrayLike | None = None,
        *,
        torques: npt.ArrayLike | None = None,
        period_s: float | None = None,
    ) -> Outcome:
        """Lets the robot act on wheel rates in rad/s, or torques in N m, one a wheel in the robot's order, for a time in seconds,
        by default a control period; with sampled wheel loops a whole number of physics steps.

        Raises ValueError or TypeError for numbers that are not finite or of another count, before anything happens;
        `ilon.DivergedError` where the robot's motion is no number afterwards; KeyboardInterrupt between steps of a long time.
        """
    def truth(self) -> Truth:
        """Where the robot really is and how it really moves."""
    def snapshot(self) -> Snapshot:
        """The simulation as it is now, to come back to."""
    def restore(self, snapshot: Snapshot) -> None:
        """Goes back to a snapshot, of this simulation or of another of the same scenario and robot: from there all is as it was, to the
        bit. Raises `ilon.ScenarioError` for a snapshot of another scenario or robot."""
    def push(self, force_n: npt.ArrayLike, lasts_s: float, *, place_m: npt.ArrayLike | None = None) -> None:
        """Pushes the chassis from now on with a constant force (x, y, z in N, in the world frame) for a time in seconds, at a place
        in the body frame (x, y, z in m); without one, at the chassis's centre of mass. Pushes add up; a reset ends them."""
    def set_wrench(
        self,
        force_n: npt.ArrayLike | None = None,
        moment_n_m: npt.ArrayLike | None = None,
        *,
        place_m: npt.ArrayLike | None = None,
    ) -> None:
        """Lets a force in N and a moment in N m, both x, y, z in the world frame, act on the chassis from now on until they are set again; the
        force at a place in the body frame in m, or without one at the chassis's centre of mass. What is left out is 0."""
    def set_articulated_inertia(self, inertia: npt.ArrayLike) -> None:
        """Lets the chassis bear from now on the articulated-body inertia of something that another simulator moves: six rows of six numbers,
        linear at the body frame's origin before angular, along the world's axes, in kg, kg m and kg m^2. With `set_wrench` of what that puts
        on the chassis where it is not accelerated, both meet without a delay, whatever weighs more. All zeros end it."""
    def command_joints(
        self,
        positions: dict[str, float] | None = None,
        *,
        rates: dict[str, float] | None = None,
        efforts: dict[str, float] | None = None,
    ) -> None:
        """Tells the servos of joints between bodies, by name, from now on: a position in rad or m; a rate in rad/s or m/s, with a position how fast that moves on
        as long as it is given anew in every control period, without one how fast the joint goes; or a torque or force in N m or N, within the servo's
        effort, in place of holding the joint anywhere. All are told, or none. The scenario's setpoints no longer hold for these joints; a reset brings them
        back."""
    def joints(self) -> dict[str, float]:
        """Where the joints between bodies are now, in rad or m, by name."""
    def set_payload(self, mass_kg: float, *, place_m: npt.ArrayLike | None = None) -> None:
        """Puts a mass in kg on the robot, in place of the one put there before; 0 takes it off. It lies at a place in the body frame in m,
        or without one at the chassis's centre of mass."""
    def set_friction(self, friction: float) -> None:
        """Changes Coulomb's coefficient of friction of the floor from now on, but on its patches."""
    def set_grip(self, wheel: int, share: float) -> None:
        """Lets the rollers of a wheel, counted from 0, find a share of the ground's friction from now on; 1 for all of it."""
    def set_down(self, down: npt.ArrayLike) -> None:
        """Lets the ground lean from now on: gravity pulls along a direction (x, y, z in the world frame, of any length); [0, 0, -1] is level
        ground."""
    def body(self) -> Body:
        """The body in three dimensions, as it really is."""
    def wheels(self) -> Wheels:
        """The wheels and their contacts, as they really are."""
    def free_bodies(self) -> dict[str, FreeBody]:
        """The scenario's `[[world.bodies]]` by their names, as they really are."""
    def energies(self) -> dict[str, float]:
        """Where energy is and where it went since the start, in J: `kinetic_j` and `potential_j` now; the work of the motors `motor_j`, what
        they did of it while they drove `motor_positive_j`, and that of wrenches, payloads and leaning ground `outside_j`; and what went into `slip_j`, `spin_up_j` of rollers that came down, `bearing_j`
        and `impact_j`."""
    def desired(self, t_s: float | None = None) -> Desired | None:
        """Where the scenario's `[reference]` wants the robot at a time in seconds, by default now; None without a reference."""
    def wheel_rates(self, twist: npt.ArrayLike) -> _Floats:
        """The wheel rates in rad/s for a twist of the body in its own frame (m/s, m/s, rad/s): Indiveri 2009, eq. (7)."""
    def twist(self, wheel_rates: npt.ArrayLike) -> _Floats:
        """The twist of the body in its own frame (m/s, m/s, rad/s) that fits wheel rates in rad/s best."""
    @property
    def time_s(self) -> float:
        """Simulated time since the start or the last reset, in seconds."""
    @property
    def control_dt_s(self) -> float:
        """The period of the control, in seconds."""
    @property
    def physics_dt_s(self) -> float:
        """The step of the physics, in seconds."""
    @property
    def wheel_names(self) -> list[str]:
        """The names of the wheels' joints, in the robot's order."""
    @property
    def wheel_rate_limit_rad_s(self) -> float:
        """The rate in rad/s that wheels are held to; infinite where nothing limits it."""
    @property
    def torque_limits_n_m(self) -> _Floats:
        """The largest torque of each motor in N m; infinite where nothing limits it."""
    @property
    def scenario(self) -> dict[str, Any]:
        """The scenario with every default spelled out."""
    @property
    def warnings(self) -> list[str]:
        """What a person should know about the input, although it can be run."""

@final
class ArrowTable:
    """Columns of Arrow, to hand over by its PyCapsule protocol: `polars.DataFrame(table)`, `pyarrow.table(table)`,
    `pandas.DataFrame.from_arrow(table)`, or by name in a query of DuckDB."""

    @property
    def num_rows(self) -> int:
        """How many rows there are."""
    @property
    def column_names(self) -> list[str]:
        """The names of the columns."""
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    def __arrow_c_schema__(self) -> object: ...

@final
class Recorded:
    def column(self, name: str) -> npt.NDArray[Any]: ...
    @property
    def columns(self) -> list[str]: ...
    @property
    def rows(self) -> int: ...
    @property
    def header(self) -> dict[str, Any]: ...
    def to_arrow(self) -> ArrowTable: ...

class Run:
    def __new__(cls, run: Run) -> Self: ...
    @property
    def summary(self) -> dict[str, Any]:
        """The figures of the run, as in `summary.json`."""
    @property
    def recorded(self) -> Recorded: ...
    @property
    def scenario(self) -> dict[str, Any]:
        """The scenario as it was run, every default spelled out."""
    @property
    def figures(self) -> dict[str, float]:
        """The numbers of the summary by their dotted names, such as `twist_ratio_ideal.vy`; those that do not apply are left out."""
    @property
    def scenario_toml(self) -> str:
        """The same as the text of a scenario file."""
    @property
    def name(self) -> str:
        """The scenario's name."""
    @property
    def warnings(self) -> list[str]:
        """What a person should know about the input, although it could be run."""
    def report_html(self) -> str: ...
    def write(self, folder: str | os.PathLike[str]) -> None:
        """Writes what `ilon run --out` writes into a folder: summary.json, trace.parquet, report.html, scenario.toml."""
    def parts(self) -> tuple[bytes, str, str, str, Path, list[Path] | None, list[str], str]: ...
    @staticmethod
    def of_parts(
        trace: bytes, summary: str, scenario: str, name: str, folder: str | os.PathLike[str],
        sandbox: list[Path] | None, warnings: list[str], called: str
    ) -> Run: ...

@final
class Study:
    """A study that was read."""

    def __new__(
        cls,
        study: str | os.PathLike[str] | Mapping[str, Any],
        *,
        folder: str | os.PathLike[str] | None = None,
        sandbox: _Sandbox | None = None,
    ) -> Self: ...
    @staticmethod
    def of_text(text: str, path: str | os.PathLike[str], *, sandbox: _Sandbox | None = None) -> Study:
        """A study from the text of a file that need not be there; the paths in it start from `path`."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def path(self) -> Path:
        """Its file."""
    @property
    def text(self) -> str:
        """The text of its file."""
    @property
    def fingerprint(self) -> str:
        """A hash of all that its rows depend on."""
    def make(self, parts: Sequence[int], *, jobs: int, folder: str | os.PathLike[str] | None = None) -> bytes:
        """Makes parts of the study, so many runs at a time; their rows, as text. `folder` is that of its results."""

@final
class Rows:
    """What was run of a study, for this process alone until it is finished or closed."""

    def __new__(
        cls, study: Study, *, folder: str | os.PathLike[str] | None = None, shard: str | None = None
    ) -> Self: ...
    @property
    def folder(self) -> Path | None:
        """The folder that its rows and results are in."""
    @property
    def damaged(self) -> int:
        """How many rows could not be read again, and are run anew."""
    @property
    def done(self) -> int:
        """How many runs are there."""
    @property
    def most(self) -> int:
        """How many there will be; of a search, at most."""
    def missing(self) -> list[int]:
        """The parts of the study of which rows are missing."""
    def put(self, rows: bytes) -> None:
        """Adds rows that were made elsewhere; those that are there already are left as they are."""
    def finish(self, *, jobs: int | None = None, progress: Callable[[int, int], object] | None = None) -> Sweep:
        """Runs what is missing, says what came of it and writes it; the rows are closed then."""
    def close(self) -> None:
        """Leaves the rows to others."""

class Sweep:
    def __new__(cls, sweep: Sweep) -> Self: ...
    @property
    def name(self) -> str:
        """The name of the study."""
    @property
    def failed(self) -> int:
        """How many of the runs failed."""
    @property
    def findings(self) -> dict[str, Any] | None:
        """What was found, as in `findings.json`; None of a shard."""
    @property
    def folder(self) -> Path | None:
        """The folder of the results; None where they are in memory alone."""
    @property
    def columns(self) -> list[str]:
        """The names of the columns of `runs.parquet`."""
    def __len__(self) -> int:
        """How many runs there are."""
    def __getitem__(self, key: str, /) -> npt.NDArray[Any] | list[str | None]:
        """A column: numbers as a numpy array, NaN where they are absent; texts as a list, None where they are absent."""
    def to_arrow(self) -> ArrowTable:
        """All rows as a table of Arrow."""
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...
    def report_html(self) -> str | None: ...

@final
class Track:
    def __new__(cls, scenario: str | os.PathLike[str] | Mapping[str, Any], options: dict[str, Any]) -> Self: ...
    def reset(
        self, seeds: Sequence[int | None], mask: Sequence[bool] | None = None
    ) -> tuple[npt.NDArray[np.float32], _Floats, _Floats]: ...
    def step(
        self, actions: npt.ArrayLike
    ) -> tuple[
        npt.NDArray[np.float32],
        _Floats,
        npt.NDArray[np.bool_],
        npt.NDArray[np.bool_],
        _Floats,
        _Floats,
        tuple[npt.NDArray[np.float32], _Floats, _Floats] | None,
    ]: ...
    def above(self, robot: int) -> tuple[_Floats, _Floats, _Floats, _Floats]: ...
    @property
    def bounds(self) -> npt.NDArray[np.float32]: ...
    @property
    def observation_names(self) -> list[str]: ...
    @property
    def action_names(self) -> list[str]: ...
    @property
    def action_scale(self) -> _Floats: ...
    @property
    def control_dt_s(self) -> float: ...
    @property
    def alive_per_s(self) -> float: ...
    @property
    def steps(self) -> int: ...

def run(
    scenario: str | os.PathLike[str] | Mapping[str, Any],
    *,
    called: str,
    settings: Mapping[str, Any] | None = None,
    controller: Callable[[Observation, Desired | None], npt.ArrayLike | Torques] | None = None,
    folder: str | os.PathLike[str] | None = None,
    sandbox: _Sandbox | None = None,
    converge: bool = False,
    causes: Literal["named", "all"] | None = None,
) -> Run: ...
def suspects(
    path: str | os.PathLike[str],
    options: Mapping[str, Any],
    *,
    settings: Mapping[str, Any] | None = None,
    sandbox: _Sandbox | None = None,
) -> list[dict[str, Any]]: ...
def identify(
    study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    out: str | os.PathLike[str] | None = None,
    folder: str | os.PathLike[str] | None = None,
    sandbox: _Sandbox | None = None,
) -> dict[str, Any]: ...
def inspect(
    path: str | os.PathLike[str],
    options: Mapping[str, Any],
    *,
    limits: Mapping[str, Any] | None = None,
    sandbox: _Sandbox | None = None,
) -> tuple[dict[str, Any], str, str, str | None]: ...
def generate(spec: str | os.PathLike[str]) -> str: ...
def compare(runs: list[Any]) -> tuple[list[dict[str, Any]], list[dict[str, Any]], str]: ...
def merge_sweeps(folders: Sequence[str | os.PathLike[str]], out: str | os.PathLike[str]) -> Sweep: ...
def judged(run: Run) -> list[dict[str, Any]]: ...
def schema() -> dict[str, Any]:
    """The JSON Schema of the scenario file."""
def command(arguments: list[str]) -> int: ...
