#!/usr/bin/env python3
"""Writes chair.obj and chair.mtl: a stacking chair of thin moulded plastic, 0.89 m high.

Seat and back are one curved sheet 4 mm thick with slots in the back and a turned-down rim; legs and
arms are thin open sections whose ends run into the sheet. It stands on y = 0 and faces +z.
"""

import math
import os

from modelling import Model, add, cross, mul, sub, unit

MATERIALS = {  # colour, roughness, metallic
    "plastic": ("#1f8f86", 0.35, 0.0),
    "feet": ("#2c2f33", 0.8, 0.0),
}

SHEET = 0.004  # m, thickness of seat and back
LEG = 0.0035   # m, thickness of the legs' wall

chair = Model("chair", MATERIALS)

# The sheet's centre line from the front lip to the top of the back, as (z, y), and half its width.
LINE = [(0.236, 0.398), (0.228, 0.428), (0.200, 0.446), (0.150, 0.448), (0.080, 0.441),
        (0.000, 0.434), (-0.070, 0.430), (-0.130, 0.431), (-0.175, 0.443), (-0.205, 0.468),
        (-0.222, 0.505), (-0.237, 0.560), (-0.253, 0.630), (-0.270, 0.700), (-0.288, 0.770),
        (-0.306, 0.838), (-0.318, 0.868), (-0.340, 0.882)]
HALF_WIDTH = [0.196, 0.212, 0.220, 0.222, 0.222, 0.221, 0.219, 0.215, 0.210, 0.205, 0.202, 0.204,
              0.208, 0.209, 0.204, 0.184, 0.156, 0.118]


def smooth(values, u):
    """A Catmull-Rom spline through `values` (numbers), 0 <= u <= len - 1."""
    i = min(int(u), len(values) - 2)
    t = u - i
    p1, p2 = values[i], values[i + 1]
    p0 = values[i - 1] if i > 0 else 2 * p1 - p2
    p3 = values[i + 2] if i + 2 < len(values) else 2 * p2 - p1
    return 0.5 * (2 * p1 + (p2 - p0) * t + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t * t
                  + (3 * p1 - p0 - 3 * p2 + p3) * t * t * t)


def step(t):
    t = max(0.0, min(1.0, t))
    return t * t * (3 - 2 * t)


def sheet_point(u, t):
    """The sheet's middle surface: u along LINE, t from -1 to 1 across."""
    z, y = smooth([p[0] for p in LINE], u), smooth([p[1] for p in LINE], u)
    e = 1e-3
    a, b = max(0, u - e), min(len(LINE) - 1, u + e)
    dz = smooth([p[0] for p in LINE], b) - smooth([p[0] for p in LINE], a)
    dy = smooth([p[1] for p in LINE], b) - smooth([p[1] for p in LINE], a)
    n = math.hypot(dz, dy)
    normal = (0.0, -dz / n, dy / n)  # up on the seat, forwards on the back
    half = smooth(HALF_WIDTH, u)
    back = step((u - 8) / 4)
    top = step((u - 14.0) / 2.5)
    dish = (0.014 + 0.022 * back) * (1 - top) * t * t  # the seat is hollow, the back embraces
    rim = 0.030 * (1 - 0.6 * top) * step((abs(t) - 0.86) / 0.14)  # turned down, or backwards
    tuck = 0.006 * step((abs(t) - 0.86) / 0.14)
    x = math.copysign(half * abs(t) - tuck, t) if t else 0.0
    return add((x, y, z), mul(normal, dish - rim))


def is_slot(i, j, across, along):
    """Whether the cell is cut out: upright slots in the back."""
    u = (j + 0.5) / along * (len(LINE) - 1)
    k = abs(i + 0.5 - across / 2)
    return 10.6 < u < 14.4 and k < 11 and int(k + 1) % 4 >= 2


def sheet(across=36, along=52):
    middle = {}
    for j in range(along + 1):
        for i in range(across + 1):
            # Lines crowd towards the rims, where the sheet turns.
            t = 2 * i / across - 1
            t = math.copysign(1 - (1 - abs(t)) ** 1.15, t)
            middle[i, j] = sheet_point(j / along * (len(LINE) - 1), t)

    def normal(i, j):
        right = sub(middle[min(i + 1, across), j], middle[max(i - 1, 0), j])
        on = sub(middle[i, min(j + 1, along)], middle[i, max(j - 1, 0)])
        return unit(cross(right, on))

    chair.use("sheet", "plastic")
    upper, lower = {}, {}
    for (i, j), p in middle.items():
        n = mul(normal(i, j), SHEET / 2)
        upper[i, j], lower[i, j] = chair.vertex(add(p, n)), chair.vertex(sub(p, n))

    solid = {(i, j) for i in range(across) for j in range(along)
             if not is_slot(i, j, across, along)}
    for i, j in sorted(solid, key=lambda c: (c[1], c[0])):
        loop = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
        chair.face([upper[c] for c in loop])
        chair.face([lower[c] for c in reversed(loop)])
        # Walls where the sheet ends.
        for k, beyond in enumerate(((i, j - 1), (i + 1, j), (i, j + 1), (i - 1, j))):
            if beyond not in solid:
                a, b = loop[k], loop[(k + 1) % 4]
                chair.face((lower[a], lower[b], upper[b], upper[a]))


def curve(points, pieces):
    top = len(points) - 1
    return [tuple(smooth([p[d] for p in points], top * i / pieces) for d in range(3))
            for i in range(pieces + 1)]


def channel(radius, spread, wall, sides):
    """An open round section of `spread` degrees, bulging to +u, with a wall: a closed profile."""
    angles = [math.radians(-spread / 2 + spread * i / sides) for i in range(sides + 1)]
    outside = [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
    inside = [((radius - wall) * math.cos(a), (radius - wall) * math.sin(a)) for a in angles]
    return outside + inside[::-1]


def leg(points, outwards, radius, foot):
    """A channel swept down `points`, its bulge turned `outwards`, tapering to `foot` of its size."""
    path = curve(points, 16)
    rings = []
    for k, p in enumerate(path):
        t = k / (len(path) - 1)
        s = 1 + (foot - 1) * t
        u = unit(outwards)
        v = cross((0, -1, 0), u)
        # The path leads down; a ring must be counter-clockwise seen from below.
        rings.append([add(p, add(mul(u, s * (a - 0.6 * radius)), mul(v, s * b)))
                      for a, b in channel(radius, 200, LEG / s, 8)])
    chair.use("legs", "plastic")
    chair.rings(rings)
    # A foot of another plastic, pressed over the end.
    end = path[-1]
    u = unit(outwards)
    centre = add(end, mul(u, -0.25 * radius * foot))
    chair.use("feet", "feet")
    chair.column((centre[0], centre[2]), [(0.0, 0.040, 0.040), (0.004, 0.046, 0.046),
                                          (0.016, 0.046, 0.046), (0.02, 0.038, 0.038)], 0.012)


def legs():
    for side in (-1, 1):
        leg([(side * 0.188, 0.436, 0.178), (side * 0.200, 0.30, 0.198), (side * 0.211, 0.15, 0.214),
             (side * 0.224, 0.008, 0.226)], (side, 0, 0.9), 0.036, 0.62)
        leg([(side * 0.182, 0.440, -0.150), (side * 0.192, 0.30, -0.188),
             (side * 0.204, 0.15, -0.226), (side * 0.219, 0.008, -0.262)], (side, 0, -0.9), 0.036,
            0.62)


def arms():
    chair.use("arms", "plastic")
    for side in (-1, 1):
        path = curve([(side * 0.200, 0.668, -0.248), (side * 0.243, 0.668, -0.200),
                      (side * 0.262, 0.664, -0.080), (side * 0.266, 0.660, 0.050),
                      (side * 0.262, 0.640, 0.135), (side * 0.250, 0.585, 0.172),
                      (side * 0.234, 0.510, 0.176), (side * 0.214, 0.425, 0.172)], 28)
        # A thin strap with rounded edges, wide where the arm lies.
        rings = []
        for k, p in enumerate(path):
            ahead = unit(sub(path[min(k + 1, len(path) - 1)], path[max(k - 1, 0)]))
            flat = unit(sub((side, 0, 0), mul(ahead, ahead[0] * side)))  # across the strap
            thick = cross(flat, ahead)
            t = k / (len(path) - 1)
            w = 0.020 + 0.008 * step(t * 4) * (1 - step((t - 0.6) * 3))
            h = 0.0045
            profile = [(w, -0.5 * h), (w, 0.5 * h), (0.8 * w, h), (0, 1.25 * h), (-0.8 * w, h),
                       (-w, 0.5 * h), (-w, -0.5 * h), (-0.8 * w, -h), (0, -0.75 * h), (0.8 * w, -h)]
            # thick is flat x ahead: counter-clockwise in (flat, thick) is clockwise from ahead.
            rings.append([add(p, add(mul(flat, a), mul(thick, -b))) for a, b in profile])
        chair.rings(rings)


if __name__ == "__main__":
    sheet()
    legs()
    arms()
    chair.write(os.path.dirname(os.path.abspath(__file__)))
