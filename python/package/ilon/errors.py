"""What ilon raises: each class says which kind of thing is wrong, each message how to repair it."""

from __future__ import annotations

__all__ = [
    "ControlError",
    "DivergedError",
    "Error",
    "ReadError",
    "RobotError",
    "ScenarioError",
    "TraceError",
    "WorldError",
]


class Error(Exception):
    """Something that ilon refuses.

    `message` says what is wrong, `help` how to repair it (None where that is not known), and `str(error)` is all of it as
    the command line shows it, with the lines of the file at fault.
    """

    message: str
    help: str | None

    def __init__(self, message: str, help: str | None = None, shown: str | None = None) -> None:
        super().__init__(message, help, shown)
        self.message = message
        self.help = help
        self._shown = shown

    def __str__(self) -> str:
        if self._shown is not None:
            return self._shown.strip("\n").removeprefix("  × ")
        if self.help:
            return f"{self.message}\n  help: {self.help}"
        return self.message


class ReadError(Error, OSError):
    """A file cannot be read, or may not be."""

    __str__ = Error.__str__


class ScenarioError(Error, ValueError):
    """A scenario holds a key or a value that it may not, or asks for what this robot cannot do."""


class RobotError(Error, ValueError):
    """A robot's file cannot be used."""


class ControlError(Error, ValueError):
    """The robot's wheels, or the reference, are such that it cannot be controlled."""


class WorldError(Error, ValueError):
    """The robot cannot be put into its world."""


class TraceError(Error):
    """A trace or another file of results cannot be written or read."""


class DivergedError(Error, ArithmeticError):
    """The robot's motion is no number any more."""
