# SPDX-License-Identifier: Apache-2.0
"""Curves as SVG."""
import math

WIDTH, PANEL = 720, 210
LEFT, RIGHT, ABOVE, BELOW = 60, 20, 40, 36
COLOURS = ("#1f5fa8", "#c2571a", "#3a7d34", "#8a3b9c", "#7a6a1f", "#555555")


def round_up(value):
    """To four steps of a round size."""
    power = 10 ** math.floor(math.log10(value / 4)) if value > 0 else 0.25
    return next(4 * step * power for step in (1, 2, 2.5, 5, 10) if 4 * step * power >= value)


def panel(title, x_name, series, top, highest=None):
    """`series`: names with points (x, y)."""
    everything = [point for points in series.values() for point in points]
    low, high = min(x for x, _ in everything), max(x for x, _ in everything)
    highest = highest or round_up(max(y for _, y in everything))
    bottom, left, right = top + PANEL - BELOW, LEFT, WIDTH - RIGHT
    height = PANEL - ABOVE - BELOW

    def x_of(x):
        return left + (x - low) / (high - low) * (right - left)

    def y_of(y):
        return bottom - min(y, highest) / highest * height
    body = [f'<text x="{left}" y="{top + 16}"><tspan font-weight="bold">{title}</tspan>' +
            "".join(f'<tspan dx="10" fill="{colour}">{name}</tspan>' for name, colour in zip(series, COLOURS)) + "</text>",
            f'<path d="M{left} {top + ABOVE}V{bottom}H{right}" fill="none" stroke="#999"/>']
    for step in range(5):
        y = highest * step / 4
        body.append(f'<text x="{left - 6}" y="{y_of(y) + 4:.1f}" text-anchor="end">{y:.2g}</text>')
        x = low + (high - low) * step / 4
        body.append(f'<text x="{x_of(x):.1f}" y="{bottom + 15}" text-anchor="middle">{x:.2g}</text>')
    body.append(f'<text x="{right}" y="{bottom + 30}" text-anchor="end">{x_name}</text>')
    for points, colour in zip(series.values(), COLOURS):
        line = " ".join(f"{x_of(x):.1f},{y_of(y):.1f}" for x, y in points)
        body.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.8"/>')
    return "\n".join(body) + "\n"


def draw(panels):
    """`panels`: (title, name of x, series, the highest y or None)."""
    body = "".join(panel(title, x_name, series, i * PANEL, highest) for i, (title, x_name, series, highest) in enumerate(panels))
    height = PANEL * len(panels)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}" '
            f'font-family="sans-serif" font-size="12">\n<rect width="100%" height="100%" fill="#fff"/>\n{body}</svg>\n')
