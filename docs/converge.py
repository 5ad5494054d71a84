#!/usr/bin/env python3
"""Writes into docs/measured.md which figures of the shipped scenarios move by more than 1 % at half the step, and why.

`docs/converge.py ILON` runs every scenario three times (`ilon check assets/scenarios --converge`) and writes the table, with ILON the program;
`docs/converge.py --check ILON` exits 1 where the table is not up to date. Both exit 1 where a place, a heading or a way moves by more than 1 %.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "measured.md"
BEGIN, END = "<!-- docs/converge.py: begin -->\n", "<!-- docs/converge.py: end -->\n"
LEAST = 0.01
# So many scenarios are named for each figure, those in which it moves most.
NAMED = 3

# Of each figure what it is called, and why it depends on the step; None of what must not.
FIGURES = {
    "end_x_m": ("x at the end", None),
    "end_y_m": ("y at the end", None),
    "end_heading_rad": ("heading at the end", None),
    "travelled_m": ("length of the way", None),
    "turned_rad": ("turned, back and forth", None),
    "position_error_rms_m": ("position error, rms", None),
    "position_error_max_m": ("position error, largest", None),
    "position_error_final_m": ("position error, at the end", None),
    "heading_error_rms_rad": ("heading error, rms", None),
    "heading_error_max_rad": ("heading error, largest", None),
    "heading_error_final_rad": ("heading error, at the end", None),
    "twist_ratio_ideal.vx": ("real over ideal, vx", None),
    "twist_ratio_ideal.vy": ("real over ideal, vy", None),
    "twist_ratio_ideal.omega": ("real over ideal, omega", None),
    "twist_ratio_contact.vx": ("real over contact kinematics, vx", None),
    "twist_ratio_contact.vy": ("real over contact kinematics, vy", None),
    "twist_ratio_contact.omega": ("real over contact kinematics, omega", None),
    "energy.motor_j": ("work of the motors", "follows landings and sliding"),
    "energy.bearing_j": ("lost in bearings", "rollers that land spin up"),
    "slip_energy_j": ("lost to sliding", "sliding at a hand-over lasts about a step"),
    "energy.spin_up_j": ("roller spin-up", "spin-up lasts about a step"),
    "energy.impact_j": ("lost in impacts", "landings are first order in the step"),
    "slip_speed_max_m_s": ("sliding speed, largest", "a shorter step shows more of a peak"),
    "wheel_torque_max_n_m": ("torque, largest", "mean over one step"),
    "friction_used_max": ("most grip used", "mean over one step"),
    "airborne_share": ("in the air", "hops last about a step"),
    "saturated_share": ("saturated", "counted in control periods"),
    "chassis_load_share": ("weight on the chassis", "landings last about a step"),
}


def percent(share):
    """A share in words: figures that are next to nothing at one of the steps have no share to speak of."""
    return f"{100 * share:.0f} %" if share < 10 else "over 1000 %"


def table(scenarios):
    """The table as text, and what moved without a reason."""
    rows, wrong = {}, []
    for scenario in scenarios:
        if scenario["error"] or not scenario["converge"]:
            wrong.append(f"{scenario['scenario']}: {scenario['error'] or 'it could not be repeated at half the step'}")
        for key, moved in scenario["converge"].items():
            if moved["share"] > LEAST:
                rows.setdefault(key, []).append((moved["share"], scenario["scenario"]))
                if FIGURES[key][1] is None:
                    wrong.append(f"{scenario['scenario']}: {key} moves by {100 * moved['share']:.2f} %")
    lines = ["| figure | moves by more than 1 % in | why |", "|---|---|---|"]
    for key, (name, why) in FIGURES.items():
        moved = sorted(rows.get(key, []), reverse=True)
        if moved:
            words = ", ".join(f"{scenario} {percent(share)}" for share, scenario in moved[:NAMED])
            if len(moved) > NAMED:
                words += f"; {len(moved) - NAMED} more"
            lines.append(f"| {name} | {words} | {why or 'to be explained'} |")
    return "\n".join(lines) + "\n", wrong


def main():
    check = "--check" in sys.argv[1:]
    program = next(word for word in sys.argv[1:] if not word.startswith("-"))
    said = subprocess.run([program, "check", ROOT / "assets" / "scenarios", "--converge", "--json"], stdout=subprocess.PIPE, text=True)
    written, wrong = table(json.loads(said.stdout)["scenarios"])
    for line in wrong:
        print(line, file=sys.stderr)
    page = PAGE.read_text()
    before = re.search(re.escape(BEGIN) + "(.*?)" + re.escape(END), page, re.S)
    if before[1] != written:
        if check:
            print("docs/measured.md is not up to date: docs/converge.py ILON writes its table", file=sys.stderr)
        else:
            PAGE.write_text(page[: before.start(1)] + written + page[before.end(1) :])
    sys.exit(bool(wrong) or (check and before[1] != written))


if __name__ == "__main__":
    main()
