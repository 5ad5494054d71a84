"""The `ilon` command: the same program as the one that cargo installs."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

from ._ilon import command


def main() -> int:
    """Runs the command of this process's arguments; gives its exit code."""
    # Python handles Ctrl-C only between its own instructions; the command should end at once, as
    # any other does.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # The C library in the package, which `ilon export --fmu` packs.
    for library in Path(__file__).parent.glob("*ilon_c.*"):
        os.environ.setdefault("ILON_C_LIBRARY", str(library))
    return command(["ilon", *sys.argv[1:]])
