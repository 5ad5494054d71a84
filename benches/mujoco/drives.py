"""The five open-loop drives, the measure of their accuracy, and the speed of pure stepping."""

from __future__ import annotations

import math
import time
from dataclasses import asdict, dataclass, field

import mujoco
import numpy as np
from mujoco import rollout

from model import Settings, mjcf
from robot import Robot

# Body twists (vx in m/s, vy in m/s, omega in rad/s).
DRIVES = {
    "D1": (0.3, 0.0, 0.0),
    "D2": (0.0, 0.3, 0.0),
    "D3": (0.0, 0.0, 1.0),
    "D4": (0.2, 0.2, 0.0),
    "D5": (0.3, 0.0, 0.5),
}
REST_S, RAMP_S, HOLD_S, MEASURED_S = 1.0, 0.5, 4.0, 3.0
# The drives are also run slower and faster, to see what of an accuracy holds beyond the speed it was found at.
OTHER_SPEEDS = (0.5, 1.5)
# A configuration whose wheels miss the rates asked for by more than this has not done the drive: its loop is too slow.
RATE_SHORTFALL_MAX = 0.1
DURATION_S = REST_S + RAMP_S + HOLD_S
# Warnings of a simulation that blows up are counted in its data; MuJoCo would also print them and write a log file.
mujoco.set_mju_user_warning(lambda message: None)
FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS


@dataclass
class Outcome:
    """What one drive came to."""

    error_pct: float
    """Worst deviation of the mean real twist from the mean of the contact kinematics, of the driven components."""
    ideal_ratio: list[float | None]
    """Mean real over mean ideal twist, of the driven components."""
    hub_ripple_m: float
    """Largest peak-to-peak change of a hub's height."""
    hub_height_m: float
    """Mean height of the hubs."""
    rate_ratio: float
    """Mean wheel rates over those asked for, by their norms."""
    final_state: np.ndarray


@dataclass
class Measured:
    """A configuration with its accuracy over all drives, and its speed."""

    settings: Settings
    outcomes: dict[str, Outcome] = field(default_factory=dict)
    other_speeds: dict[tuple[str, float], Outcome] = field(default_factory=dict)
    cpu_s_per_sim_s: dict[str, float] = field(default_factory=dict)

    @property
    def worst_error_pct(self) -> float:
        errors = [o.error_pct for o in self.outcomes.values()]
        return max(errors) if all(map(math.isfinite, errors)) else math.inf

    @property
    def any_speed_error_pct(self) -> float:
        """The worst error at all speeds."""
        return max([self.worst_error_pct] + [o.error_pct for o in self.other_speeds.values()])

    @property
    def rate_shortfall(self) -> float:
        """Worst deviation of the mean wheel rates from those asked for, relative."""
        return max(abs(o.rate_ratio - 1) if math.isfinite(o.rate_ratio) else math.inf for o in self.outcomes.values())

    @property
    def hub_ripple_m(self) -> float:
        return max(o.hub_ripple_m for o in self.outcomes.values())

    @property
    def sim_s_per_cpu_s(self) -> float:
        """Simulated seconds over CPU seconds of the five drives together."""
        return len(self.cpu_s_per_sim_s) / sum(self.cpu_s_per_sim_s.values())

    @property
    def steps_per_cpu_s(self) -> float:
        return self.sim_s_per_cpu_s / self.settings.dt_s

    def row(self) -> dict:
        """For JSON."""
        return {
            "settings": asdict(self.settings),
            "worst_error_pct": self.worst_error_pct,
            "any_speed_error_pct": self.any_speed_error_pct,
            "hub_ripple_m": self.hub_ripple_m,
            "rate_shortfall": self.rate_shortfall,
            "sim_s_per_cpu_s": self.sim_s_per_cpu_s,
            "steps_per_cpu_s": self.steps_per_cpu_s,
            "drives": {
                name: {"error_pct": o.error_pct, "ideal_ratio": o.ideal_ratio} for name, o in self.outcomes.items()
            },
        }


class Bench:
    """One configuration of one robot, built."""

    def __init__(self, robot: Robot, settings: Settings):
        self.robot = robot
        self.measured = Measured(settings)
        self.model = mujoco.MjModel.from_xml_string(mjcf(robot, settings))
        self.data = mujoco.MjData(self.model)
        joints = [self.model.joint(w.name) for w in robot.wheels]
        self.angle_at = [j.qposadr[0] for j in joints]
        self.rate_at = [j.dofadr[0] for j in joints]

    def controls(self, drive: str, speed: float = 1.0) -> np.ndarray:
        """The actuators' inputs of every step: rest, ramp, hold. They depend on time alone."""
        dt_s = self.measured.settings.dt_s
        t = np.arange(round(DURATION_S / dt_s)) * dt_s
        rates = np.clip((t - REST_S) / RAMP_S, 0, 1)[:, None] * (speed * self.robot.rate_matrix @ DRIVES[drive])
        # The loop's two actuators a wheel stand side by side and take the same rate.
        return np.repeat(rates, self.model.nu // len(self.robot.wheels), axis=1)

    def run(self, drive: str, speed: float = 1.0) -> np.ndarray:
        """Simulates a drive: states after every step (T, size)."""
        mujoco.mj_resetData(self.model, self.data)
        start = np.zeros((1, mujoco.mj_stateSize(self.model, FULL)))
        mujoco.mj_getState(self.model, self.data, start[0], FULL)
        states, _ = rollout.rollout(self.model, [self.data], start, self.controls(drive, speed)[None])
        return states[0]

    def split(self, states: np.ndarray):
        """Positions and velocities of states: time, qpos, qvel, then the actuators' own."""
        nq, nv = self.model.nq, self.model.nv
        return states[:, 1 : 1 + nq], states[:, 1 + nq : 1 + nq + nv]

    def accuracy(self, drive: str, speed: float = 1.0) -> Outcome:
        """Runs a drive, at a multiple of its speed, and measures its last three seconds."""
        outcome = self._outcome(drive, speed)
        if speed == 1.0:
            self.measured.outcomes[drive] = outcome
        else:
            self.measured.other_speeds[drive, speed] = outcome
        return outcome

    def _outcome(self, drive: str, speed: float) -> Outcome:
        robot, states = self.robot, self.run(drive, speed)
        q, v = self.split(states[-round(MEASURED_S / self.measured.settings.dt_s) :])
        if not np.isfinite(q).all() or any(w.number for w in self.data.warning):
            return Outcome(math.inf, [], math.inf, math.nan, math.nan, states[-1].copy())
        rotation = _rotations(q[:, 3:7])
        # MuJoCo gives a free body's linear velocity in the world, its angular one in the body; here both in the body.
        linear, angular = np.einsum("tij,ti->tj", rotation, v[:, :3]), v[:, 3:6]
        real = np.stack([linear[:, 0], linear[:, 1], angular[:, 2]], axis=1).mean(axis=0)
        rates = v[:, self.rate_at]
        contact = robot.contact_twists(q[:, self.angle_at], rates).mean(axis=0)
        ideal = np.linalg.lstsq(robot.rate_matrix, rates.mean(axis=0), rcond=None)[0]
        driven = np.array(DRIVES[drive]) != 0
        centers = np.array([w.center_m for w in robot.wheels])
        heights = q[:, 2:3] + rotation[:, 2] @ centers.T
        asked = speed * robot.rate_matrix @ DRIVES[drive]
        return Outcome(
            error_pct=float(100 * np.abs(real[driven] / contact[driven] - 1).max()),
            ideal_ratio=[float(r / i) if on else None for r, i, on in zip(real, ideal, driven)],
            hub_ripple_m=float(np.ptp(heights, axis=0).max()),
            hub_height_m=float(heights.mean()),
            rate_ratio=float(np.linalg.norm(rates.mean(axis=0)) / np.linalg.norm(asked)),
            final_state=states[-1].copy(),
        )

    def time(self, drive: str, stretches: int, stretch_s: float = 1.0) -> None:
        """CPU time of pure stepping, inside MuJoCo, on at the held speed; the best of all stretches so far stands."""
        steps = max(1, round(stretch_s / self.measured.settings.dt_s))
        simulated_s = steps * self.measured.settings.dt_s
        mujoco.mj_setState(self.model, self.data, self.measured.outcomes[drive].final_state, FULL)
        self.data.ctrl[:] = self.controls(drive)[-1]
        best = self.measured.cpu_s_per_sim_s.get(drive, math.inf)
        for _ in range(stretches):
            start = time.process_time()
            mujoco.mj_step(self.model, self.data, steps)
            best = min(best, (time.process_time() - start) / simulated_s)
        self.measured.cpu_s_per_sim_s[drive] = best

    def all(self, stretches: int, give_up_pct: float = math.inf, speeds: tuple = ()) -> Measured:
        """Accuracy and speed over all drives; drives left out once one is worse than `give_up_pct`."""
        for drive, speed in [(d, s) for s in (1.0, *speeds) for d in DRIVES]:
            if self.accuracy(drive, speed).error_pct > give_up_pct:
                break
        for drive in self.measured.outcomes:
            self.time(drive, stretches)
        return self.measured


def _rotations(quaternions: np.ndarray) -> np.ndarray:
    w, x, y, z = quaternions.T
    return np.stack(
        [
            1 - 2 * (y * y + z * z),
            2 * (x * y - w * z),
            2 * (x * z + w * y),
            2 * (x * y + w * z),
            1 - 2 * (x * x + z * z),
            2 * (y * z - w * x),
            2 * (x * z - w * y),
            2 * (y * z + w * x),
            1 - 2 * (x * x + y * y),
        ],
        axis=-1,
    ).reshape(-1, 3, 3)
