"""A round leather pouffe, its flat top finely divided for what ripples there: pouffe.obj."""

import math
import os

from modelling import Model, circle

SIDES, WEDGES = 96, 12
TOP, RADIUS, HEIGHT, EDGE = 0.5, 0.6, 0.36, 0.1  # m; the top is flat to TOP
pouffe = Model("pouffe", {
    "leather": ("#8c3b1f", 0.25, 0), "hide": ("#d9b98a", 0.25, 0), "cord": ("#2b1a14", 0.5, 0)})


def outline():
    """(radius, height) from under the foot to the middle of the top; all but the ends have rings."""
    points = [(0.25, 0), (0.45, 0)]
    for i in range(1, 9):
        a = math.pi / 2 * (i / 8 - 1)
        points.append((0.5 + EDGE * math.cos(a), EDGE + EDGE * math.sin(a)))
    for i in range(1, 8):
        t = i / 8
        points.append((RADIUS + 0.02 * math.sin(math.pi * t), EDGE + (HEIGHT - 2 * EDGE) * t))
    for i in range(9):
        a = math.pi / 2 * i / 8
        points.append((TOP + EDGE * math.cos(a), HEIGHT - EDGE + EDGE * math.sin(a)))
    rings = 40
    points += [(TOP * (1 - i / rings), HEIGHT) for i in range(1, rings)]
    return points


def at(radius, height, side):
    a = 2 * math.pi * side / SIDES
    return (radius * math.cos(a), height, -radius * math.sin(a))


if __name__ == "__main__":
    rings = [[pouffe.vertex(at(r, y, i)) for i in range(SIDES)] for r, y in outline()]
    foot, crown = pouffe.vertex((0, 0, 0)), pouffe.vertex((0, HEIGHT, 0))
    for i in range(SIDES):
        j = (i + 1) % SIDES
        pouffe.use("cover", ("leather", "hide")[i * WEDGES // SIDES % 2])
        pouffe.face((rings[0][j], rings[0][i], foot))
        for a, b in zip(rings, rings[1:]):
            pouffe.face((a[i], a[j], b[j], b[i]))
        pouffe.face((rings[-1][i], rings[-1][j], crown))
    pouffe.use("cord", "cord")
    for radius, height in ((0.578, HEIGHT - 0.029), (0.578, 0.029)):
        ids = [[pouffe.vertex(at(radius + u, height + v, i)) for u, v in circle(0.014, 8)]
               for i in range(SIDES)]
        for i in range(SIDES):
            for k in range(8):
                a, b = ids[i], ids[(i + 1) % SIDES]
                pouffe.face((a[k], b[k], b[(k + 1) % 8], a[(k + 1) % 8]))
    pouffe.write(os.path.dirname(os.path.abspath(__file__)))
