"""Studies on a Ray cluster: tasks simulate batches of runs, and the caller collects their rows.

A task simulates some parts of a study and returns their rows as text. It reads the study's files on
its node; the fingerprint tells whether they are the same. If workers or nodes are lost, Ray repeats
their tasks elsewhere.
"""

from __future__ import annotations

import math
import os
import time
import warnings
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from . import _ilon
from .errors import Error
from .runs import Sandbox, folders

# Target duration of a task, in seconds; chosen: long compared with Ray's overhead of milliseconds,
# short compared with the cost of losing it.
_TASK_S = 2.0
# Submitted tasks per task that can run at a time: when one ends the next is ready.
_HANDED_OUT = 2
# Least number of submitted tasks, so that a cluster that scales with its queue does so.
_HANDED_OUT_LEAST = 4
# Retries of a task whose worker or node was lost.
_RETRIES = 5
# Interval of checks whether the cluster has grown or shrunk, in seconds.
_LOOK_S = 1.0
# Longest time for a cluster to add a node that is large enough for a task, in seconds: an
# autoscaler needs minutes.
_PATIENCE_S = 600.0


@dataclass(frozen=True)
class _Order:
    """Data shared by all tasks of a study."""

    version: str
    """Of ilon."""
    fingerprint: str
    """Of the study as the caller reads it."""
    text: str
    """The study file."""
    paths: tuple[str, ...]
    """Where the study file lies, as the caller names it and from the root."""
    jobs: int
    """Runs at a time."""
    folder: str | None
    """That of the study's results, as the caller sees it, from the root."""
    sandbox: tuple[tuple[str, ...] | None, ...]
    """The folders below which alone files are read, for each of `paths`; None where any are."""


def _ray() -> ModuleType:
    try:
        import ray
    except ImportError as missing:
        raise ImportError("studies on Ray need it: pip install ray") from missing
    return ray


def connect() -> None:
    """Connects to the cluster that the program or its environment names, or starts Ray on this machine, unless it is connected."""
    ray = _ray()
    if not ray.is_initialized():
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        ray.init()


def make(
    study: _ilon.Study,
    rows: _ilon.Rows,
    jobs: int,
    progress: Callable[[int, int], object] | None,
    sandbox: Sandbox | None = None,
) -> None:
    """Makes all rows of a study that are missing, on the cluster. `jobs` is how many CPUs a task takes, and how many runs it makes at a
    time. Where no node has so many, the tasks are handed out all the same, so that a cluster that grows does so, and a warning says it;
    they are waited for as long as `_PATIENCE_S`.

    Raises `ilon.Error` where the cluster cannot make them: rows that were made by then are there.
    """
    ray = _ray()
    missing = deque(rows.missing())
    if not missing:
        return
    path, folder = Path(study.path), rows.folder
    order = ray.put(
        _Order(
            version=_ilon.__version__,
            fingerprint=study.fingerprint,
            text=study.text,
            paths=(str(path), str(path.absolute())),
            jobs=jobs,
            folder=None if folder is None else str(Path(folder).absolute()),
            sandbox=_sandboxes(sandbox),
        )
    )
    task = ray.remote(num_cpus=jobs, max_retries=_RETRIES)(_work)
    under_way: dict[Any, list[int]] = {}
    each_s: float | None = None
    too_small_since_s: float | None = None
    # If this ends early, the running tasks continue to their end: Ray's `cancel` sometimes aborts
    # the caller's process if a task ends at that moment ("Tried to complete task that was not
    # pending", seen with Ray 2.60 in 4 of 85 interrupts).
    while missing or under_way:
        at_a_time = max(1, int(ray.cluster_resources().get("CPU", 0)) // jobs)
        while missing and len(under_way) < max(_HANDED_OUT * at_a_time, _HANDED_OUT_LEAST):
            count = _batch(len(missing), at_a_time, jobs, each_s)
            parts = [missing.popleft() for _ in range(count)]
            under_way[task.remote(order, parts)] = parts
        ready, _ = ray.wait(list(under_way), timeout=_LOOK_S)
        too_small_since_s = _patience(ray, jobs, too_small_since_s)
        for reference in ready:
            parts = under_way.pop(reference)
            made, took_s = _result(ray, reference, parts)
            rows.put(made)
            # The newest counts most: runs late in a study may be longer than the first.
            newest_s = took_s / len(parts)
            each_s = newest_s if each_s is None else 0.5 * (each_s + newest_s)
            if progress is not None:
                progress(rows.done, rows.most)


def _patience(ray: ModuleType, jobs: int, since_s: float | None) -> float | None:
    """The time since which no node of the cluster has been large enough for a task; None while one
    is. Prints a message once, and gives up in the end.
    """
    most_cpus = max((node["Resources"].get("CPU", 0) for node in ray.nodes() if node["Alive"]), default=0)
    if jobs <= most_cpus:
        return None
    now_s = time.monotonic()
    lacks = f"no node of the Ray cluster has {jobs} CPUs for a task of the study, but {most_cpus:g} at most"
    if since_s is None:
        warnings.warn(f"{lacks}; its tasks wait until one has, for at most {_PATIENCE_S:g} s", stacklevel=4)
        return now_s
    if now_s - since_s > _PATIENCE_S:
        raise Error(
            f"{lacks}, and none came in {_PATIENCE_S:g} s",
            f"let the cluster grow nodes of {jobs} CPUs or more, or give fewer jobs; the same call with the same out continues",
        )
    return since_s


def _sandboxes(sandbox: Sandbox | None) -> tuple[tuple[str, ...] | None, ...]:
    """The folders of a sandbox as the caller names them and as absolute paths, as the study's file
    has.
    """
    if sandbox is None:
        return None, None
    named = folders(sandbox)
    return tuple(os.fspath(each) for each in named), tuple(str(Path(each).absolute()) for each in named)


def _batch(missing: int, at_a_time: int, jobs: int, each_s: float | None) -> int:
    """The number of parts in the next task."""
    if each_s is None:
        return min(jobs, missing)
    by_time = _TASK_S / max(each_s, 1e-9)
    # Towards the end tasks get shorter, so that none runs alone.
    by_end = math.ceil(missing / (_HANDED_OUT * at_a_time))
    return max(1, min(missing, max(jobs, int(min(by_time, by_end)))))


def _result(ray: ModuleType, reference: Any, parts: list[int]) -> tuple[bytes, float]:
    """The result of a task."""
    try:
        result: tuple[bytes, float] = ray.get(reference)
    except ray.exceptions.RayError as fault:
        cause = getattr(fault, "cause", None)
        if isinstance(cause, Error):
            raise cause from None
        if isinstance(cause, ImportError):
            raise Error(
                f"a worker of Ray cannot use ilon: {cause}",
                "install the same version of ilon on all nodes, or name it in ray.init(runtime_env={'pip': [...]})",
            ) from fault
        reason = (str(fault).splitlines() or [type(fault).__name__])[0]
        raise Error(
            f"Ray could not make {len(parts)} runs, the first of them {parts[0]}: {reason}",
            "start it again with the same out: what was made by then is not made again",
        ) from fault
    return result


# The newest study that this process has read: workers process one after the other.
_read: dict[str, _ilon.Study] = {}


def _work(order: _Order, parts: list[int]) -> tuple[bytes, float]:
    """A task: the rows of some parts, and their duration in seconds."""
    if _ilon.__version__ != order.version:
        raise Error(
            f"a worker of Ray has ilon {_ilon.__version__}, and this is ilon {order.version}: rows are not mixed",
            "install the same version of ilon on all nodes, or name it in ray.init(runtime_env={'pip': [...]})",
        )
    if order.fingerprint not in _read:
        _read.clear()
        _read[order.fingerprint] = _study(order)
    study = _read[order.fingerprint]
    begun_s = time.perf_counter()
    rows = study.make(parts, jobs=order.jobs, folder=order.folder)
    return rows, time.perf_counter() - begun_s


def _study(order: _Order) -> _ilon.Study:
    """The study as read here; it must be the same as the caller's."""
    reason = "the scenarios or robots are others than there"
    for path, sandbox in zip(order.paths, order.sandbox, strict=True):
        try:
            study = _ilon.Study.of_text(order.text, path, sandbox=sandbox)
        except Error as fault:
            reason = fault.message
            continue
        if study.fingerprint == order.fingerprint:
            return study
    raise Error(
        f"a worker of Ray does not read the study `{order.paths[-1]}` as this process does: {reason}",
        "let all nodes see its scenarios and robots at the same place, or hand them out: start the program in their folder with "
        "ray.init(runtime_env={'working_dir': '.'}), and name the study by a path from there",
    )
