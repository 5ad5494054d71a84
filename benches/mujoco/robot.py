"""The project's short robot descriptions (assets/robots/*.toml), and the kinematics at the rollers that touch.

Frames, as in the rest of the project. Body: origin on the ground, x forward, y left, z up. Hub: one a wheel, at its
centre, z along the hub axis n, x straight down at wheel angle zero. Symbols: rho the wheel's radius, r the roller's
largest radius, a = rho - r, gamma the angle from the hub axis to the rolling direction of the roller that points down,
k = cos gamma the sine of the angle between roller axis and hub axis, N the rollers around one wheel.
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Wheel:
    """Where one wheel sits: its joint's name, centre in the body frame, hub axis angle and handedness."""

    name: str
    center_m: np.ndarray
    axis_rad: float
    gamma_rad: float

    @property
    def body_from_hub(self) -> np.ndarray:
        """Columns x, y, z of the hub frame at wheel angle zero: down, k x n, n."""
        n = np.array([math.cos(self.axis_rad), math.sin(self.axis_rad), 0.0])
        return np.stack([-UP, np.cross(UP, n), n], axis=1)


class Robot:
    """A described robot, and what follows from its geometry."""

    def __init__(self, path: str | Path):
        self.path = Path(path)
        d = tomllib.loads(self.path.read_text())
        self.name: str = d["name"]
        self.chassis, self.wheel, self.rollers = d["chassis"], d["wheel"], d["rollers"]
        self.wheels = _placed(d["wheels"], self.wheel["radius_m"])
        self.rows = self.rollers.get("rows", 1)
        self.roller_count = self.rollers["per_row"] * self.rows
        self.radius_m = self.wheel["radius_m"]
        self.ring_radius_m = self.radius_m - self.rollers["radius_m"]

    # --- masses -----------------------------------------------------------------------------------------------------

    @property
    def mass_kg(self) -> float:
        wheel_kg = self.wheel["hub_mass_kg"] + self.roller_count * self.rollers["mass_kg"]
        return self.chassis["mass_kg"] + len(self.wheels) * wheel_kg

    def chassis_moments_kg_m2(self) -> list[float]:
        """Principal moments of the chassis about its centre: a solid box, or an upright solid cylinder."""
        m, shape = self.chassis["mass_kg"], self.chassis["shape"]
        if "box" in shape:
            x, y, z = shape["box"]["size_m"]
            return [m / 12 * (y * y + z * z), m / 12 * (x * x + z * z), m / 12 * (x * x + y * y)]
        return cylinder_moments_kg_m2(m, shape["cylinder"]["radius_m"], shape["cylinder"]["height_m"])

    def hub_moments_kg_m2(self) -> list[float]:
        w = self.wheel
        return cylinder_moments_kg_m2(w["hub_mass_kg"], w["hub_radius_m"], w["hub_width_m"])

    # --- the exact roller -------------------------------------------------------------------------------------------

    def half_length_m(self, gamma_rad: float) -> float:
        """Neighbours hand over with neither gap nor overlap: L/2 = a tan(pi/N) / k."""
        return self.ring_radius_m * math.tan(math.pi / self.roller_count) / math.cos(gamma_rad)

    def profile_m(self, gamma_rad: float, z_m: np.ndarray) -> np.ndarray:
        """Radius of the barrel at places along its axis: the envelope of spheres s(t) = rho - sqrt(a^2 + t^2 k^2)."""
        t = np.linspace(-1, 1, 401) * self.half_length_m(gamma_rad)
        s = self.radius_m - np.hypot(self.ring_radius_m, t * math.cos(gamma_rad))
        return np.sqrt(np.maximum(s**2 - (np.asarray(z_m)[:, None] - t) ** 2, 0.0).max(axis=1))

    def roller_moments_kg_m2(self, gamma_rad: float) -> list[float]:
        """Across, across and about the axis of a barrel of even density, cut flat at +-L/2: the sum of its slices."""
        half, m = self.half_length_m(gamma_rad), self.rollers["mass_kg"]
        z = half * (2 * (np.arange(400) + 0.5) / 400 - 1)
        r2 = self.profile_m(gamma_rad, z) ** 2
        share = m * r2 / r2.sum()
        across = float((share * (r2 / 4 + z * z)).sum())
        return [across, across, float((share * r2 / 2).sum())]

    def roller_in_hub(self, wheel: Wheel, index: int) -> tuple[np.ndarray, np.ndarray]:
        """Centre and axis of a roller in the hub frame. The axis of the one that points down is k x u_gamma."""
        f = 2 * math.pi * index / self.roller_count
        offset = self.rollers.get("row_spacing_m", 0.0) * (index % 2 - 0.5) if self.rows == 2 else 0.0
        k = math.cos(wheel.gamma_rad)
        center = np.array([self.ring_radius_m * math.cos(f), self.ring_radius_m * math.sin(f), offset])
        return center, np.array([-k * math.sin(f), k * math.cos(f), -math.sin(wheel.gamma_rad)])

    # --- kinematics -------------------------------------------------------------------------------------------------

    def constraints(self, angles_rad: np.ndarray):
        """What rolling without slip asks at wheel angles (T, wheels), at the roller that touches.

        With p the contact point and d the roller's axis, both in the body frame, and d_g the unit vector along d's
        projection on the ground: d_g . (v + omega k x p + q' n x (p - p_hub)) = 0. Returns rows (T, wheels, 3), such
        that row . (vx, vy, omega) = lever * q', the levers (T, wheels) in m, and p, d, s (contact to roller axis, in
        m) and the touching roller's index.
        """
        a, pitch = self.ring_radius_m, 2 * math.pi / self.roller_count
        rows, levers, points, axes, radii, indices = [], [], [], [], [], []
        for h, wheel in enumerate(self.wheels):
            k = math.cos(wheel.gamma_rad)
            theta = angles_rad[:, h]
            # The barrels hand over at +-pi/N: the roller nearest to straight down is the one that touches.
            index = np.round(-theta / pitch).astype(int)
            phi = theta + index * pitch
            index %= self.roller_count
            s_phi, c_phi, zero = np.sin(phi), np.cos(phi), np.zeros_like(phi)
            d = np.stack([-k * s_phi, k * c_phi, zero - math.sin(wheel.gamma_rad)], axis=-1)
            t = -a * np.tan(phi) / k  # the sphere of the barrel that reaches lowest
            s = self.radius_m - np.hypot(a, t * k)
            offset = self.rollers.get("row_spacing_m", 0.0) * (index % 2 - 0.5) if self.rows == 2 else zero
            p = np.stack([a * c_phi + s, a * s_phi, offset], axis=-1) + t[:, None] * d
            turn = wheel.body_from_hub
            d, arm = d @ turn.T, p @ turn.T
            p = arm + wheel.center_m
            d_g = d[:, :2] / np.linalg.norm(d[:, :2], axis=1)[:, None]
            rows.append(np.stack([d_g[:, 0], d_g[:, 1], p[:, 0] * d_g[:, 1] - p[:, 1] * d_g[:, 0]], axis=-1))
            levers.append(-(d_g * np.cross(turn[:, 2], arm)[:, :2]).sum(axis=1))
            points.append(p), axes.append(d), radii.append(s), indices.append(index)
        stack = lambda parts: np.stack(parts, axis=1)
        return stack(rows), stack(levers), stack(points), stack(axes), stack(radii), stack(indices)

    def contact_twists(self, angles_rad: np.ndarray, rates_rad_s: np.ndarray) -> np.ndarray:
        """The twist (T, 3) without slip: least squares of all wheels' constraints, a sliding speed as the misfit."""
        rows, levers, *_ = self.constraints(angles_rad)
        scale = np.array([1.0, 1.0, 1.0 / max(np.hypot(*w.center_m[:2]) for w in self.wheels)])
        rows = rows * scale
        normal = np.einsum("tha,thb->tab", rows, rows)
        right = np.einsum("tha,th->ta", rows, levers * rates_rad_s)
        return np.linalg.solve(normal, right[..., None])[..., 0] * scale

    @property
    def rate_matrix(self) -> np.ndarray:
        """Ideal wheel rates per twist (wheels, 3), Indiveri 2009, eq. (9): the touching roller flat, below the hub."""
        rows = []
        for wheel in self.wheels:
            turn = wheel.body_from_hub
            d = math.cos(wheel.gamma_rad) * turn[:, 1] - math.sin(wheel.gamma_rad) * turn[:, 2]
            lever = -d @ np.cross(turn[:, 2], -self.radius_m * UP)
            b = wheel.center_m
            rows.append(np.array([d[0], d[1], b[0] * d[1] - b[1] * d[0]]) / lever)
        return np.array(rows)

    def lateral_share(self) -> float:
        """Lateral speed of a mecanum robot over the ideal one, in the mean of a turn: sin(pi/N) / (pi/N)."""
        return math.sin(math.pi / self.roller_count) / (math.pi / self.roller_count)


def cylinder_moments_kg_m2(mass_kg: float, radius_m: float, length_m: float) -> list[float]:
    """Principal moments of a solid cylinder along z about its centre."""
    across = mass_kg * (3 * radius_m**2 + length_m**2) / 12
    return [across, across, mass_kg * radius_m**2 / 2]


def _placed(arrangement: dict, radius_m: float) -> list[Wheel]:
    """The wheels of a description one by one, in the order in which the project writes them."""

    def wheel(name, x, y, axis_deg, gamma_deg):
        return Wheel(name, np.array([x, y, radius_m]), math.radians(axis_deg), math.radians(gamma_deg))

    ((kind, w),) = arrangement.items() if isinstance(arrangement, dict) else (("list", arrangement),)
    if kind == "list":
        return [wheel(p["name"], *p["position_m"], p["axis_deg"], p["gamma_deg"]) for p in w]
    if kind == "ring":
        angles = [w.get("first_deg", 0.0) + 360.0 * i / w["count"] for i in range(w["count"])]
        at = lambda deg: (w["distance_m"] * math.cos(math.radians(deg)), w["distance_m"] * math.sin(math.radians(deg)))
        return [wheel(f"wheel_{i + 1}", *at(deg), deg, w["gamma_deg"]) for i, deg in enumerate(angles)]
    axles, middle_m = w["axles_m"], sum(w["axles_m"]) / len(w["axles_m"])
    names = ["front"] + [f"axle_{i + 1}" for i in range(1, len(axles) - 1)] + ["rear"] * (len(axles) > 1)
    if len(axles) == 3:
        names[1] = "middle"
    out = []
    for name, x_m in zip(names, axles):
        left_deg = -w["gamma_deg"] if x_m >= middle_m else w["gamma_deg"]
        out.append(wheel(f"{name}_left", x_m, w["half_width_m"], 90.0, left_deg))
        out.append(wheel(f"{name}_right", x_m, -w["half_width_m"], 90.0, -left_deg))
    return out
