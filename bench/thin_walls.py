#!/usr/bin/env python3
"""Compares how far Voxelize says that a thin wall is too stiff with how far it is.

    bench/thin_walls.py [--program build/release/aspic] [--furniture FOLDER]

Free strips and bars, long against their thickness, lie in the grid in many ways. Each is a document:
Primitive, Transform, Voxelize, Modes. The truth is the square of the lowest frequency over that of a
free beam (Euler, Bernoulli): f = 4.730041^2 / (2 pi L^2) sqrt(E t^2 / (12 rho)). The prediction is the
number in Voxelize's warning; no warning counts as 1. Exit code 1 where one differs by more than a
factor of 1.5, or where there is a warning although the error is below 3 %.

--furniture takes the OBJ files below a folder instead (unpacked *.sh3f of the Debian package
sweethome3d-furniture) and of each model, spread evenly over all, its two largest closed pieces of
at least 8 cubes along their longest side (smaller ones hardly bend). Cubes are 1/32 of the model's
longest side; the truth is the square of the piece's lowest frequency over that with cubes of a third of
its thinnest wall, and pieces that take more than 60,000 of these are left out.
"""
import argparse
import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

root = pathlib.Path(__file__).resolve().parent.parent
YOUNG, DENSITY = 1e9, 1000
# Length, width, thickness (m); rotation about x, y, z (degrees); cubes in thicknesses.
STRIP, WIDE, BAR, THIN = (1.2, 0.15, 0.03), (1.5, 0.3, 0.025), (1.2, 0.03, 0.03), (0.8, 0.05, 0.01)
CASES = [
    (STRIP, (0, 0, 0), 0.5), (STRIP, (0, 0, 0), 1), (STRIP, (0, 0, 0), 1.25), (STRIP, (0, 0, 35), 2.5),
    (STRIP, (10, 30, 0), 1), (STRIP, (10, 30, 0), 2), (STRIP, (35, 15, 5), 1.25), (STRIP, (35, 15, 5), 3),
    (STRIP, (0, 8, 0), 1.5), (STRIP, (0, 12, 70), 2), (WIDE, (60, 10, 20), 1), (WIDE, (60, 10, 20), 1.75),
    (WIDE, (25, 0, 40), 1.5), (WIDE, (25, 0, 40), 2.5), (WIDE, (3, 3, 3), 1.2), (BAR, (25, 35, 15), 1),
    (BAR, (25, 35, 15), 2), (BAR, (15, 10, 50), 1.5), (BAR, (15, 10, 50), 3), (THIN, (40, 25, 60), 1),
    (THIN, (40, 25, 60), 3), (THIN, (0, 0, 0), 1.6), (THIN, (5, 30, 10), 2.2), (THIN, (0, 22, 0), 4),
]


def document(size, turn, cube):
    return {"aspic": 1, "frames": {"first": 1, "last": 1, "fps": 24}, "nodes": {
        "box": {"type": "Primitive@1", "params": {
            "shape": "box", "box": {"size": list(size), "divisions_x": 40}}},
        "turned": {"type": "Transform@1", "inputs": {"mesh": "box.mesh"},
                   "params": {"rotate_degrees": list(turn)}},
        "cubes": {"type": "Voxelize@1", "inputs": {"mesh": "turned.mesh"}, "params": {
            "method": "solid", "size": cube,
            "matter": {"young": YOUNG, "density": DENSITY, "poisson": 0.3}}},
        "modes": {"type": "Modes@1", "inputs": {"cubes": "cubes.cubes", "mesh": "turned.mesh"},
                  "params": {"count": 1}}}}


def of_piece(path, cube):
    return {"aspic": 1, "frames": {"first": 1, "last": 1, "fps": 24}, "nodes": {
        "piece": {"type": "ReadMesh@1", "params": {"path": str(path), "unit": "m", "up": "y"}},
        "cubes": {"type": "Voxelize@1", "inputs": {"mesh": "piece.mesh"}, "params": {
            "method": "solid", "size": cube,
            "matter": {"young": YOUNG, "density": DENSITY, "poisson": 0.3}}},
        "modes": {"type": "Modes@1", "inputs": {"cubes": "cubes.cubes", "mesh": "piece.mesh"},
                  "params": {"count": 1}}}}


def told(program, file, folder):
    """The factor in Voxelize's warning, 1 where there is none, and how thick the wall is (m)."""
    said = subprocess.run([program, "cook", file, "--node", "cubes", "--no-disk-cache", "--out", folder,
                           "--allow-outside"], text=True, capture_output=True, check=True)
    text = said.stdout + said.stderr
    number = re.search(r"about ([\d.e+]+) times too stiff", text)
    thick = re.search(r"cubes thick \(([\d.e+-]+) m", text)
    return float(number[1]) if number else 1.0, float(thick[1]) if thick else None


def lowest_frequency(program, file, cube, folder):
    subprocess.run([program, "sweep", file, "--vary", f"cubes.size={cube!r}", "--no-disk-cache", "--quiet",
                    "--out", folder, "--allow-outside"], text=True, capture_output=True, check=True,
                   timeout=300)
    with open(folder / "sweep.csv") as table:
        return float(list(csv.DictReader(table))[0]["modes.lowest_frequency"])


def measure(program, folder, size, turn, cubes):
    """Predicted and true factor of one case."""
    length, _, thick = size
    cube = cubes * thick
    file = folder / "case.json"
    file.write_text(json.dumps(document(size, turn, cube)))
    factor, _ = told(program, file, folder)
    beam = 4.730041**2 / (2 * math.pi * length**2) * math.sqrt(YOUNG * thick**2 / (12 * DENSITY))
    return factor, (lowest_frequency(program, file, cube, folder) / beam)**2


def closed_pieces(path):
    """Vertices (m, of a model in cm), the triangles of its closed connected pieces, and its longest side."""
    places, index, number, faces = [], [], {}, []
    for line in path.read_text(errors="replace").splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            p = tuple(float(x) / 100 for x in words[1:4])
            index.append(number.setdefault(p, len(number)))
            if len(number) > len(places):
                places.append(p)
        elif words[0] == "f":
            at = [int(w.split("/")[0]) for w in words[1:]]
            at = [index[i - 1 if i > 0 else i] for i in at]
            faces += [(at[0], at[k], at[k + 1]) for k in range(1, len(at) - 1)]
    faces = [f for f in faces if len(set(f)) == 3]
    parent = list(range(len(places)))

    def root(k):
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for a, b, c in faces:
        parent[root(a)] = parent[root(b)] = root(c)
    pieces = {}
    for f in faces:
        pieces.setdefault(root(f[0]), []).append(f)
    longest = max((max(p[k] for p in places) - min(p[k] for p in places) for k in range(3)), default=0)
    closed = []
    for piece in pieces.values():
        sides = set()
        for f in piece:
            sides.update((f[k], f[(k + 1) % 3]) for k in range(3))
        if len(sides) == 3 * len(piece) and all((b, a) in sides for a, b in sides):
            closed.append(piece)
    return places, closed, longest


def furniture(program, folder, library, most):
    """Predicted and true factors of pieces of models, one after the other."""
    models = sorted(library.rglob("*.obj"))
    for path in models[::max(1, len(models) // most)]:
        places, closed, longest = closed_pieces(path)
        extent = {}
        for n, piece in enumerate(closed):
            used = [places[k] for f in piece for k in f]
            sides = [max(p[k] for p in used) - min(p[k] for p in used) for k in range(3)]
            extent[n] = sides
        cube = longest / 32
        large = [n for n in extent if max(extent[n]) >= 8 * cube]
        for n in sorted(large, key=lambda k: -max(extent[k]))[:2]:
            lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in places]
            lines += ["f " + " ".join(str(k + 1) for k in f) for f in closed[n]]
            (folder / "piece.obj").write_text("\n".join(lines) + "\n")
            file = folder / "piece.json"
            file.write_text(json.dumps(of_piece(folder / "piece.obj", cube)))
            factor, thick = told(program, file, folder)
            fine = (thick or cube) / 3
            count = math.prod(side / fine + 1 for side in extent[n])
            name = f"{path.stem}, piece {n + 1} of {len(closed)}"
            if count > 60_000:
                print(f"{name}: {count:.2g} fine cubes, left out")
                continue
            try:
                coarse = lowest_frequency(program, file, cube, folder)
                true = (coarse / lowest_frequency(program, file, fine, folder))**2
            except (subprocess.SubprocessError, KeyError, ValueError) as error:
                print(f"{name}: {error}")
                continue
            yield name, factor, true


def report(cases):
    """Prints predicted and true factors as they come; how many are wrong."""
    wrong = total = 0
    for name, told_factor, true in cases:
        ratio = told_factor / true
        bad = not 1 / 1.5 <= ratio <= 1.5 or (told_factor > 1 and true < 1.03)
        wrong += bad
        total += 1
        print(f"{name}: {told_factor:.2f}, {true:.2f}, {ratio:.2f}{' WRONG' if bad else ''}", flush=True)
    print(f"{total - wrong} of {total} within a factor of 1.5")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=root / "build/release/aspic", type=pathlib.Path)
    parser.add_argument("--furniture", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--models", default=20, type=int, help="of the furniture, how many (default: 20)")
    arguments = parser.parse_args()
    program = arguments.program.resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if arguments.furniture:
            print("model, piece: predicted, true, ratio")
            return 1 if report(furniture(program, folder, arguments.furniture, arguments.models)) else 0
        print("length width thickness, turned, cube / thickness: predicted, true, ratio")
        cases = ((f"{size}, {turn}, {cubes}", *measure(program, folder, size, turn, cubes))
                 for size, turn, cubes in CASES)
        return 1 if report(cases) else 0


if __name__ == "__main__":
    sys.exit(main())
