"""A robot that is driven while it is simulated."""

from __future__ import annotations

import html
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from types import TracebackType

from .errors import Error
from .runs import Sandbox

__all__ = ["Live", "live"]

_Setting = str | float | bool


class Live:
    """A live run, in a separate process: its page is at `url`; it runs until `stop()`, or the end of a `with` block."""

    url: str
    """Where the page is, on this machine alone."""

    def __init__(self, process: subprocess.Popen[str], url: str) -> None:
        self._process = process
        self.url = url

    @property
    def running(self) -> bool:
        """Whether it still runs."""
        return self._process.poll() is None

    def wait(self, timeout_s: float | None = None) -> None:
        """Waits until it ends: at its `seconds`, or when it is stopped. Raises `TimeoutError` where that takes longer than `timeout_s`."""
        try:
            self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"it still runs after {timeout_s} s") from None
        if self._process.stdout:
            self._process.stdout.close()

    def stop(self) -> None:
        """Ends it."""
        self._process.terminate()
        self.wait()

    def __enter__(self) -> Live:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.stop()

    def __del__(self) -> None:
        if getattr(self, "_process", None) is not None:
            self.stop()

    def __repr__(self) -> str:
        return f"<ilon.Live at {self.url}>" if self.running else "<ilon.Live, ended>"

    def _repr_html_(self) -> str:
        url = html.escape(self.url)
        return f'Drive at <a href="{url}" target="_blank">{url}</a>' if self.running else "The live run has ended."


def live(
    scenario: str | os.PathLike[str],
    *,
    settings: Mapping[str, _Setting] | None = None,
    port: int = 0,
    speed: float = 1.0,
    seconds: float | None = None,
    ros2: bool = False,
    foxglove: bool = False,
    sandbox: Sandbox | None = None,
) -> Live:
    """Simulates a scenario in real time, to be driven from a page in the browser by keys, sticks or a gamepad, as `ilon live` does.

    It comes back at once; `webbrowser.open(ilon.live("scenario.toml").url)` shows the page. `settings` are keys of the scenario that are otherwise than
    in the file, `port` is where the page is served (0 for any that is free), `speed` is how many simulated seconds a second has, and after `seconds` it ends by
    itself. With `ros2` it is a node of ROS 2, with `foxglove` it serves Foxglove too: released wheels have both.

    Raises `ilon.Error` where it cannot begin, in the words of the command.
    """
    arguments = [os.fspath(scenario), "--port", str(port), "--speed", str(speed)]
    arguments += [part for key, value in (settings or {}).items() for part in ("--set", f"{key}={_toml(value)}")]
    arguments += ["--seconds", str(seconds)] if seconds is not None else []
    arguments += ["--ros2"] * ros2 + ["--foxglove=0"] * foxglove
    for folder in _folders(sandbox):
        arguments += ["--sandbox", os.fspath(folder)]
    # Later output goes to the file: a pipe that is not read would block the command.
    with tempfile.TemporaryFile("w+", encoding="utf-8") as said:
        command = [sys.executable, "-m", "ilon", "live", *arguments]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=said, stdin=subprocess.DEVNULL, text=True, encoding="utf-8")
        assert process.stdout is not None
        for line in process.stdout:
            if found := re.search(r"drive at (http://\S+)", line):
                return Live(process, found.group(1))
        process.stdout.close()
        process.wait()
        said.seek(0)
        # Of the command line's own errors, without its beginning and its hint.
        shown = said.read().removeprefix("error: ").partition("\nFor more information")[0]
    first = next((line.removeprefix("  × ") for line in shown.splitlines() if line.strip()), "it ended at once")
    raise Error(first, None, shown or None)


def _folders(sandbox: Sandbox | None) -> Sequence[str | os.PathLike[str]]:
    if sandbox is None:
        return []
    return [sandbox] if isinstance(sandbox, (str, os.PathLike)) else sandbox


def _toml(value: _Setting) -> str:
    """A value in the command's syntax."""
    if isinstance(value, bool):
        return str(value).lower()
    return json.dumps(value) if isinstance(value, str) else str(value)
