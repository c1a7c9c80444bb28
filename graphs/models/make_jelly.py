"""A fluted jelly, as it comes out of its mould: jelly.obj."""

import math
import os

from modelling import Model

SIDES, FLUTES = 72, 12
jelly = Model("jelly", {"jelly": ("#c81e2c", 0.18, 0)})


def smooth(t):
    t = min(1, max(0, t))
    return t * t * (3 - 2 * t)


def outline():
    """(radius, height, depth of the flutes) from under the foot, over the top, into its dent."""
    points = [(0.06, 0.0, 0), (0.115, 0.0, 0.2), (0.138, 0.002, 0.6)]
    steps = 20
    for i in range(steps + 1):
        t = i / steps
        points.append((0.146 - 0.046 * t - 0.012 * math.sin(math.pi * t), 0.01 + 0.135 * t,
                       1 - 0.25 * smooth((t - 0.7) / 0.3)))
    for i in range(1, 13):
        a = math.pi / 2 * i / 12
        points.append((0.076 + 0.024 * math.cos(a), 0.145 + 0.024 * math.sin(a), 0.75 - 0.6 * i / 12))
    for i in range(1, 6):
        t = i / 6
        points.append((0.076 * (1 - t), 0.169 - 0.010 * smooth(t), 0.15 * (1 - t)))
    return points


if __name__ == "__main__":
    jelly.use("jelly", "jelly")
    rings = []
    for radius, height, flute in outline():
        ring = []
        for i in range(SIDES):
            a = 2 * math.pi * i / SIDES
            r = radius * (1 + 0.085 * flute * (abs(math.cos(FLUTES / 2 * a)) - 0.6))
            ring.append((r * math.cos(a), height, -r * math.sin(a)))
        rings.append(ring)
    jelly.rings(rings)
    jelly.write(os.path.dirname(os.path.abspath(__file__)))
