"""Whether memory stays as it is over millions of control steps, and over environments that are made and dropped.

    python python/benchmarks/endurance.py [--steps 10000000] [--environments 1000] [--threads 1]

Robots are stepped in one process, with episodes of some seconds that begin anew by themselves and draw friction and payload. Memory is what
the process has resident, from /proc; it is printed as it goes, with the threads and open files of the process.
"""

from __future__ import annotations

import argparse
import gc
import os
import time
from pathlib import Path

import gymnasium
import numpy as np

import ilon
import ilon.gym

ROBOTS = 64


def process() -> tuple[float, int, int]:
    """Resident memory in MB, threads, open files."""
    lines = Path("/proc/self/status").read_text().splitlines()
    status = dict(line.split(":", 1) for line in lines)
    return int(status["VmRSS"].split()[0]) / 1024, int(status["Threads"]), len(os.listdir("/proc/self/fd"))


def say(what: str, begun: float) -> None:
    memory_mb, threads, files = process()
    print(
        f"{time.perf_counter() - begun:8.1f} s  {what:>24}  {memory_mb:7.1f} MB  {threads} threads  {files} files",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--steps", type=int, default=10_000_000)
    parser.add_argument("--environments", type=int, default=1000)
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    options = {
        "settings": {"run.physics_dt_s": 0.01},
        "randomise": {"world.floor.friction": (0.4, 0.9)},
        "episode_s": 10.0,
    }
    begun = time.perf_counter()
    say("begun", begun)
    envs = gymnasium.make_vec("ilon/Track-v0", num_envs=ROBOTS, threads=arguments.threads, **options)
    envs.reset(seed=0)
    action = np.zeros(envs.action_space.shape, dtype=np.float32)
    episodes = 0
    rounds = arguments.steps // ROBOTS
    for step in range(rounds):
        # Twists that turn slowly, so that nothing slides.
        action[:] = 0.2 * np.array([np.cos(0.02 * step), np.sin(0.02 * step), 0.3])
        _, _, terminated, truncated, _ = envs.step(action)
        episodes += int(np.count_nonzero(terminated | truncated))
        if step % (rounds // 20) == 0:
            say(f"{ROBOTS * (step + 1)} steps", begun)
    say(f"{ROBOTS * rounds} steps", begun)
    print(f"{episodes} episodes", flush=True)
    envs.close()
    del envs
    gc.collect()
    say("closed", begun)
    for count in range(1, arguments.environments + 1):
        env = gymnasium.make("ilon/Track-v0", disable_env_checker=True, **options)
        env.reset(seed=count)
        env.step(env.action_space.sample() * 0.1)
        env.close()
        del env
        if count % max(1, arguments.environments // 10) == 0:
            gc.collect()
            say(f"{count} environments", begun)


if __name__ == "__main__":
    main()
