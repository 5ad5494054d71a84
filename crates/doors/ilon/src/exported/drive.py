"""Drives a robot that `ilon export` wrote, in MuJoCo, and prints as JSON what it does: python drive.py drive.json

Each wheel's rate follows the drive's; speeds are given over those that ideal kinematics gives for the rates that the wheels really had.
A drive with a `trace` is compared with ilon's path, also at half the step and on contacts twice as stiff: `softness` and `step` are what
these change at the end. `geometry` is what the fitted shapes change, by contact kinematics.
"""

import json
import math
import sys
from pathlib import Path

import mujoco
import numpy as np


def drive(file, about, times, rates, step_s=None, stiffer=1.0):
    """Time, x, y, z, heading and the wheels' angles after each step."""
    model = mujoco.MjModel.from_xml_path(str(file))
    if step_s:
        model.opt.timestep = step_s
    model.geom_solref[:, 0] /= stiffer
    data = mujoco.MjData(model)
    wheels = about["wheels"]
    angle_at = [model.joint(name).qposadr[0] for name in wheels]
    motor_of = [model.actuator(name).id for name in wheels]
    base = model.joint(0).qposadr[0]
    rows = []
    for k in range(round(times[-1] / model.opt.timestep)):
        for motor, of_wheel in zip(motor_of, rates):
            data.ctrl[motor] = np.interp(k * model.opt.timestep, times, of_wheel)
        mujoco.mj_step(model, data)
        x, y, z, qw, qx, qy, qz = data.qpos[base : base + 7]
        heading = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
        rows.append([data.time, x, y, z, heading, *data.qpos[angle_at]])
    rows = np.array(rows)
    rows[:, 4] = np.unwrap(rows[:, 4])
    return rows


def measured(about, rows, window):
    """Twist over that of ideal kinematics, by axis, and how far the base rises and falls, in mm."""
    rows = rows[rows[:, 0] >= window[0]]
    lasts_s = rows[-1, 0] - rows[0, 0]
    steps = np.diff(rows, axis=0)
    heading = 0.5 * (rows[1:, 4] + rows[:-1, 4])
    ahead = np.cos(heading) * steps[:, 1] + np.sin(heading) * steps[:, 2]
    left = np.cos(heading) * steps[:, 2] - np.sin(heading) * steps[:, 1]
    twist = np.array([ahead.sum(), left.sum(), steps[:, 4].sum()]) / lasts_s
    ideal = np.linalg.pinv(np.array(about["rate_matrix"])) @ ((rows[-1, 5:] - rows[0, 5:]) / lasts_s)
    return twist, ideal, 1e3 * (rows[:, 3].max() - rows[:, 3].min())


def main():
    place = Path(sys.argv[1])
    about = json.loads(place.read_text())
    file = place.parent / about["model"]
    drives = []
    for one in about["drives"]:
        rows = drive(file, about, one["times_s"], one["rates_rad_s"])
        twist, ideal, travel_mm = measured(about, rows, one["window_s"])
        axis = one["axis"]
        drives.append({"name": one["name"], "ratio": twist[axis] / ideal[axis], "travel_mm": travel_mm})
    answer = {"simulator": "MuJoCo " + mujoco.__version__, "drives": drives}
    if "trace" in about:
        trace = about["trace"]
        play = [trace["times_s"], trace["rates_rad_s"]]
        rows = drive(file, about, *play)
        step_s = mujoco.MjModel.from_xml_path(str(file)).opt.timestep
        half = drive(file, about, *play, step_s=0.5 * step_s)
        stiff = drive(file, about, *play, step_s=0.5 * step_s, stiffer=2.0)
        start, end = np.array(trace["start"]), np.array(trace["end"])

        def at_end(of):
            x, y, heading = of[-1, 1], of[-1, 2], of[-1, 4]
            c, s = math.cos(start[2]), math.sin(start[2])
            return np.array([start[0] + c * x - s * y, start[1] + s * x + c * y, start[2] + heading])

        answer["scenario"] = {
            "end": at_end(rows).tolist(),
            "ilon": end.tolist(),
            "difference": (at_end(rows) - end).tolist(),
            "geometry": trace["geometry"],
            "softness": (at_end(half) - at_end(stiff)).tolist(),
            "step": (at_end(rows) - at_end(half)).tolist(),
            # Above all wheels that lag here and did not in ilon.
            "remainder": (
                at_end(rows) - end - trace["geometry"] - (at_end(half) - at_end(stiff)) - (at_end(rows) - at_end(half))
            ).tolist(),
        }
    print(json.dumps(answer))


main()
