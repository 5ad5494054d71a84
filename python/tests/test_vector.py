"""The task for many robots, stepped by the compiled half on all cores."""

import os
import pickle

import numpy as np
import pytest

import ilon

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.vector import AutoresetMode  # noqa: E402

COUNT = 5


def vector(mode=AutoresetMode.NEXT_STEP, **options):
    return gymnasium.make_vec("ilon/Track-v0", num_envs=COUNT, autoreset_mode=mode, **options)


def others(mode=AutoresetMode.NEXT_STEP, **options):
    """The same robots, stepped one by one by Gymnasium."""
    return gymnasium.vector.SyncVectorEnv(
        [lambda: ilon.gym.TrackEnv(**options) for _ in range(COUNT)], autoreset_mode=mode
    )


def actions(step):
    phases = 0.1 * step + np.arange(COUNT)[:, np.newaxis] + np.arange(3)
    return (0.4 * np.sin(phases)).astype(np.float32)


def test_gymnasium_makes_the_compiled_one():
    env = vector()
    assert isinstance(env.unwrapped, ilon.gym.TrackVectorEnv)
    assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert env.observation_space.shape == (COUNT, env.single_observation_space.shape[0])


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_many_robots_go_the_ways_of_single_ones(mode):
    # Episodes with different ends: some leave the path, some run out of time.
    options = {"episode_s": 0.3, "fail_at_m": 0.12, "start_off_m": 0.1}
    ours, theirs = vector(mode, **options), others(mode, **options)
    seen, _ = ours.reset(seed=11)
    expected, _ = theirs.reset(seed=11)
    np.testing.assert_array_equal(seen, expected)
    ends = 0
    for step in range(60):
        got, want = ours.step(actions(step)), theirs.step(actions(step))
        for one, other in zip(got[:4], want[:4], strict=True):
            np.testing.assert_array_equal(one, other)
            assert one.dtype == other.dtype
        ended = got[2] | got[3]
        ends += ended.sum()
        assert set(got[4]) == set(want[4])
        np.testing.assert_array_equal(got[4]["position_error_m"], want[4]["position_error_m"])
        if mode is AutoresetMode.SAME_STEP and ended.any():
            np.testing.assert_array_equal(got[4]["_final_obs"], want[4]["_final_obs"])
            for index in np.flatnonzero(ended):
                np.testing.assert_array_equal(got[4]["final_obs"][index], want[4]["final_obs"][index])
            finals = [infos[4]["final_info"]["position_error_m"][ended] for infos in (got, want)]
            np.testing.assert_array_equal(*finals)
        if mode is AutoresetMode.DISABLED and ended.any():
            resets = [env.reset(options={"reset_mask": ended.copy()}) for env in (ours, theirs)]
            np.testing.assert_array_equal(resets[0][0], resets[1][0])
    # More than one each, so the test covers new episodes.
    assert ends > COUNT


def test_a_robot_that_is_over_is_not_stepped():
    env = vector(AutoresetMode.DISABLED, episode_s=0.02)
    env.reset(seed=0)
    env.step(actions(0))
    with pytest.raises(RuntimeError, match="robot 0 is over"):
        env.step(actions(1))


def test_what_comes_out_does_not_depend_on_the_threads():
    def seen(threads):
        env = vector(threads=threads)
        env.reset(seed=2)
        return [env.step(actions(step))[0] for step in range(30)]

    np.testing.assert_array_equal(seen(1), seen(4))


def test_observations_that_were_handed_out_stay_as_they_are():
    env = vector()
    first, _ = env.reset(seed=0)
    kept = first.copy()
    second = env.step(actions(0))[0]
    kept_second = second.copy()
    env.step(actions(1))
    np.testing.assert_array_equal(first, kept)
    np.testing.assert_array_equal(second, kept_second)


def test_seeds_are_given_one_by_one_or_counted_on():
    env = vector()
    counted, _ = env.reset(seed=5)
    listed, _ = env.reset(seed=[5, 6, 7, 8, 9])
    np.testing.assert_array_equal(counted, listed)
    with pytest.raises(ValueError, match="5 environments"):
        env.reset(seed=[1, 2])
    # Without seeds the random numbers continue.
    assert (env.reset()[0] != listed).any()
    some, _ = env.reset(seed=[5, None, 7, None, 9])
    np.testing.assert_array_equal(some[::2], listed[::2])


@pytest.mark.parametrize(
    ("mask", "error"),
    [
        ([True] * COUNT, TypeError),
        (np.ones(COUNT), TypeError),
        (np.ones(COUNT + 1, dtype=bool), ValueError),
        (np.zeros(COUNT, dtype=bool), ValueError),
    ],
)
def test_a_bad_mask_is_refused(mask, error):
    env = vector(AutoresetMode.DISABLED)
    env.reset(seed=0)
    with pytest.raises(error):
        env.reset(options={"reset_mask": mask})


@pytest.mark.parametrize(
    "bad", [np.zeros((COUNT, 2)), np.zeros((COUNT + 1, 3)), np.zeros(3), np.full((COUNT, 3), np.nan)]
)
def test_what_are_no_actions_is_refused_and_nothing_happens(bad):
    env, other = vector(), vector()
    env.reset(seed=0), other.reset(seed=0)
    with pytest.raises(ValueError):
        env.step(bad)
    np.testing.assert_array_equal(env.step(actions(0))[0], other.step(actions(0))[0])


def test_no_robots_are_none():
    with pytest.raises(ValueError, match="num_envs"):
        ilon.gym.TrackVectorEnv(num_envs=0)


def test_keys_are_drawn_for_each_robot():
    env = vector(randomise={"world.floor.friction": (0.05, 0.9)}, start_off_m=0.0, start_off_rad=0.0, any_phase=False)
    env.reset(seed=0)
    for _ in range(20):
        seen = env.step(np.ones((COUNT, 3), dtype=np.float32))[0]
    assert len({row.tobytes() for row in seen}) == COUNT


def test_a_pickled_one_is_made_again():
    env = vector(episode_s=0.5).unwrapped
    again = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(again.reset(seed=1)[0], env.reset(seed=1)[0])
    assert again.metadata == env.metadata


def test_gymnasiums_wrappers_fit():
    env = gymnasium.wrappers.vector.RecordEpisodeStatistics(vector(episode_s=0.1))
    env.reset(seed=0)
    for step in range(6):
        info = env.step(actions(step))[4]
        if "episode" in info:
            break
    assert info["episode"]["l"].tolist() == [5] * COUNT


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_it_goes_on_in_both_processes_of_a_fork():
    env = vector(threads=2)
    env.reset(seed=0)
    env.step(actions(0))
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.write(writing, env.step(actions(1))[0].tobytes())
        os._exit(0)
    os.close(writing)
    ours = env.step(actions(1))[0]
    theirs = os.read(reading, 1 << 20)
    assert os.waitpid(child, 0)[1] == 0
    assert theirs == ours.tobytes()
