"""An arm of MuJoCo on a mecanum base of ilon, which drives against a box and pushes it while the arm swings.

ilon moves the base on its rollers, MuJoCo the arm and the box. At the end both engines' accounts of energy are laid side by side: what the
motors gave, where it went, and what passed between the engines.

    pip install "./python[mujoco]"
    python python/examples/mujoco_arm.py [--viewer] [--friction 0.6]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path

import mujoco
import mujoco.viewer
import numpy as np

import ilon
import ilon.mujoco

ROBOT = Path(__file__).resolve().parents[2] / "assets" / "robots" / "mecanum4.urdf"

# The base's own geom only touches the box: it stands on ilon's wheels.
SCENE = """
<mujoco model="arm on a base">
  <option timestep="0.001" gravity="0 0 -9.81" integrator="implicitfast"/>
  <visual><global offwidth="960" offheight="540"/></visual>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="3 3 .1" friction=".3 .005 .0001" rgba=".9 .9 .88 1"/>
    <body name="base_link" pos="0 0 .05">
      <freejoint/>
      <geom type="box" size=".2 .14 .04" pos="0 0 .05" friction=".1 .005 .0001" rgba=".2 .4 .7 1"/>
      <body name="upper" pos="0 0 .08">
        <joint name="shoulder" axis="0 0 1" damping=".05"/>
        <geom type="capsule" fromto="0 0 .05 .25 0 .15" size=".02" mass=".8" contype="0" conaffinity="0"/>
        <body name="fore" pos=".25 0 .15">
          <joint name="elbow" axis="0 1 0" damping=".05"/>
          <geom type="capsule" fromto="0 0 0 .2 0 .05" size=".02" mass=".5" contype="0" conaffinity="0"/>
          <geom name="payload" type="sphere" size=".03" pos=".2 0 .05" mass=".7" contype="0" conaffinity="0"/>
        </body>
      </body>
    </body>
    <body name="box" pos=".5 0 .1">
      <freejoint/>
      <geom type="box" size=".1 .15 .1" mass="2" friction=".3 .005 .0001" rgba=".8 .5 .2 1"/>
    </body>
  </worldbody>
  <contact><exclude body1="world" body2="base_link"/></contact>
  <actuator>
    <motor joint="shoulder" ctrlrange="-12 12" ctrllimited="true"/>
    <motor joint="elbow" ctrlrange="-12 12" ctrllimited="true"/>
  </actuator>
</mujoco>
"""

STIFFNESS, DAMPING = np.array([120.0, 120.0]), np.array([8.0, 6.0])
AHEAD_M_S, LASTS_S, STARTS_S = 0.3, 2.0, 0.4


def arm_wants(t_s: float) -> np.ndarray:
    """Angles of shoulder and elbow: a swing to both sides, and a nod."""
    return np.array([0.8 * np.sin(2.5 * t_s), 0.3 * (1 - np.cos(3.0 * t_s))])


@dataclass
class Account:
    """Energies supplied and dissipated, in J, and distances, in m."""

    ilon: dict[str, float]
    scene_stored: float
    scene_motors: float
    scene_dampers: float
    scene_contacts: float
    passed_by_mujoco: float
    passed_by_ilon: float
    base_m: float
    box_m: float
    potential_begins: float


def drive(friction: float = 0.6, lasts_s: float = LASTS_S, looker: object = None) -> Account:
    """Drives ahead against the box; returns the account at the end."""
    simulation = ilon.Simulation({
        "robot": {"file": str(ROBOT)},
        "twist": {},
        "world": {"floor": {"friction": friction}},
        "run": {"duration_s": lasts_s, "physics_dt_s": 0.001},
        # Default gains follow from the robot's own mass, without arm and box.
        "wheel_loop": {"bandwidth_rad_s": 40.0},
    })
    model = mujoco.MjModel.from_xml_string(SCENE)
    data = mujoco.MjData(model)
    base = ilon.mujoco.Base(model, data, simulation, body="base_link")
    view = mujoco.viewer.launch_passive(model, data) if looker else None
    joints = slice(6, 8)
    begins_j, box_begins_m = sum(base.scene_energy_j()), data.body("box").xpos.copy()
    potential_begins_j = simulation.energies()["potential_j"]
    motors_j = dampers_j = 0.0
    while data.time < lasts_s - 1e-9:
        # A gentle start: sliding wheels have no control.
        ahead = AHEAD_M_S * min(data.time / STARTS_S, 1.0)
        data.ctrl[:] = STIFFNESS * (arm_wants(data.time) - data.qpos[7:9]) - DAMPING * data.qvel[joints]
        torques, before = np.clip(data.ctrl, -12, 12), data.qvel[joints].copy()
        base.step(simulation.wheel_rates([ahead, 0.0, 0.0]))
        mean = 0.5 * (before + data.qvel[joints])
        motors_j += torques @ mean * base.dt_s
        dampers_j += model.dof_damping[joints] @ (mean**2) * base.dt_s
        if view is not None:
            view.sync()
            time.sleep(base.dt_s)
    stored_j = sum(base.scene_energy_j()) - begins_j
    return Account(
        ilon=simulation.energies(),
        scene_stored=stored_j,
        scene_motors=motors_j,
        scene_dampers=dampers_j,
        scene_contacts=motors_j + base.work_on_scene_j - dampers_j - stored_j,
        passed_by_mujoco=base.work_on_scene_j,
        passed_by_ilon=-simulation.energies()["outside_j"],
        base_m=simulation.truth().pose[0],
        potential_begins=potential_begins_j,
        box_m=float(np.linalg.norm(data.body("box").xpos - box_begins_m)),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--viewer", action="store_true", help="look at it in MuJoCo's viewer")
    parser.add_argument("--friction", type=float, default=0.6, help="of ilon's floor under the wheels")
    arguments = parser.parse_args()
    account = drive(arguments.friction, looker=arguments.viewer)
    print(f"the base drove {account.base_m:.3f} m and pushed the box {account.box_m:.3f} m")
    for name, joules in account.ilon.items():
        print(f"  ilon    {name:16} {joules:9.4f} J")
    for name in ("scene_motors", "scene_stored", "scene_dampers", "scene_contacts"):
        print(f"  MuJoCo  {name:16} {getattr(account, name):9.4f} J")
    print(f"  passed from the base to the scene: {account.passed_by_mujoco:.5f} J by MuJoCo, {account.passed_by_ilon:.5f} J by ilon")


if __name__ == "__main__":
    main()
