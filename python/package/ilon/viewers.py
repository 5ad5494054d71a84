"""Runs in other people's viewers."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from .runs import Run

__all__ = ["to_rerun"]

_TIMELINE = "t"
_NEWTON_M = 0.005
"""Length of a force's arrow, in m for each N."""
_SLIP_S = 1.0
"""Length of a slip velocity's arrow, in m for each m/s."""
_QUANTITIES = ("target_rad_s", "rate_rad_s", "torque_n_m", "normal_force_n")


def to_rerun(run: Run, path: str | os.PathLike[str] | None = None) -> Any:
    """A run in the viewer of rerun (needs the package `rerun-sdk`): the robot's wheels and rollers as they turn, the forces of the ground
    and the slip of each contact as arrows, path and reference, and the wheels' rates, torques and loads, all on one timeline `t`.

    Written to an `.rrd` file if `path` is given, which `rerun FILE` opens; the recording is given back either way. Rollers turn as
    recorded where the scenario says `run.roller_angles_hz`; without that they are carried around by their wheels.
    """
    import rerun as rr

    trace, header = run.trace, run.trace.header
    recording = rr.RecordingStream("ilon", recording_id=None)
    if path is not None:
        recording.save(os.fspath(path))
    times = trace["t_s"]
    timeline = [rr.TimeColumn(_TIMELINE, duration=times)]

    def send(entity: str, *columns: Any) -> None:
        for column in columns:
            recording.send_columns(entity, timeline, column)

    recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    if header["urdf"]:
        recording.log("urdf", rr.TextDocument(header["urdf"], media_type="application/xml"), static=True)

    zeros = np.zeros_like(times)
    position = np.column_stack([trace["truth_x_m"], trace["truth_y_m"], trace["truth_height_m"]])
    send(
        "world/robot",
        rr.Transform3D.columns(
            translation=position,
            quaternion=_quaternions(trace["truth_roll_rad"], trace["truth_pitch_rad"], trace["truth_heading_rad"]),
        ),
    )
    recording.log("world/path", rr.LineStrips3D([position], colors=[[40, 90, 200]]), static=True)
    if np.isfinite(trace["desired_x_m"]).any():
        desired = np.column_stack([trace["desired_x_m"], trace["desired_y_m"], zeros])
        recording.log("world/reference", rr.LineStrips3D([desired], colors=[[150, 150, 150]]), static=True)
    for index, outline in enumerate(header["chassis_outlines_m"]):
        points = [[x, y, 0.0] for x, y in [*outline, outline[0]]]
        recording.log(f"world/robot/chassis/{index}", rr.LineStrips3D([points]), static=True)

    for index, wheel in enumerate(header["wheels"]):
        entity = f"world/robot/{wheel['name']}"
        _wheel(rr, recording, send, trace, entity, index, wheel)
        contact = np.column_stack([trace[f"wheel{index}_contact_x_m"], trace[f"wheel{index}_contact_y_m"], -position[:, 2]])
        force = np.column_stack([trace[f"wheel{index}_{name}"] for name in ("force_x_n", "force_y_n", "normal_force_n")])
        slip = np.column_stack([trace[f"wheel{index}_slip_x_m_s"], trace[f"wheel{index}_slip_y_m_s"], zeros])
        arrows = (("force", _NEWTON_M * force, [60, 160, 60]), ("slip", _SLIP_S * slip, [220, 60, 40]))
        for name, vectors, color in arrows:
            recording.log(f"world/robot/contacts/{wheel['name']}/{name}", rr.Arrows3D.from_fields(colors=[color]), static=True)
            send(f"world/robot/contacts/{wheel['name']}/{name}", rr.Arrows3D.columns(origins=contact, vectors=vectors))
        for quantity in _QUANTITIES:
            send(f"{quantity}/{wheel['name']}", rr.Scalars.columns(scalars=trace[f"wheel{index}_{quantity}"]))
    if path is not None:
        recording.flush()
    return recording


def _wheel(rr: Any, recording: Any, send: Any, trace: Any, entity: str, index: int, wheel: dict[str, Any]) -> None:
    """A wheel that turns about its axis, with its rollers around it."""
    axis = np.array([*wheel["axis"], 0.0])
    height = trace[f"wheel{index}_hub_height_m"] - trace["truth_height_m"]
    places = np.column_stack([np.full_like(height, wheel["position_m"][0]), np.full_like(height, wheel["position_m"][1]), height])
    angles = trace[f"wheel{index}_angle_rad"]
    half = 0.5 * angles[:, np.newaxis]
    send(entity, rr.Transform3D.columns(translation=places, quaternion=np.hstack([np.sin(half) * axis, np.cos(half)])))
    across = np.cross(axis, [0.0, 0.0, 1.0])
    radius, count = wheel["radius_m"], wheel["roller_count"]
    sine, cosine = np.sin(wheel["gamma_rad"]), np.cos(wheel["gamma_rad"])
    # As long as the wheel is wide, or as the distance to the next one.
    length = wheel["width_m"] / abs(sine) if abs(sine) > 0.3 else 2.0 * np.pi * radius / max(count, 1)
    for roller in range(count):
        around = 2.0 * np.pi * roller / count
        outwards = np.cos(around) * np.array([0.0, 0.0, -1.0]) + np.sin(around) * across
        # The lowest roller rolls at gamma from the hub's axis, counter-clockwise seen from above,
        # and spins across that.
        spin = cosine * np.cross(-outwards, axis) - sine * axis
        middle = 0.8 * radius * outwards
        ends = [middle - 0.5 * length * spin, middle + 0.5 * length * spin]
        name = f"{entity}/roller_{roller}"
        recording.log(name, rr.LineStrips3D([ends], radii=[0.2 * radius], colors=[[50, 50, 50]]), static=True)
        angle = f"wheel{index}_roller{roller}_angle_rad"
        if angle in trace:
            send(f"roller_angle_rad/{wheel['name']}/{roller}", rr.Scalars.columns(scalars=trace[angle]))


def _quaternions(roll: np.ndarray, pitch: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Quaternions x, y, z, w of rotations by roll about x, then pitch about y, then heading about
    z.
    """
    sines, cosines = zip(*((np.sin(0.5 * angle), np.cos(0.5 * angle)) for angle in (roll, pitch, heading)), strict=True)
    (sr, sp, sy), (cr, cp, cy) = sines, cosines
    return np.column_stack(
        [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ]
    )
