"""Robots with joints between bodies, ilon beside MuJoCo: arms that swing, springs over a step, swing arms in braking.

MuJoCo reads the same URDF by its own reader. It gets a floor, springs and servos as the scenario has them, and wheels that are spheres of the wheels' radius, for
straight ahead a mecanum wheel rolls as a round one: all that differs is how rollers hand over. Each line says the largest difference over the run, over the largest
change of the quantity, of forces and torques over that of the one that changes most.

    python benches/mujoco/joints.py --ilon target/release/ilon
"""

from __future__ import annotations

import argparse
import math
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import pyarrow.parquet as pq

ROBOTS = Path(__file__).resolve().parents[2] / "assets" / "robots"
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
ROLLERS = "wheels = { rollers = 9, roller_radius_m = 0.012, roller_mass_kg = 0.01, damping_n_m_s = 1e-6, gamma.x_deg = 45 }"
# MuJoCo's step, and how long both are averaged over: a contact's force in one step is that step's own.
DT_S = 1e-4
MEAN_S = 0.05
WITHIN = 0.01


@dataclass
class Seen:
    """What is compared: rows of times, and of each quantity the values at them."""

    t_s: np.ndarray
    values: dict[str, np.ndarray]


def ilon(path: str, text: str, columns: dict[str, str], files: dict[str, str] | None = None) -> Seen:
    """A run of ilon, of which some columns are kept."""
    with tempfile.TemporaryDirectory() as folder:
        for name, content in (files or {}).items():
            (Path(folder) / name).write_text(content)
        scenario = Path(folder) / "joints.toml"
        scenario.write_text(text)
        out = Path(folder) / "out"
        subprocess.run([path, "run", str(scenario), "--out", str(out), "--no-report", "--quiet"], check=True)
        table = pq.read_table(out / "trace.parquet", columns=["t_s", *columns])
    read = lambda name: table.column(name).to_numpy()
    return Seen(read("t_s"), {ours: read(name) for name, ours in columns.items()})


def model(
    urdf: str, joints: dict[str, dict], friction: float, step_m: tuple[float, float] | None = None, held: str = ""
) -> mujoco.MjModel:
    """MuJoCo's own reading of a URDF on a floor, with springs and dampers in joints, one of them held, and round wheels."""
    spec = mujoco.MjSpec.from_file(urdf)
    spec.compiler.fusestatic = False
    spec.option.timestep = DT_S
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for body in list(spec.bodies):
        for geom in body.geoms:
            geom.contype, geom.conaffinity = 0, 0
            geom.group = 3
    for body in list(spec.bodies):
        # Straight ahead no roller turns: they are parts of their wheels.
        for joint in list(body.joints):
            if "_roller_" in joint.name or joint.name == held:
                spec.delete(joint)
    spec.body("base_link").add_freejoint(name="root")
    solid = dict(contype=1, conaffinity=1, condim=3, friction=[friction, 0, 0], solref=[0.002, 1], solimp=[0.99, 0.99, 1e-3, 0.5, 2])
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[50, 50, 1], **solid)
    if step_m:
        at_m, height_m = step_m
        size = [2, 2, height_m / 2]
        spec.worldbody.add_geom(name="step", type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=[at_m + 2, 0, height_m / 2], **solid)
    for wheel in WHEELS:
        solid_wheel = solid | dict(contype=2, conaffinity=1)
        spec.body(f"{wheel}_link").add_geom(name=wheel, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.05, 0, 0], **solid_wheel)
    for name, numbers in joints.items():
        joint = spec.joint(name)
        for key, value in numbers.items():
            # Stiffness and damping are of first, second and third order.
            setattr(joint, key, [value, 0, 0] if key in ("stiffness", "damping") else value)
    return spec.compile()


class Run:
    """A run of MuJoCo, with the means of what is compared over `MEAN_S`."""

    def __init__(self, built: mujoco.MjModel) -> None:
        self.model, self.data = built, mujoco.MjData(built)
        self.rows: list[tuple[float, list[float]]] = []

    def joint(self, name: str) -> tuple[int, int]:
        joint = self.model.joint(name)
        return int(joint.qposadr[0]), int(joint.dofadr[0])

    def loads_n(self) -> np.ndarray:
        loads, force = np.zeros(len(WHEELS)), np.zeros(6)
        for index, contact in enumerate(self.data.contact[: self.data.ncon]):
            for geom in contact.geom:
                name = self.model.geom(geom).name
                if name in WHEELS:
                    mujoco.mj_contactForce(self.model, self.data, index, force)
                    # Along the vertical: at a step's edge the normal leans.
                    loads[WHEELS.index(name)] += abs(contact.frame[2]) * force[0]
        return loads

    def attitude(self) -> tuple[float, float]:
        """Pitch and heading of the base."""
        w, x, y, z = self.data.qpos[3:7]
        pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
        return pitch, math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))

    def settle(self, for_s: float, act) -> None:
        while self.data.time < for_s:
            act(0.0)
            mujoco.mj_step(self.model, self.data)
        self.data.time = 0.0

    def go(self, until_s: float, act, see) -> None:
        while self.data.time < until_s:
            act(self.data.time)
            mujoco.mj_step(self.model, self.data)
            self.rows.append((self.data.time, see()))

    def seen(self, names: list[str]) -> Seen:
        t_s = np.array([row[0] for row in self.rows])
        values = np.array([row[1] for row in self.rows])
        return Seen(t_s, {name: values[:, place] for place, name in enumerate(names)})


def smooth(seen: Seen, at_s: np.ndarray) -> dict[str, np.ndarray]:
    """Means over `MEAN_S` around times."""
    found = {}
    for name, values in seen.values.items():
        steps = 0.5 * (values[1:] + values[:-1]) * np.diff(seen.t_s)
        sums = np.concatenate([[0.0], np.cumsum(steps)])
        mean = lambda t: (np.interp(t + MEAN_S / 2, seen.t_s, sums) - np.interp(t - MEAN_S / 2, seen.t_s, sums)) / MEAN_S
        found[name] = mean(at_s)
    return found


def compare(what: str, ours: Seen, theirs: Seen, from_s: float) -> bool:
    """Prints the largest difference of each quantity over its largest change; whether all are within `WITHIN`."""
    end_s = min(ours.t_s[-1], theirs.t_s[-1]) - MEAN_S
    at_s = np.arange(from_s, end_s, 0.01)
    a, b = smooth(ours, at_s), smooth(theirs, at_s)
    good = True
    for name in a:
        # Levers, centres and zeros may be counted from elsewhere: how it changes is compared.
        unit = name.rsplit(", ", 1)[1]
        alike = [other for other in b if other == name or unit in ("N", "N m") and other.endswith(f", {unit}")]
        change = max(np.ptp(b[other]) for other in alike)
        off = np.abs(a[name] - a[name][0] - (b[name] - b[name][0]))
        share = off.max() / change
        good &= share < WITHIN
        kind = "" if share < WITHIN else "  <-- beyond"
        print(f"{what}: {name}: {100 * share:.2f} % of {change:.4g} (at {at_s[off.argmax()]:.2f} s: ilon {a[name][off.argmax()]:.5g}, MuJoCo {b[name][off.argmax()]:.5g}){kind}")
    return good


def loads_of_ilon() -> dict[str, str]:
    return {f"wheel{index}_normal_force_n": f"{wheel} load, N" for index, wheel in enumerate(WHEELS)}


def add_sums(seen: Seen) -> None:
    """Four wheels under a rigid chassis share a load as their contacts give way, and in each engine they give way otherwise; what an axle and a side bear, moments say."""
    of = lambda *names: sum(seen.values[f"{name} load, N"] for name in names)
    seen.values["front axle, N"] = of("front_left", "front_right")
    seen.values["left side, N"] = of("front_left", "rear_left")
    for wheel in WHEELS:
        del seen.values[f"{wheel} load, N"]


def arm_swing(path: str) -> bool:
    """An arm of 2 kg swings out by a quarter turn within 0.6 s while the base is free to turn on ice."""
    k, d, begins_s, takes_s, turns_rad = 600.0, 20.0, 0.5, 0.6, math.pi / 2
    urdf = str(ROBOTS / "mecanum4_arm.urdf")
    text = f"""
[robot]
file = "{urdf}"
{ROLLERS}
[robot.joints.arm]
role = "driven"
stiffness_n_m_rad = {k}
damping_n_m_s_rad = {d}
effort_n_m = 1000
rate_limit_rad_s = 1000
friction_n_m = 0
setpoints = [{{ t_s = {begins_s}, position_rad = 0 }}, {{ t_s = {begins_s + takes_s}, position_rad = {turns_rad} }}]
[world.floor]
friction = 0
[twist]
vx_m_s = 0
[run]
duration_s = 2
control_dt_s = 0.001
physics_dt_s = 0.0005
"""
    columns = {"truth_heading_rad": "base yaw, rad", "joint_arm_position_rad": "arm, rad"} | loads_of_ilon()
    ours = ilon(path, text, columns)
    ours.values["base yaw, rad"] = np.unwrap(ours.values["base yaw, rad"])
    run = Run(model(urdf, {"arm": dict(frictionloss=0)}, 0.0, held="lift"))
    q, v = run.joint("arm")

    def act(t_s: float) -> None:
        s = min(max((t_s - begins_s) / takes_s, 0.0), 1.0)
        at = turns_rad * s**3 * (10 - s * (15 - 6 * s))
        rate = turns_rad * 30 * (s * (1 - s)) ** 2 / takes_s
        run.data.qfrc_applied[v] = k * (at - run.data.qpos[q]) + d * (rate - run.data.qvel[v])

    def see() -> list[float]:
        return [run.attitude()[1], run.data.qpos[q], *run.loads_n()]

    run.settle(1.0, act)
    heading_before = run.attitude()[1]
    run.go(2.0, act, see)
    theirs = run.seen(list(ours.values))
    theirs.values["base yaw, rad"] = np.unwrap(theirs.values["base yaw, rad"]) - heading_before
    add_sums(ours)
    add_sums(theirs)
    return compare("arm swing", ours, theirs, 0.1)


def sprung_over_a_step(path: str) -> bool:
    """A chassis on four springs drives up a step of 5 mm at 0.3 m/s."""
    k, d, at_m, height_m, vx, loop, most_n_m = 4000.0, 60.0, 0.5, 0.005, 0.3, 0.3, 1.8
    urdf = str(ROBOTS / "mecanum4_sprung.urdf")
    springs = [f"{wheel}_spring" for wheel in WHEELS]
    tables = "".join(f"[robot.joints.{name}]\nstiffness_n_m = {k}\ndamping_n_s_m = {d}\n" for name in springs)
    text = f"""
[robot]
file = "{urdf}"
{ROLLERS}
{tables}
[[world.floor.boxes]]
x_m = {at_m + 2}
y_m = 0
length_x_m = 4
length_y_m = 4
height_m = {height_m}
[twist]
vx_m_s = {vx}
rest_s = 0
ramp_s = 0.5
[wheel_loop]
proportional_n_m_s = {loop}
integral_n_m = 0
feedforward_damping_n_m_s = 0
[run]
duration_s = 3.5
control_dt_s = 0.001
physics_dt_s = 0.0005
"""
    columns = {"truth_x_m": "x, m", "truth_pitch_rad": "pitch, rad", "truth_height_m": "height, m"} | {f"joint_{name}_force_n": f"{name}, N" for name in springs}
    ours = ilon(path, text, columns)
    built = model(urdf, {name: dict(stiffness=k, damping=d) for name in springs}, 0.6, (at_m, height_m))
    run = Run(built)
    wheels = [run.joint(wheel) for wheel in WHEELS]
    slides = [run.joint(name) for name in springs]
    start = run.data.qpos[0]

    def act(t_s: float) -> None:
        # Commands hold over a control period of 1 ms.
        asked_rad_s = vx * min(math.floor(t_s / 0.001 + 1e-6) * 0.001 / 0.5, 1.0) / 0.05
        for _, v in wheels:
            torque = loop * (asked_rad_s - run.data.qvel[v])
            run.data.qfrc_applied[v] = min(max(torque, -most_n_m), most_n_m)

    def see() -> list[float]:
        pitch, _ = run.attitude()
        return [run.data.qpos[0], pitch, run.data.qpos[2], *(-k * run.data.qpos[q] - d * run.data.qvel[v] for q, v in slides)]

    run.settle(1.5, act_still(run, wheels))
    run.data.qpos[0] = start
    run.go(3.5, act, see)
    return compare("sprung over a step", ours, run.seen(list(ours.values)), 0.1)


def act_still(run: Run, wheels: list[tuple[int, int]]):
    def act(_: float) -> None:
        for _, v in wheels:
            run.data.qfrc_applied[v] = -5.0 * run.data.qvel[v]

    return act


def braking_on_arms(path: str) -> bool:
    """A robot on trailing arms is driven by torques: ahead for 0.3 s, and braked for 0.25 s."""
    with tempfile.TemporaryDirectory() as folder:
        urdf = str(Path(folder) / "arms.urdf")
        subprocess.run([path, "generate", str(ROBOTS / "mecanum4_arms.toml"), "--out", urdf], check=True, capture_output=True)
        k, d = 35.0, 0.7
        times = [(0.0, 0.0), (0.3, 0.5), (0.6, 0.0), (0.9, -0.5), (1.15, 0.0), (2.2, 0.0)]
        rows = "".join(f"{t},{','.join([str(torque)] * 4)}\n" for t, torque in times)
        log = "t_s," + ",".join(f"{wheel}_torque_n_m" for wheel in WHEELS) + "\n" + rows
        text = f"""
[robot]
file = "{urdf}"
[playback]
file = "torques.csv"
drives = "wheel_torques"
[run]
duration_s = 2.2
control_dt_s = 0.001
physics_dt_s = 0.0005
"""
        arms = [f"{wheel}_arm" for wheel in WHEELS]
        columns = {"truth_pitch_rad": "pitch, rad", "truth_vx_m_s": "speed, m/s"} | {f"joint_{name}_force_n_m": f"{name}, N m" for name in arms} | loads_of_ilon()
        ours = ilon(path, text, columns, {"torques.csv": log})
        built = model(urdf, {name: dict(stiffness=k, damping=d) for name in arms}, 0.6)
    run = Run(built)
    wheels = [run.joint(wheel) for wheel in WHEELS]
    turns = [run.joint(name) for name in arms]

    def act(t_s: float) -> None:
        torque = [torque for t, torque in times if t <= t_s + 1e-9][-1]
        for _, v in wheels:
            run.data.qfrc_applied[v] = torque

    def see() -> list[float]:
        pitch, heading = run.attitude()
        vx = math.cos(heading) * run.data.qvel[0] + math.sin(heading) * run.data.qvel[1]
        return [pitch, vx, *(-k * run.data.qpos[q] - d * run.data.qvel[v] for q, v in turns), *run.loads_n()]

    run.settle(1.5, act_still(run, wheels))
    run.data.qvel[:] = 0
    run.go(2.2, act, see)
    return compare("braking on swing arms", ours, run.seen(list(ours.values)), 0.1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ilon", default="target/release/ilon", help="the command")
    parser.add_argument("cases", nargs="*", default=[], help="arm_swing, sprung_over_a_step, braking_on_arms")
    given = parser.parse_args()
    cases = [arm_swing, sprung_over_a_step, braking_on_arms]
    chosen = [case for case in cases if not given.cases or case.__name__ in given.cases]
    held = [case(given.ilon) for case in chosen]
    raise SystemExit(0 if all(held) else 1)


if __name__ == "__main__":
    main()
