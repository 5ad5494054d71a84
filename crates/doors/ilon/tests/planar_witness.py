"""Drives the base of planar.xml in MuJoCo over held_out.csv and prints how far it is off from ilon, as planar.json counts it."""
import csv
import json
import pathlib
import sys

import mujoco
import numpy as np

folder = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(folder))
from planar import moved  # noqa: E402

model = mujoco.MjModel.from_xml_path(str(folder / "planar.xml"))
data = mujoco.MjData(model)
rows = [[float(x) for x in row] for row in list(csv.reader(open(folder / "held_out.csv")))[1:]]
drives = {}
for row in rows:
    drives.setdefault(row[0], []).append(row[1:])
squares, over_path, headings = [], [], []
for drive in drives.values():
    mujoco.mj_resetData(model, data)
    # What was pushed stays below what the ranges allow: nothing asked is cut off.
    truth, before, path = np.zeros(3), 0.0, 0.0
    for t, *twists in drive:
        twists = np.array(twists)
        dt, before = t - before, t
        assert (np.abs(twists[:3]) <= model.actuator_ctrlrange[:, 1] * (1 + 1e-6)).all()
        data.ctrl[:] = twists[:3]
        # Steps of 2 ms or less, a whole number of them in a row of the file.
        model.opt.timestep = dt / np.ceil(dt / 0.002)
        for _ in range(round(dt / model.opt.timestep)):
            mujoco.mj_step(model, data)
        truth = moved(truth, twists[3:], dt)
        path += np.hypot(*twists[3:5]) * dt
        c, s = np.cos(data.qpos[2]), np.sin(data.qpos[2])
        v = np.array([c * data.qvel[0] + s * data.qvel[1], c * data.qvel[1] - s * data.qvel[0], data.qvel[2]])
        squares.append((v - twists[3:]) ** 2)
    over_path.append(np.hypot(*(data.qpos[:2] - truth[:2])) / path)
    headings.append((data.qpos[2] - truth[2]) ** 2)
# With its servos off and a push, the base slides with what friction and damping leave.
mujoco.mj_resetData(model, data)
model.opt.timestep = 0.002
model.opt.disableactuator = 1 << 1
force, mass = 0.2 * model.actuator_forcerange[0, 1], model.body_mass[1] + model.dof_armature[0]
while data.time < 1.0:
    data.xfrc_applied[1, 0] = force
    mujoco.mj_step(model, data)
friction, damping = model.dof_frictionloss[0], model.dof_damping[0]
k = damping / mass
expected = (force - friction) / mass * ((1 - np.exp(-k)) / k if k > 0 else 1.0)
print(json.dumps({
    "twist_rms": list(np.sqrt(np.mean(squares, axis=0))),
    "position_over_path": np.mean(over_path),
    "heading_rms_rad": np.sqrt(np.mean(headings)),
    "pushed": data.qvel[0] / expected,
}))
