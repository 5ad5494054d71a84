"""Control steps a second of the task, beside a plain Gymnasium loop over MuJoCo: the same robot, 1/50 s a control step.

    python python/benchmarks/throughput.py [--seconds 5] [--json FILE]

MuJoCo reads the same URDF: every roller a body on its own hinge, seven spheres its outline, as the file has it. Its wheels are
driven by velocity actuators within the same torques. Its step is its default of 2 ms, and the longest at which the robot still
drives as it does there is looked at too. All drive the same twists, which turn slowly, so that nothing slides.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import gymnasium
import numpy as np

import ilon
import ilon.gym

URDF = Path(__file__).resolve().parents[2] / "assets" / "robots" / "mecanum4.urdf"
CONTROL_DT_S = 0.02
ROBOTS = 64
EPISODE = 800
"""Control steps of an episode of the task."""


def twists(step: int) -> np.ndarray:
    """Shares of the top speeds that turn slowly, from rest."""
    share = 0.2 * min(1.0, step / 50)
    return share * np.array([np.cos(0.02 * step), np.sin(0.02 * step), 0.3], dtype=np.float32)


def rate(act, seconds: float, robots: int = 1) -> tuple[float, float]:
    """Control steps per second: of wall clock, and of the CPU time of all threads."""
    warm_up = 100
    for step in range(warm_up):
        act(step)
    wall, cpu, step = time.perf_counter(), time.process_time(), warm_up
    while time.perf_counter() - wall < seconds:
        act(step)
        step += 1
    steps = robots * (step - warm_up)
    return steps / (time.perf_counter() - wall), steps / (time.process_time() - cpu)


def of_ilon(seconds: float, physics_dt_s: float | None, robots: int = 1, threads: int | None = None, action=twists):
    """Steps of `TrackEnv`, or of `TrackVectorEnv` for several robots."""
    settings = {} if physics_dt_s is None else {"run.physics_dt_s": physics_dt_s}
    options = {"settings": settings, "fail_at_m": 1e3, "episode_s": 1e4}
    if robots == 1:
        env = gymnasium.make("ilon/Track-v0", disable_env_checker=True, **options)

        def act(step: int) -> None:
            # Integrals of wheels that hold one another wind up over minutes, which episodes do not last.
            if step % EPISODE == 0:
                env.reset(seed=0)
            env.step(action(step % EPISODE))

        return rate(act, seconds)
    env = gymnasium.make_vec("ilon/Track-v0", num_envs=robots, threads=threads, **options)
    env.reset(seed=0)
    return rate(lambda step: env.step(np.tile(action(step), (robots, 1))), seconds, robots)


def mujoco_model(timestep_s: float):
    """The robot of the URDF on a plane, with one velocity actuator per wheel."""
    import mujoco

    # By default MuJoCo merges links that are fixed to each other, and drops their names.
    text = URDF.read_text().replace(
        "</robot>", '<mujoco><compiler discardvisual="true" fusestatic="false"/></mujoco></robot>'
    )
    spec = mujoco.MjSpec.from_string(text)
    base = spec.body("base_link")
    base.add_freejoint()
    floor = spec.worldbody.add_geom()
    floor.type, floor.size = mujoco.mjtGeom.mjGEOM_PLANE, [0, 0, 1]
    floor.friction[0] = 0.6
    for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
        actuator = spec.add_actuator(name=wheel, target=wheel, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.gainprm[0], actuator.biasprm[2] = 0.5, -0.5
        actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        actuator.forcelimited, actuator.forcerange = True, [-1.8, 1.8]
    # Only the robot and the floor touch.
    model = spec.compile()
    for geom in range(model.ngeom):
        is_floor = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE
        model.geom_contype[geom], model.geom_conaffinity[geom] = (1, 0) if is_floor else (0, 1)
    return model


class MujocoEnv(gymnasium.Env):
    """The plain loop, as users write it."""

    def __init__(self, timestep_s: float, kinematics: ilon.Simulation, scale: np.ndarray) -> None:
        import mujoco

        self.mj = mujoco
        self.model = mujoco_model(timestep_s)
        self.data = mujoco.MjData(self.model)
        self.substeps = round(CONTROL_DT_S / timestep_s)
        self.kinematics, self.scale = kinematics, scale
        size = self.model.nq + self.model.nv
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (size,), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (3,), np.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.mj.mj_resetData(self.model, self.data)
        self.mj.mj_forward(self.model, self.data)
        return self._see(), {}

    def step(self, action):
        self.data.ctrl[:] = self.kinematics.wheel_rates(action * self.scale)
        self.mj.mj_step(self.model, self.data, self.substeps)
        return self._see(), 0.0, False, False, {}

    def _see(self):
        return np.concatenate([self.data.qpos, self.data.qvel]).astype(np.float32)


def of_mujoco(seconds: float, timestep_s: float):
    env = ilon.gym.TrackEnv()
    loop = MujocoEnv(timestep_s, ilon.Simulation(ilon.gym.FIGURE_EIGHT), env.action_scale)
    loop.reset(seed=0)
    rates = rate(lambda step: loop.step(twists(step)), seconds)
    # Checks that it drives: a robot that has fallen over would be measured otherwise.
    loop.reset(seed=0)
    for _ in range(100):
        loop.step(np.array([0.2, 0.0, 0.0], dtype=np.float32))
    return rates, float(loop.data.qvel[0]), float(loop.data.qpos[2])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    seconds, figures = arguments.seconds, {}

    def say(name: str, rates: tuple[float, float], further: str = "") -> None:
        figures[name] = {"steps_per_s": rates[0], "steps_per_cpu_s": rates[1]}
        print(f"{name:55} {rates[0]:9.0f} control steps/s {rates[1]:9.0f} a core {further}")

    for dt_s in (None, 0.004, 0.005, 0.01, 0.02):
        step = ilon.Simulation(
            ilon.gym.FIGURE_EIGHT, settings={} if dt_s is None else {"run.physics_dt_s": dt_s}
        ).physics_dt_s
        say(f"ilon, one robot, physics {1e3 * step:.2f} ms", of_ilon(seconds, dt_s))
        say(f"ilon, {ROBOTS} robots, physics {1e3 * step:.2f} ms", of_ilon(seconds, dt_s, ROBOTS))
    rng = np.random.default_rng(0)
    wild = of_ilon(seconds, None, action=lambda _: rng.uniform(-1, 1, 3).astype(np.float32))
    say("ilon, one robot, actions at random, which slide", wild)
    for timestep_s in (0.002, 0.004, 0.005):
        rates, vx_m_s, height_m = of_mujoco(seconds, timestep_s)
        say(f"MuJoCo, one robot, physics {1e3 * timestep_s:.0f} ms", rates, f"(0.3 m/s asked: {vx_m_s:.3f}; z {height_m:.3f} m)")
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
