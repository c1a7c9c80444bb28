#!/usr/bin/env python3
"""Compares how far Voxelize says that a thin wall is too stiff with how far it is.

    bench/thin_walls.py [--program build/release/aspic]

Free strips and bars, long against their thickness, lie in the grid in many ways. Each is a document:
Primitive, Transform, Voxelize, Modes. The truth is the square of the lowest frequency over that of a
free beam (Euler, Bernoulli): f = 4.730041^2 / (2 pi L^2) sqrt(E t^2 / (12 rho)). The prediction is the
number in Voxelize's warning; no warning counts as 1. Exit code 1 where one differs by more than a
factor of 1.5, or where there is a warning although the error is below 3 %.
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


def measure(program, folder, size, turn, cubes):
    """Predicted and true factor of one case."""
    length, _, thick = size
    cube = cubes * thick
    file = folder / "case.json"
    file.write_text(json.dumps(document(size, turn, cube)))
    told = subprocess.run([program, "cook", file, "--node", "cubes", "--no-disk-cache", "--out", folder],
                          text=True, capture_output=True, check=True)
    number = re.search(r"about ([\d.e+]+) times too stiff", told.stdout + told.stderr)
    subprocess.run([program, "sweep", file, "--vary", f"cubes.size={cube!r}", "--no-disk-cache", "--quiet",
                    "--out", folder], text=True, capture_output=True, check=True)
    with open(folder / "sweep.csv") as table:
        frequency = float(list(csv.DictReader(table))[0]["modes.lowest_frequency"])
    beam = 4.730041**2 / (2 * math.pi * length**2) * math.sqrt(YOUNG * thick**2 / (12 * DENSITY))
    return float(number[1]) if number else 1.0, (frequency / beam)**2


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=root / "build/release/aspic", type=pathlib.Path)
    program = parser.parse_args().program.resolve()
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        print("length width thickness, turned, cube / thickness: predicted, true, ratio")
        for size, turn, cubes in CASES:
            told, true = measure(program, pathlib.Path(folder), size, turn, cubes)
            ratio = told / true
            bad = not 1 / 1.5 <= ratio <= 1.5 or (told > 1 and true < 1.03)
            wrong += bad
            print(f"{size}, {turn}, {cubes}: {told:.2f}, {true:.2f}, {ratio:.2f}{' WRONG' if bad else ''}")
    print(f"{len(CASES) - wrong} of {len(CASES)} within a factor of 1.5")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
