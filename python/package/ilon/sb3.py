"""The many robots of `ilon.gym.TrackVectorEnv` for Stable-Baselines3: `PPO("MlpPolicy", ilon.sb3.TrackVecEnv(num_envs=64))`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvIndices, VecEnvObs, VecEnvStepReturn

from .gym import FIGURE_EIGHT, TrackVectorEnv
from .runs import Scenario

__all__ = ["TrackVecEnv"]


class TrackVecEnv(VecEnv):
    """Many robots, stepped on all cores, as Stable-Baselines3 takes them. Options are those of `ilon.gym.TrackEnv`.

    Episodes begin anew in the step in which they end; what was seen last is `info["terminal_observation"]`.
    """

    def __init__(self, scenario: Scenario = FIGURE_EIGHT, *, num_envs: int = 1, **options: Any) -> None:
        self.envs = TrackVectorEnv(scenario, num_envs=num_envs, autoreset_mode=AutoresetMode.SAME_STEP, **options)
        super().__init__(num_envs, self.envs.single_observation_space, self.envs.single_action_space)
        self._actions: np.ndarray | None = None
        self._earned, self._steps = np.zeros(num_envs), np.zeros(num_envs, dtype=int)

    def reset(self) -> VecEnvObs:
        observations, info = self.envs.reset(seed=list(self._seeds))
        self.reset_infos = [{"position_error_m": float(error)} for error in info["position_error_m"]]
        self._reset_seeds()
        self._earned[:], self._steps[:] = 0.0, 0
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        if self._actions is None:
            raise RuntimeError("there are no actions: call step_async first, or step")
        observations, rewards, failed, time_is_up, info = self.envs.step(self._actions)
        done = failed | time_is_up
        self._earned += rewards
        self._steps += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for index in np.flatnonzero(done):
            infos[index] = {
                "terminal_observation": info["final_obs"][index],
                "TimeLimit.truncated": bool(time_is_up[index]),
                # The figures of `Monitor`, which wraps only single environments.
                "episode": {"r": float(self._earned[index]), "l": int(self._steps[index]), "t": 0.0},
            }
        self._earned[done], self._steps[done] = 0.0, 0
        return observations, rewards.astype(np.float32), done, infos

    def close(self) -> None:
        self.envs.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        return [getattr(self.envs, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        raise NotImplementedError("all robots share one task: make another environment with the option changed")

    def env_method(self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any) -> list[Any]:
        raise NotImplementedError("all robots share one task, which has no methods for one of them")

    def env_is_wrapped(self, wrapper_class: type, indices: VecEnvIndices = None) -> list[bool]:
        return [False] * len(list(self._get_indices(indices)))

    def get_images(self) -> Sequence[np.ndarray | None]:
        return [None] * self.num_envs
