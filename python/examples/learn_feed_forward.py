"""Learns what the paper's law does not know: how far ahead to look, and how much must be asked for.

The paper's law asks for the desired velocity plus gains times the error. Wheel loops and motors come late, and tilted rollers come
short of it, so that a fast figure eight is missed by millimetres. Here six numbers are learned by the cross-entropy method, from 64
robots at once:

| number | is |
|---|---|
| lead | how far ahead the desired velocity is read, in s |
| vx, vy, omega | by what factor more of it is asked for |
| position, heading | the gains, in 1/s |

What was learned then drives whole runs as a controller of one's own, beside the paper's law: the figure eight that it was learned on,
and one that it has not seen.

    python python/examples/learn_feed_forward.py        # a few minutes on two cores
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import ilon
import ilon.gym

SCENARIO = Path(__file__).resolve().parents[2] / "assets" / "scenarios" / "mecanum4_fast_eight_pid.toml"
"""A figure eight in 9 s, two metres across, looking along it."""
UNSEEN = {"reference.figure_eight.period_s": 8.5, "reference.figure_eight.half_width_m": 0.9}
"""A smaller eight, as none was in the learning."""

PAPER = np.array([0.0, 1.0, 1.0, 1.0, 3.0, 3.0])
"""The paper's law with the gains of the scenario: lead, vx, vy, omega, position, heading."""
SPREAD = np.array([0.02, 0.02, 0.02, 0.02, 1.5, 1.5])
"""How far around it the search begins."""
AHEAD_S = 0.1
RADIAN_M = 0.2
"""How bad a heading error is: that of a corner of the robot."""
SETTLED_S = 3.0
"""The start from rest into a moving reference is no matter of feed-forward."""


def law(numbers: np.ndarray, error: np.ndarray, velocity: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """The twist to ask for, in the body's frame: m/s, m/s, rad/s. `ahead` is how far the path goes within `AHEAD_S`."""
    lead, factors, gains = numbers[..., :1], numbers[..., 1:4], numbers[..., [4, 4, 5]]
    acceleration = 2.0 * (ahead - velocity * AHEAD_S) / AHEAD_S**2
    return factors * (velocity + lead * acceleration) + gains * error


def cost(envs: ilon.gym.TrackVectorEnv, numbers: np.ndarray, seed: int) -> np.ndarray:
    """The root mean square of the true errors in an episode, a radian as bad as `RADIAN_M`, for each row of numbers; infinite where a
    robot is lost."""
    seen, _ = envs.reset(seed=[seed] * envs.num_envs)
    squares, lost, steps = np.zeros(envs.num_envs), np.zeros(envs.num_envs, dtype=bool), 0
    while True:
        asked = law(numbers, seen[:, 0:3], seen[:, 3:6], seen[:, 6:9]) / envs.action_scale
        seen, _, failed, time_is_up, info = envs.step(asked.astype(np.float32))
        lost |= failed
        steps += 1
        if steps * envs.control_dt_s > 1.0:
            squares += info["position_error_m"] ** 2 + (RADIAN_M * info["heading_error_rad"]) ** 2
        if (time_is_up | lost).all():
            return np.where(lost, np.inf, np.sqrt(squares / steps))
        if (time_is_up | failed).any():
            # Those that are lost begin again, and do not count.
            seen, _ = envs.reset(options={"reset_mask": time_is_up | failed})


def learn(generations: int, robots: int = 64, seed: int = 0) -> np.ndarray:
    """The numbers that the cross-entropy method finds: each generation is drawn around the best eighth of the last."""
    envs = ilon.gym.TrackVectorEnv(
        SCENARIO,
        num_envs=robots,
        autoreset_mode="Disabled",
        preview_s=[AHEAD_S],
        episode_s=5.0,
        start_off_m=0.0,
        start_off_rad=0.0,
        # Learned at many speeds, or it would be learned by heart.
        randomise={"reference.figure_eight.period_s": (8.0, 12.0)},
    )
    rng = np.random.default_rng(seed)
    mean, spread = PAPER.copy(), SPREAD.copy()
    for generation in range(generations):
        numbers = mean + spread * rng.standard_normal((robots, len(mean)))
        numbers[0] = mean
        costs = cost(envs, numbers, seed + generation)
        best = numbers[np.argsort(costs)[: robots // 8]]
        mean = 0.3 * mean + 0.7 * best.mean(axis=0)
        # Never so narrow that it stands still early.
        spread = np.maximum(0.3 * spread + 0.7 * best.std(axis=0), 0.02 * SPREAD)
        print(f"generation {generation}: {1e3 * costs[0]:.2f} mm in the middle, {1e3 * costs.min():.2f} mm at best")
    return mean


def controller(numbers: np.ndarray, settings: Mapping[str, Any]) -> Callable[..., np.ndarray]:
    """The law as a controller of a whole run."""
    robot = ilon.Simulation(SCENARIO, settings=settings)

    def command(now: ilon.Observation, desired: ilon.Desired) -> np.ndarray:
        heading = now.pose[2]
        cos, sin = np.cos(heading), np.sin(heading)
        body_from_world = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        error = desired.pose - now.pose
        error[2] = (error[2] + np.pi) % (2.0 * np.pi) - np.pi
        ahead = robot.desired(now.t_s + AHEAD_S).pose - desired.pose
        asked = law(
            numbers, body_from_world @ error, body_from_world @ desired.velocity_in_world, body_from_world @ ahead
        )
        return robot.wheel_rates(asked)

    return command


def error_m(run: ilon.Run) -> float:
    """The root mean square of the true position error once the start is over, in m."""
    trace = run.trace
    off = np.hypot(trace["truth_x_m"] - trace["desired_x_m"], trace["truth_y_m"] - trace["desired_y_m"])
    return float(np.sqrt(np.mean(off[trace["t_s"] > SETTLED_S] ** 2)))


def compared(numbers: np.ndarray, settings: Mapping[str, Any]) -> tuple[float, float]:
    """The errors of the paper's law and of the learned one in whole runs, in m."""
    paper = ilon.run(SCENARIO, settings=settings)
    learned = ilon.run(SCENARIO, settings=settings, controller=controller(numbers, settings))
    return error_m(paper), error_m(learned)


def main() -> None:
    parser = argparse.ArgumentParser(description="Learns a feed-forward that beats the paper's law on a fast figure eight.")
    parser.add_argument("--generations", type=int, default=20)
    numbers = learn(parser.parse_args().generations)
    print(dict(zip(("lead_s", "vx", "vy", "omega", "position_per_s", "heading_per_s"), numbers.round(4), strict=True)))
    for what, settings in (("learned on", {}), ("not seen", UNSEEN)):
        paper_m, learned_m = compared(numbers, settings)
        print(f"{what}: {1e3 * paper_m:.2f} mm under the paper's law, {1e3 * learned_m:.2f} mm as learned")


if __name__ == "__main__":
    main()
