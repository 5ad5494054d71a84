"""ilon's half: what `ilon bench` measures, and longer steps through `ilon run`."""

from __future__ import annotations

import json
import math
import subprocess
import tempfile

import numpy as np

from drives import DRIVES, OTHER_SPEEDS
from model import Settings, wheel_loop_gains
from robot import Robot

SCENARIOS = {"D1": "forward", "D2": "lateral", "D3": "yaw", "D4": "diagonal", "D5": "arc"}
# Steps a second beyond those of `ilon bench`, in the contact window, and bandwidths of the wheel loop: None is ilon's
# own choice, which keeps a wheel in the air stable at any step and grows slow with long ones.
LONG_RATES_HZ = (60.0, 40.0, 30.0, 20.0)
LOOPS_RAD_S = (None, 10.0, 4.0)


def version(path: str) -> str:
    return _output([path, "--version"]).removeprefix("ilon").strip()


def bench_rows(path: str, robots: list[Robot]) -> dict[str, list[dict]]:
    """The configurations of `ilon bench`, by robot."""
    report = json.loads(_output([path, "bench", "--json"]))
    return {
        robot.name: [
            _row(
                f"{c['roller_bodies']} rollers",
                None,
                c["physics_dt_s"],
                c["worst_error_pct"],
                c["hub_ripple_m"],
                c["sim_s_per_cpu_s"] or 0.0,
                None,
            )
            for c in report["robots"][robot.name]["configurations"]
        ]
        for robot in robots
    }


def run_rows(path: str, robot: Robot) -> list[dict]:
    """The five drives through the scenarios of the project, at long steps."""
    return [_run(path, robot, 1 / rate_hz, loop) for rate_hz in LONG_RATES_HZ for loop in LOOPS_RAD_S]


def complete(path: str, robot: Robot, row: dict) -> None:
    """Adds what `ilon bench` does not tell: how far the wheels miss their rates, and the error at other speeds."""
    if row["name"] != "near rollers":
        return
    if row["rate_shortfall"] is None:
        row["rate_shortfall"] = _run(path, robot, row["dt_s"], row["loop_rad_s"])["rate_shortfall"]
    others = [_run(path, robot, row["dt_s"], row["loop_rad_s"], speed) for speed in OTHER_SPEEDS]
    row["any_speed_error_pct"] = max(r["worst_error_pct"] for r in [row, *others])


def _run(path: str, robot: Robot, dt_s: float, loop_rad_s: float | None, speed: float = 1.0) -> dict:
    """As `ilon bench` does it, and with another wheel loop or at another speed where one is given."""
    given = {
        "run.physics_dt_s": dt_s,
        "run.control_dt_s": dt_s * max(1, round(0.01 / dt_s)),
        "robot.roller_bodies": "near",
    }
    if loop_rad_s is not None:
        loop = Settings(dt_s=dt_s, loop_rad_s=loop_rad_s, loop_air_bound=False)
        kp, ki = wheel_loop_gains(robot, loop)
        given |= {"wheel_loop.proportional_n_m_s": kp, "wheel_loop.integral_n_m": ki}
    errors, ripples, shortfalls, cpu_s, sim_s = [], [], [], 0.0, 0.0
    for drive, asked in DRIVES.items():
        scenario = robot.path.parent.parent / "scenarios" / f"{robot.name}_{SCENARIOS[drive]}.toml"
        twist = {f"twist.{key}": speed * x for key, x in zip(("vx_m_s", "vy_m_s", "omega_rad_s"), asked)}
        with tempfile.TemporaryDirectory() as out:
            settings = [part for key, value in (given | twist).items() for part in ("--set", f"{key}={value}")]
            summary = json.loads(_output([path, "run", str(scenario), "--json", "--out", out, *settings]))
        ratios = summary["twist_ratio_contact"]
        for name, component in zip(("vx", "vy", "omega"), asked):
            if component:
                errors.append(abs((ratios[name] or 0.0) - 1))
        ideal = summary["twist_ideal_mean"]
        reached = robot.rate_matrix @ [ideal["vx_m_s"], ideal["vy_m_s"], ideal["omega_rad_s"]]
        shortfalls.append(abs(np.linalg.norm(reached) / np.linalg.norm(speed * robot.rate_matrix @ asked) - 1))
        ripples.append(summary["hub_ripple_m"])
        sim_s += summary["duration_s"]
        cpu_s += summary["duration_s"] / summary["sim_seconds_per_cpu_second"]
    return _row(
        "near rollers",
        loop_rad_s,
        dt_s,
        100 * max(errors),
        max(ripples, key=lambda r: r or 0.0),
        sim_s / cpu_s,
        max(shortfalls),
    )


def _row(name, loop_rad_s, dt_s, error_pct, ripple_m, speed, shortfall) -> dict:
    return {
        "engine": "ilon",
        "name": name,
        "drive": "pi",
        "words": f"loop_rad_s {loop_rad_s:g}" if loop_rad_s else "",
        "dt_s": dt_s,
        "worst_error_pct": error_pct if math.isfinite(error_pct) else math.inf,
        "hub_ripple_m": ripple_m,
        "sim_s_per_cpu_s": speed,
        "rate_shortfall": shortfall,
        "loop_rad_s": loop_rad_s,
        "any_speed_error_pct": None,
    }


def _output(command: list[str]) -> str:
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True).stdout
