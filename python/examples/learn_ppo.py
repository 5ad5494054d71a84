"""Learns `ilon/Track-v0` by PPO of Stable-Baselines3, from nothing, and says what came of it.

    pip install "./python[sb3]"
    python python/examples/learn_ppo.py [--steps 500000]
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecNormalize

import ilon.gym
import ilon.sb3

ROBOTS = 32
EPISODE_S = 8.0
TASK = {
    "episode_s": EPISODE_S,
    "randomise": {"world.floor.friction": (0.4, 0.9)},
    # Ten times the task's own step: coarse, for a first try.
    "settings": {"run.physics_dt_s": 0.01},
}


def judged(act) -> tuple[float, float, float]:
    """The share of its episodes that a law survives, and its mean position error in m and heading
    error in rad meanwhile: 64 robots, with seeds not used for learning.
    """
    envs = ilon.gym.TrackVectorEnv(num_envs=64, autoreset_mode="Disabled", **TASK)
    seen, _ = envs.reset(seed=list(range(5000, 5064)))
    on, lived, off_m, off_rad = np.ones(64, dtype=bool), 0, 0.0, 0.0
    steps = round(EPISODE_S / envs.control_dt_s)
    for _ in range(steps):
        seen, _, failed, time_is_up, info = envs.step(act(seen, envs))
        on &= ~failed
        lived += on.sum()
        off_m += info["position_error_m"][on].sum()
        off_rad += info["heading_error_rad"][on].sum()
        if (failed | time_is_up).any():
            seen, _ = envs.reset(options={"reset_mask": failed | time_is_up})
    return lived / (64 * steps), off_m / max(lived, 1), off_rad / max(lived, 1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=500_000)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    # Networks of this size are slower on several threads than on one.
    torch.set_num_threads(1)

    def said(name: str, act) -> None:
        lived, off_m, off_rad = judged(act)
        print(f"{name}: lives {100 * lived:.0f} %, {1e3 * off_m:.1f} mm and {np.degrees(off_rad):.2f} deg off", flush=True)

    said("at rest", lambda seen, _: np.zeros((len(seen), 3), dtype=np.float32))
    said("the paper's law, gains 2 /s", lambda seen, envs: ((seen[:, 3:6] + 2.0 * seen[:, :3]) / envs.action_scale).astype(np.float32))

    # Observations have units, and a network needs them normalised.
    envs = VecNormalize(ilon.sb3.TrackVecEnv(num_envs=ROBOTS, **TASK))
    # Small first actions: a beginner that draws from the whole range of 1.5 m/s leaves its path at
    # once.
    policy = {"log_std_init": -2.0, "net_arch": [64, 64]}
    model = PPO("MlpPolicy", envs, n_steps=128, batch_size=512, n_epochs=8, policy_kwargs=policy, seed=arguments.seed, device="cpu")
    began, done = time.perf_counter(), 0
    while done < arguments.steps:
        part = max(arguments.steps // 5, 1)
        model.learn(part, reset_num_timesteps=False)
        done += part

        def learned(seen, _):
            return model.predict(envs.normalize_obs(seen), deterministic=True)[0]

        said(f"PPO after {model.num_timesteps} steps and {time.perf_counter() - began:.0f} s", learned)


if __name__ == "__main__":
    main()
