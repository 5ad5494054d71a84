"""The reward rewards the task's aim: to stay on the path, near it."""

import math

import numpy as np
import pytest

import ilon

pytest.importorskip("gymnasium")


@pytest.mark.parametrize(
    ("fail_at_m", "weights", "action"),
    [
        (0.5, {}, "twist"),
        (0.5, {}, "wheel_rates"),
        (0.5, {}, "wheel_torques"),
        (0.2, {"position": 50.0, "heading": 0.0}, "twist"),
        (1.0, {"position": 5.0, "heading": 10.0, "action_change": 3.0}, "twist"),
        # Costs per joule are unbounded.
        (0.5, {"energy": 100.0}, "twist"),
        (0.5, {"slip": 1000.0}, "twist"),
        (0.5, {"position": -3.0}, "twist"),
    ],
)
def test_to_go_on_is_never_worth_less_than_to_end(fail_at_m, weights, action):
    # An episode that has ended earns nothing more: if no step's reward is negative, no state is
    # worth less than that, whatever the robot does.
    envs = ilon.gym.TrackVectorEnv(
        num_envs=8,
        action=action,
        reward=weights,
        fail_at_m=fail_at_m,
        autoreset_mode="SameStep",
        start_off_rad=3.0,
        settings={"run.physics_dt_s": 0.02},
    )
    envs.reset(seed=0)
    rng, ends, paid = np.random.default_rng(1), 0, 0
    for step in range(120):
        if step % 40 == 0:
            held = rng.choice([-1.0, 0.3, 1.0], envs.action_space.shape)
        # Away in one direction, and jerkily.
        actions = held * (1.0 if step % 2 else 0.5)
        _, rewards, failed, _, _ = envs.step(actions.astype(np.float32))
        assert (rewards >= 0.0).all() and (rewards[failed] == 0.0).all()
        ends, paid = ends + failed.sum(), paid + (rewards > 0.0).sum()
    # Some failed and some earned, so the test covers both.
    assert ends > 0 and paid > 0


@pytest.mark.parametrize("fail_at_m", [0.1, 0.5, 3.0])
def test_a_second_earns_by_default_what_it_can_cost_at_worst(fail_at_m):
    # At the edge of the path, looking back, with each number of the action from one end to the
    # other: 2^2.
    worst = 5.0 * fail_at_m + 1.0 * math.pi + 0.05 * 4.0
    assert ilon.gym.TrackEnv(fail_at_m=fail_at_m).alive_per_s == pytest.approx(worst, rel=1e-12)
    assert ilon.gym.TrackEnv(fail_at_m=fail_at_m, reward={"alive": 0.7}).alive_per_s == 0.7


def test_costs_are_taken_from_what_living_earns(circle):
    env = ilon.gym.TrackEnv(circle)
    env.reset(seed=1)
    for _ in range(20):
        _, reward, _, _, info = env.step(np.zeros(3, dtype=np.float32))
        earned = env.alive_per_s - 5.0 * info["position_error_m"] - info["heading_error_rad"]
        assert reward == pytest.approx(earned * env.control_dt_s, rel=1e-6)


def test_only_living_can_be_left_to_the_task():
    with pytest.raises(TypeError, match="only `alive`"):
        ilon.gym.TrackEnv(reward={"position": None})


class Learner:
    """Random search over linear laws, from zero: the command is a matrix times the observed errors
    and desired velocity (Mania, Guy and Recht 2018, "Simple random search provides a competitive
    approach to reinforcement learning", V1-t).
    """

    DIRECTIONS, BEST, REACH, RATE = 16, 8, 0.15, 0.15
    EPISODE_S = 4.0

    def __init__(self, reward=None):
        self.envs = ilon.gym.TrackVectorEnv(
            num_envs=2 * self.DIRECTIONS,
            reward=reward,
            episode_s=self.EPISODE_S,
            autoreset_mode="Disabled",
            settings={"run.physics_dt_s": 0.01},
        )
        self.law = np.zeros((3, 6))

    def driven(self, laws, seeds):
        """Returns, survived shares of the episode, and mean position errors in m meanwhile, one
        each per law.
        """
        envs, robots = self.envs, self.envs.num_envs
        seen, _ = envs.reset(seed=seeds)
        bounds = envs.single_observation_space.high[:6]
        earned, lived, off_m, on = np.zeros(robots), np.zeros(robots), np.zeros(robots), np.ones(robots, dtype=bool)
        for _ in range(round(self.EPISODE_S / envs.control_dt_s)):
            asked = np.einsum("rij,rj->ri", laws, seen[:, :6] / bounds)
            seen, rewards, failed, time_is_up, info = envs.step(np.clip(asked, -1, 1).astype(np.float32))
            earned += on * rewards
            lived += on * ~failed
            off_m += on * ~failed * info["position_error_m"]
            on &= ~failed
            if (failed | time_is_up).any():
                # Lost robots begin again, and do not count.
                seen, _ = envs.reset(options={"reset_mask": failed | time_is_up})
        steps = round(self.EPISODE_S / envs.control_dt_s)
        return earned, lived / steps, off_m / np.maximum(lived, 1)

    def judged(self):
        """Mean return, survived share and error in m of the current law, in episodes without
        learning.
        """
        laws = np.repeat(self.law[np.newaxis], self.envs.num_envs, axis=0)
        return [float(of.mean()) for of in self.driven(laws, list(range(9000, 9000 + self.envs.num_envs)))]

    def learn(self, generations, seed):
        rng = np.random.default_rng(seed)
        for generation in range(generations):
            directions = rng.standard_normal((self.DIRECTIONS, *self.law.shape))
            laws = np.concatenate([self.law + self.REACH * directions, self.law - self.REACH * directions])
            # All from the same start, so that only the laws differ.
            earned, _, _ = self.driven(laws, [generation] * len(laws))
            ahead, back = np.split(earned, 2)
            best = np.argsort(-np.maximum(ahead, back))[: self.BEST]
            pull = np.einsum("d,dij->ij", (ahead - back)[best], directions[best])
            spread = np.concatenate([ahead[best], back[best]]).std()
            self.law += self.RATE / (self.BEST * max(spread, 1e-9)) * pull


@pytest.mark.timeout(300)
@pytest.mark.parametrize("seed", [0, 1])
def test_a_learner_from_zero_lives_and_comes_nearer_to_its_path(seed):
    learner = Learner()
    earned, lived, off_m = learner.judged()
    # A robot that does not move is left behind within two of its four seconds.
    assert lived < 0.5
    learner.learn(15, seed)
    earned_then, lived_then, off_then_m = learner.judged()
    assert earned_then > earned and lived_then > 0.95
    # A start is 40 mm off on average, which takes some of the four seconds to correct.
    assert off_then_m < 0.1 < off_m


@pytest.mark.timeout(300)
def test_where_living_does_not_pay_the_same_learner_learns_to_leave():
    # With 1 per second a robot that is 0.2 m off earns less than nothing until it fails at 0.5 m:
    # the default must not do that.
    learner = Learner(reward={"alive": 1.0})
    earned, lived, _ = learner.judged()
    learner.learn(10, seed=0)
    earned_then, lived_then, _ = learner.judged()
    assert earned_then > earned and lived_then < 0.9 * lived
