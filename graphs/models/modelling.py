"""The few modelling tools that the scripts in this folder share: extrusions, tubes, revolved and
lofted surfaces, written as one OBJ with its material library. Plain Python, no libraries, and the
same bytes every time. Metres, y up."""

import math
import os


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def mul(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return math.sqrt(dot(a, a))


def unit(a):
    n = length(a)
    return (a[0] / n, a[1] / n, a[2] / n)


def mix(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def circle(radius, sides, turn=0.0):
    """A closed profile, counter-clockwise."""
    return [(radius * math.cos(2 * math.pi * (i + turn) / sides),
             radius * math.sin(2 * math.pi * (i + turn) / sides)) for i in range(sides)]


def rectangle(width, height, bevel=0.0):
    """A closed profile, counter-clockwise, its corners cut by `bevel`."""
    w, h, b = width / 2, height / 2, bevel
    if b == 0:
        return [(w, -h), (w, h), (-w, h), (-w, -h)]
    return [(w - b, -h), (w, -h + b), (w, h - b), (w - b, h),
            (-w + b, h), (-w, h - b), (-w, -h + b), (-w + b, -h)]


def i_beam(width, height, flange, web):
    """A closed profile, counter-clockwise."""
    w, h, f, t = width / 2, height / 2, flange, web / 2
    return [(w, -h), (w, -h + f), (t, -h + f), (t, h - f), (w, h - f), (w, h),
            (-w, h), (-w, h - f), (-t, h - f), (-t, -h + f), (-w, -h + f), (-w, -h)]


class Model:
    """Vertices, and faces sorted into groups and materials as they were added."""

    def __init__(self, name, materials, decimals=4):
        self.name, self.materials, self.decimals = name, materials, decimals
        self.vertices, self.faces = [], []
        self.group, self.material = "", ""

    def use(self, group, material):
        if material not in self.materials:
            raise KeyError(material)
        self.group, self.material = group, material

    def vertex(self, p):
        self.vertices.append(p)
        return len(self.vertices)

    def face(self, corners):
        self.faces.append((self.group, self.material, tuple(corners)))

    def polygon(self, points):
        self.face([self.vertex(p) for p in points])

    def rings(self, rings, caps=True):
        """Skins closed rings of points, each counter-clockwise seen from the far end."""
        ids = [[self.vertex(p) for p in ring] for ring in rings]
        n = len(ids[0])
        for a, b in zip(ids, ids[1:]):
            for i in range(n):
                j = (i + 1) % n
                self.face((a[i], a[j], b[j], b[i]))
        if caps:
            self.face(reversed(ids[0]))
            self.face(ids[-1])

    def between(self, a, b):
        """Triangles between two closed rings of vertices that begin side by side and run the same
        way, of any number each: whichever ring is behind goes on."""
        i = j = 0
        while i < len(a) or j < len(b):
            if j == len(b) or (i < len(a) and (i + 1) * len(b) <= (j + 1) * len(a)):
                self.face((a[i], a[(i + 1) % len(a)], b[j % len(b)]))
                i += 1
            else:
                self.face((a[i % len(a)], b[(j + 1) % len(b)], b[j]))
                j += 1

    def sweep(self, profile, path, up=(0, 1, 0), caps=True, scale=None):
        """A profile (right, up) moved along a path of points."""
        rings = []
        for k, p in enumerate(path):
            ahead = unit(sub(path[min(k + 1, len(path) - 1)], path[max(k - 1, 0)]))
            side = up if abs(dot(up, ahead)) < 0.99 else (1, 0, 0)
            right = unit(cross(ahead, side))
            above = cross(right, ahead)
            s = scale[k] if scale else 1
            # (right, above, ahead) is right-handed as (x, y, z) seen from ahead: a profile that is
            # counter-clockwise there is counter-clockwise seen from the far end.
            rings.append([add(p, add(mul(right, -s * u), mul(above, s * v))) for u, v in profile])
        self.rings(rings, caps)

    def bar(self, profile, a, b, pieces=1, up=(0, 1, 0), caps=True):
        self.sweep(profile, [mix(a, b, i / pieces) for i in range(pieces + 1)], up, caps)

    def box(self, centre, size, bevel=0.0):
        self.bar(rectangle(size[0], size[1], bevel),
                 (centre[0], centre[1], centre[2] + size[2] / 2),
                 (centre[0], centre[1], centre[2] - size[2] / 2))

    def column(self, centre, sections, bevel):
        """Stacked octagons along y: (y, size along x, size along z)."""
        rings = []
        for y, sx, sz in sections:
            rings.append([(centre[0] - u, y, centre[1] + v)
                          for u, v in rectangle(sx, sz, min(bevel, sx / 3, sz / 3))])
        self.rings(rings)

    def dome(self, base, normal, radius, sides=6):
        """A rivet head: a low cone with a flat top, open below."""
        n = unit(normal)
        u = unit(cross(n, (0, 0, 1) if abs(n[2]) < 0.9 else (1, 0, 0)))
        v = cross(n, u)

        def ring(r, h):
            return [add(base, add(mul(n, h), add(mul(u, r * x), mul(v, r * y))))
                    for x, y in circle(1, sides)]
        low, high = ring(radius, 0), ring(0.6 * radius, 0.55 * radius)
        a, b = [self.vertex(p) for p in low], [self.vertex(p) for p in high]
        for i in range(sides):
            j = (i + 1) % sides
            self.face((a[i], a[j], b[j], b[i]))
        self.face(b)

    def write(self, folder):
        number = "%." + str(self.decimals) + "f"

        def text(x):
            s = (number % x).rstrip("0").rstrip(".")
            return "0" if s in ("-0", "") else s

        with open(os.path.join(folder, self.name + ".mtl"), "w", newline="\n") as out:
            out.write("# Written by make_%s.py. Colours are display values (sRGB).\n" % self.name)
            for name in self.materials:
                colour, roughness, metallic = self.materials[name]
                out.write("\nnewmtl %s\nKd %s\nPr %s\nPm %s\n" % (
                    name, " ".join(text(int(colour[i:i + 2], 16) / 255) for i in (1, 3, 5)),
                    text(roughness), text(metallic)))

        # Faces by group, then material, both in order of first use.
        order = {}
        for group, material, corners in self.faces:
            order.setdefault(group, {}).setdefault(material, []).append(corners)
        with open(os.path.join(folder, self.name + ".obj"), "w", newline="\n") as out:
            out.write("# Written by make_%s.py. Metres, y up.\nmtllib %s.mtl\n"
                      % (self.name, self.name))
            for p in self.vertices:
                out.write("v %s %s %s\n" % (text(p[0]), text(p[1]), text(p[2])))
            for group, materials in order.items():
                out.write("o %s\n" % group)
                for material, faces in materials.items():
                    out.write("usemtl %s\n" % material)
                    for corners in faces:
                        out.write("f %s\n" % " ".join(map(str, corners)))
        triangles = sum(len(c) - 2 for _, _, c in self.faces)
        print("%s: %d vertices, %d triangles" % (self.name, len(self.vertices), triangles))
