"""A described robot as a MuJoCo model: every roller an explicit body on a passive hinge."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import lru_cache

import mujoco
import numpy as np

from robot import UP, Robot, Wheel

FRICTION = 0.6


@dataclass(frozen=True)
class Settings:
    """One MuJoCo configuration. The defaults are MuJoCo's own, but for the step, shape and integrator.

    `drive`: "servo" is MuJoCo's velocity actuator; "pi" is the project's wheel loop, see `wheel_loop_gains`.
    `loop_rad_s` is that loop's bandwidth on the ground, `loop_air_bound` whether its gain is held to what a wheel in
    the air stands at this step (the project's own choice where a scenario sets no gains).
    `integrator`: "implicitfast" lets the servo be stiff; with "Euler" actuator torques are held over a step.
    """

    dt_s: float = 0.002
    drive: str = "servo"
    shape: str = "ellipsoid"
    cone: str = "pyramidal"
    impratio: float = 1.0
    solref: tuple[float, float] = (0.02, 1.0)
    solimp: tuple[float, float, float] = (0.9, 0.95, 0.001)
    integrator: str = "implicitfast"
    jacobian: str = "auto"
    solver: str = "Newton"
    iterations: int = 100
    tolerance: float = 1e-8
    refsafe: bool = True
    island: bool = True
    servo_n_m_s: float = 1.0
    armature_ratio: float = 0.0
    loop_rad_s: float = 60.0
    loop_air_bound: bool = True

    def words(self) -> str:
        """What differs from MuJoCo's defaults, in short; the step and the drive are columns of their own."""
        default = Settings()
        skip = ("dt_s", "drive", "servo_n_m_s")
        given = {k: v for k, v in asdict(self).items() if k not in skip and v != getattr(default, k)}
        show = lambda v: "/".join(f"{x:g}" for x in v) if isinstance(v, (tuple, list)) else str(v)
        return ", ".join(f"{k} {show(v)}" for k, v in given.items()) or "defaults"


def outline_m(robot: Robot, gamma_rad: float, shape: str, r: float, h: float, phi: np.ndarray) -> np.ndarray:
    """Reach of a roller below the hub axis, standing at phi from straight down: ellipsoid (r, r, h) or capsule."""
    c = math.cos(gamma_rad) * np.sin(phi)
    own = np.sqrt(r * r * (1 - c * c) + h * h * c * c) if shape == "ellipsoid" else h * np.abs(c) + r
    return robot.ring_radius_m * np.cos(phi) + own


@lru_cache
def fitted(robot: Robot, gamma_rad: float, shape: str) -> tuple[float, float, float]:
    """Radius and half length of the ellipsoid or capsule whose wheel is roundest, and its worst error, in metres.

    Minimises the largest deviation of the wheel's outline from its circle over the half pitch, on nested grids.
    """
    phi = np.linspace(0, math.pi / robot.roller_count, 200)
    r, h, dr, dh = robot.rollers["radius_m"], robot.half_length_m(gamma_rad), 1e-3, 0.9
    best = (math.inf, r, h)
    for _ in range(8):
        _, r0, h0 = best
        for r in np.linspace(r0 - dr, r0 + dr, 41):
            for h in np.linspace(h0 * (1 - dh), h0 * (1 + dh), 81):
                error = np.abs(outline_m(robot, gamma_rad, shape, r, h, phi) - robot.radius_m).max()
                best = min(best, (float(error), float(r), float(h)))
        dr, dh = dr / 8, dh / 8
    return best[1], best[2], best[0]


def mjcf(robot: Robot, s: Settings) -> str:
    """The model as MJCF. Collisions: rollers against the floor only, as in the project's own world."""
    w, r = robot.wheel, robot.rollers
    kp, ki = wheel_loop_gains(robot, s) if s.drive == "pi" else (0.0, 0.0)
    assets, wheels, actuators = {}, [], []
    for wheel in robot.wheels:
        geom = _roller_geom(robot, wheel, s.shape, assets)
        moments = robot.roller_moments_kg_m2(wheel.gamma_rad)
        wheels.append(
            f'<body name="{wheel.name}" pos="{_nums(wheel.center_m)}" quat="{_nums(_quat(wheel.body_from_hub))}">'
            f'<inertial pos="0 0 0" mass="{w["hub_mass_kg"]}" diaginertia="{_nums(robot.hub_moments_kg_m2())}"/>'
            f'<joint name="{wheel.name}" axis="0 0 1" damping="{w.get("damping_n_m_s", 0)}"'
            f' frictionloss="{w.get("friction_n_m", 0)}"'
            f' actuatorfrcrange="{-w["motor_effort_n_m"]} {w["motor_effort_n_m"]}"/>'
        )
        for j in range(robot.roller_count):
            center, axis = robot.roller_in_hub(wheel, j)
            name = f"{wheel.name}_roller_{j + 1}"
            wheels.append(
                f'<body name="{name}" pos="{_nums(center)}" zaxis="{_nums(axis)}">'
                f'<inertial pos="0 0 0" mass="{r["mass_kg"]}" diaginertia="{_nums(moments)}"/>'
                f'<joint name="{name}" axis="0 0 1" damping="{r.get("damping_n_m_s", 0)}"'
                f' frictionloss="{r.get("friction_n_m", 0)}" armature="{s.armature_ratio * moments[2]:.12g}"/>'
                f"{geom}</body>"
            )
        wheels.append("</body>")
        if s.drive == "servo":
            actuators.append(f'<velocity name="{wheel.name}" joint="{wheel.name}" kv="{s.servo_n_m_s}"/>')
        else:
            # k_p r + (integral of k_i r) - k_i q - k_p q': with q the sum of q' dt this is k_p e + k_i sum(e dt).
            actuators.append(f'<motor name="{wheel.name}" joint="{wheel.name}" gear="{kp:.12g}"/>')
            actuators.append(
                f'<general name="{wheel.name}_i" joint="{wheel.name}" dyntype="integrator" gaintype="fixed"'
                f' gainprm="{ki:.12g}" biastype="affine" biasprm="0 {-ki:.12g} {-kp:.12g}" actearly="true"/>'
            )
    c = robot.chassis
    return f"""<mujoco model="{robot.name}">
<option timestep="{s.dt_s:.12g}" gravity="0 0 -9.81" integrator="{s.integrator}" solver="{s.solver}" cone="{s.cone}"
 impratio="{s.impratio}" iterations="{s.iterations}" tolerance="{s.tolerance}" jacobian="{s.jacobian}">
 <flag refsafe="{_switch(s.refsafe)}" island="{_switch(s.island)}"/></option>
<default><geom condim="3" friction="{FRICTION} 0 0" solref="{_nums(s.solref)}" solimp="{_nums(s.solimp)}"/></default>
<asset>{"".join(assets.values())}</asset>
<worldbody><geom type="plane" size="0 0 1" contype="1" conaffinity="0"/>
<body name="base_link"><freejoint/><inertial pos="{_nums(c["center_m"])}" mass="{c["mass_kg"]}"
 diaginertia="{_nums(robot.chassis_moments_kg_m2())}"/>
{"".join(wheels)}</body></worldbody>
<actuator>{"".join(actuators)}</actuator></mujoco>"""


def wheel_loop_gains(robot: Robot, s: Settings) -> tuple[float, float]:
    """Gains of a wheel's PI loop as the project proposes them: k_p in N m s/rad and k_i in N m/rad.

    k_p = J_ground w_b, but with the bound at most J_air / dt; k_i = k_p^2 / (4 J_ground).
    """
    ground, air = wheel_inertias_kg_m2(robot)
    kp = ground * s.loop_rad_s
    if s.loop_air_bound:
        kp = min(kp, air / s.dt_s)
    return kp, kp * kp / (4 * ground)


@lru_cache
def wheel_inertias_kg_m2(robot: Robot) -> tuple[float, float]:
    """The largest inertia that a wheel's loop can feel while all wheels roll, and a wheel's own in the air.

    From MuJoCo's mass matrix: T^T M T, with T the joint velocities per wheel rates, the body's twist following by the
    least squares of the ideal kinematics and the touching rollers' spins by rolling.
    """
    model = mujoco.MjModel.from_xml_string(mjcf(robot, Settings()))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    n = len(robot.wheels)
    _, _, p, d, s, index = (x[0] for x in robot.constraints(np.zeros((1, n))))
    twist_from_rates = np.linalg.pinv(robot.rate_matrix)
    columns = np.zeros((model.nv, n))
    dof = lambda name: model.joint(name).dofadr[0]
    for q, column in enumerate(columns.T):
        vx, vy, omega = twist_from_rates[:, q]
        column[[0, 1, 5]] = vx, vy, omega
        for h, wheel in enumerate(robot.wheels):
            rate = float(h == q)
            column[dof(wheel.name)] = rate
            v = np.array([vx, vy, 0]) + omega * np.cross(UP, p[h])
            v += rate * np.cross(wheel.body_from_hub[:, 2], p[h] - wheel.center_m)
            e = np.cross(d[h], UP)
            column[dof(f"{wheel.name}_roller_{index[h] + 1}")] = v @ e / (s[h] * (e @ e))
    # M T, a column at a time, without the dense matrix.
    product = np.zeros((n, model.nv))
    for q in range(n):
        mujoco.mj_mulM(model, data, product[q], np.ascontiguousarray(columns[:, q]))
    unit, out = np.zeros(model.nv), np.zeros(model.nv)
    unit[dof(robot.wheels[0].name)] = 1.0
    mujoco.mj_mulM(model, data, out, unit)
    return float(np.linalg.eigvalsh(product @ columns).max()), float(out @ unit)


def _roller_geom(robot: Robot, wheel: Wheel, shape: str, assets: dict) -> str:
    if shape == "mesh":
        name = f"roller_{abs(wheel.gamma_rad):.6f}"
        if name not in assets:
            half = robot.half_length_m(wheel.gamma_rad)
            z = np.linspace(-half, half, 15)
            radius, around = robot.profile_m(wheel.gamma_rad, z), 2 * math.pi * np.arange(32) / 32
            ring = lambda f: np.outer(radius, f(around))
            points = np.stack([ring(np.cos), ring(np.sin), np.repeat(z[:, None], 32, 1)], axis=-1)
            assets[name] = f'<mesh name="{name}" vertex="{_nums(points.ravel())}"/>'
        return f'<geom type="mesh" mesh="{name}" contype="0" conaffinity="1"/>'
    radius, half, _ = fitted(robot, wheel.gamma_rad, shape)
    size = f"{radius} {radius} {half}" if shape == "ellipsoid" else f"{radius} {half}"
    return f'<geom type="{shape}" size="{size}" contype="0" conaffinity="1"/>'


def _quat(rotation: np.ndarray) -> np.ndarray:
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(rotation).ravel())
    return quat


def _switch(on: bool) -> str:
    return "enable" if on else "disable"


def _nums(values) -> str:
    return " ".join(f"{x:.12g}" for x in values)
