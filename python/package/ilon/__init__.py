"""ilon simulates omnidirectional robots down to the rollers of their wheels.

>>> run = ilon.run("mecanum4_lateral.toml")
>>> run.summary["twist_ratio_ideal"]["vy"]
>>> run.trace["truth_x_m"]
>>> run.report()

`run` goes through a whole scenario, `sweep` through many under keys that vary; `live` lets a person drive in a browser; `Simulation` is driven step by step; `gymnasium.make("ilon/Track-v0")` is a task to learn.
Lengths are in metres, angles in radians, and names that could be doubted carry their unit. Frames: x forward, y left, z up.
"""

from __future__ import annotations

from ._ilon import (
    ArrowTable,
    Body,
    Desired,
    FreeBody,
    Imu,
    Observation,
    Outcome,
    Simulation,
    Snapshot,
    Torques,
    Truth,
    Wheels,
    __version__,
    schema,
)
from .errors import (
    ControlError,
    DivergedError,
    Error,
    ReadError,
    RobotError,
    ScenarioError,
    TraceError,
    WorldError,
)
from .judging import Judgement, judge
from .livedrive import Live, live
from .runs import Report, Run, Trace, explain, run, suspects
from .sweeps import Sweep, merge_sweeps, sweep, tune_trainable
from .tools import Check, Comparison, Inspection, check, compare, generate, identify, inspect
from .viewers import to_rerun

__all__ = [
    "ArrowTable",
    "Body",
    "Check",
    "Comparison",
    "ControlError",
    "Desired",
    "DivergedError",
    "Error",
    "FreeBody",
    "Inspection",
    "Imu",
    "Judgement",
    "Live",
    "Observation",
    "Outcome",
    "ReadError",
    "Report",
    "RobotError",
    "Run",
    "ScenarioError",
    "Simulation",
    "Snapshot",
    "Sweep",
    "Torques",
    "Trace",
    "TraceError",
    "Truth",
    "Wheels",
    "WorldError",
    "__version__",
    "check",
    "compare",
    "explain",
    "generate",
    "identify",
    "inspect",
    "judge",
    "live",
    "merge_sweeps",
    "run",
    "schema",
    "suspects",
    "sweep",
    "to_rerun",
    "tune_trainable",
]


def _register() -> None:
    """Registers the tasks with Gymnasium, if it is installed."""
    try:
        import gymnasium
    except ImportError:
        return
    if "ilon/Track-v0" not in gymnasium.registry:
        gymnasium.register(
            "ilon/Track-v0",
            entry_point="ilon.gym:TrackEnv",
            vector_entry_point="ilon.gym:TrackVectorEnv",
        )


_register()


def __getattr__(name: str) -> object:
    # Imported on demand, since they need other packages.
    if name in ("gym", "mujoco", "sb3"):
        import importlib

        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
