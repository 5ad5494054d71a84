"""Studies: many runs of a scenario under keys that vary."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal

from . import _ilon
from .runs import Report, Sandbox, Scenario, absolute, folders, run

__all__ = ["Sweep", "merge_sweeps", "sweep", "tune_trainable"]


class Sweep(_ilon.Sweep):
    """What came of a study: one row a run, and what the rows say. `print` shows it as the command does.

    `sweep["slip_energy_j"]` is a column of `runs.parquet`; pandas, polars, pyarrow and DuckDB take the whole of it by Arrow's
    PyCapsule protocol, as `polars.DataFrame(sweep)` does.
    """

    def report(self) -> Report:
        """The page of the study: curves, heat maps, the best and worst runs with the command that runs each again.

        Raises ValueError of a shard, which shows nothing by itself.
        """
        page = self.report_html()
        if page is None:
            raise ValueError("a shard has no page of its own: merge all shards by ilon.merge_sweeps(folder)")
        return Report(page)

    def to_pandas(self) -> Any:
        """The rows of the study, as a `pandas.DataFrame`: a row a run. Needs pandas."""
        import pandas

        return pandas.DataFrame({name: self[name] for name in self.columns})

    @property
    def held(self) -> bool:
        """Whether every `[expect]` of the study held; of a shard it is not known, and False."""
        findings = self.findings
        return findings is not None and all(one["held"] for one in findings.get("expectations", []))

    def _repr_html_(self) -> str | None:
        return None if self.findings is None else self.report()._repr_html_()

    def __repr__(self) -> str:
        failed = f", {self.failed} of them failed" if self.failed else ""
        return f"<ilon.Sweep of {self.name}: {len(self)} runs{failed}>"


def sweep(
    study: str | os.PathLike[str] | Mapping[str, Any],
    *,
    on: Literal["ray"] | None = None,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    shard: str | None = None,
    progress: Callable[[int, int], object] | None = None,
    folder: str | os.PathLike[str] | None = None,
    sandbox: Sandbox | None = None,
) -> Sweep:
    """Runs a study: a scenario many times under keys that vary, as `ilon sweep` does.

    `study` is the path of a study file, or a dict of what the file would hold; relative paths in a dict start from `folder`, or
    from where the program runs, and its axes are taken in the order of their names.

    With `out`, every finished run is kept in that folder at once: stopped or killed at any moment, the same call goes on and runs
    only what is missing. `runs.parquet`, `findings.json` and `report.html` are written there at the end. Without it, all stays
    in memory, and traces that the study would keep are not kept.

    `on=None` runs `jobs` runs at a time on this machine, by default as many as it has cores. `on="ray"` runs batches of them as
    tasks of Ray, each on `jobs` CPUs, by default one; the rows are the same. `shard="3/8"` makes only the third of eight parts, into
    a folder of its own within `out`; `merge_sweeps` gathers them.

    With `sandbox`, the study and all that it names are read below these folders alone.

    `progress(done, most)` is called now and then with how many runs are there and how many there will be, of a search as far as is known.

    A run that fails is a row with its error. Raises a subclass of `ilon.Error` for a study that the command line refuses and for an
    `out` that holds something else; Ctrl-C ends it within a second or so.
    """
    if on not in (None, "ray"):
        raise ValueError(f'studies run on this machine, on=None, or on="ray"; not on {on!r}')
    if jobs is not None and (isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1):
        raise ValueError(f"jobs is a whole number from 1 on, not {jobs!r}")
    if shard is not None and out is None:
        raise ValueError("a shard is kept in a folder: name it by out")
    if on == "ray":
        from . import _ray

        _ray.connect()
    read = _ilon.Study(study, folder=folder, sandbox=sandbox)
    rows = _ilon.Rows(read, folder=out, shard=shard)
    try:
        if rows.damaged:
            warnings.warn(f"{rows.damaged} rows could not be read again, and are run anew", stacklevel=2)
        if on == "ray":
            _ray.make(read, rows, jobs or 1, progress, sandbox)
            jobs = None
        return Sweep(rows.finish(jobs=jobs, progress=progress))
    finally:
        rows.close()


def merge_sweeps(
    *folders: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
) -> Sweep:
    """Gathers the rows of one study from several folders, and from the shards in them, into `out`; one folder is by default merged in
    its place.

    Raises `ilon.ScenarioError` where runs are missing, or where the folders are not of one study.
    """
    if out is None:
        if len(folders) != 1:
            raise ValueError("several folders are merged into one that out names")
        out = folders[0]
    return Sweep(_ilon.merge_sweeps(list(folders), out))


def tune_trainable(
    scenario: Scenario,
    *,
    settings: Mapping[str, Any] | None = None,
    folder: str | os.PathLike[str] | None = None,
    sandbox: Sandbox | None = None,
) -> Callable[[Mapping[str, Any]], dict[str, float]]:
    """A trainable for Ray Tune: runs the scenario with the keys of a trial's `config`, and gives back the numbers of its summary.

    >>> tune.Tuner(ilon.tune_trainable("scenario.toml"), param_space={"wheel_loop.bandwidth_rad_s": tune.uniform(5, 60)})

    `settings` changes keys in all trials. It serves any optimiser that calls a function, Optuna's `study.optimize` included. A
    scenario that cannot be run raises, which Tune counts as an error of that trial.
    """
    # Tune runs trials in folders of their own.
    scenario, folder = absolute(scenario, folder)
    sandbox = None if sandbox is None else [Path(each).absolute() for each in folders(sandbox)]

    def trial(config: Mapping[str, Any]) -> dict[str, float]:
        return run(scenario, settings={**(settings or {}), **config}, folder=folder, sandbox=sandbox).figures

    return trial
