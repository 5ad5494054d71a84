"""ilon's half: what `ilon bench` measures, and the error at other speeds through `ilon run`."""

from __future__ import annotations

import json
import math
import subprocess
import tempfile

from drives import DRIVES, OTHER_SPEEDS
from robot import Robot

SCENARIOS = {"D1": "forward", "D2": "lateral", "D3": "yaw", "D4": "diagonal", "D5": "arc"}
# Steps a second with all rollers' shapes in the world, and in the contact window.
ALL_RATES_HZ = (1000, 500, 250, 125, 60, 30, 20, 15, 12, 10)
NEAR_RATES_HZ = (1000, 500, 250, 125, 110, 100, 90, 80, 75, 70, 65, 60, 40, 30, 20, 15, 12, 10)
# Bandwidths of the wheel loop: None is ilon's own, 60 rad/s.
LOOPS_RAD_S = (None, 10.0, 4.0)


def version(path: str) -> str:
    return _output([path, "--version"]).removeprefix("ilon").strip()


def bench_rows(path: str, robots: list[Robot], rounds: int) -> dict[str, list[dict]]:
    """What `ilon bench` measures, by robot: every step with ilon's own loop, and the window with the others."""
    rows = {robot.name: [] for robot in robots}
    for rollers, rates_hz in (("all", ALL_RATES_HZ), ("near", NEAR_RATES_HZ)):
        for loop_rad_s in LOOPS_RAD_S if rollers == "near" else LOOPS_RAD_S[:1]:
            command = [path, "bench", "--json", "--rollers", rollers, "--rounds", str(rounds)]
            command += ["--rates", ",".join(map(str, rates_hz))]
            command += [part for robot in robots for part in ("--robot", robot.name)]
            command += ["--bandwidth", str(loop_rad_s)] if loop_rad_s else []
            report = json.loads(_output(command))
            for robot in robots:
                for c in report["robots"][robot.name]["configurations"]:
                    rows[robot.name].append(_row(c, loop_rad_s))
    return rows


def complete(path: str, robot: Robot, row: dict) -> None:
    """Adds what `ilon bench` does not tell: the error at other speeds."""
    if row["name"] != "near rollers":
        return
    others = [_error_pct(path, robot, row["dt_s"], row["loop_rad_s"], speed) for speed in OTHER_SPEEDS]
    row["any_speed_error_pct"] = max(row["worst_error_pct"], *others)


def _error_pct(path: str, robot: Robot, dt_s: float, loop_rad_s: float | None, speed: float) -> float:
    """The worst error of the five drives at another speed."""
    given = {
        "run.physics_dt_s": dt_s,
        "run.control_dt_s": dt_s * max(1, round(0.01 / dt_s)),
        "robot.roller_bodies": "near",
    }
    if loop_rad_s is not None:
        given["wheel_loop.bandwidth_rad_s"] = loop_rad_s
    errors = []
    for drive, asked in DRIVES.items():
        scenario = robot.path.parent.parent / "scenarios" / f"{robot.name}_{SCENARIOS[drive]}.toml"
        twist = {f"twist.{key}": speed * x for key, x in zip(("vx_m_s", "vy_m_s", "omega_rad_s"), asked)}
        with tempfile.TemporaryDirectory() as out:
            settings = [part for key, value in (given | twist).items() for part in ("--set", f"{key}={value}")]
            summary = json.loads(_output([path, "run", str(scenario), "--json", "--out", out, *settings]))
        ratios = summary["twist_ratio_contact"]
        for name, component in zip(("vx", "vy", "omega"), asked):
            if component:
                errors.append(100 * abs((ratios[name] or 0.0) - 1))
    return max(errors)


def _row(configuration: dict, loop_rad_s: float | None) -> dict:
    error_pct = configuration["worst_error_pct"]
    return {
        "engine": "ilon",
        "name": f"{configuration['roller_bodies']} rollers",
        "drive": "pi",
        "words": f"loop_rad_s {loop_rad_s:g}" if loop_rad_s else "",
        "dt_s": configuration["physics_dt_s"],
        "worst_error_pct": error_pct if error_pct is not None and math.isfinite(error_pct) else math.inf,
        "hub_ripple_m": configuration["hub_ripple_m"],
        "sim_s_per_cpu_s": configuration["sim_s_per_cpu_s"] or 0.0,
        "rate_shortfall": configuration["rate_shortfall_pct"] / 100,
        "loop_rad_s": loop_rad_s,
        "any_speed_error_pct": None,
    }


def _output(command: list[str]) -> str:
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True).stdout
