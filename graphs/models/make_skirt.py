"""A circle skirt, cut as a flat ring, and the tailor's dummy that wears it: skirt.obj, dummy.obj."""

import math
import os

from modelling import Model

SIDE = 0.04  # m, of triangles, about
WAIST, HEM, HEIGHT = 0.15, 0.58, 1.0
here = os.path.dirname(os.path.abspath(__file__))


def ring(model, radius, height, count, turn=0.0):
    return [model.vertex((radius * math.cos(2 * math.pi * (i + turn) / count), height,
                          -radius * math.sin(2 * math.pi * (i + turn) / count)))
            for i in range(count)]


def skirt():
    out = Model("skirt", {"cloth": ("#8f2f45", 0.7, 0), "border": ("#d8b46a", 0.6, 0)}, 5)
    rows = round((HEM - WAIST) / (SIDE * math.sqrt(3) / 2))
    below = None
    for k in range(rows + 1):
        radius = WAIST + (HEM - WAIST) * k / rows
        here_ring = ring(out, radius, HEIGHT, round(2 * math.pi * radius / SIDE), 0.25 * (k % 2))
        if below:
            out.use("skirt", "border" if k in (rows - 2, rows - 1) else "cloth")
            out.between(below, here_ring)
        below = here_ring
    out.write(here)


def dummy():
    out = Model("dummy", {"linen": ("#c9bda6", 0.8, 0), "wood": ("#4a3324", 0.35, 0)})
    body = [(0.0, 0.72), (0.1, 0.73), (0.15, 0.76), (0.178, 0.81), (0.182, 0.86), (0.168, 0.92),
            (0.15, 0.97), (0.14, 1.01), (0.145, 1.06), (0.165, 1.13), (0.18, 1.2), (0.178, 1.26),
            (0.16, 1.31), (0.12, 1.345), (0.06, 1.36), (0.045, 1.38), (0.04, 1.42), (0.0, 1.425)]
    post = [(0.0, 0.73), (0.02, 0.73), (0.02, 0.06), (0.05, 0.035), (0.15, 0.02), (0.16, 0.0),
            (0.0, 0.0)]
    for name, material, outline, way in (("body", "linen", body, 1), ("post", "wood", post, -1)):
        out.use(name, material)
        sides = 48
        below = None
        for radius, height in outline[::way]:
            count = 1 if radius == 0 else sides
            now = ring(out, radius, height, count)
            if below:
                for i in range(sides):
                    j = (i + 1) % sides
                    if len(below) == 1:
                        out.face((below[0], now[j], now[i]))
                    elif len(now) == 1:
                        out.face((below[i], below[j], now[0]))
                    else:
                        out.face((below[i], below[j], now[j], now[i]))
            below = now
    out.write(here)


if __name__ == "__main__":
    skirt()
    dummy()
