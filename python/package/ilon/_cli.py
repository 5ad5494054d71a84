"""The `ilon` command: the same program as the one that cargo installs."""

from __future__ import annotations

import signal
import sys

from ._ilon import command


def main() -> int:
    """Runs the command of this process's arguments; gives its exit code."""
    # Python only notes Ctrl-C and looks at it later; the command shall end at once, as any other does.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return command(["ilon", *sys.argv[1:]])
