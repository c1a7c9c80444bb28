#!/usr/bin/env python3
"""Frequencies and sags of beams and sheets that lie in the grid at any tilt, by cubes of several sizes.

    bench/tilted.py [--program build/release/aspic]

Free bodies, 16 thicknesses long: a beam of square section and a sheet half as wide as long. Of each
tilt and size of cubes it prints, with stiffness filled and calibrated:

  the first four frequencies over those of a straight body in cubes of a sixth of its thickness;
  the sag under its own weight, pulled across and along its thin side, with one end held by points of the
  material inside a ball, over that of the straight body.

1 is right.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

root = pathlib.Path(__file__).resolve().parent.parent
THICK, LONG = 0.03, 0.48
BODIES = {"beam": (LONG, THICK, THICK), "sheet": (LONG, LONG / 2, THICK)}
TILTS = {"0": (0, 0, 0), "10": (0, 0, 10), "20": (0, 0, 20), "30": (0, 0, 30), "45": (0, 0, 45),
         "sheet 10": (10, 0, 0), "sheet 20": (20, 0, 0), "sheet 45": (45, 0, 0),
         "10/10/10": (10, 10, 10), "20/20/20": (20, 20, 20), "30/45/10": (30, 45, 10)}
MATTER = {"young": 1e7, "density": 1000, "poisson": 0.3}


def cook(program, folder, nodes, targets):
    file = folder / "case.json"
    file.write_text(json.dumps({"aspic": 1, "frames": {"first": 1, "last": 1, "fps": 24}, "nodes": nodes}))
    words = [program, "cook", file, "--no-disk-cache", "--out", folder]
    for target in targets:
        words += ["--node", target]
    said = subprocess.run(words, text=True, capture_output=True, timeout=580)
    if said.returncode:
        raise RuntimeError(said.stderr)
    return said.stdout


def body(size, turn, cube, stiffness):
    return {
        "straight": {"type": "Primitive@1", "params": {
            "shape": "box", "box": {"size": list(size), "divisions_x": 32,
                                    "divisions_y": 8 if size[1] > THICK else 2}}},
        "mesh": {"type": "Transform@1", "inputs": {"mesh": "straight.mesh"},
                 "params": {"rotate_degrees": list(turn)}},
        "cubes": {"type": "Voxelize@1", "inputs": {"mesh": "mesh.mesh"}, "params": {
            "method": "solid", "size": cube, "stiffness": stiffness, "matter": MATTER}}}


def frequencies(program, folder, *case):
    """Hz, of the first four modes that are not rigid."""
    nodes = body(*case)
    nodes["modes"] = {"type": "Modes@1", "inputs": {"cubes": "cubes.cubes", "mesh": "mesh.mesh"},
                      "params": {"count": 4}}
    nodes["write"] = {"type": "WriteModes@1", "inputs": {"model": "modes.model"},
                      "params": {"path": "modes.txt"}}
    cook(program, folder, nodes, ["write"])
    found = []
    for line in (folder / "modes.txt").read_text().splitlines():
        if line.startswith("mode "):
            found.append(float(line.split()[1]))
    return found[:4]


def turned(turn, v):
    """v rotated about x, then y, then z."""
    for axis in range(3):
        c, s = math.cos(math.radians(turn[axis])), math.sin(math.radians(turn[axis]))
        a, b = (axis + 1) % 3, (axis + 2) % 3
        v = list(v)
        v[a], v[b] = c * v[a] - s * v[b], s * v[a] + c * v[b]
    return v


def sags(program, folder, size, turn, cube, stiffness):
    """m, of the free end: pulled across its thin side, and sideways in its plane."""
    out = []
    for way in ((0, 0, 1), (0, 1, 0)):
        nodes = body(size, turn, cube, stiffness)
        end = turned(turn, (-LONG / 2, 0, 0))
        nodes["hold"] = {"type": "Pin@1", "inputs": {"cubes": "cubes.cubes", "mesh": "mesh.mesh"}, "params": {
            "hold": "points", "where": "sphere",
            "sphere": {"centre": end, "radius": 0.6 * size[1] if size[1] > THICK else 2 * THICK}}}
        nodes["sim"] = {"type": "Simulate@2", "inputs": {"cubes": "cubes.cubes", "pins": ["hold.pins"]},
                        "params": {"initial_shape": "equilibrium",
                                   "gravity": [0.02 * x for x in turned(turn, way)]}}
        nodes["shape"] = {"type": "Embed@3", "inputs": {
            "mesh": "mesh.mesh", "cubes": "cubes.cubes", "state": "sim.state"}}
        nodes["sag"] = {"type": "Measure@1", "inputs": {"mesh": "shape.mesh", "rest": "mesh.mesh"},
                        "params": {"what": "displacement_max"}}
        text = cook(program, folder, nodes, ["sag"])
        out.append(next(float(line.split()[-1]) for line in text.splitlines() if line.startswith("sag.value")))
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=root / "build/release/aspic", type=pathlib.Path)
    parser.add_argument("--sizes", default="0.25,0.5,1,2", help="cubes in thicknesses")
    parser.add_argument("--tilts", default=",".join(TILTS), help="which")
    parser.add_argument("--bodies", default=",".join(BODIES), help="which")
    arguments = parser.parse_args()
    program = arguments.program.resolve()
    print("body, tilt (degrees), cube / thickness, stiffness: frequencies; sags across, sideways")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for kind in arguments.bodies.split(","):
            size = BODIES[kind]
            straight = (size, (0, 0, 0), THICK / 6, "filled")
            true, fine = frequencies(program, folder, *straight), sags(program, folder, *straight)
            for tilt in arguments.tilts.split(","):
                turn = TILTS[tilt]
                for cubes in map(float, arguments.sizes.split(",")):
                    for stiffness in ("filled", "calibrated"):
                        case = (size, turn, cubes * THICK, stiffness)
                        try:
                            f = frequencies(program, folder, *case)
                            s = sags(program, folder, *case)
                        except RuntimeError as error:
                            print(f"{kind}, {tilt}, {cubes:g}, {stiffness}: {error}", flush=True)
                            continue
                        ratios = " ".join(f"{a / b:.3f}" for a, b in zip(f, true))
                        print(f"{kind}, {tilt}, {cubes:g}, {stiffness}: {ratios}; " +
                              " ".join(f"{a / b:.3f}" for a, b in zip(s, fine)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
