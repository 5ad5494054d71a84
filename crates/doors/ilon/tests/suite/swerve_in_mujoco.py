"""A swerve robot in MuJoCo: cylinders for tyres, position servos for modules, velocity servos for wheels.

Prints as JSON the twist that it reaches over the one that its wheels and modules give by the ideal kinematics: along x and y, and about z.
Arguments: the twist in m/s and rad/s, and the width of the tyres in metres.
"""

import json
import sys

import mujoco
import numpy as np

VX, VY, OMEGA, WIDTH_M = map(float, sys.argv[1:])
PLACES = [(x, y) for x in (0.25, -0.25) for y in (0.2, -0.2)]
RADIUS_M = 0.05

# Masses and lengths of assets/robots/swerve4.urdf.
MODULE = """<body pos="{x} {y} .1"><joint name="steer{i}" axis="0 0 1"/><inertial pos="0 0 .04" mass="1" diaginertia=".002 .002 .002"/>
  <body pos="0 0 -.05"><joint name="drive{i}" axis="0 1 0"/><inertial pos="0 0 0" mass=".5" diaginertia=".00035 .000625 .00035"/>
    <geom type="cylinder" size="{radius} {half}" euler="90 0 0"/></body></body>"""
ACTUATORS = '<position joint="steer{i}" kp="200" kv="4"/><velocity joint="drive{i}" kv="5"/>'
MODULES = "".join(MODULE.format(i=i, x=x, y=y, radius=RADIUS_M, half=WIDTH_M / 2) for i, (x, y) in enumerate(PLACES))
MODEL = f"""<mujoco><option timestep="0.001" cone="elliptic" impratio="10" integrator="implicitfast"/>
<default><geom friction=".6 0 0" condim="3" solref=".004 1"/></default>
<worldbody><geom type="plane" size="9 9 1"/>
<body name="base"><freejoint/><inertial pos="0 0 .18" mass="20" diaginertia=".433333 .616667 1.016667"/>{MODULES}</body></worldbody>
<actuator>{"".join(ACTUATORS.format(i=i) for i in range(4))}</actuator></mujoco>"""

model = mujoco.MjModel.from_xml_string(MODEL)
data = mujoco.MjData(model)
velocities = [np.array([VX - OMEGA * y, VY + OMEGA * x]) for x, y in PLACES]
real, ideal, seen = np.zeros(3), np.zeros(3), np.empty(6)
while data.time < 4.0:
    ramp = np.clip((data.time - 0.5) / 0.5, 0.0, 1.0)
    for i, v in enumerate(velocities):
        data.ctrl[2 * i] = np.arctan2(v[1], v[0])
        data.ctrl[2 * i + 1] = ramp * np.linalg.norm(v) / RADIUS_M
    mujoco.mj_step(model, data)
    if data.time < 2.0:
        continue
    # Angular before linear, in the frame of the body.
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, 1, seen, 1)
    real += seen[[3, 4, 2]]
    # u . v_h = rho q' along each wheel, n . v_h = 0 across it, for the angles and rates as measured.
    rows, sides = [], []
    for i, (x, y) in enumerate(PLACES):
        s, rate = data.joint(f"steer{i}").qpos[0], data.joint(f"drive{i}").qvel[0]
        for (ux, uy), side in (((np.cos(s), np.sin(s)), RADIUS_M * rate), ((-np.sin(s), np.cos(s)), 0.0)):
            rows.append([ux, uy, x * uy - y * ux])
            sides.append(side)
    ideal += np.linalg.lstsq(np.array(rows), np.array(sides), rcond=None)[0]
print(json.dumps((real / ideal).tolist()))
