#!/usr/bin/env python3
"""MuJoCo and ilon on the same robots, drives and measure, in one session: accuracy against speed.

  side_by_side.py --ilon ../../target/release/ilon --json speed.json --svg ../../docs/speed.svg > table.md

Without --ilon only the MuJoCo half runs. Speed is simulated seconds per CPU second. MuJoCo's is pure stepping inside
the library, the best of all stretches of each drive; ilon's is that of `ilon bench`, the best of all stretches of each
drive too, which counts the wheel loops and the recording as well. The rounds of both alternate, so that both meet the same
noise of the machine.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from pathlib import Path

import mujoco
import numpy as np

import ilon
from check import check
from drives import OTHER_SPEEDS, RATE_SHORTFALL_MAX, Bench
from model import Settings
from plot import svg
from robot import Robot
from search import load

HERE = Path(__file__).parent
ROBOTS = HERE.parent.parent / "assets" / "robots"
# The error in per cent up to which a configuration counts, for each robot; the first of each is the one that is asked
# of a simulation of this robot, the others show the rest of the curve.
LIMITS_PCT = {"mecanum4": (0.4, 0.2, 0.1, 0.05), "volksbot": (0.1, 0.05, 0.03)}


def sweeps(drive: str):
    """Hand-set configurations over a range of steps: name and settings."""

    def at(name, milliseconds, **settings):
        return [(name, Settings(dt_s=1e-3 * ms, drive=drive, **settings)) for ms in milliseconds]

    hard = {"cone": "elliptic", "solimp": (0.99, 0.999, 1e-4), "jacobian": "sparse"}

    def looped(loop_rad_s):
        loop = {"loop_rad_s": loop_rad_s, "loop_air_bound": False}
        return at(f"hard, loop {loop_rad_s:g} rad/s", (4, 8, 12, 16), **loop, **hard)

    return [
        *at("defaults", (1, 2, 4, 8, 12)),
        *at("stiff", (0.5, 1, 2, 4, 8), cone="elliptic", solref=(0.002, 1.0)),
        *at("hard", (2, 4, 8, 12, 16), **hard),
        *[row for loop in (10.0, 4.0) if drive == "pi" for row in looped(loop)],
        *at("friction first", (2, 4, 8, 12), impratio=10.0, jacobian="sparse"),
        *at("hard, capsules", (4, 8), shape="capsule", **hard),
        *at("stiff, capsules", (1, 2), shape="capsule", cone="elliptic", solref=(0.002, 1.0)),
        *at("hard, meshes", (4, 8), shape="mesh", **hard),
        *at("stiff, meshes", (1, 2), shape="mesh", cone="elliptic", solref=(0.002, 1.0)),
    ]


def tuned(path: Path, robot: str, drive: str):
    """The front that `search.py` found."""
    return [("tuned", s) for s in load(path, robot) if s.drive == drive]


def mujoco_row(name: str, bench: Bench) -> dict:
    m = bench.measured
    return {
        "engine": "MuJoCo",
        "name": name,
        "drive": m.settings.drive,
        "words": m.settings.words(),
        "dt_s": m.settings.dt_s,
        **m.row(),
    }


def fastest(rows: list[dict], engine: str, drive: str | None, limit_pct: float, error="worst_error_pct") -> dict | None:
    """The fastest configuration whose error is within the limit, and which does the drives at all."""
    fits = [r for r in rows if r["engine"] == engine and drive in (None, r["drive"])]
    fits = [r for r in fits if r[error] is not None and r[error] <= limit_pct]
    does = [r for r in fits if (r["rate_shortfall"] or 0.0) <= RATE_SHORTFALL_MAX]
    return max(does, key=lambda r: r["sim_s_per_cpu_s"], default=None)


def measure(args, robots: list[Robot]) -> dict[str, list[dict]]:
    """All rows by robot."""
    benches = {
        robot.name: [
            (name, Bench(robot, settings))
            for drive in ("servo", "pi")
            for name, settings in [*sweeps(drive), *tuned(args.tuned, robot.name, drive)]
        ]
        for robot in robots
    }
    for name, members in benches.items():
        for _, bench in members:
            bench.all(stretches=1, speeds=OTHER_SPEEDS)
        print(f"{name}: {len(members)} MuJoCo configurations run", file=sys.stderr)
    best: dict[str, dict[tuple, dict]] = {robot.name: {} for robot in robots}
    for number in range(1, args.rounds + 1):
        if args.ilon:
            benched = ilon.bench_rows(args.ilon, robots, args.stretches)
            for robot in robots:
                for row in benched[robot.name]:
                    key = (row["name"], row["words"], round(1e6 * row["dt_s"]))
                    old = best[robot.name].get(key)
                    if old is None:
                        best[robot.name][key] = row
                        continue
                    old["sim_s_per_cpu_s"] = max(old["sim_s_per_cpu_s"], row["sim_s_per_cpu_s"])
        for members in benches.values():
            for _, bench in members:
                for drive in bench.measured.outcomes:
                    bench.time(drive, stretches=args.stretches)
        print(f"round {number} of {args.rounds} done", file=sys.stderr)
    for robot in robots:
        for row in best[robot.name].values():
            ilon.complete(args.ilon, robot, row)
    rows = {
        name: [*best[name].values(), *(mujoco_row(label, bench) for label, bench in members)]
        for name, members in benches.items()
    }
    return rows


def line(row: dict) -> str:
    percent = lambda x: "" if x is None else f"{x:.4f}" if np.isfinite(x) else "diverges"
    ripple, shortfall = row["hub_ripple_m"], row["rate_shortfall"]
    known = lambda x: x is not None and np.isfinite(x)
    name = f"{row['engine']}, {row['name']}"
    if row["words"] and (row["engine"] == "ilon" or row["name"] == "tuned"):
        name += f": {row['words']}"
    return (
        f"| {name} | {row['drive']} | {1e3 * row['dt_s']:.2f} | {percent(row['worst_error_pct'])} "
        f"| {percent(row['any_speed_error_pct'])} "
        f"| {f'{1e3 * ripple:.4f}' if known(ripple) else ''} | {f'{100 * shortfall:.1f}' if known(shortfall) else ''} "
        f"| {row['sim_s_per_cpu_s']:.0f} | {row['sim_s_per_cpu_s'] / row['dt_s']:.0f} |"
    )


def equal_accuracy(robot: str, rows: list[dict], title: str, error: str) -> list[str]:
    out = [
        f"\n### {robot}: {title}\n",
        "| error at most, % | ilon, own gains | ilon, any loop | MuJoCo, servo | MuJoCo, PI loop "
        "| any loop over servo | over PI loop |",
        "|---|---|---|---|---|---|---|",
    ]
    show = lambda b: f"{b['sim_s_per_cpu_s']:.0f} ({1e3 * b['dt_s']:.3g} ms)" if b else "none"
    for limit_pct in LIMITS_PCT[robot]:
        own = fastest([r for r in rows if not r["words"]], "ilon", None, limit_pct, error)
        any_loop = fastest(rows, "ilon", None, limit_pct, error)
        others = [fastest(rows, "MuJoCo", drive, limit_pct, error) for drive in ("servo", "pi")]
        over = lambda one, o: f"{one['sim_s_per_cpu_s'] / o['sim_s_per_cpu_s']:.2f}" if one and o else ""
        ratios = [over(any_loop, o) for o in others]
        out.append(f"| {limit_pct} | {' | '.join(map(show, [own, any_loop, *others]))} | {' | '.join(ratios)} |")
    return out


def same_loop(robot: str, rows: list[dict]) -> list[str]:
    """Both engines under one and the same wheel loop, each at its own best step."""
    limit_pct = LIMITS_PCT[robot][0]
    out = [
        f"\n### {robot}: the same wheel loop, error at most {limit_pct} %\n",
        "| bandwidth on the ground | ilon, sim s/CPU s | MuJoCo | ilon over MuJoCo |",
        "|---|---|---|---|",
    ]
    show = lambda r: f"{r['sim_s_per_cpu_s']:.0f} ({1e3 * r['dt_s']:.3g} ms)" if r else "none"
    for loop in ilon.LOOPS_RAD_S:
        asked = (60.0, True) if loop is None else (loop, False)
        given = [r for r in rows if r["engine"] == "ilon" and r["loop_rad_s"] == loop]
        for r in rows:
            if r["drive"] == "pi" and r["engine"] == "MuJoCo":
                given += [r] if (r["settings"]["loop_rad_s"], r["settings"]["loop_air_bound"]) == asked else []
        own, other = (fastest(given, engine, None, limit_pct) for engine in ("ilon", "MuJoCo"))
        ratio = f"{own['sim_s_per_cpu_s'] / other['sim_s_per_cpu_s']:.2f}" if own and other else ""
        name = "60 rad/s, or what a wheel in the air allows" if loop is None else f"{loop:g} rad/s"
        out.append(f"| {name} | {show(own)} | {show(other)} | {ratio} |")
    return out


def equal_steps(robot: str, rows: list[dict]) -> list[str]:
    out = [
        f"\n### {robot}: equal steps\n",
        "| step, ms | ilon all, steps/CPU s (error, %) | ilon near | MuJoCo, servo | MuJoCo, PI loop | near/servo |",
        "|---|---|---|---|---|---|",
    ]
    show = lambda r: f"{r['sim_s_per_cpu_s'] / r['dt_s']:.0f} ({r['worst_error_pct']:.3f})" if r else "none"
    for step_s in (0.001, 0.002, 0.004, 0.008, 0.016):
        # ilon's steps are whole parts of a second: 240, 120 and 60 Hz stand beside 4, 8 and 16 ms.
        here = [r for r in rows if abs(r["dt_s"] / step_s - 1) < 0.05]
        limit_pct = LIMITS_PCT[robot][0]
        of_ilon = [[r for r in here if r["name"] == name] for name in ("all rollers", "near rollers")]
        cells = [fastest(rows, "ilon", None, limit_pct) for rows in of_ilon]
        cells += [fastest(here, "MuJoCo", drive, limit_pct) for drive in ("servo", "pi")]
        near, servo = cells[1], cells[2]
        ratio = ""
        if near and servo:
            ratio = f"{near['sim_s_per_cpu_s'] / near['dt_s'] * servo['dt_s'] / servo['sim_s_per_cpu_s']:.2f}"
        out.append(f"| {1e3 * step_s:g} | {' | '.join(map(show, cells))} | {ratio} |")
    return out


def thinned(rows: list[dict]) -> list[dict]:
    """All rows, but of the tuned ones only those that are 5 % faster than every more accurate one."""
    out, fastest_yet = [], {}
    for row in sorted(rows, key=lambda r: r["worst_error_pct"] if r["name"] == "tuned" else -1.0):
        if row["name"] == "tuned":
            if row["sim_s_per_cpu_s"] < 1.05 * fastest_yet.get(row["drive"], 0.0):
                continue
            fastest_yet[row["drive"]] = row["sim_s_per_cpu_s"]
        out.append(row)
    return sorted(
        out, key=lambda r: (r["engine"] != "ilon", r["name"] == "tuned", r["drive"] == "pi" and r["name"] == "tuned")
    )


def tables(rows: dict[str, list[dict]]) -> str:
    out = []
    for robot, all_rows in rows.items():
        out += equal_accuracy(robot, all_rows, "equal accuracy", "worst_error_pct")
        out += equal_accuracy(
            robot, all_rows, "equal accuracy at half, full and 1.5 times the speed", "any_speed_error_pct"
        )
        out += same_loop(robot, all_rows)
        out += equal_steps(robot, all_rows)
        out += [
            f"\n### {robot}: work against precision\n",
            "| configuration | wheel drive | step, ms | worst error, % | at 0.5-1.5 times the speed | hub ripple, mm "
            "| rates missed by, % | sim s/CPU s | steps/CPU s |",
            "|---|---|---|---|---|---|---|---|---|",
        ]
        out += [line(row) for row in thinned(all_rows)]
        out.append("")
    return "\n".join(out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ilon", help="path of an ilon built with --release")
    parser.add_argument("--robots", nargs="+", type=Path, default=[ROBOTS / "mecanum4.toml", ROBOTS / "volksbot.toml"])
    parser.add_argument("--tuned", type=Path, default=HERE / "tuned.json", help="settings that search.py found")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument(
        "--stretches", type=int, default=3, help="timed stretches a drive and round, one simulated s each"
    )
    parser.add_argument("--core", type=int, help="run all on this core only")
    parser.add_argument("--json", type=Path, help="write everything that was measured")
    parser.add_argument("--svg", type=Path, help="draw error against speed")
    args = parser.parse_args()
    if args.core is not None:
        os.sched_setaffinity(0, {args.core})
    robots = [Robot(path) for path in args.robots]
    findings = [finding for robot in robots for finding in check(robot)]
    rows = measure(args, robots)
    versions = {
        "ilon": ilon.version(args.ilon) if args.ilon else "",
        "mujoco": mujoco.__version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
        "machine": _processor(),
    }
    if args.json:
        report = {"versions": versions, "checks": findings, "robots": rows}
        args.json.write_text(json.dumps(_finite(report), indent=1, allow_nan=False))
    if args.svg:
        args.svg.write_text(svg(rows))
    print(", ".join(f"{k} {v}".strip() for k, v in versions.items() if v), end="\n\n")
    print("\n".join(f"- {finding}" for finding in findings), end="\n\n")
    print(tables(rows))


def _finite(value):
    """The same with null for what is not a number: JSON has no infinity."""
    if isinstance(value, dict):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _processor() -> str:
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [text.split(":", 1)[1].strip() for text in lines if text.startswith("model name")]
    return names[0] if names else platform.processor()


if __name__ == "__main__":
    main()
