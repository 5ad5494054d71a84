"""Learns what the paper's law does not know of a robot, beside that law, and holds both against tracks that neither has seen.

The robot carries a load of up to 8 kg somewhere on it and does not know how much or where, its wheel loops are soft (5 rad/s), and a camera shows its
pose a tenth of a second late, 30 times a second. High gains make such a robot oscillate, low ones leave it behind its path. Three laws are tuned by the
same search, from the same gains, with as many simulated robots; and the paper's law gets, besides, the best of a grid of gains for each held-out track
itself, which no other law may see:

| law | asks for | numbers |
|---|---|---|
| paper | the desired velocity + gains times the error: Indiveri 2009, eq. (26) | 2 |
| lead | the same, the desired velocity read some time ahead | 3 |
| residual | the paper's law + five things that are seen of each axis, each times a number that begins at zero | 17 |

    python python/examples/learn_residual.py        # some minutes on two cores
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import ilon
import ilon.gym

ROBOT = Path(__file__).resolve().parents[2] / "assets" / "robots" / "mecanum4.urdf"

EIGHT = {"figure_eight": {"half_width_m": 1.0, "period_s": 10.0, "heading": {"from_path_deg": 0.0}}}
"""What is learned on, at all the periods and headings of `DRAWN`."""
DRAWN = {
    "reference.figure_eight.period_s": (8.0, 12.0),
    "reference.figure_eight.heading.from_path_deg": (-180.0, 180.0),
}
LOAD = {
    "faults.0.payload.mass_kg": (0.1, 8.0),
    "faults.0.payload.x_m": (-0.1, 0.1),
    "faults.0.payload.y_m": (-0.1, 0.1),
}
"""What no law knows, drawn for each episode, on tracks that are learned on and on others."""

HELD_OUT = {
    "a small, fast eight": {"figure_eight": {"half_width_m": 0.7, "period_s": 6.5, "heading": "along_path"}},
    "a circle, looking one way": {"circle": {"radius_m": 0.6, "speed_m_s": 0.5, "heading": {"constant_deg": 0.0}}},
    "a slalom, turning": {
        "waypoints": {
            "points_m": [[0.0, 0.0], [0.6, 0.4], [1.2, -0.4], [1.8, 0.4], [2.4, -0.4], [3.0, 0.0]],
            "headings_deg": [0.0, 60.0, 120.0, 60.0, 0.0, -60.0],
            "speed_m_s": 0.45,
        }
    },
}
"""Tracks of other shapes, sizes and headings, on which nothing is learned."""
HELD_OUT_SEEDS = range(10_000, 10_016)
"""Loads and noise on them, which no generation draws."""

LEARNED_DT_S, JUDGED_DT_S = 0.01, 0.001
"""Physics steps: ten times longer ones to learn in, and right ones to be judged in."""
PREVIEW_S = (0.1, 0.3)
SETTLED_S = 2.0
"""The start from rest into a moving reference is no matter of tracking."""
RADIAN_M = 0.2
"""How bad a heading error is: that of a corner of the robot."""
GAINS_PER_S = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0)
"""Gains that are tried on the held-out tracks themselves."""
LOST_M = 1.0
"""What a robot costs that leaves its path."""


def scenario(reference: Mapping[str, Any], physics_dt_s: float) -> dict[str, Any]:
    """The robot on a track."""
    return {
        "robot": {"file": str(ROBOT), "roller_bodies": "near"},
        "reference": dict(reference),
        "guidance": {},
        "wheel_loop": {"bandwidth_rad_s": 5.0},
        "sensors": {
            "pose": {"rate_hz": 30.0, "latency_s": 0.1, "position_noise_m": 0.003, "heading_noise_deg": 0.3},
        },
        "faults": [{"payload": {"mass_kg": 4.0, "x_m": 0.0, "y_m": 0.0, "z_m": 0.15}}],
        "run": {"duration_s": 8.0, "control_dt_s": 0.02, "physics_dt_s": physics_dt_s},
    }


LAWS = ("paper", "lead", "residual")


class Law:
    """A law with parameters to be found, one of `LAWS`."""

    def __init__(self, kind: str) -> None:
        robot = ilon.Simulation(scenario(EIGHT, JUDGED_DT_S))
        self.kind = kind
        self.twist_from_rates = np.stack([robot.twist(row) for row in np.eye(len(robot.wheel_names))], axis=1)
        # Gains as logarithms: they stay positive, and a search changes them by factors.
        gains, spread = [np.log(2.0)] * 2, [0.4, 0.4]
        more = {"paper": [], "lead": [0.05], "residual": np.repeat([0.2, 0.03, 0.1, 0.2, 0.5], 3).tolist()}[kind]
        self.start, self.spread = np.array(gains + [0.0] * len(more)), np.array(spread + more)

    def twist(self, numbers: np.ndarray, seen: np.ndarray, action_scale: np.ndarray) -> np.ndarray:
        """The commanded twist in the body frame, in m/s, m/s and rad/s, one row per robot."""
        error, velocity, near, far = (seen[:, i : i + 3] for i in (0, 3, 6, 9))
        # The change of the desired velocity from now to `PREVIEW_S`, in m/s^2, m/s^2 and rad/s^2.
        soon, later = PREVIEW_S
        sooner = 2.0 * (near - velocity * soon) / soon**2
        later_on = 2.0 * (far - velocity * later) / later**2
        asked = velocity + np.exp(numbers[:, [0, 0, 1]]) * error
        if self.kind == "lead":
            asked = asked + numbers[:, 2:] * sooner
        if self.kind == "residual":
            # The lag of the wheels behind their last command.
            rates, last = seen[:, 12:16], seen[:, 16:19]
            behind = last * action_scale - rates @ self.twist_from_rates.T
            features = np.stack([velocity, sooner, later_on, behind, error], axis=1)
            asked = asked + np.einsum("rfi,rfi->ri", numbers[:, 2:].reshape(-1, 5, 3), features)
        return asked


def errors(envs: ilon.gym.TrackVectorEnv, act: Callable[[np.ndarray], np.ndarray], seeds: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """The root mean squares of the true position errors in m and heading errors in rad after the
    start, for each robot; for one that left its path, `LOST_M` and half a turn.
    """
    seen, _ = envs.reset(seed=seeds)
    squares, lost, steps = np.zeros((2, envs.num_envs)), np.zeros(envs.num_envs, dtype=bool), 0
    step = 0
    while True:
        seen, _, failed, time_is_up, info = envs.step((act(seen) / envs.action_scale).astype(np.float32))
        step += 1
        lost |= failed
        if step * envs.control_dt_s > SETTLED_S:
            squares += np.stack([info["position_error_m"], info["heading_error_rad"]]) ** 2
            steps += 1
        if (time_is_up | lost).all():
            rms = np.sqrt(squares / max(steps, 1))
            return np.where(lost, LOST_M, rms[0]), np.where(lost, np.pi, rms[1])
        if (time_is_up | failed).any():
            # Lost robots begin again, and do not count.
            seen, _ = envs.reset(options={"reset_mask": time_is_up | failed})


def tuned(law: Law, generations: int, seed: int, candidates: int = 24, episodes: int = 2) -> np.ndarray:
    """Parameters found by the cross-entropy method: each generation is drawn around the best
    quarter of the last, and each candidate drives the same few episodes.
    """
    envs = ilon.gym.TrackVectorEnv(
        scenario(EIGHT, LEARNED_DT_S),
        num_envs=candidates * episodes,
        autoreset_mode="Disabled",
        preview_s=PREVIEW_S,
        episode_s=5.0,
        start_off_m=0.0,
        start_off_rad=0.0,
        randomise={**DRAWN, **LOAD},
    )
    rng = np.random.default_rng(seed)
    mean, spread = law.start.copy(), law.spread.copy()
    for generation in range(generations):
        numbers = mean + spread * rng.standard_normal((candidates, len(mean)))
        numbers[0] = mean
        each = np.repeat(numbers, episodes, axis=0)
        draws = rng.integers(0, 10_000, episodes).tolist()
        position_m, heading_rad = errors(envs, lambda seen: law.twist(each, seen, envs.action_scale), draws * candidates)
        costs = np.hypot(position_m, RADIAN_M * heading_rad).reshape(candidates, episodes).mean(axis=1)
        best = numbers[np.argsort(costs)[: candidates // 4]]
        mean = 0.5 * mean + 0.5 * best.mean(axis=0)
        # A lower bound of the spread keeps the search from stopping early.
        spread = np.maximum(0.5 * spread + 0.5 * best.std(axis=0), 0.05 * law.spread)
        if generation % 10 == 9:
            print(f"  {law.kind}, generation {generation + 1}: {1e3 * costs[0]:.1f} mm", flush=True)
    return mean


def held_out(law: Law, numbers: np.ndarray, physics_dt_s: float = JUDGED_DT_S) -> dict[str, np.ndarray]:
    """The position errors in m on each held-out track, one for each held-out seed."""
    found, seeds = {}, list(HELD_OUT_SEEDS)
    for name, reference in HELD_OUT.items():
        envs = ilon.gym.TrackVectorEnv(
            scenario(reference, physics_dt_s),
            num_envs=len(seeds),
            autoreset_mode="Disabled",
            preview_s=PREVIEW_S,
            any_phase=False,
            start_off_m=0.0,
            start_off_rad=0.0,
            randomise=LOAD,
        )
        each = np.tile(numbers, (len(seeds), 1))
        found[name], _ = errors(envs, lambda seen, envs=envs: law.twist(each, seen, envs.action_scale), seeds)
    return found


def best_gains(law: Law) -> dict[str, tuple[float, tuple[float, float]]]:
    """The paper's law with the best gains of a grid for each held-out track itself: the error in m
    and the gains in 1/s.
    """
    best: dict[str, tuple[float, tuple[float, float]]] = {}
    for gains in itertools.product(GAINS_PER_S, GAINS_PER_S):
        for name, found_m in held_out(law, np.log(gains), LEARNED_DT_S).items():
            best[name] = min(best.get(name, (np.inf, gains)), (float(found_m.mean()), gains))
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--generations", type=int, default=16)
    parser.add_argument("--searches", type=int, default=2, help="how often each law is tuned, from other seeds")
    arguments = parser.parse_args()
    for name, (best_m, gains) in best_gains(Law("paper")).items():
        print(f"paper, at the best gains for {name}, {gains}: {1e3 * best_m:.1f} mm", flush=True)
    paper_m: dict[str, float] = {}
    for kind in LAWS:
        law = Law(kind)
        searches = [held_out(law, tuned(law, arguments.generations, seed)) for seed in range(arguments.searches)]
        for name in HELD_OUT:
            each_m = np.array([found[name].mean() for found in searches])
            # The paper's law comes first.
            share = each_m.mean() / paper_m.setdefault(name, each_m.mean()) - 1.0
            loads_m = np.mean([found[name].std() for found in searches])
            print(
                f"{kind} on {name}: {1e3 * each_m.mean():.1f} mm ({100 * share:+.0f} %); by search {(1e3 * each_m).round(1)},"
                f" by load and noise +-{1e3 * loads_m:.1f} mm",
                flush=True,
            )


if __name__ == "__main__":
    main()
