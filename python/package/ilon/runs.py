"""Whole runs."""

from __future__ import annotations

import html
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NoReturn

from . import _ilon
from ._ilon import ArrowTable, Desired, Observation, Torques

if TYPE_CHECKING:
    import numpy.typing as npt

    from .tools import Check

Scenario = str | os.PathLike[str] | Mapping[str, Any]
"""A scenario: the path of a file, or a dict of what such a file holds."""

Controller = Callable[[Observation, Desired | None], "npt.ArrayLike | Torques"]
"""A controller of one's own: from what is seen, and desired if the scenario has a `[reference]`, to wheel rates in rad/s, one a
wheel in the robot's order, or to `Torques` in N m. It is called once a control period."""

Sandbox = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]
"""Folders below which alone files are read, whatever a scenario or a robot names, as `--sandbox` of the command: one, or a list. Links are
followed first, and xacro files see nothing of the environment."""

_REPORT_HEIGHT_PX = 800


class Report(str):
    """A page as the text of one HTML file that opens offline; a notebook shows it."""

    __slots__ = ()

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the page to a file."""
        Path(path).write_text(self, encoding="utf-8")

    def _repr_html_(self) -> str:
        # A separate page within the notebook's: neither affects the other's styles and scripts.
        return (
            f'<iframe srcdoc="{html.escape(self)}" sandbox="allow-scripts" '
            f'style="width:100%;height:{_REPORT_HEIGHT_PX}px;border:0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<ilon.Report of {len(self) / 1e6:.1f} MB>"


class Trace(dict[str, "npt.NDArray[Any]"]):
    """What a run recorded, one row a control period: numpy arrays by the names of their columns, as in `trace.parquet`.

    An array is made when it is first read, and cannot be written to. Where a number is absent it is NaN.
    """

    def __init__(self, recorded: _ilon.Recorded) -> None:
        self.columns: list[str] = recorded.columns
        """The names of all columns, in the order of the file's."""
        self.rows: int = recorded.rows
        """How many rows there are."""
        self.to_arrow = recorded.to_arrow
        """All columns as a table of Arrow."""
        super().__init__(dict.fromkeys(self.columns))  # type: ignore[arg-type]
        self._recorded = recorded

    @property
    def header(self) -> dict[str, Any]:
        """What the run was: wheels, steps, the robot's URDF, the ground."""
        return self._recorded.header

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        if super().get(name) is None:
            super().__setitem__(name, self._recorded.column(name))
        return super().__getitem__(name)

    def _refused(self, *_: object, **__: object) -> NoReturn:
        raise TypeError("what a run recorded cannot be changed: `dict(trace)` is a copy")

    __setitem__ = __delitem__ = __ior__ = _refused
    pop = popitem = setdefault = update = clear = _refused
    __eq__, __ne__ = object.__eq__, object.__ne__

    def __iter__(self) -> Iterator[str]:
        # Without this, `dict(trace)` would copy arrays that were not made yet.
        return super().__iter__()

    get, items, values = Mapping.get, Mapping.items, Mapping.values  # type: ignore[assignment]

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def __repr__(self) -> str:
        return f"<ilon.Trace: {len(self)} columns, {self.rows} rows>"


class Run(_ilon.Run):
    """A finished run: its figures, what was recorded, and what it shows.

    A run can be pickled, and so be handed to another process.
    """

    def report(self) -> Report:
        """The report as one HTML page: `run.report().write("report.html")`; in a notebook it is shown."""
        return Report(self.report_html())

    def to_arrow(self) -> ArrowTable:
        """Everything recorded, as a table that pandas, polars, pyarrow and DuckDB take by Arrow's PyCapsule protocol."""
        return self.trace.to_arrow()

    def to_pandas(self) -> Any:
        """Everything recorded, as a `pandas.DataFrame`: a row a recorded period, a column a signal. Needs pandas."""
        import pandas

        return pandas.DataFrame(self.trace)

    @cached_property
    def trace(self) -> Trace:
        """What was recorded, by column."""
        return Trace(self.recorded)

    @property
    def effects(self) -> list[dict[str, Any]]:
        """What each cause did, of a run with `causes`: dicts of `cause`, `words`, `key`, `with`, `without`, `difference`, `floor` and `differs`."""
        effects: list[dict[str, Any]] = self.summary.get("effects", [])
        return effects

    def check(self) -> Check:
        """Holds the run against its scenario's `[expect]`."""
        from .tools import Check

        return Check(self)

    def _repr_html_(self) -> str:
        return self.report()._repr_html_()

    def __repr__(self) -> str:
        summary = self.summary
        return f"<ilon.Run of {self.name} with {summary['robot']}: {summary['duration_s']:g} s>"

    def __reduce__(self) -> tuple[Any, ...]:
        return (_of_parts, self.parts())


def _of_parts(*parts: Any) -> Run:
    return Run(_ilon.Run.of_parts(*parts))


def absolute(
    scenario: Scenario, folder: str | os.PathLike[str] | None
) -> tuple[Scenario, str | os.PathLike[str] | None]:
    """A scenario, and the folder that a dict's paths start from, whatever folder a process then works in."""
    if isinstance(scenario, Mapping):
        return scenario, Path(folder or ".").absolute()
    return Path(scenario).absolute(), folder


def folders(sandbox: Sandbox) -> list[str | os.PathLike[str]]:
    """The folders of a sandbox, each by itself."""
    return [sandbox] if isinstance(sandbox, (str, os.PathLike)) else list(sandbox)


def run(
    scenario: Scenario,
    *,
    settings: Mapping[str, Any] | None = None,
    controller: Controller | None = None,
    folder: str | os.PathLike[str] | None = None,
    sandbox: Sandbox | None = None,
    converge: bool = False,
    causes: Literal["named", "all"] | None = None,
) -> Run:
    """Simulates a scenario to its end.

    `scenario` is the path of a scenario file, or a dict of what the file would hold; relative paths in a dict start from
    `folder`, or from where the program runs. `settings` changes keys: `{"world.floor.friction": 0.2}`.
    `controller` drives the wheels in place of the scenario's guidance. With `sandbox`, files are read below these folders alone: for
    scenarios and robots of people that you do not know. With `converge`, it is run again at half the step, beside it: `summary["converge"]` has by
    each figure's name its `value`, the same at `half_step` and `half_split`, by how much it `moved`, that as a `share`, and whether it `exceeds`
    the accuracy that is stated of it. With `causes`, it is run again without what the scenario names (`"named"`: faults, what lies on the floor, slope,
    bodies, sensors' errors), or without all that can make a difference (`"all"`), one after the other: `effects` has what each did.

    Other threads of Python run meanwhile, and Ctrl-C ends it. Raises a subclass of `ilon.Error` for what the command line
    refuses, and whatever the controller raises.
    """
    called = _call(scenario, settings, controller, folder, sandbox, converge, causes)
    return Run(
        _ilon.run(
            scenario,
            called=called,
            settings=settings,
            controller=controller,
            folder=folder,
            sandbox=sandbox,
            converge=converge,
            causes=causes,
        )
    )


def explain(
    scenario: Scenario,
    *,
    settings: Mapping[str, Any] | None = None,
    folder: str | os.PathLike[str] | None = None,
    sandbox: Sandbox | None = None,
) -> Run:
    """Runs a scenario, and again without each of all causes: `run(..., causes="all")`.

    `explain("scenario.toml").effects` has what each did; sorted by `difference` of the key `apart_m`, the first moved the robot most.
    """
    return run(scenario, settings=settings, folder=folder, sandbox=sandbox, causes="all")


def suspects(
    path: str | os.PathLike[str], *, settings: Mapping[str, Any] | None = None, sandbox: Sandbox | None = None, **options: Any
) -> list[dict[str, Any]]:
    """What the usual suspects do to a robot that drives ahead, to the left, diagonally, in an arc, and turns on the spot.

    Each is a dict: `words`, the `wheel` that it is about, and `drifts`, one for each motion: `ahead_m`, `left_m` and `turned_rad` for each metre, or for
    each turn on the spot, and the `floor` below which they cannot be told from none. `options` are keys of a scenario's `[robot]`, as those of
    `inspect`; `settings` are any of its keys.
    """
    return _ilon.suspects(path, options, settings=settings, sandbox=sandbox)


def _call(
    scenario: Scenario,
    settings: object,
    controller: object,
    folder: object,
    sandbox: object,
    converge: bool,
    causes: object,
) -> str:
    """The equivalent command line of a run; a scenario in a dict is in its report anyway."""
    words = ["scenario" if isinstance(scenario, Mapping) else repr(str(scenario))]
    if settings is not None:
        words.append(f"settings={settings!r}")
    if controller is not None:
        words.append(f"controller={getattr(controller, '__qualname__', type(controller).__qualname__)}")
    if folder is not None:
        words.append(f"folder={str(folder)!r}")
    if sandbox is not None:
        words.append(f"sandbox={sandbox!r}")
    if converge:
        words.append("converge=True")
    if causes is not None:
        words.append(f"causes={causes!r}")
    return f"ilon.run({', '.join(words)})"
