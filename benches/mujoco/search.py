#!/usr/bin/env python3
"""Searches MuJoCo's settings for its best trade of speed against accuracy on the described robots.

Every candidate runs all five drives. From hand-set beginnings, random changes of members of the front (nothing else is
both faster and more accurate) are tried; what joins the front is changed further. Writes `tuned.json`, from which
`side_by_side.py` takes the tuned configurations; what is in it already is among the beginnings.

  search.py --evaluations 300 --robots ../../assets/robots/mecanum4.toml ../../assets/robots/volksbot.toml
"""

from __future__ import annotations

import argparse
import json
import os
import random
import sys
from dataclasses import asdict, replace
from pathlib import Path

from drives import OTHER_SPEEDS, RATE_SHORTFALL_MAX, Bench, Measured
from model import Settings
from robot import Robot

HERE = Path(__file__).parent
# Worse than this is of no use to anybody; the front ends here.
GIVE_UP_PCT = 2.0
CHOICES = {
    "cone": ["pyramidal", "elliptic"],
    "impratio": [1.0, 2.0, 3.0, 5.0, 10.0, 30.0, 100.0],
    "integrator": ["implicitfast", "implicit", "Euler"],
    "jacobian": ["dense", "sparse"],
    "solver": ["Newton", "CG", "PGS"],
    "iterations": [1, 2, 3, 4, 6, 10, 100],
    "tolerance": [1e-8, 1e-6, 1e-5, 1e-4, 1e-3],
    "refsafe": [True, False],
    "island": [True, False],
    "armature_ratio": [0.0, 1.0, 3.0, 10.0],
    "shape": ["ellipsoid", "capsule"],
}
SERVOS_N_M_S = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0]
TIME_CONSTANTS_S = [0.002, 0.004, 0.006, 0.008, 0.01, 0.012, 0.016, 0.02, 0.024, 0.03, 0.04]
DAMPING_RATIOS = [0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0]
IMPEDANCES = [0.5, 0.7, 0.8, 0.9, 0.95, 0.97, 0.98, 0.99, 0.995, 0.999, 0.9999]
# Bandwidth of the wheel loop on the ground, and whether a wheel in the air bounds it.
LOOPS = [(60.0, True), (60.0, False), (30.0, False), (10.0, False), (4.0, False)]
WIDTHS_M = [1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3]


def beginnings(drive: str):
    for dt_s in (0.001, 0.002, 0.004, 0.008, 0.012, 0.016):
        base = Settings(dt_s=dt_s, drive=drive, jacobian="sparse")
        yield replace(base, cone="elliptic", solref=(0.002, 1.0))
        yield replace(base, cone="elliptic", solimp=(0.99, 0.999, 1e-4))
        yield replace(base, cone="pyramidal", impratio=10.0)
        yield replace(base, cone="pyramidal", solimp=(0.99, 0.999, 1e-4))
        if drive == "pi":
            yield replace(base, cone="elliptic", solimp=(0.99, 0.999, 1e-4), loop_rad_s=10.0, loop_air_bound=False)


def changed(s: Settings, rng: random.Random) -> Settings:
    """One to three random changes."""
    for _ in range(rng.choice([1, 1, 2, 3])):
        what = rng.choice(["dt", "dt", "solref", "solref", "solimp", "solimp", "servo", *CHOICES])
        if what == "dt":
            s = replace(s, dt_s=min(max(round(2000 * s.dt_s * rng.choice([0.8, 0.9, 1.1, 1.25, 1.5])), 2), 60) / 2000)
        elif what == "solref":
            s = replace(s, solref=(rng.choice(TIME_CONSTANTS_S), rng.choice(DAMPING_RATIOS)))
        elif what == "solimp":
            least, most = sorted(rng.sample(IMPEDANCES, 2))
            s = replace(s, solimp=(least, most, rng.choice(WIDTHS_M)))
        elif what == "servo" and s.drive == "servo":
            s = replace(s, servo_n_m_s=rng.choice(SERVOS_N_M_S))
        elif what == "servo":
            loop_rad_s, air_bound = rng.choice(LOOPS)
            s = replace(s, loop_rad_s=loop_rad_s, loop_air_bound=air_bound)
        else:
            s = replace(s, **{what: rng.choice(CHOICES[what])})
    return s


def front(candidates: list[Measured]) -> list[Measured]:
    """Those than which none is both faster and more accurate, most accurate first."""
    out: list[Measured] = []
    for m in sorted(candidates, key=lambda m: (m.any_speed_error_pct, -m.sim_s_per_cpu_s)):
        does = m.any_speed_error_pct <= GIVE_UP_PCT and m.rate_shortfall <= RATE_SHORTFALL_MAX
        if does and (not out or m.sim_s_per_cpu_s > out[-1].sim_s_per_cpu_s):
            out.append(m)
    return out


def search(
    robot: Robot, drive: str, evaluations: int, seed: int, known: list[Settings], speeds: tuple
) -> list[Measured]:
    rng = random.Random(seed)
    seen, done = set(), []
    queue = [*known, *beginnings(drive)]
    while len(done) < evaluations:
        s = queue.pop(0) if queue else changed(rng.choice(front(done)).settings, rng)
        if s in seen:
            continue
        seen.add(s)
        done.append(Bench(robot, s).all(stretches=3, give_up_pct=GIVE_UP_PCT, speeds=speeds))
        if len(done) % 50 == 0:
            print(f"{robot.name} {drive}: {len(done)} tried, {len(front(done))} on the front", file=sys.stderr)
    # The front again with more stretches, since a lucky one would stay on it.
    return front([Bench(robot, m.settings).all(stretches=8, speeds=speeds) for m in front(done)])


def load(path: Path, robot: str) -> list[Settings]:
    """The settings that an earlier search wrote for a robot."""
    rows = json.loads(path.read_text()) if path.exists() else []
    tuples = lambda s: {k: tuple(v) if isinstance(v, list) else v for k, v in s.items()}
    return [Settings(**tuples(row["settings"])) for row in rows if row["robot"] == robot]


def main() -> None:
    robots = HERE.parent.parent / "assets" / "robots"
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=[robots / "mecanum4.toml", robots / "volksbot.toml"])
    parser.add_argument("--drives", nargs="+", default=["servo", "pi"], choices=["servo", "pi"])
    parser.add_argument("--evaluations", type=int, default=300, help="candidates a robot and wheel drive")
    parser.add_argument(
        "--any-speed", action="store_true", help="accuracy that holds at half and 1.5 times the speed too"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--core", type=int, help="run on this core only")
    parser.add_argument("--out", type=Path, default=HERE / "tuned.json")
    args = parser.parse_args()
    if args.core is not None:
        os.sched_setaffinity(0, {args.core})
    found = {}
    for path in args.robots:
        robot = Robot(path)
        found[robot.name] = {}
        for drive in args.drives:
            known = [s for s in load(args.out, robot.name) if s.drive == drive]
            members = search(robot, drive, args.evaluations, args.seed, known, OTHER_SPEEDS if args.any_speed else ())
            # What was known stays: the fronts at one speed and at all speeds are different ones.
            found[robot.name][drive] = [asdict(s) for s in dict.fromkeys([*known, *(m.settings for m in members)])]
            for m in members:
                print(
                    f"{robot.name} {drive} {1e3 * m.settings.dt_s:5.1f} ms {m.any_speed_error_pct:7.4f} % "
                    f"{1e3 * m.hub_ripple_m:6.3f} mm {m.sim_s_per_cpu_s:6.0f} sim s/s  {m.settings.words()}",
                    flush=True,
                )
    lines = []
    for name, drives in found.items():
        for settings in drives.values():
            lines += [json.dumps({"robot": name, "settings": s}) for s in settings]
    args.out.write_text("[\n  " + ",\n  ".join(lines) + "\n]\n")


if __name__ == "__main__":
    main()
