"""A hollow traffic cone of rubber on a flange, open above and below: cone.obj."""

import math
import os

from modelling import Model

SIDE = 0.026  # m, of triangles, about
cone = Model("cone", {"orange": ("#d9541e", 0.45, 0), "white": ("#e8e6e0", 0.35, 0),
                      "black": ("#2a2a2c", 0.6, 0)}, 5)
# radius and height along the outline, and what it is made of up to there
OUTLINE = [((0.21, 0.006), "black"), ((0.145, 0.006), "black"), ((0.105, 0.16), "orange"),
           ((0.0875, 0.24), "white"), ((0.065, 0.34), "orange"), ((0.055, 0.41), "white"),
           ((0.042, 0.5), "orange")]


def rows():
    """Radius, height and material of each ring."""
    out = [(OUTLINE[0][0], OUTLINE[0][1])]
    for (a, _), (b, material) in zip(OUTLINE, OUTLINE[1:]):
        pieces = max(1, round(math.dist(a, b) / (SIDE * math.sqrt(3) / 2)))
        for i in range(1, pieces + 1):
            out.append(((a[0] + (b[0] - a[0]) * i / pieces, a[1] + (b[1] - a[1]) * i / pieces),
                        material))
    return out


if __name__ == "__main__":
    below = None
    for k, ((radius, height), material) in enumerate(rows()):
        count = max(8, round(2 * math.pi * radius / SIDE))
        turn = 0.25 * (k % 2)
        now = [cone.vertex((radius * math.cos(2 * math.pi * (i + turn) / count), height,
                            -radius * math.sin(2 * math.pi * (i + turn) / count)))
               for i in range(count)]
        if below:
            cone.use("cone", material)
            cone.between(below, now)
        below = now
    cone.write(os.path.dirname(os.path.abspath(__file__)))
