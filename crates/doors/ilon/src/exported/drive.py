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
# Of the wheels' motors here: their gains over those in the file, and the rate demanded per angle that is missing, in 1/s. Wheels of a steady drive
# keep their rates at each hand-over, as in ilon; those of a trace keep their angles, and take the jolts of its start softly.
STRONGER, FOLLOWS = 10.0, 5.0
OF_TRACE = 1.0, 25.0
# Of the servos that steer: their gains over those in the file.
STIFFER = 30.0
# Of motors in the file: the time in which they settle, in seconds.
SETTLES_S = 0.02


def drive(file, about, times, rates, angles=None, step_s=None, stiffer=1.0, steering=None):
    """Time, x, y, z, heading and the wheels' angles after each step. Angles that are not given are the integrals of the rates."""
    model = mujoco.MjModel.from_xml_path(str(file))
    if step_s:
        model.opt.timestep = step_s
    model.geom_solref[:, 0] /= stiffer
    # Of tyres stiffness and damping, of all others the time in which they settle.
    model.pair_solref *= np.array([stiffer**2, stiffer])
    model.pair_solreffriction *= stiffer
    data = mujoco.MjData(model)
    wheels = about["wheels"]
    stronger, follows = (STRONGER, FOLLOWS) if angles is None else OF_TRACE
    angle_at = [model.joint(name).qposadr[0] for name in wheels]
    motor_of = [model.actuator(name).id for name in wheels]
    if about["on_tyres"]:
        # Tyres slide in turns, and where a wheel turns more easily than its robot moves MuJoCo's friction pulls less along it than Coulomb's.
        turned = [model.joint(name).dofadr[0] for name in wheels]
        model.dof_armature[turned] += (stronger - 1.0) * SETTLES_S * model.actuator_gainprm[motor_of, 0]
    gains = stronger * model.actuator_gainprm[motor_of, 0]
    model.actuator_gainprm[motor_of, 0] = follows * gains
    model.actuator_biasprm[motor_of, 1] = -follows * gains
    model.actuator_biasprm[motor_of, 2] = -gains
    model.actuator_forcelimited[motor_of] = model.actuator_ctrllimited[motor_of] = 0
    for name, position in (steering or {}).items():
        # Tyres that turn on the spot would push a servo of the file off by 0.2 % of the turn.
        servo = model.actuator(name).id
        model.actuator_gainprm[servo] *= STIFFER
        model.actuator_biasprm[servo] *= STIFFER
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
    for demanded in (angles + rates / follows).T[:-1]:
        data.ctrl[motor_of] = demanded
        mujoco.mj_step(model, data)
        x, y, z, *quaternion = data.qpos[base : base + 7]
        rows.append([data.time, x, y, z, heading_of(*quaternion), *data.qpos[angle_at]])
    rows = np.array(rows)
    rows[:, 4] = np.unwrap(rows[:, 4])
    return rows


def heading_of(w, x, y, z):
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def angles_of(rates, step_s):
    """The integrals of rates."""
    means = 0.5 * step_s * (rates[:, 1:] + rates[:, :-1])
    return np.cumsum(np.hstack([0.0 * rates[:, :1], means]), axis=1)


def measured(one, rows):
    """What a drive of which these are the rows reached: its speed over that of ideal kinematics, and how far the base rose and fell, in mm."""
    first, last = one["window_s"]
    rows = rows[(rows[:, 0] >= first - 1e-9) & (rows[:, 0] <= last + 1e-9)]
    steps = np.diff(rows, axis=0)
    heading = 0.5 * (rows[1:, 4] + rows[:-1, 4])
    ahead = np.cos(heading) * steps[:, 1] + np.sin(heading) * steps[:, 2]
    left = np.cos(heading) * steps[:, 2] - np.sin(heading) * steps[:, 1]
    moved = np.array([ahead.sum(), left.sum(), steps[:, 4].sum()])
    # Rows below those of the wheels are what tyres hold at zero.
    turned = np.zeros(len(one["rate_matrix"]))
    turned[: rows.shape[1] - 5] = rows[-1, 5:] - rows[0, 5:]
    ideal = np.linalg.pinv(np.array(one["rate_matrix"])) @ turned
    ratio = moved[one["axis"]] / ideal[one["axis"]]
    return {"name": one["name"], "ratio": ratio, "travel_mm": 1e3 * (rows[:, 3].max() - rows[:, 3].min())}


def main():
    place = Path(sys.argv[1])
    about = json.loads(place.read_text())
    file = place.parent / about["model"]
    drives = [measured(one, drive(file, about, one["times_s"], one["rates_rad_s"], steering=one["steering"])) for one in about["drives"]]
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

        ends = {
            "end": at_end(rows),
            "ilon": end,
            "difference": at_end(rows) - end,
            "geometry": np.array(trace["geometry"]),
            "softness": at_end(fine) - at_end(stiff),
            "step": at_end(rows) - at_end(fine),
            "remainder": at_end(stiff) - end - trace["geometry"],
        }
        # Headings by the shorter way round.
        answer["scenario"] = {name: [x, y, math.remainder(turn, math.tau)] for name, (x, y, turn) in ends.items()}
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
