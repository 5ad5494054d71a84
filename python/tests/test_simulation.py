"""A robot that is driven step by step."""

import copy
import math
import pickle
import threading
import time

import numpy as np
import pytest

import ilon


@pytest.fixture
def simulation(circle):
    return ilon.Simulation(circle)


def driven(simulation, steps, rates=(5.0, -5.0, -5.0, 5.0)):
    for _ in range(steps):
        simulation.advance(rates)
    return simulation.truth()


def same(one, other):
    return (one.pose == other.pose).all() and (one.twist_in_body == other.twist_in_body).all()


def test_a_run_of_the_command_is_driven_again_step_by_step_to_the_bit(lateral, lateral_run):
    # The commanded wheel rates, applied from outside, and the same step.
    simulation = ilon.Simulation(lateral_run.scenario, folder=lateral.parent)
    targets = np.column_stack([lateral_run.trace[f"wheel{wheel}_target_rad_s"] for wheel in range(4)])
    for row, rates in enumerate(targets[:200]):
        assert simulation.truth().pose[1] == lateral_run.trace["truth_y_m"][row]
        simulation.advance(rates)
    assert simulation.time_s == pytest.approx(200 * simulation.control_dt_s)


def test_a_simulation_begins_where_the_scenario_says(simulation):
    seen = simulation.observe()
    np.testing.assert_array_equal(seen.pose, [1.0, 0.0, 0.0])
    assert seen.t_s == 0.0 and seen.wheel_rates_rad_s.shape == (4,)
    assert simulation.desired().pose == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    # A quarter of the circle at 0.3 m/s.
    assert simulation.desired(math.pi / 2 / 0.3).pose == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)


def test_an_imu_says_how_the_robot_turns_and_what_holds_it(circle):
    assert ilon.Simulation(circle).observe().imu is None
    simulation = ilon.Simulation({**circle, "sensors": {"imu": {}}})
    turned_rad = 0.0
    for _ in range(100):
        simulation.advance(simulation.wheel_rates([0.0, 0.0, 0.5]))
        imu = simulation.observe().imu
        turned_rad += imu.rate_rad_s[2] * simulation.control_dt_s
    # Its reading is the mean since the last reading: no part of the turn is lost.
    assert turned_rad == pytest.approx(simulation.truth().pose[2], rel=1e-9)
    assert turned_rad > 0.4
    # At the body's origin, the robot turns on the spot; the ground supports it.
    assert imu.specific_force_m_s2 == pytest.approx([0.0, 0.0, 9.81], abs=0.02)
    assert [imu.roll_rad, imu.pitch_rad] == pytest.approx([0.0, 0.0], abs=1e-3)


def test_an_imu_errs_by_the_seed(circle):
    section = {"accelerometer": {"noise": 0.1, "bias": 0.2}, "gyroscope": {"noise": 0.01, "bias": 0.02}}
    simulation = ilon.Simulation({**circle, "sensors": {"imu": section}})

    def said(seed):
        simulation.reset(seed=seed)
        driven(simulation, 5)
        imu = simulation.observe().imu
        return np.concatenate([imu.rate_rad_s, imu.specific_force_m_s2])

    first = said(1)
    assert (said(1) == first).all()
    assert (said(2) != first).all()


def test_reset_leads_to_the_same_motion(simulation):
    first = driven(simulation, 50)
    simulation.reset()
    assert simulation.time_s == 0.0
    assert same(driven(simulation, 50), first)


def test_a_robot_is_reset_to_a_pose(simulation):
    seen = simulation.reset(pose=[3.0, -2.0, 0.5])
    np.testing.assert_allclose(seen.pose, [3.0, -2.0, 0.5])
    np.testing.assert_allclose(simulation.truth().pose, [3.0, -2.0, 0.5], atol=1e-6)


def test_noise_comes_from_the_seed(circle):
    circle["sensors"] = {"pose": {"position_noise_m": 0.01}}
    simulation = ilon.Simulation(circle)
    poses = {seed: simulation.reset(seed=seed).pose for seed in (1, 2)}
    poses["again"] = simulation.reset(seed=1).pose
    assert (poses[1] == poses["again"]).all() and (poses[1] != poses[2]).any()


def test_a_snapshot_leads_to_the_same_motion(simulation):
    driven(simulation, 20)
    snapshot = simulation.snapshot()
    first = driven(simulation, 30)
    simulation.restore(snapshot)
    assert simulation.time_s == pytest.approx(20 * simulation.control_dt_s)
    assert same(driven(simulation, 30), first)
    # One of another simulation of the same scenario is valid too.
    other = ilon.Simulation(simulation.scenario)
    other.restore(snapshot)
    assert same(driven(other, 30), first)


def test_a_snapshot_of_another_simulation_is_refused(simulation, assets):
    driven(simulation, 10)
    scenario = simulation.scenario
    on_ice = {**scenario, "world": {**scenario["world"], "floor": {**scenario["world"]["floor"], "friction": 0.05}}}
    others = [ilon.Simulation(on_ice), ilon.Simulation(assets / "scenarios" / "volksbot_position_first.toml")]
    before = simulation.snapshot()
    first = driven(simulation, 10)
    for other in others:
        with pytest.raises(ilon.ScenarioError, match="another simulation"):
            simulation.restore(other.snapshot())
        with pytest.raises(ilon.ScenarioError, match="another simulation"):
            other.restore(before)
    # The state is restored.
    simulation.restore(before)
    assert same(driven(simulation, 10), first)


def test_a_snapshot_is_not_pickled_into_another_process(simulation):
    with pytest.raises(TypeError, match="cannot be pickled"):
        pickle.dumps(simulation.snapshot())
    with pytest.raises(TypeError, match="cannot be pickled"):
        copy.deepcopy(simulation.snapshot())


def test_a_torque_acts(simulation):
    outcome = simulation.advance(torques=[0.1, 0.1, 0.1, 0.1])
    np.testing.assert_allclose(outcome.torques_n_m, 0.1)
    assert simulation.truth().twist_in_body[0] > 0.0


def test_a_push_gives_its_impulse(simulation):
    # On a robot of 12 kg with free wheels: dv = F t / m, less the effect of the rotating wheels and
    # rollers.
    simulation.push([0.0, 0.0, 0.0], 0.01)
    simulation.push([12.0, 0.0, 0.0], 0.5)
    for _ in range(50):
        simulation.advance(torques=[0.0] * 4)
    assert 0.3 < simulation.truth().twist_in_body[0] < 0.5
    before = simulation.truth().twist_in_body[0]
    for _ in range(10):
        simulation.advance(torques=[0.0] * 4)
    # The push has ended.
    assert simulation.truth().twist_in_body[0] <= before


def test_rates_and_twists_are_each_others_inverse(simulation):
    twist = [0.3, -0.2, 0.5]
    np.testing.assert_allclose(simulation.twist(simulation.wheel_rates(twist)), twist)


def test_a_long_advance_is_many_short_ones(circle):
    one, many = ilon.Simulation(circle), ilon.Simulation(circle)
    rates = [5.0, 5.0, 5.0, 5.0]
    # More physics steps than are taken at once.
    steps = round(1200 * one.physics_dt_s / one.control_dt_s)
    long = one.advance(rates, period_s=steps * one.control_dt_s)
    torques = np.mean([many.advance(rates).torques_n_m for _ in range(steps)], axis=0)
    assert same(one.truth(), many.truth()) and one.time_s == pytest.approx(many.time_s)
    np.testing.assert_allclose(long.torques_n_m, torques, rtol=1e-9, atol=1e-12)


def test_other_threads_run_while_it_steps(simulation):
    ticks, done = 0, threading.Event()
    # A second thread counts during one long step of this one.
    def count():
        nonlocal ticks
        while not done.is_set():
            ticks += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    start = time.monotonic()
    simulation.advance([5.0] * 4, period_s=10.0)
    took = time.monotonic() - start
    done.set()
    counter.join()
    # Blocked by the step, it would count once or twice.
    assert ticks > 10 * took


def test_two_threads_cannot_step_the_same_simulation_at_once(simulation):
    started = threading.Event()

    def step():
        started.set()
        simulation.advance([5.0] * 4, period_s=20.0)

    thread = threading.Thread(target=step)
    thread.start()
    started.wait()
    refused = False
    while thread.is_alive() and not refused:
        try:
            simulation.truth()
        except RuntimeError:
            refused = True
    thread.join()
    assert refused


def test_threads_step_simulations_of_their_own(circle):
    simulations = [ilon.Simulation(circle) for _ in range(4)]
    results = [None] * 4

    def step(index):
        results[index] = driven(simulations[index], 40)

    threads = [threading.Thread(target=step, args=(index,)) for index in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same(result, results[0]) for result in results)


@pytest.mark.parametrize(
    ("rates", "error"),
    [
        ([1.0, 2.0, 3.0], ValueError),
        ([1.0, 2.0, 3.0, math.nan], ValueError),
        ([1.0, 2.0, 3.0, math.inf], ValueError),
        ([[1.0, 2.0, 3.0, 4.0]], ValueError),
        (1.0, ValueError),
        ("fast", TypeError),
        (["a", "b", "c", "d"], TypeError),
        ({}, TypeError),
    ],
)
@pytest.mark.parametrize("kind", ["wheel_rates", "torques"])
def test_what_is_no_command_is_refused_and_nothing_happens(simulation, rates, error, kind):
    with pytest.raises(error):
        simulation.advance(**{kind: rates})
    assert simulation.time_s == 0.0


def test_one_kind_of_command_is_given(simulation):
    with pytest.raises(TypeError, match="either"):
        simulation.advance()
    with pytest.raises(TypeError, match="either"):
        simulation.advance([1.0] * 4, torques=[1.0] * 4)


@pytest.mark.parametrize("period_s", [0.0, -1.0, math.nan, math.inf, 1e-9, 1e300])
def test_a_time_that_is_none_is_refused(simulation, period_s):
    with pytest.raises(ilon.ScenarioError, match="cannot be advanced"):
        simulation.advance([0.0] * 4, period_s=period_s)
    assert simulation.time_s == 0.0


@pytest.mark.parametrize("period_s", [0.001, 0.0123456, 100.0123456])
def test_any_other_time_is_taken(simulation, period_s):
    simulation.advance([0.0] * 4, period_s=period_s)
    assert simulation.time_s == pytest.approx(period_s, abs=1e-9)


@pytest.mark.parametrize("pose", [[0, 0], [0, 0, math.nan], [math.inf, 0, 0], [1e30, 0, 0], "here"])
def test_a_robot_is_not_reset_to_nowhere(simulation, pose):
    driven(simulation, 3)
    before = simulation.truth()
    with pytest.raises((ValueError, TypeError)):
        simulation.reset(pose=pose)
    assert same(simulation.truth(), before)


@pytest.mark.parametrize("push", [([0, 0], 1.0), ([0, 0, math.nan], 1.0), ([1, 0, 0], 0.0), ([1, 0, 0], math.inf)])
def test_a_push_that_cannot_be_is_refused(simulation, push):
    with pytest.raises(ValueError):
        simulation.push(*push)


def test_a_negative_seed_is_refused(simulation):
    with pytest.raises(OverflowError):
        simulation.reset(seed=-1)


def test_a_box_that_is_pushed_says_where_it_is_and_what_it_takes(assets):
    # mu m g is 0.3 * 2 kg * 9.81 m/s^2 = 5.886 N; the scenario checks the mean within 0.03 N,
    # single steps within 5 % of it.
    simulation = ilon.Simulation(assets / "scenarios" / "mecanum4_push_box.toml")
    rates = simulation.wheel_rates([0.2, 0.0, 0.0])
    rest = simulation.free_bodies()["box"]
    assert rest.work_of_robot_j == 0.0
    np.testing.assert_allclose(rest.position_m, [0.5, 0.0, 0.06], atol=1e-5)
    simulation.advance(rates)
    assert simulation.free_bodies()["box"].sleeps
    while simulation.time_s < 3.0:
        simulation.advance(rates)
    middle, forces = simulation.free_bodies()["box"], []
    while simulation.time_s < 4.5:
        simulation.advance(rates)
        forces.append(simulation.free_bodies()["box"].force_of_robot_n)
    end = simulation.free_bodies()["box"]
    assert np.mean(forces, axis=0)[0] == pytest.approx(5.886, rel=0.005)
    way_m = end.position_m[0] - middle.position_m[0]
    assert way_m == pytest.approx(0.2 * 1.5, rel=0.01)
    assert end.work_of_robot_j - middle.work_of_robot_j == pytest.approx(5.886 * way_m, rel=0.005)
    assert not end.sleeps and end.velocity_in_world_m_s[0] == pytest.approx(0.2, rel=0.05)
    assert abs(end.angular_in_world_rad_s).max() < 0.05 and end.quaternion_wxyz[0] == pytest.approx(1.0, abs=1e-4)
    assert simulation.free_bodies().keys() == {"box"}


def test_a_world_without_bodies_has_none(simulation):
    assert simulation.free_bodies() == {}


@pytest.fixture
def with_arm(assets):
    return ilon.Simulation(
        {
            "robot": {
                "file": str(assets / "robots" / "mecanum4_arm.urdf"),
                "wheels": {
                    "rollers": 9,
                    "roller_radius_m": 0.012,
                    "roller_mass_kg": 0.01,
                    "damping_n_m_s": 1e-6,
                    "gamma": {"x_deg": 45},
                },
                "joints": {"arm": {"role": "driven"}, "lift": {"role": "driven"}},
            },
            "twist": {"vx_m_s": 0},
            "run": {"duration_s": 1},
        }
    )


def test_joints_go_where_they_are_sent_and_a_reset_brings_them_back(with_arm):
    with_arm.command_joints({"arm": 0.4, "lift": 0.05})
    with_arm.advance([0.0] * 4, period_s=1.5)
    # The lift sags by its load over its stiffness, 2.5 mm at 10 Hz (docs/suspension.md).
    assert with_arm.joints() == {"arm": pytest.approx(0.4, abs=2e-3), "lift": pytest.approx(0.05, abs=4e-3)}
    with_arm.reset()
    assert with_arm.joints()["arm"] == pytest.approx(0.0, abs=1e-6)


def test_joints_run_at_rates_and_bear_forces(with_arm):
    with_arm.command_joints(rates={"arm": 0.5}, efforts={"lift": 60.0})
    with_arm.advance([0.0] * 4, period_s=0.2)
    # The arm follows except for its sag; 60 N lift 4 kg by 4.94 m/s2 less damping and friction.
    assert with_arm.joints()["arm"] == pytest.approx(0.1, abs=0.01)
    assert with_arm.joints()["lift"] == pytest.approx(0.09, abs=0.01)
    with pytest.raises(ValueError, match="effort"):
        with_arm.command_joints({"arm": 0.1}, efforts={"arm": 1.0})


@pytest.mark.parametrize(
    ("positions", "rates", "words"),
    [
        ({"arm": 0.1, "arn": 0.1}, None, "no joint `arn`"),
        ({"arm": 0.1, "lift": 9.0}, None, "its limits are"),
        ({"arm": math.nan}, None, "finite"),
        ({"arm": 0.1}, {"lifd": 1.0}, "no joint `lifd`"),
    ],
)
def test_joints_that_cannot_go_are_refused_and_none_goes(with_arm, positions, rates, words):
    with pytest.raises(ValueError, match=words):
        with_arm.command_joints(positions, rates=rates)
    with_arm.advance([0.0] * 4, period_s=0.5)
    assert with_arm.joints()["arm"] == pytest.approx(0.0, abs=1e-6)
