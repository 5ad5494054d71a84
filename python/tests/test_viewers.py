"""Runs in other viewers."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ilon

rr = pytest.importorskip("rerun")

from ilon import to_rerun  # noqa: E402
from ilon.viewers import _quaternions  # noqa: E402


def test_a_recording_holds_wheels_rollers_arrows_and_scalars(circle, tmp_path):
    circle["run"] |= {"duration_s": 0.2, "roller_angles_hz": 50}
    run = ilon.run(circle)
    path = tmp_path / "run.rrd"
    to_rerun(run, path)
    command = Path(sys.executable).with_name("rerun")
    said = subprocess.run([command, "rrd", "print", path], capture_output=True, text=True, check=True).stdout
    for entity in (
        "/world/robot",
        "/world/reference",
        "/world/robot/front_left",
        "/world/robot/rear_right/roller_8",
        "/world/robot/contacts/rear_left/slip",
        "/torque_n_m/front_right",
        "/roller_angle_rad/front_left/0",
    ):
        assert entity in said, entity
    assert "Arrows3D" in said and "Transform3D" in said and "Scalars" in said


def test_turns_are_applied_roll_first():
    roll, pitch, heading = 0.3, -0.2, 1.1
    x, y, z, w = _quaternions(*(np.array([angle]) for angle in (roll, pitch, heading)))[0]

    def about(axis, angle):
        sine, cosine = np.sin(angle), np.cos(angle)
        matrix = np.eye(3)
        first, second = [other for other in range(3) if other != axis]
        sign = -1.0 if axis == 1 else 1.0
        matrix[first, first] = matrix[second, second] = cosine
        matrix[first, second], matrix[second, first] = -sign * sine, sign * sine
        return matrix

    expected = about(2, heading) @ about(1, pitch) @ about(0, roll)
    got = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    np.testing.assert_allclose(got, expected, atol=1e-12)
