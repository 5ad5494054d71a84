"""The task for one robot, with Gymnasium's interface."""

import pickle
import subprocess
import sys
import warnings

import numpy as np
import pytest

import ilon
from ilon import _draw

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

ACTIONS = ("twist", "wheel_rates", "wheel_torques")


def rollout(env, steps, seed=0, scale=0.3):
    """Observations and rewards for actions that change slowly."""
    seen, earned = [env.reset(seed=seed)[0]], []
    for step in range(steps):
        action = scale * np.sin(0.1 * step + np.arange(env.action_space.shape[0])).astype(np.float32)
        observation, reward, terminated, truncated, _ = env.step(action)
        seen.append(observation)
        earned.append(reward)
        if terminated or truncated:
            break
    return np.array(seen), np.array(earned)


@pytest.mark.parametrize("action", ACTIONS)
def test_gymnasium_finds_no_fault_with_the_task(action):
    env = gymnasium.make("ilon/Track-v0", action=action, episode_s=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
    env.close()


def test_importing_ilon_makes_the_task_known():
    code = "import gymnasium, ilon; print(gymnasium.make('ilon/Track-v0').spec.id)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "ilon/Track-v0"


def test_each_observation_and_action_has_a_name():
    env = ilon.gym.TrackEnv()
    assert len(env.observation_names) == env.observation_space.shape[0]
    assert env.observation_names[:3] == ["error_x_m", "error_y_m", "error_heading_rad"]
    assert env.action_names == ["vx", "vy", "omega"]
    # 30 rad/s on wheels of 0.05 m: 1.5 m/s ahead, and as much sideways.
    np.testing.assert_allclose(env.action_scale[:2], 1.5, rtol=1e-3)


def test_a_differential_robot_has_no_twist_sideways(assets):
    scenario = {
        "robot": {"file": str(assets / "robots" / "differential.urdf")},
        "reference": {"circle": {"radius_m": 1.0, "speed_m_s": 0.3, "heading": "along_path"}},
        "run": {"duration_s": 4.0},
    }
    env = ilon.gym.TrackEnv(scenario)
    assert (env.action_scale > 0).tolist() == [True, False, True]
    env.reset(seed=1)
    assert np.isfinite(env.step(np.ones(3, np.float32))[0]).all()


def test_steered_wheels_turn_to_a_twist(assets):
    """A swerve robot is asked for 0.3 m/s to the left for 2 s: its modules turn by 90 degrees at 6 rad/s or more, in 0.3 s at most,
    and then it goes there."""
    scenario = {
        "robot": {"file": str(assets / "robots" / "swerve4.urdf")},
        "reference": {"circle": {"radius_m": 1.0, "speed_m_s": 0.3}},
        "run": {"duration_s": 4.0},
    }
    env = ilon.gym.TrackEnv(scenario, fail_at_m=5.0, start_off_m=0.0, start_off_rad=0.0, any_phase=False)
    env.reset(seed=1)
    pose, _, _, _ = env._track.above(0)
    action = np.array([0.0, 0.3 / env.action_scale[1], 0.0], np.float32)
    period_s = 0.01
    for _ in range(round(2.0 / period_s)):
        env.step(action)
    end, _, _, _ = env._track.above(0)
    ahead, left = np.array([np.cos(pose[2]), np.sin(pose[2])]), np.array([-np.sin(pose[2]), np.cos(pose[2])])
    went = end[:2] - pose[:2]
    assert 0.5 < went @ left < 0.6
    assert abs(went @ ahead) < 0.05 and abs(end[2] - pose[2]) < 0.05


@pytest.mark.parametrize("action", ACTIONS)
def test_a_seed_decides_everything(action):
    one, other = (rollout(ilon.gym.TrackEnv(action=action), 40, seed=7) for _ in range(2))
    np.testing.assert_array_equal(one[0], other[0])
    np.testing.assert_array_equal(one[1], other[1])
    assert (rollout(ilon.gym.TrackEnv(action=action), 1, seed=8)[0][0] != one[0][0]).any()


def test_a_reset_without_a_seed_goes_on_with_the_random_numbers():
    env = ilon.gym.TrackEnv()
    firsts = [env.reset(seed=3)[0], env.reset()[0], env.reset()[0]]
    assert (firsts[0] != firsts[1]).any() and (firsts[1] != firsts[2]).any()
    again = [env.reset(seed=3)[0], env.reset()[0], env.reset()[0]]
    np.testing.assert_array_equal(firsts, again)


def test_the_errors_seen_are_those_of_the_pose(circle):
    # At rest on the circle at (1, 0), the path leads along +y at 0.3 m/s; the robot looks along +x
    # and stands 0.1 m outside.
    circle["robot"]["x_m"] = 1.0
    env = ilon.gym.TrackEnv(circle, any_phase=False, start_off_m=0.0, start_off_rad=0.0, preview_s=[0.5])
    observation, info = env.reset(seed=0)
    named = dict(zip(env.observation_names, observation, strict=True))
    assert named["error_x_m"] == pytest.approx(0.0, abs=1e-6)
    assert named["desired_vy_m_s"] == pytest.approx(0.3, abs=1e-6)
    angle = 0.3 * 0.5
    assert named["ahead_0.5s_x_m"] == pytest.approx(np.cos(angle) - 1.0, abs=1e-6)
    assert named["ahead_0.5s_y_m"] == pytest.approx(np.sin(angle), abs=1e-6)
    assert info["position_error_m"] == pytest.approx(0.0, abs=1e-6)
    for _ in range(25):
        _, _, _, _, info = env.step(np.zeros(3, dtype=np.float32))
    # It stood still for 0.25 s while the path moved by the chord of 0.075 rad; the rest is the
    # robot's settling on its wheels.
    assert info["position_error_m"] == pytest.approx(2 * np.sin(0.075 / 2), abs=5e-4)


def test_the_reward_is_what_its_documentation_says(circle):
    weights = {"alive": 2.0, "position": 3.0, "heading": 0.5, "action_change": 0.25}
    env = ilon.gym.TrackEnv(circle, reward=weights)
    env.reset(seed=1)
    last = np.zeros(3, dtype=np.float32)
    for step in range(20):
        action = np.full(3, 0.02 * step, dtype=np.float32)
        _, reward, _, _, info = env.step(action)
        change = np.mean((action - last) ** 2)
        last = action
        earned = 2.0 - 3.0 * info["position_error_m"] - 0.5 * info["heading_error_rad"] - 0.25 * change
        assert reward == pytest.approx(earned * env.control_dt_s, rel=1e-6)


def test_energy_and_slip_can_cost(circle):
    def earned(**reward):
        return rollout(ilon.gym.TrackEnv(circle, reward=reward), 30, scale=1.0)[1].sum()

    # A robot that starts hard on a wet floor slides: both cost.
    circle["world"] = {"floor": {"friction": 0.2}}
    free = earned()
    assert earned(energy=1.0) < free and earned(slip=1.0) < free


def test_an_episode_is_truncated_when_its_time_is_up(circle):
    env = ilon.gym.TrackEnv(circle, episode_s=0.2, fail_at_m=10.0)
    env.reset(seed=0)
    ends = [env.step(np.zeros(3, dtype=np.float32))[2:4] for _ in range(20)]
    assert ends == [(False, False)] * 19 + [(False, True)]
    with pytest.raises(RuntimeError, match="is over"):
        env.step(np.zeros(3, dtype=np.float32))


def test_an_episode_terminates_where_the_robot_leaves_its_path(circle):
    env = ilon.gym.TrackEnv(circle, fail_at_m=0.1, start_off_m=0.0)
    env.reset(seed=0)
    for _ in range(60):
        _, _, terminated, truncated, info = env.step(np.array([-0.3, 0.0, 0.0], dtype=np.float32))
        if terminated or truncated:
            break
    assert terminated and not truncated and info["position_error_m"] > 0.1


def test_what_lies_outside_of_the_actions_is_cut_off(circle):
    def after(action):
        env = ilon.gym.TrackEnv(circle)
        env.reset(seed=0)
        return env.step(np.array(action))[0]

    np.testing.assert_array_equal(after([5.0, -3.0, 0.0]), after([1.0, -1.0, 0.0]))


@pytest.mark.parametrize(
    ("action", "error"),
    [
        ([0.0, np.nan, 0.0], ValueError),
        ([0.0, np.inf, 0.0], ValueError),
        ([0.0, 0.0], ValueError),
        ([[0.0, 0.0, 0.0]], ValueError),
        (0.0, ValueError),
        (["a", "b", "c"], TypeError),
        (None, (TypeError, ValueError)),
    ],
)
def test_what_is_no_action_is_refused_and_nothing_happens(circle, action, error):
    env, other = ilon.gym.TrackEnv(circle), ilon.gym.TrackEnv(circle)
    env.reset(seed=0), other.reset(seed=0)
    with pytest.raises(error):
        env.step(action)
    still = np.zeros(3, dtype=np.float32)
    np.testing.assert_array_equal(env.step(still)[0], other.step(still)[0])


def test_keys_of_the_scenario_are_drawn(circle):
    circle["faults"] = [{"payload": {"mass_kg": 1.0, "z_m": 0.1}}]
    drawn = {
        "world.floor.friction": (0.3, 0.9),
        "faults.0.payload.mass_kg": (0.1, 5.0),
        "sensors.pose.position_noise_m": (0.001, 0.01),
        "reference.circle.radius_m": (0.5, 2.0),
    }
    env = ilon.gym.TrackEnv(circle, randomise=drawn)
    one, other = rollout(env, 20, seed=4), rollout(env, 20, seed=4)
    np.testing.assert_array_equal(one[0], other[0])
    assert np.isfinite(one[0]).all()
    # With the same seed and start, only the drawn values differ.
    fixed = rollout(ilon.gym.TrackEnv(circle), 20, seed=4)
    assert (one[0][-1] != fixed[0][-1]).any()


def test_what_is_drawn_in_a_list_needs_no_list_in_the_scenario():
    """The docstring's example, on the task's default scenario: a payload from none to 5 kg."""
    env = ilon.gym.TrackEnv(
        randomise={
            "world.floor.friction": (0.3, 0.9),
            "faults.0.payload.mass_kg": (0, 5),
            "sensors.pose.position_noise_m": (0, 0.01),
        }
    )
    assert np.isfinite(rollout(env, 20, seed=4)[0]).all()
    # A heavy load has an effect, and a zero one has none.
    ends = {
        kg: rollout(ilon.gym.TrackEnv(randomise={"faults.0.payload.mass_kg": (kg, kg)}), 20, seed=4)[0][-1] for kg in (0, 5)
    }
    bare = rollout(ilon.gym.TrackEnv(randomise={"robot.x_m": (0, 0)}), 20, seed=4)[0][-1]
    np.testing.assert_array_equal(ends[0], bare)
    assert (ends[5] != bare).any()


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"action": "legs"}, ValueError, "wheel_torques"),
        ({"preview_s": [0.0]}, ValueError, "preview_s"),
        ({"fail_at_m": -1.0}, ValueError, "fail_at_m"),
        ({"fail_at_m": 0.0}, ValueError, "give a finite number above 0"),
        ({"start_off_m": np.nan}, ValueError, "start_off_m"),
        ({"episode_s": 0.0}, ValueError, "episode_s"),
        ({"reward": {"beauty": 1.0}}, ValueError, "beauty"),
        ({"reward": {"alive": np.inf}}, ValueError, "alive"),
        ({"randomise": {"world.floor.friction": (0.9, 0.3)}}, ValueError, "smaller first"),
        ({"randomise": {"world.floor.friction": 0.3}}, TypeError, "low, high"),
        ({"randomise": {"world.floor.friction": (-1.0, 0.3)}}, ilon.ScenarioError, "friction"),
        ({"randomise": {"world.floor.frictoin": (0.1, 0.3)}}, ilon.ScenarioError, "frictoin"),
        ({"randomise": {"faults.1.payload.mass_kg": (0.1, 0.3)}}, ilon.ScenarioError, "list `faults` has no place 1"),
        ({"randomise": {"faults.0.payload.mass_kg": (-1, 0.3)}}, ilon.ScenarioError, "0 or more"),
        ({"action_scale": [1.0]}, ilon.ScenarioError, "action_scale"),
        ({"action_scale": [1.0, 0.0, 1.0]}, ilon.ScenarioError, r"`action_scale` is \[1.0, 0.0, 1.0\]"),
        ({"settings": {"run.duration_s": -1}}, ilon.ScenarioError, "duration_s"),
        ({"render_mode": "human"}, ValueError, "rgb_array"),
        ({"beauty": 1}, TypeError, "beauty"),
    ],
)
def test_bad_options_are_refused_in_words(options, error, words):
    with pytest.raises(error, match=words):
        ilon.gym.TrackEnv(**options)


def seen_at(picture):
    """The mean column and row of the robot's pixels, and how many columns and rows they take."""
    rows, columns = np.nonzero((picture == (30, 60, 110)).all(axis=2))
    return (columns.mean(), rows.mean()), (np.ptp(columns) + 1, np.ptp(rows) + 1)


# Of a picture of 640 x 480 pixels, the path of 2 m and a wheel of 0.1 m on each side take 400 pixels: x to the right, y up.
PER_M = 400 / 2.2
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@pytest.mark.parametrize("heading_rad", [0.0, np.pi / 2, -np.pi / 2])
def test_a_picture_shows_the_robot_where_it_is(heading_rad):
    # One wheel of radius 0.1 m, 0.1 m wide, that rolls along the robot's x; between robot and wheel nothing else is drawn but the nose.
    wheel = np.array([[0.0, 0.0, np.pi / 2, 0.1, 0.05]])
    pose = np.array([0.5, -0.3, heading_rad])
    picture = _draw.from_above(pose, np.array([-0.5, 0.6, 0.0]), SQUARE, wheel)
    assert picture.shape == (480, 640, 3) and picture.dtype == np.uint8
    middle, size = seen_at(picture)
    # Edges fall within pixels, which then are of no pure colour.
    np.testing.assert_allclose(middle, (319.5 + 0.5 * PER_M, 239.5 + 0.3 * PER_M), atol=1.0)
    along, across = 0.2 * PER_M, 0.1 * PER_M
    turned = (along, across) if heading_rad == 0.0 else (across, along)
    np.testing.assert_allclose(size, turned, atol=2.0)


@pytest.mark.parametrize("heading_rad", [0.0, 0.7, 2.0, -2.5])
def test_a_picture_turns_what_is_on_the_robot(heading_rad):
    # A wheel 0.05 m to the left of the robot's middle; it reaches as far as that of the test above.
    wheel = np.array([[0.0, 0.05, np.pi / 2, 0.05, 0.02]])
    picture = _draw.from_above(np.array([0.4, 0.3, heading_rad]), np.array([-0.5, 0.0, 0.0]), SQUARE, wheel)
    rows, columns = np.nonzero((picture == (30, 60, 110)).all(axis=2))
    x_m, y_m = (columns - 319.5) / PER_M - 0.4, (239.5 - rows) / PER_M - 0.3
    ahead = x_m * np.cos(heading_rad) + y_m * np.sin(heading_rad)
    left = y_m * np.cos(heading_rad) - x_m * np.sin(heading_rad)
    # The nose lies on the axis ahead; the wheel is all that lies further to the left. A pixel is 5.5 mm.
    wheel_seen = left > 0.02
    np.testing.assert_allclose((ahead[wheel_seen].mean(), left[wheel_seen].mean()), (0.0, 0.05), atol=0.004)


def test_rendering_follows_the_robot():
    env = gymnasium.make("ilon/Track-v0", render_mode="rgb_array", any_phase=False, start_off_m=0.0, start_off_rad=0.0)
    env.reset(seed=1)
    for _ in range(3):
        for _ in range(12):
            env.step(np.array([0.5, 0.3, 0.4], dtype=np.float32))
        picture = env.render()
        assert picture.shape == (480, 640, 3)
        pose, desired, path, wheels = env.unwrapped._track.above(0)
        assert abs(pose[1]) > 0.05 and abs(pose[2]) > 0.05
        reach_m = np.max(np.hypot(wheels[:, 0], wheels[:, 1]) + wheels[:, 3])
        seen_m = np.concatenate([path, [pose[:2], desired[:2]]])
        size_m = np.ptp(seen_m, axis=0) + 2 * reach_m
        per_m = min(560 / size_m[0], 400 / size_m[1])
        x_m, y_m = pose[:2] - 0.5 * (seen_m.min(axis=0) + seen_m.max(axis=0))
        # The wheels stand around the robot's middle; the nose draws the mean ahead, by less than a tenth of the reach.
        middle, _ = seen_at(picture)
        np.testing.assert_allclose(middle, (319.5 + x_m * per_m, 239.5 - y_m * per_m), atol=0.1 * reach_m * per_m)
    assert env.metadata["render_fps"] == 50
    assert ilon.gym.TrackEnv().render() is None
    many = gymnasium.make_vec("ilon/Track-v0", num_envs=2, render_mode="rgb_array")
    many.reset(seed=1)
    assert [picture.shape for picture in many.render()] == [(480, 640, 3)] * 2


def test_a_scenario_without_a_path_is_refused(lateral):
    with pytest.raises(ilon.ScenarioError, match=r"\[reference\]"):
        ilon.gym.TrackEnv(lateral)


def test_a_pickled_task_is_made_again(circle):
    env = ilon.gym.TrackEnv(circle, action="wheel_rates", episode_s=0.5)
    again = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(rollout(again, 10)[0], rollout(env, 10)[0])


def test_the_robot_that_comes_with_the_task_is_that_of_the_repository(assets):
    shipped = ilon.gym.FIGURE_EIGHT.with_name("mecanum4.toml")
    assert shipped.read_text() == (assets / "robots" / "mecanum4.toml").read_text()
