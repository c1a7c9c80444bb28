"""A block of jelly about the origin, a little smaller than 4 x 5 x 4 cubes of 0.1 m:
jelly_block.obj."""

import math
import os

from modelling import Model

HALF = (0.196, 0.245, 0.196)
SIDES, RINGS = 16, 9
block = Model("jelly_block", {"raspberry": ("#c2203a", 0.25, 0)})

if __name__ == "__main__":
    block.use("jelly", "raspberry")
    rings = []
    for k in range(RINGS):
        # Rings of a superellipse along y, closer together at the rounded ends.
        t = -1 + 2 * k / (RINGS - 1)
        y = math.copysign(abs(math.sin(math.pi / 2 * t)) ** 0.8, t)
        r = max(0.35, (1 - abs(y) ** 6) ** (1 / 6))
        ring = []
        for i in range(SIDES):
            a = 2 * math.pi * (i + 0.5) / SIDES
            c, s = math.cos(a), math.sin(a)
            p = r * (abs(c) ** 5 + abs(s) ** 5) ** (-1 / 5)
            ring.append((HALF[0] * p * c, HALF[1] * y, -HALF[2] * p * s))
        rings.append(ring)
    block.rings(rings)
    block.write(os.path.dirname(os.path.abspath(__file__)))
