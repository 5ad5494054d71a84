#!/usr/bin/env python3
"""Writes the tables of docs/limits.md: what is left of the limits by statics, and how fast paths may be.

`docs/limits.py ILON` runs them and writes, with ILON the program; `docs/limits.py --check ILON` exits 1 where the page is not up to date.
"""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "limits.md"
ROBOTS = ROOT / "assets" / "robots"
MOTIONS = ["ahead", "ahead and left", "left", "turning left"]
# Eights: in words, half width in m, friction, and whether the robot looks along the path.
EIGHTS = [
    ("mecanum4", "eight of half width 0.8 m", 0.8, 0.6, False),
    ("mecanum4", "eight of 0.2 m", 0.2, 0.6, False),
    ("mecanum4", "eight of 0.8 m, friction 0.1", 0.8, 0.1, False),
    ("mecanum4", "eight of 0.8 m, looks along it", 0.8, 0.6, True),
    ("mecanum6", "eight of 0.8 m, looks along it", 0.8, 0.6, True),
]
# Robots that nothing was tuned to: in words, what their wheels are, where these are, and what carries them.
ODD = [
    ("4 mecanum wheels, rollers at 60°, damped bearings", "damping_n_m_s = 0.01", "mecanum = { axles_m = [0.15, -0.15], half_width_m = 0.16, gamma_deg = 60 }", ""),
    ("4 wheels at odd axes and rollers", "", [(0.2, 0.1, 70, -40), (0.12, -0.2, 100, 50), (-0.18, 0.17, 95, 35), (-0.15, -0.13, 80, -60)], ""),
    ("6 mecanum wheels, unevenly apart", "", "mecanum = { axles_m = [0.22, 0.05, -0.2], half_width_m = 0.16, gamma_deg = 45 }", ""),
    ("ring of 5, rollers at -20°", "", "ring = { count = 5, distance_m = 0.2, gamma_deg = -20 }", ""),
    (
        "4 mecanum wheels on springs",
        "",
        "mecanum = { axles_m = [0.15, -0.15], half_width_m = 0.16, gamma_deg = 45 }",
        """
[suspension.all]
wheels = ["front_left", "front_right", "rear_left", "rear_right"]
mass_kg = 0.1
law.sprung = { stiffness_n_m = 4000, damping_n_s_m = 60, travel_m = 0.02 }
""",
    ),
]
ROBOT = """
name = "odd"
chassis = {{ shape.box = {{ size_m = [0.3, 0.25, 0.1] }}, mass_kg = 10, center_m = [0, 0, {center_m}] }}
rollers = {{ per_row = 9, radius_m = 0.012, mass_kg = 0.01 }}
[wheel]
radius_m = 0.05
hub_mass_kg = 0.25
hub_radius_m = 0.03
hub_width_m = 0.04
motor_effort_n_m = 1.8
motor_velocity_rad_s = 30
{wheel}
[wheels]
{wheels}
{suspension}
"""
PATH = """
robot = {{ file = "{robots}/{robot}.urdf", heading_deg = {heading_deg} }}
world.floor.friction = {friction}
reference.timing = "as fast as grip allows"
reference.figure_eight = {{ half_width_m = {half_width_m}, period_s = 8{heading} }}
guidance = {{ position_gain_per_s = 3, heading_gain_per_s = 3 }}
run.duration_s = 6
"""


def held(program):
    """What is left of the limits from rest, as a table."""
    lines = ["| | " + " | ".join(MOTIONS) + " |", "|---|" + len(MOTIONS) * "---|"]
    for robot in ("mecanum4", "mecanum6"):
        command = [program, "inspect", ROBOTS / f"{robot}.urdf", "--limits", "--json"]
        rows = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)["limits"]["rows"]
        from_rest = {row["motion"]: row["speeding_up"]["share_held"] for row in rows if row["speed"] == 0}
        lines.append(f"| {robot} | " + " | ".join(f"{from_rest[motion]:.2f}" for motion in MOTIONS) + " |")
    return "\n".join(lines) + "\n"


def path(program, robot, half_width_m, friction, along, share=None, folder=ROBOTS):
    """The share of grip that an eight takes, and what slides of the motors' positive work."""
    words = {"robots": folder, "robot": robot, "half_width_m": half_width_m, "friction": friction}
    text = PATH.format(heading_deg=45 if along else 0, heading=', heading = "along_path"' if along else "", **words)
    if share is not None:
        text += f"reference.share_of_grip = {share}\n"
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "eight.toml").write_text(text)
        command = [program, "run", f"{folder}/eight.toml", "--no-report", "--quiet", "--out", f"{folder}/out"]
        subprocess.run(command, stdout=subprocess.PIPE, check=True)
        summary = json.loads((Path(folder) / "out" / "summary.json").read_text())
        resolved = (Path(folder) / "out" / "scenario.toml").read_text()
    slid = summary["slip_energy_j"] / summary["energy"]["motor_positive_j"]
    return float(re.search(r"share_of_grip = (\S+)", resolved)[1]), slid


def paths(program):
    """How fast eights may be, as a table."""
    lines = ["| | share taken | lost to sliding, simulated | at a lap shorter by 3 % |", "|---|---|---|---|"]
    for robot, words, *eight in EIGHTS:
        share, slid = path(program, robot, *eight)
        _, faster = path(program, robot, *eight, share=1.06 * share)
        lines.append(f"| {robot}, {words} | {share:.2f} | {100 * slid:.2f} % | {100 * faster:.2f} % |")
    return "\n".join(lines) + "\n"


def odd(program):
    """How fast robots that nothing was tuned to may be in an eight that they look along, as a table."""
    lines = ["| | share taken | lost to sliding, simulated | at a lap shorter by 3 % |", "|---|---|---|---|"]
    for words, wheel, wheels, suspension in ODD:
        if not isinstance(wheels, str):
            keys = "name = \"w{}\", position_m = [{}, {}], axis_deg = {}, gamma_deg = {}"
            each = ["{ " + keys.format(at, *wheel) + " }" for at, wheel in enumerate(wheels)]
            wheels = "list = [" + ", ".join(each) + "]"
        text = ROBOT.format(wheel=wheel, wheels=wheels, suspension=suspension, center_m=0.16 if suspension else 0.1)
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "odd.toml").write_text(text)
            subprocess.run([program, "generate", f"{folder}/odd.toml", "--out", f"{folder}/odd.urdf", "--quiet"], check=True)
            eight = ("odd", 0.5, 0.5, True)
            share, slid = path(program, *eight, folder=folder)
            _, faster = path(program, *eight, share=1.06 * share, folder=folder)
        lines.append(f"| {words} | {share:.2f} | {100 * slid:.2f} % | {100 * faster:.2f} % |")
    return "\n".join(lines) + "\n"


def main():
    check = "--check" in sys.argv[1:]
    program = next(word for word in sys.argv[1:] if not word.startswith("-"))
    before = page = PAGE.read_text()
    for name, table in (("held", held), ("paths", paths), ("odd", odd)):
        begin, end = f"<!-- docs/limits.py: {name} -->\n", "<!-- docs/limits.py: end -->\n"
        written = begin + table(program) + end
        page = re.sub(re.escape(begin) + ".*?" + re.escape(end), lambda _: written, page, count=1, flags=re.S)
    if not check:
        PAGE.write_text(page)
    elif page != before:
        sys.exit("docs/limits.md is not up to date: docs/limits.py ILON writes its tables")


if __name__ == "__main__":
    main()
