"""MuJoCo's arm on ilon's base, against one engine that moves both."""

import re
from pathlib import Path

import numpy as np
import pytest

import ilon

mujoco = pytest.importorskip("mujoco")

ARM = """
<mujoco><option timestep="{step}" gravity="0 0 -9.81"/>
<worldbody>{world}<body name="base_link"><freejoint/>
  <geom type="box" size=".2 .12 .05" pos="0 0 .06" contype="0" conaffinity="0"/>
  <body name="carriage" pos="0 0 .15"><inertial pos="0 0 0" mass="2" diaginertia=".0067 .0067 .0067"/>
    <body pos="0 0 .06"><joint name="arm" axis="0 0 1" damping=".05" frictionloss=".1"/>
      <inertial pos=".25 0 0" mass="2" diaginertia=".0013 .0267 .0267"/></body></body></body></worldbody>
<actuator><motor joint="arm" ctrlrange="-12 12"/></actuator></mujoco>
"""
STIFFNESS, DAMPING, BEGINS_S, ENDS_S = 600.0, 19.0, 0.1, 0.9


def scenario(robot, friction, **joints):
    """A robot whose wheels are held: its loops do not depend on its weight, which is lower without
    its arm.
    """
    wheels = {
        "rollers": 9,
        "roller_radius_m": 0.012,
        "roller_mass_kg": 0.01,
        "damping_n_m_s": 1e-6,
        "gamma": {"x_deg": 45},
    }
    return {
        "robot": {"file": str(robot), "wheels": wheels, **({"joints": joints} if joints else {})},
        "twist": {"vx_m_s": 0},
        "world": {"floor": {"friction": friction}},
        "wheel_loop": {"proportional_n_m_s": 0.5, "integral_n_m": 5},
        "run": {"duration_s": 2, "physics_dt_s": 0.001},
    }


@pytest.fixture
def base(assets, tmp_path):
    """The robot without its arm, which MuJoCo moves."""
    text = (assets / "robots" / "mecanum4_arm.urdf").read_text()
    for tag, name in (("joint", "arm"), ("link", "arm_link"), ("joint", "lift"), ("link", "carriage")):
        text = re.sub(rf'<{tag} name="{name}".*?</{tag}>', "", text, flags=re.DOTALL)
    path = tmp_path / "base.urdf"
    path.write_text(text)
    return path


def coupled(base, friction, step_s=0.001, world=""):
    simulation = ilon.Simulation(scenario(base, friction))
    model = mujoco.MjModel.from_xml_string(ARM.format(step=step_s, world=world))
    data = mujoco.MjData(model)
    return ilon.mujoco.Base(model, data, simulation, body="base_link")


def target(t_s):
    """From rest to rest with minimum jerk."""
    s = min(max((t_s - BEGINS_S) / (ENDS_S - BEGINS_S), 0.0), 1.0)
    rate = (30 * s**2 - 60 * s**3 + 30 * s**4) / (ENDS_S - BEGINS_S)
    return np.pi / 2 * (10 * s**3 - 15 * s**4 + 6 * s**5), np.pi / 2 * rate


def swing(under):
    """Swings the arm of a coupled base for 1.2 s; returns its poses, and the motor's work."""
    poses, motor_j = [], 0.0
    for step in range(round(1.2 / under.dt_s)):
        angle, rate = target(step * under.dt_s)
        data = under.data
        torque = STIFFNESS * (angle - data.qpos[7]) + DAMPING * (rate - data.qvel[6])
        data.ctrl[0] = torque
        before = data.qvel[6]
        under.step([0.0] * 4)
        motor_j += np.clip(torque, -12, 12) * (before + data.qvel[6]) / 2 * under.dt_s
        poses.append(under.simulation.truth().pose)
    return np.array(poses), motor_j


# On ice only the arm's momentum moves the base; on a dry floor rollers and wheel loops hold it, and
# the result is their compliance.
@pytest.mark.parametrize("friction", [0.0, 0.6])
@pytest.mark.parametrize("step_s", [0.001, 0.002])
def test_the_base_recoils_as_where_one_engine_moves_both(assets, base, friction, step_s):
    setpoints = [{"t_s": BEGINS_S, "position_rad": 0}, {"t_s": ENDS_S, "position_rad": np.pi / 2}]
    arm = {
        "role": "driven",
        "stiffness_n_m_rad": STIFFNESS,
        "damping_n_m_s_rad": DAMPING,
        "setpoints": setpoints,
    }
    one = ilon.Simulation(scenario(assets / "robots" / "mecanum4_arm.urdf", friction, arm=arm))
    poses, _ = swing(coupled(base, friction, step_s))
    expected = []
    for _ in range(len(poses)):
        one.advance([0.0] * 4, period_s=step_s)
        expected.append(one.truth().pose)
    # The recoil: how far the base moves in each direction.
    np.testing.assert_allclose(np.abs(poses).max(axis=0), np.abs(expected).max(axis=0), rtol=0.01)


# A multiple of the plant's step of 0.1 ms; the centre of mass lies in the body's frame, so that MuJoCo's mass matrix is diagonal.
@pytest.mark.parametrize("step_s", [0.001, 0.003, 0.005, 0.0073])
def test_a_base_to_which_nothing_is_attached_moves_as_the_robot_alone(base, step_s):
    about = scenario(base, 0.6)
    about["run"]["physics_dt_s"] = 0.0001
    alone = ilon.Simulation(about)
    rates = alone.wheel_rates([0.2, 0.1, 0.3])
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{step_s}"/><worldbody><body name="base_link"><freejoint/>
        <inertial pos="0 0 0" mass="5" diaginertia=".1 .1 .1"/></body></worldbody></mujoco>"""
    )
    under = ilon.mujoco.Base(model, mujoco.MjData(model), ilon.Simulation(about), body="base_link")
    for _ in range(round(0.219 / step_s)):
        under.step(rates)
        alone.advance(rates, period_s=step_s)
    # The added mass of 1000 kg is taken out again, with an error of 1e-13 kg beside the robot's kilograms.
    np.testing.assert_allclose(under.simulation.truth().pose, alone.truth().pose, rtol=0, atol=1e-9)


def test_no_energy_comes_or_goes_between_the_engines(base):
    under = coupled(base, 0.6)
    begins_j = sum(under.scene_energy_j())
    _, motor_j = swing(under)
    # One engine's work is the other's gain: both integrate the same wrench over the same rates.
    assert under.work_on_scene_j == pytest.approx(-under.simulation.energies()["outside_j"], rel=1e-3)
    # The motor's work is stored, or dissipated in the arm's bearing: never negative.
    stored_j = sum(under.scene_energy_j()) - begins_j
    assert 0.0 < motor_j + under.work_on_scene_j - stored_j < motor_j


def test_what_does_not_fit_is_refused_in_words(base):
    simulation = ilon.Simulation(scenario(base, 0.6))

    def made(text, body="base_link"):
        model = mujoco.MjModel.from_xml_string(text)
        return ilon.mujoco.Base(model, mujoco.MjData(model), simulation, body=body)

    good = ARM.format(step=0.001, world="")
    for text, body, words in [
        (good, "nobody", "no body 'nobody'"),
        (good, "carriage", "no free joint"),
        (good.replace("0.001", "0.0017"), "base_link", "do not fit"),
        (good.replace("-9.81", "-1.62"), "base_link", "gravity is 1.62"),
        (good.replace("<option", '<option integrator="RK4"'), "base_link", "integrator"),
        (good.replace('name="arm"', 'name="front_left"'), "base_link", "a wheel of ilon's"),
    ]:
        with pytest.raises(ValueError, match=words):
            made(text.replace('joint="arm"', 'joint="front_left"') if "front_left" in text else text, body)


def test_an_arm_swings_while_its_base_pushes_a_box_and_every_joule_is_accounted_for(monkeypatch, capfd, tmp_path):
    monkeypatch.syspath_prepend(str(Path(__file__).resolve().parents[1] / "examples"))
    monkeypatch.chdir(tmp_path)
    import mujoco_arm

    account = mujoco_arm.drive(lasts_s=1.6)
    assert account.base_m > 0.3 and account.box_m > 0.1
    # One engine's work is the other's gain.
    assert account.passed_by_mujoco == pytest.approx(account.passed_by_ilon, rel=1e-3)
    assert account.passed_by_mujoco > 1.0
    # The box slides on its floor with this heat; the excess is the impact on it, and its contact
    # with the base. An impact takes at most half of the energy at the base's speed, for a box of a
    # sixth of its weight.
    slid_j = 0.3 * 2.0 * 9.81 * account.box_m
    hit_j = 0.5 * 2.0 * mujoco_arm.AHEAD_M_S**2
    assert slid_j * 0.98 < account.scene_contacts < slid_j * 1.1 + hit_j
    # On ilon's side the motors' work is stored, or dissipated by slip, bearings and landings, or
    # passed to the scene.
    there = account.ilon
    gone_j = there["slip_j"] + there["spin_up_j"] + there["bearing_j"] + there["impact_j"]
    stored_j = there["motor_j"] + there["outside_j"] - gone_j
    assert stored_j == pytest.approx(there["kinetic_j"] + there["potential_j"] - account.potential_begins, rel=0.02, abs=5e-3)
    assert "singular" not in capfd.readouterr().out and not list(tmp_path.iterdir())
