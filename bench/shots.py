#!/usr/bin/env python3
"""Shoots small things at thin things, one step a frame, and counts what gets through.

    bench/shots.py [--program build/release/aspic] [--count 200] [--first 0] [--steps 1] [--limit 60]

Each shot is a document of 8 frames at 24 frames per second, without gravity: a ball, a box, a rod or
a coin, elastic (1 MPa to 1 GPa) or rigid, of 1 to 10 cm, at 1 to 500 m/s (even in the logarithm), up to 50
degrees off the normal, turning at up to 2 turns a second; at a wall of 2 mm, a sheet without thickness (both
Colliders), a plate one cube thick, a rigid plate, a cloth or a net of wide cells, whose rims are held. A
shot went through if its centre is 1 cm or more beyond the lowest point of the target at any frame.
What takes more than --limit seconds is left out and counted. Prints a table by target, and each shot that
went through; exit code 1 if one did.
"""
import argparse
import csv
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

root = pathlib.Path(__file__).resolve().parent.parent
TARGETS = ["wall", "sheet", "plate", "rigid plate", "cloth", "net"]
FRAMES = 8


def missile(draw):
    """Nodes of what is shot, and how far it reaches from its centre (m)."""
    size = draw.uniform(0.01, 0.1)
    kind = draw.choice(["sphere", "box", "rod", "coin"])
    if kind == "sphere":
        shape = {"shape": "sphere", "sphere": {"radius": size / 2, "subdivisions": 3}}
        reach, cube = size / 2, size / 3
    else:
        sides = {"box": [size, 0.7 * size, 0.8 * size], "rod": [size, size / 6, size / 6],
                 "coin": [size, size / 8, size]}[kind]
        shape = {"shape": "box", "box": {"size": sides}}
        reach, cube = math.dist(sides, (0, 0, 0)) / 2, min(sides) if kind != "box" else size / 3
    return kind, shape, reach, cube, size


def shot(seed):
    """A document, and the shot in words."""
    draw = random.Random(seed)
    target = TARGETS[seed % len(TARGETS)]
    kind, shape, reach, cube, size = missile(draw)
    rigid = draw.random() < 0.4
    speed = 10 ** draw.uniform(0, math.log10(500))
    tilt, round_ = math.radians(draw.uniform(0, 50)), draw.uniform(0, 2 * math.pi)
    way = [math.sin(tilt) * math.cos(round_), -math.cos(tilt), math.sin(tilt) * math.sin(round_)]
    at = [draw.uniform(-0.2, 0.2), 0, draw.uniform(-0.2, 0.2)]
    # From 5 cm to two frames' ways above, so that hits fall anywhere within a frame.
    height = reach + 0.05 + min(1.5, draw.uniform(0, 2) * speed / 24)
    start = [at[k] - height * way[k] / -way[1] for k in range(3)]
    young = 10 ** draw.uniform(6, 9)
    nodes = {
        "raw": {"type": "Primitive@1", "params": shape},
        "thing": {"type": "Transform@1", "inputs": {"mesh": "raw.mesh"}, "params": {
            "rotate_degrees": [draw.uniform(-180, 180) for _ in range(3)], "translate": start}},
        "cubes": {"type": "Voxelize@1", "inputs": {"mesh": "thing.mesh"}, "params": {
            "method": "solid", "size": cube,
            "matter": {"density": draw.choice([300, 1000, 7800]), "young": young, "poisson": 0.3}}},
    }
    body = {"velocity": [speed * w for w in way],
            "spin_degrees": [draw.uniform(-720, 720) for _ in range(3)]}
    if rigid:
        body["rigid"] = True
    sim = {"inputs": {"cubes": ["cubes.cubes"], "surface": ["thing.mesh"]},
           "params": {"gravity": [0, 0, 0], "bodies": [body], "step": {"substeps": 1}}}
    matter = {"density": 700, "young": 1e9, "poisson": 0.3, "stiffness_damping": 0.001}
    if target in ("wall", "sheet"):
        if target == "wall":
            nodes["made"] = {"type": "Primitive@1", "params": {
                "shape": "box", "box": {"size": [4, 0.002, 4]}}}
        else:
            nodes["made"] = {"type": "Primitive@1", "params": {
                "shape": "grid", "grid": {"size_x": 4, "size_z": 4}}}
        nodes["obstacle"] = {"type": "Collider@1", "inputs": {"mesh": "made.mesh"}}
        sim["inputs"]["colliders"] = ["obstacle.collider"]
    elif target in ("plate", "rigid plate"):
        nodes["made"] = {"type": "Primitive@1", "params": {
            "shape": "box", "box": {"size": [1.2, 0.03, 1.2]}}}
        nodes["plate"] = {"type": "Voxelize@1", "inputs": {"mesh": "made.mesh"}, "params": {
            "method": "solid", "size": 0.03, "matter": matter}}
        nodes["rim"] = {"type": "Pin@1", "inputs": {"cubes": "plate.cubes"}, "params": {
            "where": "ends", "ends": {"axis": "x", "end": "both", "layers": 1}}}
        sim["inputs"]["pins"] = ["rim.pins"]
        sim["inputs"]["cubes"].append("plate.cubes")
        sim["inputs"]["surface"].append("made.mesh")
        sim["params"]["bodies"].append({"rigid": True} if target == "rigid plate" else {})
    else:
        cell = 0.03 if target == "cloth" else 0.08
        nodes["made"] = {"type": "Plane@1", "params": {
            "sides": {"u": 1.2, "v": 1.2}, "size": cell, "thickness": 0.002, "across": "y",
            "matter": {"density": 500, "young": 5e7, "poisson": 0.2, "stiffness_damping": 0.002}}}
        nodes["rim"] = {"type": "Pin@1", "inputs": {"cubes": "made.cubes"}, "params": {"where": "rim"}}
        sim["inputs"]["pins"] = ["rim.pins"]
        sim["inputs"]["cubes"].append("made.cubes")
        sim["inputs"]["surface"].append("made.mesh")
        sim["params"]["bodies"].append({})
    nodes["sim"] = {"type": "Simulate@2", **sim}
    nodes["centre"] = {"type": "Measure@1", "inputs": {"cubes": "cubes.cubes", "state": "sim.state"},
                       "params": {"what": "centre_of_mass", "direction": [0, 1, 0]}}
    if target not in ("wall", "sheet"):
        cubes = "plate.cubes" if "plate" in nodes else "made.cubes"
        nodes["after"] = {"type": "Embed@3", "inputs": {
            "mesh": "made.mesh", "cubes": cubes, "state": "sim.state"}}
        nodes["lowest"] = {"type": "Measure@1", "inputs": {"mesh": "after.mesh"},
                           "params": {"what": "lowest"}}
    text = (f"{kind} of {100 * size:.1f} cm, {'rigid' if rigid else f'{young:.2g} Pa'}, at {speed:.3g} m/s, "
            f"{math.degrees(tilt):.0f} degrees")
    return target, text, speed, {"aspic": 1, "frames": {"first": 1, "last": FRAMES, "fps": 24}, "nodes": nodes}


def passes(program, document, steps, limit):
    """How far beyond the target the centre gets, m; None: it took too long."""
    document["nodes"]["sim"]["params"]["step"]["substeps"] = steps
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "shot.json")
        path.write_text(json.dumps(document))
        command = [program, "cook", path, "--values", "--no-disk-cache", "--out", folder, "--quiet"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=limit)
        except subprocess.TimeoutExpired:
            return None
        if done.returncode != 0:
            sys.exit(f"{done.stderr}{done.stdout}\n{json.dumps(document)}")
        with open(pathlib.Path(folder, "values.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
    names = {key.split(" ")[0]: key for key in rows[0]}
    worst = -math.inf
    for row in rows:
        lowest = float(row[names["lowest"]]) if "lowest" in names else 0.0
        worst = max(worst, lowest - float(row[names["centre"]]))
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=root / "build/release/aspic")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--steps", type=int, default=1)
    parser.add_argument("--limit", type=float, default=60)
    given = parser.parse_args()
    through = {target: [] for target in TARGETS}
    counts, fastest = dict.fromkeys(TARGETS, 0), dict.fromkeys(TARGETS, 0.0)
    slow = dict.fromkeys(TARGETS, 0)
    for seed in range(given.first, given.first + given.count):
        target, text, speed, document = shot(seed)
        beyond = passes(given.program, document, given.steps, given.limit)
        if beyond is None:
            slow[target] += 1
            print(f"shot {seed}: {target}, {text}: took more than {given.limit:g} s", flush=True)
            continue
        counts[target] += 1
        fastest[target] = max(fastest[target], speed)
        if beyond > 0.01:
            through[target].append(speed)
            print(f"shot {seed}: {target}, {text}: {beyond:.3g} m beyond", flush=True)
    print("| target | shots | fastest, m/s | through | slowest of these, m/s | took too long |\n"
          "|---|---|---|---|---|---|")
    for target in TARGETS:
        slowest = f"{min(through[target]):.3g}" if through[target] else ""
        print(f"| {target} | {counts[target]} | {fastest[target]:.0f} | {len(through[target])} | "
              f"{slowest} | {slow[target]} |")
    return 1 if any(through.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
