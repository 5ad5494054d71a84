"""A policy that was trained anywhere, judged on the wheel as made."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from ._ilon import Simulation
from .runs import Scenario

_Array = npt.NDArray[Any]
Policy = Callable[[_Array], npt.ArrayLike] | str | os.PathLike[str]
"""Gives an action for an observation, both of `ilon.gym.TrackEnv`; or the path of an ONNX file with one input and the action as its first output."""


@dataclass(frozen=True)
class Judgement:
    """What a policy does on the wheel as made, in the mean over episodes."""

    falls: float
    """The share of the episodes that ended early: the robot left its path, or fell over."""
    error_m: float
    """The root mean square of the true position error, in m, while the robot was on its way."""
    error_rad: float
    """That of the heading, in rad."""
    slip_j: float
    """The energy lost to sliding contacts, in J a second."""
    share_ahead: float
    """The speed ahead over that of ideal kinematics at the wheels' own rates; NaN where there is none."""
    share_left: float
    """The same to the left."""
    share_turn: float
    """The same of the turning rate."""
    lost: Mapping[str, float]
    """What the transfer lost: figures here less those that were measured in the training simulator."""


def judge(
    policy: Policy,
    study: Sequence[int] | Sequence[Scenario],
    *,
    trained: Mapping[str, float] | Judgement | None = None,
    **options: Any,
) -> Judgement:
    """Lets a policy drive robots on wheels with all their rollers, and measures what it does there.

    `study` lists seeds, one an episode of `scenario`, or scenarios, each an episode with the seed of its place in the list. `trained` has
    figures of the same names, measured in the simulator where the policy was trained. `options` are those of `ilon.gym.TrackEnv`;
    `scenario` among them is by default that of `ilon/Track-v0`.

    Raises ValueError for an empty study and for figures of other names; TypeError for a list of both; ImportError for an ONNX file
    without onnxruntime.
    """
    from .gym import FIGURE_EIGHT

    if len(study) == 0:
        raise ValueError("the study is empty: give seeds, or scenarios")
    act = _loaded(policy)
    given = vars(trained) if isinstance(trained, Judgement) else dict(trained or {})
    names = [field.name for field in fields(Judgement)][:-1]
    unknown = set(given) - {*names, "lost"}
    if unknown:
        raise ValueError(f"{sorted(unknown)} of the training simulator are no figures; there are {names}")
    seeds = [int(one) for one in study if isinstance(one, int | np.integer)]
    if seeds and (len(seeds) < len(study)):
        raise TypeError("the study has both seeds and scenarios: give seeds with `scenario=`, or scenarios")
    scenario = options.pop("scenario", FIGURE_EIGHT)
    each = [(scenario, seed) for seed in seeds] or [(one, seed) for seed, one in enumerate(study)]
    found = np.array([_episode(act, one, seed, options) for one, seed in each])
    ended, lasts_s, square_m, square_rad, slip_j = found[:, :5].T
    along, ideal = found[:, 5:].sum(axis=0).reshape(2, 3)
    shares = np.divide(along, ideal, out=np.full(3, np.nan), where=ideal > 1e-9)
    error_m, error_rad = np.sqrt(np.array([square_m.sum(), square_rad.sum()]) / lasts_s.sum())
    figures = [ended.mean(), error_m, error_rad, slip_j.sum() / lasts_s.sum(), *shares]
    here = dict(zip(names, map(float, figures), strict=True))
    return Judgement(**here, lost={name: here[name] - given[name] for name in names if name in given})


def _episode(act: Callable[[_Array], npt.ArrayLike], scenario: Scenario, seed: int, options: Mapping[str, Any]) -> list[float]:
    """Whether the episode ended early, how long it was, and sums over it: squared errors, lost energy, and by axis the products of the
    body's steps and those of ideal kinematics with the latter."""
    from .gym import TrackEnv

    # The reward is what slipped: nothing else costs or earns.
    costs = {"alive": 0.0, "position": 0.0, "heading": 0.0, "action_change": 0.0, "energy": 0.0, "slip": 1.0}
    env = TrackEnv(scenario, **{**options, "reward": costs})
    robot = Simulation(scenario, **{key: options[key] for key in ("settings", "folder", "sandbox") if key in options})
    of_rates = np.stack([robot.twist(row) for row in np.eye(len(robot.wheel_names))], axis=1)
    rates_at = [at for at, name in enumerate(env.observation_names) if name.endswith("_rate_rad_s")]
    dt_s = env.control_dt_s
    seen, _ = env.reset(seed=seed)
    pose = env._track.above(0)[0]
    sums, lasts_s = np.zeros(9), 0.0
    while True:
        rates = seen[rates_at].astype(float)
        seen, reward, failed, time_is_up, errors = env.step(np.asarray(act(seen), dtype=np.float32).reshape(env.action_space.shape))
        lasts_s += dt_s
        before, pose = pose, env._track.above(0)[0]
        x_m, y_m, turn_rad = pose - before
        # Headings may be wrapped.
        turn_rad = np.arctan2(np.sin(turn_rad), np.cos(turn_rad))
        c, s = np.cos(before[2] + 0.5 * turn_rad), np.sin(before[2] + 0.5 * turn_rad)
        step = np.array([c * x_m + s * y_m, c * y_m - s * x_m, turn_rad])
        ideal = of_rates @ (0.5 * dt_s * (rates + seen[rates_at]))
        squares = [errors["position_error_m"] ** 2 * dt_s, errors["heading_error_rad"] ** 2 * dt_s, -reward]
        sums += [*squares, *(step * ideal), *(ideal * ideal)]
        if failed or time_is_up:
            return [float(failed), lasts_s, *sums]


def _loaded(policy: Policy) -> Callable[[_Array], npt.ArrayLike]:
    if callable(policy):
        return policy
    try:
        import onnxruntime
    except ImportError as error:
        raise ImportError("an ONNX file needs onnxruntime: pip install onnxruntime; or give a function") from error
    session = onnxruntime.InferenceSession(os.fspath(policy))
    name = session.get_inputs()[0].name
    return lambda seen: session.run(None, {name: np.asarray(seen, dtype=np.float32)[np.newaxis]})[0][0]
