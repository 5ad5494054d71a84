"""Drives a robot that `ilon export` wrote, in MuJoCo, and prints as JSON what it does: python drive.py drive.json

Wheels follow the drive's angles and rates, so that they stay in step as in ilon; speeds are given over those that ideal kinematics gives for the rates that the wheels really had.
A drive with a `trace` is compared with ilon's path, also at an eighth of the step, and there on contacts that settle eight times as fast: `step` and
`softness` are what these change at the end. `geometry` is what the fitted shapes change, by contact kinematics.
"""

import json
import math
import sys
from pathlib import Path

import mujoco
import numpy as np

# How much finer a run shows what the step and soft contacts do.
FINER = 8.0
# Of the wheels' motors here: rate demanded per angle that is missing, in 1/s.
FOLLOWS = 25.0
# Of motors in the file: the time in which they settle, in seconds.
SETTLES_S = 0.02
# Tyres slide in turns, and where a wheel turns more easily than its robot moves MuJoCo's friction pulls less along it than Coulomb's. Its
# motor, which follows the drive in any case, therefore carries this many times its inertia.
HEAVIER = 10.0


def drive(file, about, times, rates, angles=None, step_s=None, stiffer=1.0, steering=None):
    """Time, x, y, z, heading and the wheels' angles after each step. Angles that are not given are the integrals of the rates."""
    model = mujoco.MjModel.from_xml_path(str(file))
    if step_s:
        model.opt.timestep = step_s
    model.geom_solref[:, 0] /= stiffer
    data = mujoco.MjData(model)
    wheels = about["wheels"]
    angle_at = [model.joint(name).qposadr[0] for name in wheels]
    motor_of = [model.actuator(name).id for name in wheels]
    if about["on_tyres"]:
        turned = [model.joint(name).dofadr[0] for name in wheels]
        model.dof_armature[turned] += (HEAVIER - 1.0) * SETTLES_S * model.actuator_gainprm[motor_of, 0]
        model.actuator_gainprm[motor_of, 0] *= HEAVIER
        model.actuator_biasprm[motor_of, 2] *= HEAVIER
        model.actuator_forcelimited[motor_of] = 0
    model.actuator_gainprm[motor_of, 0] *= FOLLOWS
    model.actuator_biasprm[motor_of, 1] = -model.actuator_gainprm[motor_of, 0]
    model.actuator_ctrllimited[motor_of] = 0
    for name, position in (steering or {}).items():
        data.qpos[model.joint(name).qposadr[0]] = position
        data.ctrl[model.actuator(name).id] = position
    base = model.joint(0).qposadr[0]
    steps_s = model.opt.timestep * np.arange(round(times[-1] / model.opt.timestep) + 1)
    rates = np.array([np.interp(steps_s, times, of_wheel) for of_wheel in rates])
    if angles is None:
        angles = angles_of(rates, model.opt.timestep)
    else:
        angles = np.array([np.interp(steps_s, times, of_wheel) - of_wheel[0] for of_wheel in angles])
    rows = []
    for demanded in (angles + rates / FOLLOWS).T[:-1]:
        data.ctrl[motor_of] = demanded
        mujoco.mj_step(model, data)
        x, y, z, qw, qx, qy, qz = data.qpos[base : base + 7]
        heading = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
        rows.append([data.time, x, y, z, heading, *data.qpos[angle_at]])
    rows = np.array(rows)
    rows[:, 4] = np.unwrap(rows[:, 4])
    return rows


def angles_of(rates, step_s):
    """The integrals of rates."""
    means = 0.5 * step_s * (rates[:, 1:] + rates[:, :-1])
    return np.cumsum(np.hstack([0.0 * rates[:, :1], means]), axis=1)


def measured(matrix, rows, window):
    """Twist over that of ideal kinematics, by axis, and how far the base rises and falls, in mm."""
    rows = rows[(rows[:, 0] >= window[0] - 1e-9) & (rows[:, 0] <= window[1] + 1e-9)]
    lasts_s = rows[-1, 0] - rows[0, 0]
    steps = np.diff(rows, axis=0)
    heading = 0.5 * (rows[1:, 4] + rows[:-1, 4])
    ahead = np.cos(heading) * steps[:, 1] + np.sin(heading) * steps[:, 2]
    left = np.cos(heading) * steps[:, 2] - np.sin(heading) * steps[:, 1]
    twist = np.array([ahead.sum(), left.sum(), steps[:, 4].sum()]) / lasts_s
    # Rows below those of the wheels are what tyres hold at zero.
    rates = np.zeros(len(matrix))
    rates[: rows.shape[1] - 5] = (rows[-1, 5:] - rows[0, 5:]) / lasts_s
    ideal = np.linalg.pinv(np.array(matrix)) @ rates
    return twist, ideal, 1e3 * (rows[:, 3].max() - rows[:, 3].min())


def main():
    place = Path(sys.argv[1])
    about = json.loads(place.read_text())
    file = place.parent / about["model"]
    drives = []
    for one in about["drives"]:
        rows = drive(file, about, one["times_s"], one["rates_rad_s"], steering=one["steering"])
        twist, ideal, travel_mm = measured(one["rate_matrix"], rows, one["window_s"])
        axis = one["axis"]
        drives.append({"name": one["name"], "ratio": twist[axis] / ideal[axis], "travel_mm": travel_mm})
    answer = {"simulator": "MuJoCo " + mujoco.__version__, "drives": drives}
    if "trace" in about:
        trace = about["trace"]
        play = [trace["times_s"], trace["rates_rad_s"], trace["angles_rad"]]
        rows = drive(file, about, *play)
        step_s = mujoco.MjModel.from_xml_path(str(file)).opt.timestep
        fine = drive(file, about, *play, step_s=step_s / FINER)
        stiff = drive(file, about, *play, step_s=step_s / FINER, stiffer=FINER)
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
            "softness": (at_end(fine) - at_end(stiff)).tolist(),
            "step": (at_end(rows) - at_end(fine)).tolist(),
            "remainder": (at_end(stiff) - end - trace["geometry"]).tolist(),
        }
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
