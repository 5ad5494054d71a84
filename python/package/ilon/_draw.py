"""Pictures of a robot on its path, from above."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

_WIDTH, _HEIGHT, _MARGIN = 640, 480, 40
# Drawn larger and scaled down, so that lines are smooth.
_OVER = 3

_Array = npt.NDArray[np.float64]


def from_above(pose: _Array, desired: _Array, path: _Array, wheels: _Array) -> npt.NDArray[np.uint8]:
    """Draws a robot, its path and its desired pose: an array of rows, columns, and red, green and blue.

    Poses are x and y in m and a heading in rad; `path` has x and y in m; `wheels` has for each wheel, in the body's frame, x and y in m,
    the direction of its axis in rad, its radius and half its width in m. x points to the right, y up.
    """
    try:
        from PIL import Image, ImageDraw
    except ImportError as error:
        raise ImportError("render() needs Pillow: pip install pillow") from error
    reach_m = float(np.max(np.hypot(wheels[:, 0], wheels[:, 1]) + wheels[:, 3]))
    seen = np.concatenate([path, [pose[:2], desired[:2]]])
    low, high = seen.min(axis=0) - reach_m, seen.max(axis=0) + reach_m
    room = _OVER * np.array([_WIDTH - 2 * _MARGIN, _HEIGHT - 2 * _MARGIN])
    per_m = float(np.min(room / (high - low)))
    middle = 0.5 * (low + high)

    def pixels(points: _Array) -> list[tuple[float, float]]:
        x, y = ((np.atleast_2d(points) - middle) * per_m).T
        return [(0.5 * _OVER * _WIDTH + px, 0.5 * _OVER * _HEIGHT - py) for px, py in zip(x, y, strict=True)]

    image = Image.new("RGB", (_OVER * _WIDTH, _OVER * _HEIGHT), "white")
    draw = ImageDraw.Draw(image)
    draw.line(pixels(path), fill=(170, 178, 190), width=2 * _OVER)
    draw.line(pixels(np.array([pose[:2], desired[:2]])), fill=(200, 60, 40), width=2 * _OVER)
    around = wheels[np.argsort(np.arctan2(wheels[:, 1], wheels[:, 0])), :2]
    for at, colour in ((desired, (150, 190, 230)), (pose, (30, 60, 110))):
        frame = pixels(_moved(around, at))
        draw.line([*frame, frame[0]], fill=colour, width=_OVER)
        for outline in _outlines(wheels):
            draw.polygon(pixels(_moved(outline, at)), fill=colour)
        nose = _moved(np.array([[0.0, 0.0], [0.7 * reach_m, 0.0]]), at)
        draw.line(pixels(nose), fill=colour, width=3 * _OVER)
    return np.asarray(image.resize((_WIDTH, _HEIGHT), Image.Resampling.BOX), dtype=np.uint8)


def _outlines(wheels: _Array) -> Iterable[_Array]:
    """The rectangles of the wheels in the body frame, one row per corner."""
    for x_m, y_m, axis_rad, radius_m, half_width_m in wheels:
        corners = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
        yield _moved(np.array(corners) * (half_width_m, radius_m), np.array([x_m, y_m, axis_rad]))


def _moved(points: _Array, pose: Any) -> _Array:
    """Points of a body at a pose."""
    x_m, y_m, heading_rad = pose
    cos, sin = np.cos(heading_rad), np.sin(heading_rad)
    moved: _Array = points @ np.array([[cos, sin], [-sin, cos]]) + (x_m, y_m)
    return moved
