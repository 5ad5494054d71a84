"""Drives a robot that `ilon export --newton` wrote, in Newton, and prints as JSON what it does: python newton_drive.py drive.json"""

import json
import math
import sys
from pathlib import Path

import newton
import numpy as np
import warp as wp

STEP_S = 0.002


def drive(file, about, times, rates):
    builder = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    builder.add_mjcf(str(file), enable_self_collisions=False, ctrl_direct=True)
    model = builder.finalize()
    solver = newton.solvers.SolverMuJoCo(
        model, solver="newton", integrator="implicitfast", cone="elliptic", impratio=10.0, iterations=30, ls_iterations=30, njmax=2048, nconmax=1024
    )
    now, after, control = model.state(), model.state(), model.control()
    newton.eval_fk(model, model.joint_q, model.joint_qd, now)
    labels = [label.split("/")[-1] for label in model.joint_label]
    joints = [labels.index(name) for name in about["wheels"]]
    angle_at = [int(model.joint_q_start.numpy()[joint]) for joint in joints]
    motors = wp.clone(control.mujoco.ctrl)
    rows = []
    for k in range(round(times[-1] / STEP_S)):
        asked = motors.numpy()
        asked[: len(joints)] = [np.interp(k * STEP_S, times, of_wheel) for of_wheel in rates]
        control.mujoco.ctrl.assign(asked)
        now.clear_forces()
        solver.step(now, after, control, None, STEP_S)
        now, after = after, now
        q = now.joint_q.numpy()
        x, y, z, qx, qy, qz, qw = q[:7]
        heading = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
        rows.append([(k + 1) * STEP_S, x, y, z, heading, *q[angle_at]])
    rows = np.array(rows, dtype=float)
    rows[:, 4] = np.unwrap(rows[:, 4])
    return rows


def main():
    wp.config.quiet = True
    wp.set_device("cpu")
    place = Path(sys.argv[1])
    about = json.loads(place.read_text())
    drives = []
    for one in about["drives"]:
        rows = drive(place.parent / about["model"], about, one["times_s"], one["rates_rad_s"])
        rows = rows[rows[:, 0] >= one["window_s"][0]]
        lasts_s = rows[-1, 0] - rows[0, 0]
        steps, heading = np.diff(rows, axis=0), 0.5 * (rows[1:, 4] + rows[:-1, 4])
        ahead = np.cos(heading) * steps[:, 1] + np.sin(heading) * steps[:, 2]
        left = np.cos(heading) * steps[:, 2] - np.sin(heading) * steps[:, 1]
        twist = np.array([ahead.sum(), left.sum(), steps[:, 4].sum()]) / lasts_s
        ideal = np.linalg.pinv(np.array(about["rate_matrix"])) @ ((rows[-1, 5:] - rows[0, 5:]) / lasts_s)
        axis = one["axis"]
        travel_mm = 1e3 * (rows[:, 3].max() - rows[:, 3].min())
        drives.append({"name": one["name"], "ratio": twist[axis] / ideal[axis], "travel_mm": travel_mm})
    print(json.dumps({"simulator": "Newton " + newton.__version__, "drives": drives}))


main()
