"""A bath duck as a hand scanner sees it from around and above: duck_scan.ply.

Rays from seven places meet the duck, whose shape is a blend of ellipsoids given by its signed
distance. What a scan lacks is lacking: the underside, what hides behind the wings and the bill, most
of the dark eyes, what is met at a grazing angle, and a patch that the hand forgot. What a scan adds
is there: noise along the ray, and strays beside the edges, where half of the beam went past. Plain
Python, no libraries, and the same bytes every time; it takes minutes. Coordinates are 16-bit
integers, a twentieth of a millimetre, y up."""

import math
import os
import random
import struct

UNIT = 5e-5  # m
NOISE = 0.00035  # m, standard deviation along the ray
RAYS = 72000  # of each place, of which some miss

YELLOW, ORANGE, BLACK, WHITE = (244, 190, 38), (232, 96, 22), (22, 20, 24), (240, 238, 230)


def ellipsoid(centre, axes, tilt=0.0):
    """Tilted about z by so many degrees; the distance is a good estimate near the surface."""
    c, s = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
    cx, cy, cz = centre
    ax, ay, az = axes

    def distance(x, y, z):
        x, y, z = x - cx, y - cy, z - cz
        x, y = c * x + s * y, c * y - s * x
        k0 = math.sqrt((x / ax) ** 2 + (y / ay) ** 2 + (z / az) ** 2)
        k1 = math.sqrt((x / ax ** 2) ** 2 + (y / ay ** 2) ** 2 + (z / az ** 2) ** 2)
        return k0 * (k0 - 1) / k1 if k1 > 1e-9 else -min(axes)
    return distance


def blend(a, b, radius):
    """A smooth union: Quilez's polynomial."""
    h = max(radius - abs(a - b), 0) / radius
    return min(a, b) - h * h * radius / 4


BODY = ellipsoid((0, 0.062, 0), (0.112, 0.066, 0.080))
CHEST = ellipsoid((0.045, 0.075, 0), (0.064, 0.062, 0.066))
TAIL = ellipsoid((-0.105, 0.108, 0), (0.042, 0.016, 0.030), -42)
HEAD = ellipsoid((0.066, 0.172, 0), (0.056, 0.054, 0.054))
TUFT = ellipsoid((0.050, 0.228, 0), (0.022, 0.009, 0.010), -35)
WINGS = [ellipsoid((-0.012, 0.078, side * 0.072), (0.060, 0.034, 0.018), -14) for side in (-1, 1)]
BILL = [ellipsoid((0.121, 0.170, 0), (0.036, 0.010, 0.029), 9),
        ellipsoid((0.114, 0.156, 0), (0.029, 0.009, 0.023), -6)]
EYES = [(0.104, 0.190, side * 0.030) for side in (-1, 1)]


def duck(x, y, z):
    d = blend(BODY(x, y, z), CHEST(x, y, z), 0.05)
    d = blend(d, TAIL(x, y, z), 0.04)
    d = blend(d, HEAD(x, y, z), 0.024)
    d = blend(d, TUFT(x, y, z), 0.012)
    d = blend(d, WINGS[0 if z < 0 else 1](x, y, z), 0.008)
    d = blend(d, min(BILL[0](x, y, z), BILL[1](x, y, z)), 0.006)
    return max(d, 0.004 - y)  # it stands on a flat foot


def colour(p):
    for eye in EYES:
        r = math.dist(p, eye)
        if r < 0.0095 and math.dist(p, (eye[0] + 0.004, eye[1] + 0.004, eye[2])) < 0.0045:
            return WHITE
        if r < 0.0125:
            return BLACK
    return ORANGE if min(b(*p) for b in BILL) < 0.0012 else YELLOW


def normal(p, e=2e-4):
    g = [duck(*[p[j] + (e if j == k else 0) for j in range(3)]) -
         duck(*[p[j] - (e if j == k else 0) for j in range(3)]) for k in range(3)]
    n = math.sqrt(sum(x * x for x in g)) or 1
    return [x / n for x in g]


def meet(eye, ray):
    """How far along the ray the duck is, None where it passes; how near it came, and where."""
    t, nearest, there = 0.0, 1.0, 0.0
    for _ in range(60):
        p = [eye[k] + t * ray[k] for k in range(3)]
        d = duck(*p)
        if d < nearest:
            nearest, there = d, t
        if d < 1e-4:
            return t, nearest, there
        t += 0.9 * d
        if t > 1.2 or p[1] < 0:
            break
    return None, nearest, there


def scan(eye, seed):
    chance = random.Random(seed)
    to = (0, 0.1, 0)
    ahead = [to[k] - eye[k] for k in range(3)]
    far = math.sqrt(sum(x * x for x in ahead))
    ahead = [x / far for x in ahead]
    right = [-ahead[2], 0, ahead[0]]
    n = math.hypot(right[0], right[2])
    right = [x / n for x in right]
    up = [right[1] * ahead[2] - right[2] * ahead[1], right[2] * ahead[0] - right[0] * ahead[2],
          right[0] * ahead[1] - right[1] * ahead[0]]
    points = []
    for _ in range(RAYS):
        u, v = 0.15 * chance.uniform(-1, 1) / far, 0.15 * chance.uniform(-1, 1) / far
        ray = [ahead[k] + u * right[k] + v * up[k] for k in range(3)]
        n = math.sqrt(sum(x * x for x in ray))
        ray = [x / n for x in ray]
        t, nearest, there = meet(eye, ray)
        if t is None:
            if nearest < 0.0012 and chance.random() < 0.3:  # half of the beam met the edge
                t = there + chance.gauss(0, 0.004)
                points.append(([eye[k] + t * ray[k] for k in range(3)], YELLOW))
            continue
        p = [eye[k] + t * ray[k] for k in range(3)]
        facing = -sum(a * b for a, b in zip(normal(p), ray))
        tint = colour(p)
        if facing < chance.uniform(0.10, 0.30) or (tint == BLACK and chance.random() < 0.7):
            continue
        if math.dist(p, (-0.052, 0.118, 0.034)) < 0.013 + 0.004 * math.sin(9 * p[0] * 50):
            continue  # the patch
        t += chance.gauss(0, NOISE / max(facing, 0.4))
        light = 0.82 + 0.18 * facing + chance.gauss(0, 0.02)
        points.append(([eye[k] + t * ray[k] for k in range(3)],
                       tuple(min(255, max(0, round(c * light))) for c in tint)))
    return points


def main():
    points = []
    for i in range(7):
        turn, lift = 2 * math.pi * i / 6 + 0.4, math.radians(8 if i % 2 == 0 else 42)
        if i == 6:
            turn, lift = 1.0, math.radians(80)
        eye = [0.6 * math.cos(lift) * math.cos(turn), 0.1 + 0.6 * math.sin(lift),
               0.6 * math.cos(lift) * math.sin(turn)]
        points += scan(eye, i)
    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, "duck_scan.ply"), "wb") as out:
        out.write((f"ply\nformat binary_little_endian 1.0\ncomment unit {UNIT} m\n"
                   f"element vertex {len(points)}\nproperty short x\nproperty short y\n"
                   "property short z\nproperty uchar red\nproperty uchar green\n"
                   "property uchar blue\nend_header\n").encode())
        for p, tint in points:
            out.write(struct.pack("<hhhBBB", *[round(x / UNIT) for x in p], *tint))


if __name__ == "__main__":
    main()
