"""Holds the MuJoCo model against the description it was built from: masses, places, axes, loop, rates, kinematics."""

from __future__ import annotations

import re

import mujoco
import numpy as np

from drives import DRIVES, Bench
from model import Settings, fitted, wheel_loop_gains
from robot import Robot


def check(robot: Robot) -> list[str]:
    """One line a finding; raises AssertionError where the model is not the described robot."""
    lines = []
    bench = Bench(robot, Settings())
    mass_kg = bench.model.body_subtreemass[0]
    assert abs(mass_kg - robot.mass_kg) < 1e-9, (mass_kg, robot.mass_kg)
    worst = _against_urdf(bench.model, robot)
    lines.append(
        f"{robot.name}: {mass_kg:.2f} kg, {bench.model.nv} degrees of freedom; places, axes, masses and "
        f"inertias of all {bench.model.nbody - 1} bodies are those of {robot.path.stem}.urdf "
        f"(largest difference {worst:.0e} in SI units)"
    )
    radius, half, error = fitted(robot, robot.wheels[0].gamma_rad, "ellipsoid")
    lines.append(
        f"{robot.name}: rollers as ellipsoids {2e3 * radius:.2f} mm thick and {2e3 * half:.2f} mm long; "
        f"the wheel is round to {1e6 * error:.0f} um"
    )
    # At rest the floor carries the weight, and the hubs stand at the wheel's radius but for what contacts give way.
    fine = Settings(dt_s=0.001, cone="elliptic", solref=(0.002, 1.0))
    bench = Bench(robot, fine)
    for _ in range(1000):
        mujoco.mj_step(bench.model, bench.data)
    normal_n = sum(_force(bench, i)[0] for i in range(bench.data.ncon))
    assert abs(normal_n / (mass_kg * 9.81) - 1) < 1e-3, normal_n
    for drive in DRIVES:
        outcome = bench.accuracy(drive)
        assert abs(outcome.rate_ratio - 1) < 5e-3, (drive, outcome.rate_ratio)
        assert abs(outcome.hub_height_m - robot.radius_m) < 1e-4, outcome.hub_height_m
        assert outcome.error_pct < 1.0, outcome
    lateral = bench.measured.outcomes["D2"].ideal_ratio[1]
    expected = robot.lateral_share() if robot.wheels[0].gamma_rad else 1.0
    assert abs(lateral - expected) < 2e-3, (lateral, expected)
    lines.append(
        f"{robot.name}: at 1 ms the floor carries {normal_n:.2f} N, hubs stand at "
        f"{1e3 * bench.measured.outcomes['D1'].hub_height_m:.3f} mm, D2 makes {lateral:.4f} of the ideal "
        f"lateral speed (geometry: {expected:.4f})"
    )
    difference = _loop_difference(robot)
    assert difference < 1e-6, difference
    lines.append(
        f"{robot.name}: the wheel loop made of MuJoCo's actuators is the sampled PI loop "
        f"(wheel rates differ by at most {difference:.0e} rad/s over D5)"
    )
    return lines


def _against_urdf(model: mujoco.MjModel, robot: Robot) -> float:
    """Largest difference of any body's centre, mass, inertia (world axes) or joint axis from the URDF of the project.

    The URDF is read by MuJoCo itself, an independent path from the description to numbers.
    """
    text = robot.path.with_suffix(".urdf").read_text()
    compiler = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco>'
    text = re.sub(r"(<robot [^>]*>)", lambda m: m[1] + compiler, text, count=1)
    urdf = mujoco.MjModel.from_xml_string(text)
    ours, theirs = _bodies(model), _bodies(urdf)
    assert len(ours) == len(theirs) == 1 + len(robot.wheels) * (1 + robot.roller_count)
    worst = 0.0
    for name, numbers in ours.items():
        other = theirs[name if name == "base_link" else f"{name}_link"]
        worst = max(worst, max(float(np.abs(a - b).max()) for a, b in zip(numbers, other)))
    assert worst < 1e-6, worst
    return worst


def _bodies(model: mujoco.MjModel) -> dict:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    out = {}
    for i in range(1, model.nbody):
        turn = data.ximat[i].reshape(3, 3)
        inertia = turn @ np.diag(model.body_inertia[i]) @ turn.T
        joint = model.body_jntadr[i]
        hinge = joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
        axis = data.xaxis[joint].copy() if hinge else np.zeros(3)
        damping = model.dof_damping[model.jnt_dofadr[joint]] if hinge else 0.0
        out[model.body(i).name] = (data.xipos[i].copy(), model.body_mass[i], inertia, axis, np.array(damping))
    return out


def _force(bench: Bench, contact: int) -> np.ndarray:
    force = np.zeros(6)
    mujoco.mj_contactForce(bench.model, bench.data, contact, force)
    return force


def _loop_difference(robot: Robot) -> float:
    """Largest difference in wheel rates between the loop of MuJoCo's actuators and one written out, torques held."""
    settings = Settings(dt_s=0.002, drive="pi", integrator="Euler", cone="elliptic")
    native = Bench(robot, settings)
    _, rates = native.split(native.run("D5"))
    rates = rates[:, native.rate_at]
    explicit = Bench(robot, settings)
    model, data = explicit.model, explicit.data
    model.actuator_gainprm[:] = 0
    model.actuator_biasprm[:] = 0
    kp, ki = wheel_loop_gains(robot, settings)
    limit = robot.wheel["motor_effort_n_m"]
    integral, worst = np.zeros(len(robot.wheels)), 0.0
    targets = native.controls("D5")[:, ::2]
    for target, native_rate in zip(targets, rates):
        e = target - data.qvel[explicit.rate_at]
        integral += ki * e * settings.dt_s
        data.qfrc_applied[explicit.rate_at] = np.clip(kp * e + integral, -limit, limit)
        mujoco.mj_step(model, data)
        worst = max(worst, float(np.abs(data.qvel[explicit.rate_at] - native_rate).max()))
    return worst
