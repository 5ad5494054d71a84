"""Drives a robot that `ilon export --newton` wrote, in Newton, and prints as JSON what it does: python drive_newton.py drive.json

    pip install "newton[sim]"

`scene` is what a program of yours needs: Newton reads shapes, masses, bearings, friction and the solver's settings from the MJCF, and its
SolverMuJoCo steps them. All drives run at once, one in each world, on a GPU if there is one. Wheels follow angles and rates as in drive.py.
"""

import json
import sys
from pathlib import Path

import newton
import numpy as np
import warp as wp
from drive import FOLLOWS, STRONGER, angles_of, heading_of, measured

# For which the solver is set.
STEP_S = 0.002


def scene(file, wheels):
    """The robot on its floor, and the first coordinate and velocity of each wheel's joint, whose targets are followed."""
    one = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(one)
    one.add_mjcf(str(file))
    names = [label.split("/")[-1] for label in one.joint_label]
    joints = [names.index(name) for name in wheels]
    places = [one.joint_q_start[joint] for joint in joints], [one.joint_qd_start[joint] for joint in joints]
    for at in places[1]:
        one.joint_target_kd[at] *= STRONGER
        one.joint_target_ke[at] = FOLLOWS * one.joint_target_kd[at]
        one.joint_target_mode[at] = int(newton.JointTargetMode.POSITION_VELOCITY)
    return one, places


def drives(file, about):
    """Time, x, y, z, heading and the wheels' angles of each drive after each step."""
    one, (coordinates, velocities) = scene(file, about["wheels"])
    every = newton.ModelBuilder()
    every.replicate(one, len(about["drives"]))
    model = every.finalize()
    solver = newton.solvers.SolverMuJoCo(model, njmax=40 * len(about["wheels"]), nconmax=12 * len(about["wheels"]))
    now, then, control = model.state(), model.state(), model.control()
    newton.eval_fk(model, model.joint_q, model.joint_qd, now)
    worlds = range(len(about["drives"]))
    angle_at = np.array([[one.joint_coord_count * world + at for at in coordinates] for world in worlds])
    rate_at = np.array([[one.joint_dof_count * world + at for at in velocities] for world in worlds])
    steps_s = STEP_S * np.arange(round(max(of["times_s"][-1] for of in about["drives"]) / STEP_S) + 1)
    rates = np.array([[np.interp(steps_s, of["times_s"], r) for r in of["rates_rad_s"]] for of in about["drives"]])
    angles = np.array([angles_of(of_drive, STEP_S) for of_drive in rates])
    angle, rate = control.joint_target_q.numpy(), control.joint_target_qd.numpy()
    rows = []
    for step, t_s in enumerate(steps_s[1:]):
        angle[angle_at], rate[rate_at] = angles[:, :, step], rates[:, :, step]
        control.joint_target_q.assign(angle)
        control.joint_target_qd.assign(rate)
        now.clear_forces()
        solver.step(now, then, control, None, STEP_S)
        now, then = then, now
        q = now.joint_q.numpy().astype(float)
        for at in (one.joint_coord_count * world for world in worlds):
            x, y, z, qx, qy, qz, qw = q[at : at + 7]
            rows.append([t_s, x, y, z, heading_of(qw, qx, qy, qz), *q[at + np.array(coordinates)]])
    rows = np.array(rows).reshape(len(steps_s) - 1, len(worlds), -1).transpose(1, 0, 2)
    rows[:, :, 4] = np.unwrap(rows[:, :, 4])
    return rows


def main():
    wp.config.quiet = True
    place = Path(sys.argv[1])
    about = json.loads(place.read_text())
    if about["on_tyres"]:
        sys.exit("robots on tyres are driven in MuJoCo alone: take --mjcf")
    ran = [measured(one, rows) for one, rows in zip(about["drives"], drives(place.parent / about["model"], about))]
    print(json.dumps({"simulator": "Newton " + newton.__version__, "drives": ran}))


if __name__ == "__main__":
    main()
