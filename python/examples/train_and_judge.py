"""Trains one policy twice in MuJoCo, on the wheels as made and on planar joints, and lets ilon judge both.

The policy is linear: the wanted twist from the error to the desired pose and the desired velocity, 18 numbers, found by the cross-entropy
method on a fast figure eight. `wheels` is the robot of `ilon export --mjcf`; `planar` is the usual trick, a box on two slides and a hinge
whose servos move it at the wanted twist. Needs `pip install mujoco`, and some minutes on two cores.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from functools import cache
from multiprocessing import Pool
from pathlib import Path

import mujoco
import numpy as np

import ilon

ROBOT = Path(__file__).resolve().parents[2] / "assets" / "robots" / "mecanum4.urdf"
SCENARIO = {
    "robot": {"file": str(ROBOT), "roller_bodies": "near"},
    "reference": {"figure_eight": {"half_width_m": 1.0, "period_s": 8.0, "heading": {"constant_deg": 30.0}}},
    "guidance": {},
    "run": {"duration_s": 8.0, "control_dt_s": 0.02, "physics_dt_s": 0.001},
}
TOP = np.array([1.5, 1.5, 4.84])
"""What an action of 1 means: the robot's top speeds, in m/s, m/s and rad/s."""
CONTROL_S, STEP_S, LASTS_S, LOST_M = 0.02, 0.002, 4.0, 0.5
PLANAR = """<mujoco><option timestep="0.002" integrator="implicitfast"/><worldbody><body>
<joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/><joint name="turn" axis="0 0 1"/>
<geom type="box" size=".2 .12 .05" mass="11.36"/></body></worldbody>
<actuator><velocity joint="x" kv="600"/><velocity joint="y" kv="600"/><velocity joint="turn" kv="15"/></actuator></mujoco>"""


class World:
    """The robot in MuJoCo: a file, or `planar`."""

    def __init__(self, model: str) -> None:
        self.is_planar = model == "planar"
        self.model = mujoco.MjModel.from_xml_string(PLANAR) if self.is_planar else mujoco.MjModel.from_xml_path(model)
        self.data = mujoco.MjData(self.model)
        self.ilon = ilon.Simulation(SCENARIO)

    def pose(self) -> np.ndarray:
        if self.is_planar:
            return self.data.qpos[:3].copy()
        x, y, _, w, i, j, k = self.data.qpos[:7]
        return np.array([x, y, np.arctan2(2 * (w * k + i * j), 1 - 2 * (j * j + k * k))])

    def seen(self, t_s: float) -> np.ndarray:
        """The error and the desired velocity in the body's frame, the first six observations of `ilon/Track-v0`."""
        pose, desired = self.pose(), self.ilon.desired(t_s)
        c, s = np.cos(pose[2]), np.sin(pose[2])
        to_body = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        error = to_body @ (desired.pose - pose)
        error[2] = np.arctan2(np.sin(error[2]), np.cos(error[2]))
        return np.append(error, to_body @ desired.velocity_in_world)

    def command(self, twist: np.ndarray) -> None:
        if self.is_planar:
            c, s = np.cos(self.data.qpos[2]), np.sin(self.data.qpos[2])
            self.data.ctrl[:] = [c * twist[0] - s * twist[1], s * twist[0] + c * twist[1], twist[2]]
        else:
            rates = self.ilon.wheel_rates(twist)
            self.data.ctrl[:] = rates / max(1.0, np.abs(rates).max() / self.ilon.wheel_rate_limit_rad_s)

    def errors(self, numbers: np.ndarray, seed: int) -> tuple[float, float]:
        """The root mean square of the position error in m in an episode that begins near somewhere on the path, and whether it left it."""
        rng = np.random.default_rng(seed)
        mujoco.mj_resetData(self.model, self.data)
        phase_s = rng.uniform(0.0, SCENARIO["run"]["duration_s"])
        start = self.ilon.desired(phase_s).pose + rng.uniform(-1, 1, 3) * [0.03, 0.03, 0.1]
        x, y, turn = start
        z = self.data.qpos[2]
        self.data.qpos[: 3 if self.is_planar else 7] = start if self.is_planar else [x, y, z, np.cos(turn / 2), 0, 0, np.sin(turn / 2)]
        squares = []
        for step in range(round(LASTS_S / CONTROL_S)):
            t_s = phase_s + step * CONTROL_S
            self.command(twist_of(numbers, self.seen(t_s)))
            mujoco.mj_step(self.model, self.data, round(CONTROL_S / STEP_S))
            off_m = np.hypot(*self.seen(t_s + CONTROL_S)[:2])
            squares.append(off_m**2)
            if not off_m < LOST_M:
                return LOST_M, 1.0
        return float(np.sqrt(np.mean(squares))), 0.0


def twist_of(numbers: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """The policy: the wanted twist in m/s, m/s and rad/s."""
    return np.clip(numbers.reshape(3, 6) @ seen[:6], -TOP, TOP)


world = cache(World)


def errors(model: str, numbers: np.ndarray, seed: int) -> tuple[float, float]:
    """Those of `World.errors`, in a process that keeps its world."""
    return world(model).errors(numbers, seed)


def trained(model: str, generations: int, candidates: int = 32, episodes: int = 2) -> tuple[np.ndarray, dict[str, float]]:
    """The policy that the cross-entropy method finds, and its figures on episodes that it has not seen."""
    rng = np.random.default_rng(0)
    mean = np.hstack([2.0 * np.eye(3), np.eye(3)]).ravel()
    spread = np.where(mean > 0.0, 0.5 * mean, 0.2)
    with Pool(2) as pool:
        for generation in range(generations):
            numbers = mean + spread * rng.standard_normal((candidates, len(mean)))
            numbers[0] = mean
            seeds = rng.integers(1000, 2**31, episodes)
            found = pool.starmap(errors, [(model, each, int(seed)) for each in numbers for seed in seeds])
            costs = np.array(found).reshape(candidates, episodes, 2).sum(axis=(1, 2))
            best = numbers[np.argsort(costs)[: candidates // 4]]
            mean, spread = best.mean(axis=0), 0.9 * spread * 0.5 + 0.5 * best.std(axis=0)
            print(f"  generation {generation + 1}: {1e3 * costs.min() / episodes:.1f} mm", flush=True)
        unseen = np.array(pool.starmap(errors, [(model, mean, seed) for seed in range(16)]))
    return mean, {"error_m": float(np.sqrt((unseen[:, 0] ** 2).mean())), "falls": float(unseen[:, 1].mean())}


def main() -> None:
    parser = argparse.ArgumentParser(description="Trains one policy twice in MuJoCo, and judges both.")
    parser.add_argument("--generations", type=int, default=20)
    generations = parser.parse_args().generations
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "ilon", "export", ROBOT, "--mjcf", "--out", folder], check=True)
        for name, model in (("planar", "planar"), ("wheels", f"{folder}/mecanum4_scene.xml")):
            numbers, figures = trained(model, generations)
            options = {"scenario": SCENARIO, "start_off_m": 0.03, "episode_s": LASTS_S}
            # An action is the twist over what 1 means.
            found = ilon.judge(lambda seen, of=numbers: twist_of(of, seen) / TOP, range(16), trained=figures, **options)
            print(f"{name}: {1e3 * figures['error_m']:.1f} mm in training, {figures['falls']:.0%} lost\n  {found}", flush=True)


if __name__ == "__main__":
    main()
