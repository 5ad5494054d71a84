#!/usr/bin/env python3
"""Writes docs/scenarios.md from the first words of each scenario and study; with --check, exits 1 where it is not up to date."""

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
INDEX = ROOT / "docs" / "scenarios.md"


def comment(path):
    """The comment that a file begins with, as one paragraph."""
    lines = []
    for line in path.read_text().splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# ").strip())
    return " ".join(lines).replace("|", "\\|")


def robot(path):
    """The file of the robot that a scenario names."""
    file = tomllib.loads(path.read_text()).get("robot", {}).get("file", "")
    return Path(file).stem


def index():
    text = "# Scenarios\n\nEach file begins with what it shows. Written by `docs/scenarios.py`.\n\n"
    text += "Run one with `ilon run`, hold all of them with `ilon check assets/scenarios`.\n\n| scenario | robot | shows |\n|---|---|---|\n"
    for path in sorted((ROOT / "assets" / "scenarios").glob("*.toml")):
        text += f"| [{path.stem}](../assets/scenarios/{path.name}) | {robot(path)} | {comment(path)} |\n"
    text += "\n## Studies\n\nRun one with `ilon sweep`.\n\n| study | asks |\n|---|---|\n"
    for path in sorted((ROOT / "assets" / "studies").glob("*.toml")):
        text += f"| [{path.stem}](../assets/studies/{path.name}) | {comment(path)} |\n"
    return text


def main():
    if sys.argv[1:] == ["--check"]:
        if INDEX.read_text() != index():
            sys.exit("docs/scenarios.md is not up to date: run docs/scenarios.py")
        return
    INDEX.write_text(index())


if __name__ == "__main__":
    main()
