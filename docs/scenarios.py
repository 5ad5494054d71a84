#!/usr/bin/env python3
"""Writes docs/scenarios.md from the first sentence of each scenario; with --check, exits 1 where it is not up to date."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
INDEX = ROOT / "docs" / "scenarios.md"


def first_sentence(path):
    """The first sentence of the comment that a file begins with. A sentence ends before a space and a capital; "Fig. 4" does not end one."""
    lines = []
    for line in path.read_text().splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# ").strip())
    return re.split(r"(?<=[.?])\s(?=[A-Z])", " ".join(lines))[0].replace("|", "\\|")


# The motions that most robots have a scenario of, in the order of the table.
MOTIONS = ["forward", "lateral", "diagonal", "arc", "yaw"]


def link(path):
    return f"[{path.stem}](../assets/{path.parent.name}/{path.name})"


def index():
    text = "# Scenarios\n\nThe file's comment says more. Run one with `ilon run`, test all of them with `ilon check assets/scenarios`. Pairs to compare:\n"
    text += "[slip](slip.md#which-scenarios-to-compare). Studies: [studies](sweeps.md#the-shipped-studies). Written by `docs/scenarios.py`.\n\n"
    paths = sorted((ROOT / "assets" / "scenarios").glob("*.toml"))
    standard = {}
    for path in paths:
        robot, _, motion = path.stem.partition("_")
        if motion in MOTIONS and first_sentence(path).endswith("in open loop."):
            standard.setdefault(robot, {})[motion] = path
    for robot, motions in standard.items():
        links = " ".join(f"[{motion}](../assets/scenarios/{motions[motion].name})" for motion in MOTIONS if motion in motions)
        text += f"- {robot}, standard motions in open loop: {links}\n"
    listed = {path for motions in standard.values() for path in motions.values()}
    for path in paths:
        if path not in listed:
            text += f"- {link(path)}: {first_sentence(path)}\n"
    return text


def main():
    if sys.argv[1:] == ["--check"]:
        if INDEX.read_text() != index():
            sys.exit("docs/scenarios.md is not up to date: run docs/scenarios.py")
        return
    INDEX.write_text(index())


if __name__ == "__main__":
    main()
