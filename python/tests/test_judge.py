"""A policy is judged by what it does on wheels with all their rollers."""

import importlib.util
import math

import numpy as np
import pytest

import ilon

pytest.importorskip("gymnasium")

LEFT = {
    "robot": {"file": "mecanum4.toml", "roller_bodies": "near"},
    "reference": {"waypoints": {"points_m": [[0.0, 0.0], [0.0, 1.5]], "speed_m_s": 0.3, "headings_deg": [0.0, 0.0]}},
    "guidance": {},
    "run": {"duration_s": 4.0, "control_dt_s": 0.02, "physics_dt_s": 0.001},
}


def options():
    from ilon.gym import FIGURE_EIGHT

    still = {"any_phase": False, "start_off_m": 0.0, "start_off_rad": 0.0}
    return {"folder": FIGURE_EIGHT.parent, **still}


def following(seen):
    """The paper's law at 2 /s; an action of 1 is the top speed."""
    return (seen[3:6] + 2.0 * seen[:3]) / [1.5, 1.5, 4.83870968]


def test_the_shortfall_sideways_is_that_of_contact_kinematics():
    found = ilon.judge(following, [LEFT], **options())
    # 0.9798 by contact kinematics (docs/simulators.md); a start at rest and samples of the rates move it by less than 0.5 %.
    assert found.share_left == pytest.approx(0.9798, abs=5e-3)
    assert found.falls == 0.0
    # Left behind by the shortfall: 2 % of 0.3 m/s against a gain of 2 /s is 3 mm; the start adds to it.
    assert 0.0 < found.error_m < 0.02
    assert found.slip_j > 0.0
    # One scenario twice is the same episodes' mean.
    assert ilon.judge(following, [LEFT, LEFT], **options()).error_m == pytest.approx(found.error_m)


def test_what_the_transfer_lost_is_the_difference_to_the_training_simulator():
    first = ilon.judge(following, [3, 4], episode_s=1.0)
    again = ilon.judge(following, [3, 4], episode_s=1.0, trained=first)
    assert set(again.lost) == {"falls", "error_m", "error_rad", "slip_j", "share_ahead", "share_left", "share_turn"}
    assert all(lost == 0.0 for lost in again.lost.values())
    better = ilon.judge(following, [3, 4], episode_s=1.0, trained={"error_m": 0.001})
    assert better.lost == {"error_m": first.error_m - 0.001}


def test_a_robot_that_leaves_its_path_has_fallen():
    found = ilon.judge(lambda seen: np.zeros(3), [LEFT], fail_at_m=0.1, **options())
    assert found.falls == 1.0
    assert math.isnan(found.share_left)
    assert found.error_m < 0.1


def test_studies_and_figures_that_cannot_be_are_refused():
    with pytest.raises(ValueError, match="empty"):
        ilon.judge(following, [])
    with pytest.raises(TypeError, match="both"):
        ilon.judge(following, [1, LEFT], **options())
    with pytest.raises(ValueError, match="speed"):
        ilon.judge(following, [1], trained={"speed": 1.0})
    if importlib.util.find_spec("onnxruntime") is None:
        with pytest.raises(ImportError, match="onnxruntime"):
            ilon.judge("policy.onnx", [1])
