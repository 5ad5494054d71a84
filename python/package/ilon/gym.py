"""Tasks to learn, as environments of Gymnasium: `gymnasium.make("ilon/Track-v0")`.

`TrackEnv` is one robot, `TrackVectorEnv` many, stepped on all cores by the compiled half of the package. Both take the same
options; see `TrackEnv`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.utils import EzPickle
from gymnasium.vector import AutoresetMode

from ._draw import from_above
from ._ilon import Track
from .runs import Sandbox, Scenario

__all__ = ["FIGURE_EIGHT", "REWARD", "TrackEnv", "TrackVectorEnv"]

FIGURE_EIGHT = Path(__file__).parent / "track" / "mecanum4_figure_eight.toml"
"""The scenario of the task where none is given: a robot with four mecanum wheels on a figure eight."""

REWARD: Mapping[str, float | None] = {
    "alive": None,
    "position": 5.0,
    "heading": 1.0,
    "action_change": 0.05,
    "energy": 0.0,
    "slip": 0.0,
}
"""What a step earns and costs. Per second: `alive`, less `position` times the true position error in m, `heading` times the true
heading error in rad, `action_change` times the mean square of the action's change since the last step. Besides: less `energy`
times the motors' work in J, and `slip` times the energy lost to sliding contacts in J. The step in which a robot fails earns 0.

**Living pays.** `alive` of None is the most that a second can cost short of failing: `position * fail_at_m + heading * pi +
action_change * 4`, which is 5.84 by default (`alive_per_s` of an environment). What is counted in J has no such bound; where it
would make a step earn less than 0, the step earns 0. So no step ever costs, an episode that has ended earns nothing more, and in
every state to go on is worth at least as much as to end. An episode without errors earns `alive_per_s` times its seconds.

A number for `alive` is taken as it is. Below the bound a robot far off its path may earn more by failing soon than by coming
back, and a learner finds that out."""

ActionKind = Literal["twist", "wheel_rates", "wheel_torques"]

_SEEDS = 2**63


def _options(
    scenario: Scenario,
    num_envs: int,
    autoreset: str,
    *,
    settings: Mapping[str, Any] | None = None,
    folder: str | os.PathLike[str] | None = None,
    sandbox: Sandbox | None = None,
    action: ActionKind = "twist",
    action_scale: Sequence[float] | None = None,
    preview_s: Sequence[float] = (0.1, 0.2, 0.4),
    episode_s: float | None = None,
    reward: Mapping[str, float | None] | None = None,
    fail_at_m: float = 0.5,
    start_off_m: float = 0.05,
    start_off_rad: float = 0.1,
    any_phase: bool = True,
    randomise: Mapping[str, tuple[float, float]] | None = None,
    threads: int | None = None,
) -> Track:
    # All arguments by their names.
    options = locals() | {
        "action_scale": None if action_scale is None else [float(scale) for scale in action_scale],
        "preview_s": [float(ahead_s) for ahead_s in preview_s],
        "reward": {**REWARD, **(reward or {})},
        "randomise": dict(randomise or {}),
        # Without a seed, every environment differs.
        "seed": int(np.random.SeedSequence().generate_state(1, np.uint64)[0]) % _SEEDS,
    }
    return Track(scenario, options)


def _spaces(track: Track) -> tuple[gymnasium.spaces.Box, gymnasium.spaces.Box]:
    bounds = track.bounds
    ones = np.ones(len(track.action_names), dtype=np.float32)
    return (
        gymnasium.spaces.Box(-bounds, bounds, dtype=np.float32),
        gymnasium.spaces.Box(-ones, ones, dtype=np.float32),
    )


def _render_mode(asked: str | None) -> str | None:
    if asked not in (None, "rgb_array"):
        raise ValueError(f'render_mode is {asked!r}; give None or "rgb_array": `ilon.run` and its report show a run in 3D')
    return asked


class TrackEnv(gymnasium.Env[npt.NDArray[np.float32], npt.NDArray[np.float32]], EzPickle):
    """A robot shall follow the path of a scenario's `[reference]`.

    **Actions** are numbers in [-1, 1]; `action_scale` says what 1 is, `action_names` what each number is:

    | `action` | numbers | 1 is |
    |---|---|---|
    | `"twist"` | vx, vy, omega of the body in its own frame | its top speeds in m/s, m/s and rad/s |
    | `"wheel_rates"` | one a wheel | the wheel's rate limit in rad/s |
    | `"wheel_torques"` | one a wheel | the motor's torque limit in N m |

    What lies outside of [-1, 1] is cut off; NaN and other shapes raise. A twist at which a wheel would turn faster than it can is lowered
    by one factor for all three numbers. Where tyres exclude a motion, 1 is 0; steered wheels turn to the twist.

    **Observations** are what the robot's sensors say (`[sensors]` of the scenario), in the body's frame; `observation_names` names
    them with their units: the error to the desired pose (m, m, rad), the desired velocity (m/s, m/s, rad/s), the path `preview_s`
    ahead of the desired pose (m, m, rad each), the wheels' rates (rad/s), and the last action. What lies outside of the space is cut
    off at its bounds.

    **Reward**: see `REWARD`, of which `reward` changes what it names. No step costs: to go on is always worth as much as to end.

    **Episodes** last `episode_s` (by default the scenario's duration), then they are truncated. They terminate where the true position
    error exceeds `fail_at_m`, or the robot falls over. They begin anywhere on the path (`any_phase`), up to `start_off_m` and
    `start_off_rad` off it. `randomise` draws keys of the scenario for each episode, evenly between two numbers:
    `{"world.floor.friction": (0.3, 0.9), "faults.0.payload.mass_kg": (0, 5), "sensors.pose.position_noise_m": (0, 0.01)}`.

    **Pictures**: with `render_mode="rgb_array"`, `render()` gives the robot, its path and its desired pose from above, as an array of
    480 x 640 x 3 bytes.

    A pickled environment comes back as it was made, not where it was: reset it.
    """

    metadata = {"render_modes": ["rgb_array"]}

    def __init__(
        self, scenario: Scenario = FIGURE_EIGHT, *, render_mode: Literal["rgb_array"] | None = None, **options: Any
    ) -> None:
        EzPickle.__init__(self, scenario, render_mode=render_mode, **options)
        self.render_mode = _render_mode(render_mode)
        self._track = _options(scenario, 1, "disabled", **options)
        # Gymnasium annotates a Box by all numeric types that it might hold.
        self.observation_space, self.action_space = _spaces(self._track)  # type: ignore[assignment]
        self._describe()
        # Video recorders read it.
        self.metadata = {**self.metadata, "render_fps": round(1.0 / self.control_dt_s)}

    def _describe(self) -> None:
        self.observation_names = self._track.observation_names
        self.action_names = self._track.action_names
        self.action_scale = self._track.action_scale
        self.control_dt_s = self._track.control_dt_s
        self.alive_per_s = self._track.alive_per_s

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        super().reset(seed=seed)
        # Without a seed the random numbers continue, as Gymnasium requires.
        seeds = [None] if seed is None else [int(self.np_random.integers(_SEEDS))]
        observations, position_m, heading_rad = self._track.reset(seeds)
        return observations[0], {"position_error_m": position_m[0], "heading_error_rad": heading_rad[0]}

    def step(
        self, action: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        observations, rewards, failed, time_is_up, position_m, heading_rad, _ = self._track.step(
            np.asarray(action)[np.newaxis]
        )
        errors = {"position_error_m": position_m[0], "heading_error_rad": heading_rad[0]}
        return observations[0], float(rewards[0]), bool(failed[0]), bool(time_is_up[0]), errors


    def render(self) -> npt.NDArray[np.uint8] | None:
        return None if self.render_mode is None else from_above(*self._track.above(0))


class TrackVectorEnv(gymnasium.vector.VectorEnv[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[Any]], EzPickle):
    """Many robots, each on its own way along a path, stepped on all cores: `gymnasium.make_vec("ilon/Track-v0", num_envs=64)`.

    Options are those of `TrackEnv`, and:

    `autoreset_mode` says what happens when an episode ends: `NEXT_STEP` begins another in the next step, whatever its action;
    `SAME_STEP` in the same, with `info["final_obs"]` and `info["final_info"]`; `DISABLED` leaves it to
    `reset(options={"reset_mask": mask})`. `threads` limits the cores that are used.

    What comes out depends on the seeds, not on the number of threads. After a fork it goes on in both processes.
    """

    def __init__(
        self,
        scenario: Scenario = FIGURE_EIGHT,
        *,
        num_envs: int = 1,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: Literal["rgb_array"] | None = None,
        **options: Any,
    ) -> None:
        EzPickle.__init__(
            self, scenario, num_envs=num_envs, autoreset_mode=autoreset_mode, render_mode=render_mode, **options
        )
        mode = AutoresetMode(autoreset_mode)
        self.num_envs = num_envs
        self.render_mode = _render_mode(render_mode)
        self._autoreset = mode
        self._track = _options(scenario, num_envs, mode.name.lower(), **options)
        self.single_observation_space, self.single_action_space = _spaces(self._track)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)
        self.observation_names = self._track.observation_names
        self.action_names = self._track.action_names
        self.action_scale = self._track.action_scale
        self.control_dt_s = self._track.control_dt_s
        self.metadata = {
            "render_modes": ["rgb_array"],
            "render_fps": round(1.0 / self.control_dt_s),
            "autoreset_mode": mode,
        }
        self.alive_per_s = self._track.alive_per_s
        self._observations = np.zeros((num_envs, len(self.observation_names)), dtype=np.float32)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        seeds = self._seeds(seed)
        mask = self._mask(options)
        observations, position_m, heading_rad = self._track.reset(seeds, None if mask is None else mask.tolist())
        if mask is not None:
            # The others keep their observations.
            observations[~mask] = self._observations[~mask]
        self._observations = observations
        began = np.ones(self.num_envs, dtype=bool) if mask is None else mask.copy()
        return observations.copy(), _info(began, position_m, heading_rad)

    def step(
        self, actions: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], dict[str, Any]]:
        observations, rewards, failed, time_is_up, position_m, heading_rad, last = self._track.step(actions)
        info = _info(np.ones(self.num_envs, dtype=bool), position_m, heading_rad)
        if last is not None:
            ended = failed | time_is_up
            final_obs = np.full(self.num_envs, None, dtype=object)
            for index in np.flatnonzero(ended):
                final_obs[index] = last[0][index]
            info |= {
                "final_obs": final_obs,
                "_final_obs": ended.copy(),
                "final_info": _info(ended, *last[1:]),
                "_final_info": ended.copy(),
            }
        if self._autoreset is AutoresetMode.DISABLED:
            self._observations = observations.copy()
        return observations, rewards, failed, time_is_up, info

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        if self.render_mode is None:
            return None
        return tuple(from_above(*self._track.above(index)) for index in range(self.num_envs))

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        each = [seed + index for index in range(self.num_envs)] if isinstance(seed, int) else list(seed)
        if len(each) != self.num_envs:
            raise ValueError(f"{len(each)} seeds were given for {self.num_envs} environments")
        # As in `TrackEnv`, so that each robot behaves as a single one of the same seed.
        return [
            None if one is None else int(gymnasium.utils.seeding.np_random(one)[0].integers(_SEEDS)) for one in each
        ]

    def _mask(self, options: dict[str, Any] | None) -> npt.NDArray[np.bool_] | None:
        mask = (options or {}).get("reset_mask")
        if mask is None:
            return None
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
            raise TypeError("options['reset_mask'] is a numpy array of bools")
        if mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(f"options['reset_mask'] has the shape ({self.num_envs},), and at least one True")
        return mask


def _info(mask: npt.NDArray[np.bool_], position_m: npt.NDArray[Any], heading_rad: npt.NDArray[Any]) -> dict[str, Any]:
    """The info of Gymnasium's vector environments: arrays, and masks of the rows that count."""
    return {
        "position_error_m": position_m,
        "_position_error_m": mask,
        "heading_error_rad": heading_rad,
        "_heading_error_rad": mask.copy(),
    }
