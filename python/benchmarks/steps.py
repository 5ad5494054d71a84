"""What a physics step costs the task of `ilon/Track-v0`: how far off its robot ends, how much it slips too much, and how fast it runs.

    python python/benchmarks/steps.py             # prints the table, some minutes
    python python/benchmarks/steps.py --write     # and puts it into docs/python.md
    python python/benchmarks/steps.py --check     # holds the errors of that page against new ones; speed is the machine's matter

The robot of the task drives random twists without feedback, as a policy does that begins to learn: each of vx, vy and omega is an
autoregressive walk, drawn anew every control period of 20 ms. After 3 m of the way its place is held against that of steps of
0.125 ms, and so is what its sliding contacts lost until then; and what they lose on the path of the task under guidance, where wheels hardly slide.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import throughput

import ilon
import ilon.gym

PAGE = Path(__file__).resolve().parents[2] / "docs" / "python.md"
BEGINS, ENDS = "<!-- written by python/benchmarks/steps.py -->", "<!-- ends -->"

STEPS_S = (0.02, 0.01, 0.005, 0.004, 0.0025, 0.001)
LIMIT_S = 0.000125
"""Steps that are taken for the truth."""
DRIVES = 6
WAY_M = 3.0
LONGEST_S = 14.0
CONTROL_DT_S = 0.02

RIGHT_MM = 5.0
"""The error of a step that is right, in mm after `WAY_M`."""
RIGHT_SLIP = 0.1
"""By what share of it slip energy may be off, in drives that slide and on the path of the task."""


def twists(seed: int) -> np.ndarray:
    """Random twists, in m/s, m/s and rad/s, one per control period: standard deviations 0.34, 0.34
    and 1.0, correlated over 0.2 s.
    """
    rng, rows = np.random.default_rng(seed), [np.zeros(3)]
    for _ in range(round(LONGEST_S / CONTROL_DT_S)):
        rows.append(0.9 * rows[-1] + 0.15 * rng.standard_normal(3) * [1.0, 1.0, 3.0])
    return np.array(rows)


@dataclass(frozen=True)
class Drive:
    """The poses of a drive, and its losses so far, one row per control period."""

    places_m: np.ndarray
    slip_j: np.ndarray

    def after(self) -> int:
        """The row at which the path has the length `WAY_M`."""
        way_m = np.hypot(*np.diff(self.places_m, axis=0).T).cumsum()
        return int(np.searchsorted(way_m, WAY_M))


def driven(step_s: float | str, seed: int) -> Drive:
    """The task's robot with the twists of a seed, at a given physics step."""
    settings = {"run.physics_dt_s": step_s, "run.control_dt_s": CONTROL_DT_S, "run.duration_s": LONGEST_S}
    robot, asked = ilon.Simulation(ilon.gym.FIGURE_EIGHT, settings=settings), twists(seed)

    def blind(now: ilon.Observation, _: ilon.Desired | None) -> np.ndarray:
        return robot.wheel_rates(asked[round(now.t_s / CONTROL_DT_S)])

    trace = ilon.run(ilon.gym.FIGURE_EIGHT, settings=settings, controller=blind).trace
    return Drive(np.stack([trace["truth_x_m"], trace["truth_y_m"]], axis=1), trace["slip_energy_j"])


def followed_j(step_s: float | str) -> float:
    """The heat of sliding on the task's path with its guidance, in J."""
    run = ilon.run(ilon.gym.FIGURE_EIGHT, settings={"run.physics_dt_s": step_s, "run.control_dt_s": CONTROL_DT_S})
    return run.summary["slip_energy_j"]


@dataclass(frozen=True)
class Limit:
    """The results of steps of `LIMIT_S`, which serve as the reference."""

    drives: list[Drive]
    followed_j: float

    @classmethod
    def found(cls) -> Limit:
        """Simulates it."""
        return cls([driven(LIMIT_S, seed) for seed in range(DRIVES)], followed_j(LIMIT_S))


@dataclass(frozen=True)
class Cost:
    """The errors of a step against `LIMIT_S`, and its speed."""

    rms_mm: float
    """How far the robot is off after `WAY_M`, root mean square over the drives."""
    worst_mm: float
    slip_share: float
    """By what share all drives lose more to sliding."""
    followed_share: float
    """The same on the path of the task, under guidance."""

    def is_right(self) -> bool:
        """Whether the step may be a task's default."""
        return self.rms_mm < RIGHT_MM and max(abs(self.slip_share), abs(self.followed_share)) < RIGHT_SLIP


def cost(step_s: float | str, limit: Limit) -> Cost:
    """The errors and the speed of a step."""
    off_m, slip_j, limit_j = [], 0.0, 0.0
    for seed, true in enumerate(limit.drives):
        drive, row = driven(step_s, seed), true.after()
        off_m.append(np.hypot(*(drive.places_m[row] - true.places_m[row])))
        slip_j, limit_j = slip_j + drive.slip_j[row], limit_j + true.slip_j[row]
    off_mm = 1e3 * np.array(off_m)
    return Cost(float(np.sqrt(np.mean(off_mm**2))), float(off_mm.max()), float(slip_j / limit_j) - 1.0, followed_j(step_s) / limit.followed_j - 1.0)


def default_step_s() -> float:
    """The default step of the task."""
    return ilon.Simulation(ilon.gym.FIGURE_EIGHT).physics_dt_s


def errors_of(cost: Cost) -> str:
    """The columns that do not depend on the machine."""
    return f"{cost.rms_mm:.1f} mm | {cost.worst_mm:.1f} mm | {100 * cost.slip_share:+.0f} % | {100 * cost.followed_share:+.0f} %"


def table(costs: dict[float, Cost], seconds: float) -> str:
    """The table of the page, with the speed of this machine."""
    lines = [
        f"| physics step | open loop, off after {WAY_M:.0f} m, rms | worst of {DRIVES} drives | its slip energy | slip energy on the path | one robot, control steps/s a core"
        f" | {throughput.ROBOTS} robots, a core |",
        "|---|---|---|---|---|---|---|",
    ]
    for step_s, found in costs.items():
        name = f"{1e3 * step_s:g} ms" + (", the task's" if step_s == default_step_s() else "")
        rates = [throughput.of_ilon(seconds, step_s, robots)[1] for robots in (1, throughput.ROBOTS)]
        one, many = (f"{round(rate, -2):,.0f}".replace(",", " ") for rate in rates)
        lines.append(f"| {name} | {errors_of(found)} | {one} | {many} |")
    return "\n".join(lines)


def written(text: str) -> str:
    """The page's text between its marks."""
    begins, ends = text.index(BEGINS) + len(BEGINS), text.index(ENDS)
    return text[begins:ends].strip()


def check(costs: dict[float, Cost], page: str) -> list[str]:
    """Errors in the page's table, and in the default step."""
    faults, rows = [], [line for line in written(page).splitlines() if re.match(r"\| [0-9.]+ ms", line)]
    for (step_s, found), row in zip(costs.items(), rows, strict=True):
        name, *columns = (cell.strip() for cell in row.strip("|").split("|"))
        if not name.startswith(f"{1e3 * step_s:g} ms") or " | ".join(columns[:4]) != errors_of(found):
            faults.append(f"{row!r} is now {1e3 * step_s:g} ms | {errors_of(found)}")
        if ("the task's" in name) != (step_s == default_step_s()):
            faults.append(f"{row!r}: the task's step is {1e3 * default_step_s():g} ms")
        if step_s == default_step_s() and not found.is_right():
            faults.append(f"the task's step is wrong: {found}; take another in {ilon.gym.FIGURE_EIGHT.name}")
    return faults


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=5.0, help="how long each speed is measured")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    limit = Limit.found()
    costs = {step_s: cost(step_s, limit) for step_s in STEPS_S}
    page = PAGE.read_text()
    if arguments.check:
        if faults := check(costs, page):
            sys.exit("\n".join([*faults, "write them anew: python python/benchmarks/steps.py --write"]))
        return
    anew = table(costs, arguments.seconds)
    print(anew)
    if arguments.write:
        PAGE.write_text(page.replace(written(page), anew))


if __name__ == "__main__":
    main()
