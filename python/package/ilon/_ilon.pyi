"""The compiled half of ilon. Written by `.ci/stubs`: do not edit."""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

_Array = npt.ArrayLike
_Flags = npt.NDArray[np.bool_]
_Floats = npt.NDArray[np.float64]
_Singles = npt.NDArray[np.float32]
_Column = npt.NDArray[Any] | list[str | None]
_Begun = tuple[_Singles, _Floats, _Floats]
_Dict = dict[str, Any]
_Table = Mapping[str, Any]
_Path = str | os.PathLike[str]
_Source = _Path | _Table
_Sandbox = _Path | Sequence[_Path]
_Controller = Callable[[Observation, Desired | None], npt.ArrayLike | Torques]

__version__: str

from _typeshed import Incomplete, SupportsGetItem
from pathlib import Path
from typing import Any, SupportsFloat, SupportsIndex, final
from typing_extensions import disjoint_base

@final
class ArrowTable:
    """
    Columns of Arrow, to hand over by its PyCapsule protocol: `polars.DataFrame(table)`,
    `pyarrow.table(table)`, `pandas.DataFrame.from_arrow(table)`, or by name in a query of DuckDB.
    """

    def __arrow_c_schema__(self, /) -> object:
        """
        The names and types of the columns, for Arrow.
        """

    def __arrow_c_stream__(self, /, requested_schema: object | None=None) -> object:
        """
        The columns as a stream of Arrow.
        """

    def __repr__(self, /) -> str:
        ...

    @property
    def column_names(self, /) -> list[str]:
        """
        The names of the columns.
        """

    @property
    def num_rows(self, /) -> int:
        """
        How many rows there are.
        """

@final
class Body:
    """
    The robot's body in three dimensions, as it really is.
    """

    def __repr__(self, /) -> str:
        ...

    @property
    def acceleration_in_world_m_s2(self, /) -> _Floats:
        """
        Acceleration of the body frame's origin in the world frame, in m/s^2: the mean over the last
        advance.
        """

    @property
    def angular_in_body_rad_s(self, /) -> _Floats:
        """
        Rates about the axes of the body frame, in rad/s.
        """

    @property
    def gravity_in_world_m_s2(self, /) -> _Floats:
        """
        The acceleration of gravity in the world frame, in m/s^2. On a slope it leans.
        """

    @property
    def position_m(self, /) -> _Floats:
        """
        The body frame's origin in the world: x, y, z in m.
        """

    @property
    def quaternion_wxyz(self, /) -> _Floats:
        """
        How the body is turned in the world: a unit quaternion w, x, y, z.
        """

    @property
    def velocity_in_world_m_s(self, /) -> _Floats:
        """
        Velocity of the body frame's origin, in the world frame, in m/s.
        """

@final
class Desired:
    """
    Where a reference wants the robot, and how fast.
    """

    def __repr__(self, /) -> str:
        ...

    @property
    def pose(self, /) -> _Floats:
        """
        The pose in the world frame: x in m, y in m, heading in rad, which is not wrapped.
        """

    @property
    def velocity_in_world(self, /) -> _Floats:
        """
        Its time derivative in the world frame: in m/s, m/s and rad/s.
        """

@final
class FreeBody:
    """
    A free body of the scenario, as it really is.
    """

    def __repr__(self, /) -> str:
        ...

    @property
    def angular_in_world_rad_s(self, /) -> _Floats:
        """
        Its angular velocity, in the world frame, in rad/s.
        """

    @property
    def force_of_robot_n(self, /) -> _Floats:
        """
        The robot's force on it in the world frame, in N: the mean over the last physics step.
        """

    @property
    def position_m(self, /) -> _Floats:
        """
        Its middle in the world: x, y, z in m.
        """

    @property
    def quaternion_wxyz(self, /) -> _Floats:
        """
        How it is turned in the world: a unit quaternion w, x, y, z.
        """

    @property
    def sleeps(self, /) -> bool:
        """
        Whether it rests, and is left alone until something comes near.
        """

    @property
    def velocity_in_world_m_s(self, /) -> _Floats:
        """
        Velocity of its middle, in the world frame, in m/s.
        """

    @property
    def work_of_robot_j(self, /) -> float:
        """
        Work that the robot has done on it since the start, in J: less what it did on the robot.
        """

@final
class Imu:
    """
    What an inertial measurement unit says, in the body frame.
    """

    def __repr__(self, /) -> str:
        ...

    @property
    def pitch_rad(self, /) -> float:
        """
        Pitch against gravity in rad, by the robot's filter.
        """

    @property
    def rate_rad_s(self, /) -> _Floats:
        """
        The rate of turn about x, y and z in rad/s.
        """

    @property
    def roll_rad(self, /) -> float:
        """
        Roll against gravity in rad, by the robot's filter.
        """

    @property
    def specific_force_m_s2(self, /) -> _Floats:
        """
        The specific force along x, y and z in m/s^2: acceleration less gravity, upwards at rest.
        """

@final
class Observation:
    """
    What a robot's sensors say at one moment.
    """

    def __repr__(self, /) -> str:
        ...

    @property
    def imu(self, /) -> Imu | None:
        """
        What the inertial measurement unit said last; None without `[sensors.imu]`.
        """

    @property
    def pose(self, /) -> _Floats:
        """
        The newest pose that has arrived, in the world frame: x in m, y in m, heading in rad.
        """

    @property
    def t_s(self, /) -> float:
        """
        Simulated time in seconds.
        """

    @property
    def wheel_angles_rad(self, /) -> _Floats:
        """
        The wheels' angles since the start in rad, as the encoders counted them.
        """

    @property
    def wheel_rates_rad_s(self, /) -> _Floats:
        """
        The wheels' rates in rad/s, in the robot's order.
        """

@final
class Outcome:
    """
    What came of an advance.
    """

    def __repr__(self, /) -> str:
        ...

    @property
    def contact_residual_m_s(self, /) -> float:
        """
        By how much the laws of contact were broken at worst, in m/s: the speed of what moves and
        should not.
        """

    @property
    def torques_n_m(self, /) -> _Floats:
        """
        The torques that the motors put on the wheels in N m: the mean over the time.
        """

@final
class Recorded:
    """
    What a run recorded, one row a control period; `ilon.Trace` is the mapping of it.
    """

    def column(self, /, name: str) -> npt.NDArray[Any]:
        """
        A column by its name, such as `truth_x_m`: an array that cannot be written to, NaN where it
        is absent.
        """

    @property
    def columns(self, /) -> list[str]:
        """
        The names of all columns, in the order of the file's.
        """

    @property
    def header(self, /) -> _Dict:
        """
        What the run was: wheels, steps, the robot's URDF, the ground.
        """

    @property
    def rows(self, /) -> int:
        """
        How many rows there are.
        """

    def to_arrow(self, /) -> ArrowTable:
        """
        All columns as a table of Arrow.
        """

@final
class Rows:
    """
    What was run of a study, for this process alone until it is finished or closed.
    """

    def __new__(cls, /, study: Study, *, folder: _Path | None=None, shard: str | None=None) -> Rows:
        """
        The existing rows of a study in a folder, or none in memory; for one shard of it, such as
        `"3/8"`, or for all of it.
        """

    def close(self, /) -> None:
        """
        Closes the rows, so that other processes may use them.
        """

    @property
    def damaged(self, /) -> int:
        """
        How many rows could not be read again, and are run anew.
        """

    @property
    def done(self, /) -> int:
        """
        How many runs are there.
        """

    def finish(self, /, *, jobs: SupportsIndex | None=None, progress: Callable[[int, int], object] | None=None) -> Sweep:
        """
        Runs what is missing, says what came of it and writes it; the rows are closed then.
        """

    @property
    def folder(self, /) -> Path | None:
        """
        The folder that its rows and results are in.
        """

    def missing(self, /) -> list[int]:
        """
        The parts of the study of which rows are missing.
        """

    @property
    def most(self, /) -> int:
        """
        How many there will be; of a search, at most.
        """

    def put(self, /, rows: bytes) -> None:
        """
        Adds rows that were made elsewhere; those that are there already are left as they are.
        """

@disjoint_base
class Run:
    """
    A finished run.
    """

    def __new__(cls, /, run: Run) -> Run:
        """
        The same run in a derived Python class.
        """

    @property
    def figures(self, /) -> dict[str, float]:
        """
        The numbers of the summary by their dotted names, such as `twist_ratio_ideal.vy`; those that
        do not apply are left out.
        """

    @property
    def name(self, /) -> str:
        """
        The scenario's name.
        """

    @staticmethod
    def of_parts(trace: bytes, summary: str, scenario: str, name: str, folder: _Path, sandbox: list[Path] | None, warnings: SupportsGetItem[int, str], called: str) -> Run:
        """
        Rebuilds a run from its parts.
        """

    def parts(self, /) -> tuple[bytes, str, str, str, Path, list[Path] | None, list[str], str]:
        """
        The parts from which a run is rebuilt in another process: trace, summary, scenario, name,
        folder, sandbox, warnings, call.
        """

    @property
    def recorded(self, /) -> Recorded:
        """
        What was recorded, to be read by column.
        """

    def report_html(self, /) -> str:
        """
        The report as the text of one HTML page.
        """

    @property
    def scenario(self, /) -> _Dict:
        """
        The scenario as it was run, every default spelled out.
        """

    @property
    def scenario_toml(self, /) -> str:
        """
        The same as the text of a scenario file.
        """

    @property
    def summary(self, /) -> _Dict:
        """
        The figures of the run, as in `summary.json`.
        """

    @property
    def warnings(self, /) -> list[str]:
        """
        What a person should know about the input, although it could be run.
        """

    def write(self, /, folder: _Path) -> None:
        """
        Writes what `ilon run --out` writes into a folder: summary.json, trace.parquet, report.html,
        scenario.toml.
        """

@final
class Simulation:
    """
    A robot in its world with its motors and wheel loops, its sensors and faults, driven step by
    step.

    `scenario` is the path of a scenario file or a dict of what it would hold; relative paths in a
    dict start from `folder`, or from where the program runs. `settings` changes keys:
    `{"world.floor.friction": 0.2}`. Of `[run]`, `duration_s` ends nothing here. With `sandbox`,
    files are read below these folders alone: for scenarios and robots of people that you do not
    know.

    Another thread may run Python while it steps; two threads that call the same simulation at once
    get a RuntimeError. It cannot be pickled. Raises subclasses of `ilon.Error` for what the command
    line refuses.
    """

    def __new__(cls, /, scenario: _Source, *, settings: _Table | None=None, folder: _Path | None=None, sandbox: _Sandbox | None=None) -> Simulation:
        ...

    def __repr__(self, /) -> str:
        ...

    def advance(self, /, wheel_rates: _Array | None=None, *, torques: _Array | None=None, period_s: SupportsFloat | SupportsIndex | None=None) -> Outcome:
        """
        Lets the robot act on wheel rates in rad/s, or torques in N m, one a wheel in the robot's
        order, for a time in seconds, by default a control period; with sampled or late wheel loops
        a whole number of physics steps.

        Raises ValueError or TypeError for numbers that are not finite or of another count, before
        anything happens; `ilon.DivergedError` where the robot's motion is no number afterwards;
        KeyboardInterrupt between steps of a long time.
        """

    def body(self, /) -> Body:
        """
        The body in three dimensions, as it really is.
        """

    def command_joints(self, /, positions: dict[str, SupportsFloat | SupportsIndex] | None=None, *, rates: dict[str, SupportsFloat | SupportsIndex] | None=None, efforts: dict[str, SupportsFloat | SupportsIndex] | None=None) -> None:
        """
        Commands the servos of joints between bodies, by name, from now on. `positions` are in rad or
        m. `rates` are in rad/s or m/s: beside a position, how fast the target moves on, if both are
        given in every control period; without one, how fast the joint moves. `efforts` are torques or
        forces in N m or N within the servo's limit, and nothing then holds the joint. All are
        commanded, or none.
        The scenario's setpoints no longer hold for these joints; a reset brings them back.
        """

    @property
    def control_dt_s(self, /) -> float:
        """
        The period of the control, in seconds.
        """

    def desired(self, /, t_s: SupportsFloat | SupportsIndex | None=None) -> Desired | None:
        """
        Where the scenario's `[reference]` wants the robot at a time in seconds, by default now;
        None without a reference.
        """

    def energies(self, /) -> dict[str, float]:
        """
        Where energy is and where it went since the start, in J: `kinetic_j` and `potential_j` now;
        the work of the motors `motor_j`, what they did of it while they drove `motor_positive_j`,
        and that of wrenches, payloads and leaning ground `outside_j`; and what went into `slip_j`,
        `spin_up_j` of rollers that came down, `bearing_j` and `impact_j`.
        """

    def free_bodies(self, /) -> dict[str, FreeBody]:
        """
        The scenario's `[[world.bodies]]` by their names, as they really are.
        """

    def joints(self, /) -> dict[str, float]:
        """
        Where the joints between bodies are now, in rad or m, by name.
        """

    def observe(self, /) -> Observation:
        """
        What the robot's sensors say now. Asked again at the same moment, they say the same.
        """

    @property
    def physics_dt_s(self, /) -> float:
        """
        The step of the physics, in seconds.
        """

    def push(self, /, force_n: _Array, lasts_s: SupportsFloat | SupportsIndex, *, place_m: _Array | None=None) -> None:
        """
        Pushes the chassis from now on with a constant force (x, y, z in N, in the world frame) for
        a time in seconds, at a place in the body frame (x, y, z in m); without one, at the
        chassis's centre of mass. Pushes add up; a reset ends them.
        """

    def reset(self, /, *, seed: int | None=None, pose: _Array | None=None) -> Observation:
        """
        Begins anew: time zero, the robot at rest. Noise comes from `seed` and the robot stands at
        `pose` (x in m, y in m, heading in rad), or both are as the scenario says.
        """

    def restore(self, /, snapshot: Snapshot) -> None:
        """
        Goes back to a snapshot, of this simulation or of another of the same scenario and robot:
        from there all is as it was, to the bit. Raises `ilon.ScenarioError` for a snapshot of
        another scenario or robot.
        """

    @property
    def scenario(self, /) -> _Dict:
        """
        The scenario with every default spelled out.
        """

    def set_articulated_inertia(self, /, inertia: _Array) -> None:
        """
        Lets the chassis bear from now on the articulated-body inertia of something that another
        simulator moves: six rows of six numbers, linear at the body frame's origin before angular,
        along the world's axes, in kg, kg m and kg m^2. With `set_wrench` of what that puts on the
        chassis where it is not accelerated, both meet without a delay, whatever weighs more. All
        zeros end it.
        """

    def set_down(self, /, down: _Array) -> None:
        """
        Lets the ground lean from now on: gravity pulls along a direction (x, y, z in the world
        frame, of any length); [0, 0, -1] is level ground.
        """

    def set_friction(self, /, friction: SupportsFloat | SupportsIndex) -> None:
        """
        Changes Coulomb's coefficient of friction of the floor from now on, but on its patches.
        """

    def set_grip(self, /, wheel: SupportsIndex, share: SupportsFloat | SupportsIndex) -> None:
        """
        Lets the rollers of a wheel, counted from 0, find a share of the ground's friction from now
        on; 1 for all of it.
        """

    def set_payload(self, /, mass_kg: SupportsFloat | SupportsIndex, *, place_m: _Array | None=None) -> None:
        """
        Puts a mass in kg on the robot, in place of the one put there before; 0 takes it off. It
        lies at a place in the body frame in m, or without one at the chassis's centre of mass.
        """

    def set_wrench(self, /, force_n: _Array | None=None, moment_n_m: _Array | None=None, *, place_m: _Array | None=None) -> None:
        """
        Lets a force in N and a moment in N m, both x, y, z in the world frame, act on the chassis
        from now on until they are set again; the force at a place in the body frame in m, or
        without one at the chassis's centre of mass. What is left out is 0.
        """

    def snapshot(self, /) -> Snapshot:
        """
        A copy of the simulation at this moment, to return to.
        """

    @property
    def time_s(self, /) -> float:
        """
        Simulated time since the start or the last reset, in seconds.
        """

    @property
    def torque_limits_n_m(self, /) -> _Floats:
        """
        The largest torque of each motor in N m; infinite where nothing limits it.
        """

    def truth(self, /) -> Truth:
        """
        Where the robot really is and how it really moves.
        """

    def twist(self, /, wheel_rates: _Array) -> _Floats:
        """
        The twist of the body in its own frame (m/s, m/s, rad/s) that fits wheel rates in rad/s
        best.
        """

    @property
    def warnings(self, /) -> list[str]:
        """
        What a person should know about the input, although it can be run.
        """

    @property
    def wheel_names(self, /) -> list[str]:
        """
        The names of the wheels' joints, in the robot's order.
        """

    @property
    def wheel_rate_limit_rad_s(self, /) -> float:
        """
        The rate in rad/s that wheels are held to; infinite where nothing limits it.
        """

    def wheel_rates(self, /, twist: _Array) -> _Floats:
        """
        The wheel rates in rad/s for a twist of the body in its own frame (m/s, m/s, rad/s):
        Indiveri 2009, eq. (7).
        """

    def wheels(self, /) -> Wheels:
        """
        The wheels and their contacts, as they really are.
        """

@final
class Snapshot:
    """
    A simulation as it was at one moment. It cannot be pickled.
    """

    def __repr__(self, /) -> str:
        ...

@final
class Study:
    """
    A study that was read.
    """

    def __new__(cls, /, study: _Source, *, folder: _Path | None=None, sandbox: _Sandbox | None=None) -> Study:
        ...

    @property
    def fingerprint(self, /) -> str:
        """
        A hash of all that its rows depend on.
        """

    def make(self, /, parts: Sequence[int], *, jobs: SupportsIndex, folder: _Path | None=None) -> bytes:
        """
        Makes parts of the study, so many runs at a time; their rows, as text. `folder` is that of
        its results.
        """

    @property
    def name(self, /) -> str:
        """
        Its name.
        """

    @staticmethod
    def of_text(text: str, path: _Path, *, sandbox: _Sandbox | None=None) -> Study:
        """
        A study from the text of a file that need not be there; the paths in it start from `path`.
        """

    @property
    def path(self, /) -> Path:
        """
        Its file.
        """

    @property
    def text(self, /) -> str:
        """
        The text of its file.
        """

@disjoint_base
class Sweep:
    """
    What came of a study: one row a run, and what the rows say.
    """

    def __arrow_c_stream__(self, /, requested_schema: object | None=None) -> object:
        """
        All rows as a stream of Arrow, for libraries that read its PyCapsule protocol.
        """

    def __getitem__(self, name: Any, /) -> _Column:
        """
        A column: numbers as a numpy array, NaN where they are absent; texts as a list, None where
        they are absent.
        """

    def __len__(self, /) -> int:
        """
        How many runs there are.
        """

    def __new__(cls, /, sweep: Sweep) -> Sweep:
        """
        The same in a derived Python class.
        """

    def __str__(self, /) -> str:
        """
        What was found, as the command prints it.
        """

    @property
    def columns(self, /) -> list[str]:
        """
        The names of the columns of `runs.parquet`.
        """

    @property
    def failed(self, /) -> int:
        """
        How many of the runs failed.
        """

    @property
    def findings(self, /) -> _Dict | None:
        """
        What was found, as in `findings.json`; None of a shard.
        """

    @property
    def folder(self, /) -> Path | None:
        """
        The folder of the results; None where they are in memory alone.
        """

    @property
    def name(self, /) -> str:
        """
        The name of the study.
        """

    def report_html(self, /) -> str | None:
        """
        The page of the study as the text of one HTML file; None of a shard.
        """

    def to_arrow(self, /) -> ArrowTable:
        """
        All rows as a table of Arrow.
        """

@final
class Torques:
    """
    Torques in N m, one a wheel, which a controller returns in place of wheel rates.
    """

    def __new__(cls, /, torques_n_m: _Array) -> Torques:
        ...

@final
class Track:
    """
    Robots that follow paths, each in its own episode.
    """

    def __new__(cls, /, scenario: _Source, options: _Dict) -> Track:
        ...

    def above(self, /, robot: SupportsIndex) -> tuple[_Floats, _Floats, _Floats, _Floats]:
        """
        A robot from above, for a picture: its pose and the desired one (x and y in m, heading in
        rad), points of its path (x and y in m), and one row per wheel in the body frame (x and y in
        m, direction of its axis in rad, radius and half its width in m).
        """

    @property
    def action_names(self, /) -> list[str]:
        """
        Names of the numbers of an action.
        """

    @property
    def action_scale(self, /) -> _Floats:
        """
        The value of an action of 1: in m/s, m/s and rad/s for a twist, in rad/s for wheel rates, in
        N m for torques.
        """

    @property
    def alive_per_s(self, /) -> float:
        """
        The reward per second without any cost.
        """

    @property
    def bounds(self, /) -> _Singles:
        """
        Each observation lies between minus and plus this.
        """

    @property
    def control_dt_s(self, /) -> float:
        """
        The time between actions, in seconds.
        """

    @property
    def observation_names(self, /) -> list[str]:
        """
        Names of the observations, with their units.
        """

    def reset(self, /, seeds: Sequence[int | None], mask: Sequence[bool] | None=None) -> _Begun:
        """
        Begins new episodes, all or those of a mask, each from its own seed or with its continued
        random numbers.
        """

    def step(self, /, actions: _Array) -> tuple[_Singles, _Floats, _Flags, _Flags, _Floats, _Floats, _Begun | None]:
        """
        Steps all robots by a control period; `actions` has one row of numbers per robot, clipped to
        [-1, 1].
        """

    @property
    def steps(self, /) -> int:
        """
        Steps of an episode that does not fail.
        """

@final
class Truth:
    """
    Where the robot really is and how it really moves, whatever its sensors say.
    """

    def __repr__(self, /) -> str:
        ...

    @property
    def height_m(self, /) -> float:
        """
        Height of the body's origin above the floor, in m.
        """

    @property
    def pitch_rad(self, /) -> float:
        """
        Pitch in rad.
        """

    @property
    def pose(self, /) -> _Floats:
        """
        The body's pose in the world frame: x in m, y in m, heading in rad.
        """

    @property
    def roll_rad(self, /) -> float:
        """
        Roll in rad.
        """

    @property
    def twist_in_body(self, /) -> _Floats:
        """
        The body's twist in its own frame: vx in m/s, vy in m/s, yaw rate in rad/s.
        """

@final
class Wheels:
    """
    The robot's wheels and their contacts, as they really are, in the robot's order.
    """

    def __repr__(self, /) -> str:
        ...

    @property
    def angles_rad(self, /) -> _Floats:
        """
        Angles about the wheels' axes since the start, in rad, not wrapped.
        """

    @property
    def forces_in_body_n(self, /) -> _Floats:
        """
        The ground's tangential forces: a row of x and y in the body frame for each wheel, in N:
        means over the last advance.
        """

    @property
    def friction_used_max(self, /) -> _Floats:
        """
        The largest share of its friction limit that each wheel used in the last advance; 1 where it
        slid.
        """

    @property
    def loads_n(self, /) -> _Floats:
        """
        The ground's normal forces in N: means over the last advance.
        """

    @property
    def rates_rad_s(self, /) -> _Floats:
        """
        Rates about the wheels' axes, in rad/s.
        """

    @property
    def slip_in_body_m_s(self, /) -> _Floats:
        """
        Velocities of the rollers' surfaces over the ground: a row of x and y in the body frame for
        each wheel, in m/s: means over the time of the last advance in which the wheel touched.
        """

    @property
    def slip_speed_max_m_s(self, /) -> _Floats:
        """
        The largest sliding speed of each wheel in the last advance, in m/s.
        """

def command(arguments: list[str]) -> int:
    """
    Runs the `ilon` command; returns its exit code.
    """

def compare(runs: list[Any]) -> tuple[list[_Dict], list[_Dict], str]:
    """
    Compares runs: names and summaries, the keys that differ, and the page.
    """

def generate(spec: _Path) -> str:
    """
    A URDF with explicit rollers from the file of a robot description.
    """

def identify(study: _Source, *, out: _Path | None=None, folder: _Path | None=None, sandbox: _Sandbox | None=None) -> _Dict:
    """
    Fits all free parameters of a study of logs, or of runs measured by tape; returns the content of
    `identified.json`, and writes it with its page into a folder, if one is given.
    """

def inspect(path: _Path, options: _Table, *, limits: _Table | None=None, sandbox: _Sandbox | None=None) -> tuple[_Dict, str, str, str | None]:
    """
    Inspects a robot's file: the dict that `ilon inspect --json` prints, a drawing from above in
    SVG, and the URDF that was read; with `limits` also the speeds and accelerations that it can
    reach, and a drawing of them. `options` are keys of a scenario's `[robot]`, `limits` any of its
    keys.
    """

def judged(run: Run) -> list[_Dict]:
    """
    Checks a run against its scenario's `[expect]`: quantity, bound, measured, at_s, held, and a
    sentence, for each expectation.
    """

def merge_sweeps(folders: Sequence[_Path], out: _Path) -> Sweep:
    """
    Merges the rows of one study from several folders, and from the shards in them, into one.
    """

def run(scenario: _Source, *, called: str, settings: _Table | None=None, controller: _Controller | None=None, folder: _Path | None=None, sandbox: _Sandbox | None=None, converge: bool=False, causes: Literal['named', 'all'] | None=None) -> Run:
    """
    Simulates a scenario to its end; `called` is the equivalent call, for the report.
    """

def schema() -> _Dict:
    """
    The JSON Schema of the scenario file.
    """

def suspects(path: _Path, options: _Table, *, settings: _Table | None=None, sandbox: _Sandbox | None=None) -> list[_Dict]:
    """
    The effects of common suspects on the robot of a file in standard motions. `options` are keys of
    a scenario's `[robot]`, `settings` any of its keys.
    """
__all__ = ['__version__', 'ArrowTable', 'Body', 'Desired', 'FreeBody', 'Imu', 'Observation', 'Outcome', 'Recorded', 'Rows', 'Run', 'Simulation', 'Snapshot', 'Study', 'Sweep', 'Torques', 'Track', 'Truth', 'Wheels', 'command', 'compare', 'generate', 'identify', 'inspect', 'judged', 'merge_sweeps', 'run', 'schema', 'suspects']
