"""A printed cushion, its seam a closed loop of shared vertices, with a picture for its cloth:
cushion.obj, cushion.mtl, cushion.png. Plain Python, no libraries, and the same bytes every time."""

import math
import os
import struct
import zlib

SIDE, THICK, PIECES = 0.48, 0.17, 24  # m; squares along each side of each face
PIXELS = 256


def plump(u, v):
    """The point of the upper face at u, v in -1..1: pinched between its corners, full in the middle."""
    pinch = lambda t: 1 - 0.10 * (1 - t * t)
    height = ((1 - u * u) * (1 - v * v)) ** 0.42
    return SIDE / 2 * u * pinch(v), THICK / 2 * height, SIDE / 2 * v * pinch(u)


def ink(x, y):
    """An index into the palette: rings and rays in a frame, by the distance from the middle."""
    u, v = (x + 0.5) / PIXELS * 2 - 1, (y + 0.5) / PIXELS * 2 - 1
    edge, r, a = max(abs(u), abs(v)), math.hypot(u, v), math.atan2(v, u)
    if edge > 0.93:
        return 1
    if edge > 0.86:
        return 2 if int((u + v + 4) * 12) % 2 else 0
    petal = 0.36 + 0.22 * abs(math.cos(4 * a))
    if r < 0.12:
        return 3
    if r < 0.20:
        return 1
    if r < petal:
        return 2 if r < petal - 0.06 else 1
    if r < 0.70 and r > 0.64:
        return 3
    dots = math.hypot((u * 8) % 1 - 0.5, (v * 8) % 1 - 0.5)
    return 3 if r > 0.78 and dots < 0.24 else 0


def picture(path):
    colours = [(236, 226, 204), (28, 62, 88), (200, 84, 52), (222, 168, 62)]
    rows = b"".join(b"\0" + bytes(ink(x, y) for x in range(PIXELS)) for y in range(PIXELS))

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", PIXELS, PIXELS, 8, 3, 0, 0, 0)) +
                  chunk(b"PLTE", b"".join(bytes(c) for c in colours)) +
                  chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def model(path):
    n = PIECES
    vertices, number = [], {}

    def vertex(i, j, side):
        rim = i in (0, n) or j in (0, n)
        key = (i, j, 0 if rim else side)
        if key not in number:
            # Closer together at the rim, where the cloth turns.
            x, y, z = plump(*(math.sin(math.pi / 2 * (2 * k / n - 1)) for k in (i, j)))
            vertices.append((x, 0 if rim else side * y, z))
            number[key] = len(vertices)
        return number[key]

    faces = []
    for side in (1, -1):
        for j in range(n):
            for i in range(n):
                corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)]
                if side < 0:
                    corners.reverse()
                faces.append(" ".join("%d/%d" % (vertex(a, b, side), b * (n + 1) + a + 1)
                                      for a, b in corners))
    with open(path, "w", newline="\n") as out:
        out.write("# Written by make_cushion.py. Metres, y up.\nmtllib cushion.mtl\n")
        for p in vertices:
            out.write("v %s\n" % " ".join("%.5g" % (c + 0.0) for c in p))
        for j in range(n + 1):
            for i in range(n + 1):
                u, v = (0.5 + 0.5 * math.sin(math.pi / 2 * (2 * k / n - 1)) for k in (i, j))
                out.write("vt %.5g %.5g\n" % (u, 1 - v))
        out.write("o cushion\nusemtl cloth\n")
        for f in faces:
            out.write("f %s\n" % f)
    print("cushion: %d vertices, %d triangles" % (len(vertices), 2 * len(faces)))


if __name__ == "__main__":
    folder = os.path.dirname(os.path.abspath(__file__))
    model(os.path.join(folder, "cushion.obj"))
    picture(os.path.join(folder, "cushion.png"))
    with open(os.path.join(folder, "cushion.mtl"), "w", newline="\n") as out:
        out.write("# Written by make_cushion.py. Colours are display values (sRGB).\n\n"
                  "newmtl cloth\nKd 1 1 1\nmap_Kd cushion.png\nPr 0.85\nPm 0\n")
