"""What else the command does: inspect, generate, compare, check."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _ilon
from .runs import Report, Run, Sandbox, Scenario, run

__all__ = ["Check", "Comparison", "Inspection", "Verdict", "check", "compare", "generate", "identify", "inspect"]


class Inspection(dict[str, Any]):
    """A robot as it is understood: a dict as `ilon inspect --json` prints it; a notebook draws it from above."""

    svg: str
    """The robot from above, with the axes of its rollers."""
    urdf: str
    """The URDF that was read: expanded, converted and repaired."""
    limits_svg: str | None
    """Its accelerations without slip by direction, where limits were asked for."""

    def __init__(self, figures: Mapping[str, Any], svg: str, urdf: str, limits_svg: str | None = None) -> None:
        super().__init__(figures)
        self.svg = svg
        self.urdf = urdf
        self.limits_svg = limits_svg

    def _repr_svg_(self) -> str:
        return self.svg

    def __reduce__(self) -> tuple[Any, ...]:
        return (Inspection, (dict(self), self.svg, self.urdf, self.limits_svg))


def inspect(
    path: str | os.PathLike[str],
    *,
    limits: Mapping[str, Any] | None = None,
    sandbox: Sandbox | None = None,
    **options: Any,
) -> Inspection:
    """A robot's file as it is understood: URDF, xacro, SDF, MJCF, or a description in TOML.

    `options` are keys of a scenario's `[robot]`, such as `repair=True` or `wheels={"rollers": 9, "gamma": {"x_deg": 45}}`.
    With `limits`, a dict of conditions such as `{"world.floor.friction": 0.3}` that may be empty, `"limits"` says how hard it may be driven:
    accelerations without slip by motion (`rows`), by direction (`outlines`), as a polytope and as a box.
    With `sandbox`, the robot, its meshes and whatever it includes are read below these folders alone.
    """
    return Inspection(*_ilon.inspect(path, options, limits=limits, sandbox=sandbox))


def generate(spec: str | os.PathLike[str], out: str | os.PathLike[str] | None = None) -> str:
    """The URDF, with explicit rollers, of a short description in TOML; written to `out` too, if that is given."""
    urdf = _ilon.generate(spec)
    if out is not None:
        Path(out).write_text(urdf, encoding="utf-8")
    return urdf


def identify(
    study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    out: str | os.PathLike[str] | None = None,
    folder: str | os.PathLike[str] | None = None,
    sandbox: Sandbox | None = None,
) -> dict[str, Any]:
    """What a robot really is, fitted to logs of its drives, as `ilon identify` does: what `identified.json` holds.

    `study` is the path of a file that names the robot, the logs or runs measured by tape, and what is free, or a dict of what the file would hold, with paths
    from `folder`. `parameters` has for each name its `value`, its 95 %
    interval `ci95` and its `unit` (SI, angles in degrees where the name ends in `_deg`). With `out`, `identified.json` and the page are
    written into that folder. With `sandbox`, the study, its robot and its logs are read below these folders alone.

    Raises a subclass of `ilon.Error` for a study or a log that cannot be used.
    """
    return _ilon.identify(study, out=out, folder=folder, sandbox=sandbox)


@dataclass(frozen=True)
class Comparison:
    """Runs beside each other."""

    summaries: dict[str, dict[str, Any]]
    """The figures of each run, by its name."""
    differences: list[dict[str, Any]]
    """The keys that were set differently: `key`, and `values`, one a run."""
    page: Report
    """All curves over each other, as one HTML page."""

    def _repr_html_(self) -> str:
        return self.page._repr_html_()

    def __repr__(self) -> str:
        return f"<ilon.Comparison of {', '.join(self.summaries)}>"


def compare(*runs: Run | str | os.PathLike[str]) -> Comparison:
    """Lays runs over each other: `Run`s, folders that a run was written to, or trace files."""
    summaries, differences, page = _ilon.compare(list(runs))
    return Comparison({each["name"]: each["summary"] for each in summaries}, differences, Report(page))


@dataclass(frozen=True)
class Verdict:
    """What came of one expectation."""

    quantity: str
    """The quantity's dotted name in the summary, or the name of a column."""
    bound: str
    """The bound in words, such as `<= 0.01`."""
    measured: float | None
    """What was measured, of a column where it was worst; None where it does not apply."""
    at_s: float | None
    """When a column was worst, in seconds; None of a quantity of the whole run."""
    held: bool
    """Whether it held."""
    words: str
    """All of it in one line."""

    def __str__(self) -> str:
        return self.words


class Check:
    """A run held against its scenario's `[expect]`. It is true where everything held."""

    run: Run
    verdicts: list[Verdict]

    def __init__(self, run: Run) -> None:
        self.run = run
        self.verdicts = [Verdict(**each) for each in _ilon.judged(run)]

    @property
    def held(self) -> bool:
        """Whether all expectations held."""
        return all(verdict.held for verdict in self.verdicts)

    def __bool__(self) -> bool:
        return self.held

    def __repr__(self) -> str:
        failed = [str(verdict) for verdict in self.verdicts if not verdict.held]
        if failed:
            return f"<ilon.Check of {self.run.name}: {'; '.join(failed)}>"
        return f"<ilon.Check of {self.run.name}: all {len(self.verdicts)} held>"


def check(
    scenario: Scenario,
    *,
    settings: Mapping[str, Any] | None = None,
    folder: str | os.PathLike[str] | None = None,
    sandbox: Sandbox | None = None,
    converge: bool = False,
) -> Check:
    """Runs a scenario and holds it against its own `[expect]`; `assert ilon.check("scenario.toml")` is a test. `converge` is that of `run`."""
    return Check(run(scenario, settings=settings, folder=folder, sandbox=sandbox, converge=converge))
