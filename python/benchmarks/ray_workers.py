"""What Ray costs a study: 1, 2 and 4 workers on this machine, beside `ilon.sweep` without it.

    python python/benchmarks/ray_workers.py [--runs 1000] [--workers 1 2 4]

Of each it prints the time, the share of it that the workers spent in runs (what is lost goes into handing out tasks, gathering rows and waiting
for the last), and the time of the same study in threads of one process. That rows are equal is checked.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")

import ray  # noqa: E402

import ilon  # noqa: E402
from ilon import _ray  # noqa: E402

SCENARIO = Path(__file__).resolve().parents[2] / "assets" / "scenarios" / "mecanum4_lateral.toml"


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2, 4])
    arguments = parser.parse_args()

    def study(runs: int) -> dict:
        axes = {"world.floor.friction": {"from": 0.4, "to": 0.9}}
        return {"scenario": str(SCENARIO), "method": "latin_hypercube", "points": runs, "axes": axes}

    in_runs_s = 0.0
    result = _ray._result

    def counted(*given):
        nonlocal in_runs_s
        rows, took_s = result(*given)
        in_runs_s += took_s
        return rows, took_s

    _ray._result = counted
    for workers in arguments.workers:
        ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False)
        # Workers start, and read the robot.
        ilon.sweep(study(20 * workers), on="ray")
        in_runs_s, begun_s = 0.0, time.perf_counter()
        there = ilon.sweep(study(arguments.runs), on="ray")
        took_s, share = time.perf_counter() - begun_s, in_runs_s
        share /= workers * took_s
        ray.shutdown()
        begun_s = time.perf_counter()
        here = ilon.sweep(study(arguments.runs), jobs=workers)
        local_s = time.perf_counter() - begun_s
        assert there["key"] == here["key"] and there["trace_hash"] == here["trace_hash"]
        print(
            f"{workers} workers: {took_s:.1f} s, {100 * share:.1f} % of it in runs; without Ray {local_s:.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
