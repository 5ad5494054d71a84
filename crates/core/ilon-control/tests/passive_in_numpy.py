"""The passive law, implemented again in numpy from its documentation: reads one case per line,
prints its torques.

For each wheel: its place, the unit vector along the axis of the contacting roller, its radius,
gamma. No code is shared.
"""

import json
import sys
from itertools import combinations

import numpy as np


def share(m, wrench, loads):
    """argmin max |f| / N with M^T f = w: on the line or plane of solutions, at the minimum as many
    forces as it has directions, plus one, are at the bound.
    """
    n = len(loads)
    one = np.linalg.lstsq(m.T, wrench, rcond=None)[0] / loads
    free = (np.linalg.svd(m.T)[2][3:].T).reshape(n, n - 3) / loads[:, None]
    best = np.abs(one).max(), one
    for at_bound in combinations(range(n), n - 2):
        rows = list(at_bound)
        for signs in np.ndindex(*(2,) * (n - 3)):
            # All at +t or -t, the first at +t.
            sign = np.array([1, *(1 - 2 * np.array(signs, dtype=int))])
            a = np.column_stack([free[rows], -sign])
            if abs(np.linalg.det(a)) < 1e-12:
                continue
            pushes = one + free @ np.linalg.solve(a, -one[rows])[:-1]
            if np.abs(pushes).max() < best[0]:
                best = np.abs(pushes).max(), pushes
    return best[1] * loads


def torques(case):
    x, y, n_x, n_y, radius, gamma = np.array(case["wheels"]).T
    levers = radius * np.cos(gamma)
    # A wheel's rate is the hub velocity's component along the roller's axis: (n, n . (z x b)) of
    # vx, vy and omega.
    m = -np.column_stack([n_x, n_y, n_y * x - n_x * y])
    pseudo_inverse = np.linalg.pinv(m)
    mass, (c_x, c_y, height), gravity = case["mass"], case["center"], np.array(case["gravity"])
    d = np.diag([case["damping"], case["damping"], case["heading_damping"]])
    rates, targets = np.array(case["rates"]), np.array(case["targets"])
    twist = pseudo_inverse @ (levers * rates)
    wanted = pseudo_inverse @ (levers * targets)
    leaning = mass * np.array([gravity[0], gravity[1], c_x * gravity[1] - c_y * gravity[0]])
    wrench = d @ (wanted - twist) - leaning
    # Loads on a plane over the wheels' places, for a weight at the centre of mass that is shifted
    # downhill by its height.
    places = np.column_stack([np.ones_like(x), x, y])
    g = case["g"]
    moments = mass * np.array([g, g * c_x + height * gravity[0], g * c_y + height * gravity[1]])
    loads = places @ np.linalg.solve(places.T @ places, moments)
    p = np.eye(len(x)) - m @ pseudo_inverse
    turned = np.array(case["second"]) - np.array(case["first"])
    springs = case["between"] * p @ (levers * turned) + case["between_damping"] * p @ (levers * rates)
    return levers * share(m, wrench, loads) - levers * springs / np.mean(levers) ** 2


for line in sys.stdin:
    print(" ".join(f"{torque:.17g}" for torque in torques(json.loads(line))))
