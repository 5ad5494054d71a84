"""The adapter to Stable-Baselines3."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3", exc_type=ImportError)

from stable_baselines3 import PPO  # noqa: E402
from stable_baselines3.common.vec_env import VecMonitor  # noqa: E402

from ilon.gym import TrackVectorEnv  # noqa: E402
from ilon.sb3 import TrackVecEnv  # noqa: E402


def test_it_says_what_gymnasiums_vector_says():
    ours = TrackVecEnv(num_envs=3, episode_s=0.1)
    theirs = TrackVectorEnv(num_envs=3, episode_s=0.1, autoreset_mode="SameStep")
    ours.seed(4)
    np.testing.assert_array_equal(ours.reset(), theirs.reset(seed=4)[0])
    for _ in range(6):
        actions = np.full((3, 3), 0.1, dtype=np.float32)
        seen, rewards, done, infos = ours.step(actions)
        expected = theirs.step(actions)
        np.testing.assert_array_equal(seen, expected[0])
        np.testing.assert_allclose(rewards, expected[1], rtol=1e-6)
        np.testing.assert_array_equal(done, expected[2] | expected[3])
        if done.any():
            np.testing.assert_array_equal(infos[0]["terminal_observation"], expected[4]["final_obs"][0])
            assert infos[0]["TimeLimit.truncated"] and infos[0]["episode"]["l"] == 5


@pytest.mark.filterwarnings("ignore")
def test_ppo_takes_it():
    env = VecMonitor(TrackVecEnv(num_envs=4, episode_s=0.2))
    model = PPO("MlpPolicy", env, n_steps=16, batch_size=32, n_epochs=1, seed=0, device="cpu")
    model.learn(128)
    assert np.isfinite(model.predict(env.reset())[0]).all()
