"""The work-precision plot as SVG: worst error against speed, both on logarithmic axes; right and low is better.

A line joins the configurations of a series than which none of it is both faster and more accurate. Configurations that
do not do the drives are left out.
"""

from __future__ import annotations

import math

from drives import RATE_SHORTFALL_MAX

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 470, 360, 58, 12, 34, 46
# Range of the axes: simulated seconds per CPU second, and per cent.
SPEED, ERROR = (1.0, 2000.0), (1e-4, 10.0)
SERIES = [
    ("ilon, near rollers", "#0b6e4f", "line", lambda r: r["engine"] == "ilon" and r["name"].startswith("near")),
    ("ilon, all rollers", "#6bbf59", "line", lambda r: r["engine"] == "ilon" and r["name"].startswith("all")),
    ("MuJoCo, tuned, servo", "#b3001b", "line", lambda r: r["name"] == "tuned" and r["drive"] == "servo"),
    ("MuJoCo, tuned, PI loop", "#f18805", "line", lambda r: r["name"] == "tuned" and r["drive"] == "pi"),
    ("MuJoCo, set by hand", "#888888", "dots", lambda r: r["engine"] == "MuJoCo" and r["name"] != "tuned"),
]


def svg(rows_by_robot: dict[str, list[dict]]) -> str:
    panels = [_panel(robot, rows, i * WIDTH) for i, (robot, rows) in enumerate(rows_by_robot.items())]
    width, height = WIDTH * len(panels), HEIGHT + 24
    legend, x = [], LEFT
    for name, colour, *_ in SERIES:
        legend.append(f'<circle cx="{x}" cy="{HEIGHT + 8}" r="4" fill="{colour}"/>')
        legend.append(f'<text x="{x + 9}" y="{HEIGHT + 12}">{name}</text>')
        x += 30 + 6.4 * len(name)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        f'font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="white"/>'
        f"{''.join(panels)}{''.join(legend)}</svg>\n"
    )


def _panel(robot: str, rows: list[dict], at: float) -> str:
    def place(value, low_high, first, last):
        low, high = map(math.log10, low_high)
        return first + (math.log10(min(max(value, low_high[0]), low_high[1])) - low) / (high - low) * (last - first)

    x = lambda speed: at + place(speed, SPEED, LEFT, WIDTH - RIGHT)
    y = lambda error: place(error, ERROR, HEIGHT - BOTTOM, TOP)
    out = [f'<text x="{x(SPEED[0])}" y="20" font-size="14">{robot}</text>']
    for speed in (1, 10, 100, 1000):
        out.append(f'<path d="M{x(speed):.1f} {y(ERROR[0])}V{y(ERROR[1])}" stroke="#ddd"/>')
        out.append(f'<text x="{x(speed):.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">{speed}</text>')
    for exponent in range(-4, 2):
        error = 10.0**exponent
        out.append(f'<path d="M{x(SPEED[0])} {y(error):.1f}H{x(SPEED[1])}" stroke="#ddd"/>')
        out.append(f'<text x="{x(SPEED[0]) - 6}" y="{y(error) + 4:.1f}" text-anchor="end">{error:g} %</text>')
    middle = (x(SPEED[0]) + x(SPEED[1])) / 2
    out.append(f'<text x="{middle}" y="{HEIGHT - 12}" text-anchor="middle">simulated seconds per CPU second</text>')
    for _, colour, kind, belongs in SERIES:
        shown = [r for r in rows if belongs(r) and r["worst_error_pct"] <= ERROR[1] and r["sim_s_per_cpu_s"] > 0]
        shown = [r for r in shown if (r["rate_shortfall"] or 0.0) <= RATE_SHORTFALL_MAX]
        points = sorted((x(r["sim_s_per_cpu_s"]), y(r["worst_error_pct"])) for r in shown)
        front = [p for i, p in enumerate(points) if all(p[1] > q[1] for q in points[i + 1 :])]
        if kind == "line" and front:
            path = "L".join(f"{px:.1f} {py:.1f}" for px, py in front)
            out.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        for px, py in points:
            prominent = kind == "line" and (px, py) in front
            look = 'r="3.5"' if prominent else 'r="2" fill-opacity="0.5"'
            out.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" {look} fill="{colour}"/>')
    return "".join(out)
