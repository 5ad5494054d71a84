#!/usr/bin/env python3
"""Writes docs/scenarios.md from the first sentence of each scenario and study; with --check, exits 1 where it is not up to date."""

import re
import sys
import tomllib
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


def robot(path):
    """The file of the robot that a scenario names."""
    file = tomllib.loads(path.read_text()).get("robot", {}).get("file", "")
    return Path(file).stem


def index():
    text = "# Scenarios\n\nThe first sentence of each file; the file says more. Written by `docs/scenarios.py`.\n\n"
    text += "Run one with `ilon run`, test all of them with `ilon check assets/scenarios`. Pairs to compare: [slip](slip.md#which-scenarios-to-compare).\n\n| scenario | robot | shows |\n|---|---|---|\n"
    for path in sorted((ROOT / "assets" / "scenarios").glob("*.toml")):
        text += f"| [{path.stem}](../assets/scenarios/{path.name}) | {robot(path)} | {first_sentence(path)} |\n"
    text += "\n## Studies\n\nRun one with `ilon sweep`.\n\n| study | asks |\n|---|---|\n"
    for path in sorted((ROOT / "assets" / "studies").glob("*.toml")):
        text += f"| [{path.stem}](../assets/studies/{path.name}) | {first_sentence(path)} |\n"
    return text


def main():
    if sys.argv[1:] == ["--check"]:
        if INDEX.read_text() != index():
            sys.exit("docs/scenarios.md is not up to date: run docs/scenarios.py")
        return
    INDEX.write_text(index())


if __name__ == "__main__":
    main()
