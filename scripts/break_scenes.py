#!/usr/bin/env python3
"""Breaks each scene in five gross ways and prints which expectations notice.

    scripts/break_scenes.py [--program build/release/aspic] [--only frozen,clock] [SCENE ...]

A scene whose expectations hold although nothing moves tests nothing. This script copies graphs/ into
a temporary folder, changes every document there, and runs `aspic check` on each scene:

    frozen      nothing moves: no time passes in a frame, and keyframes keep their first value
    clock       time runs at 0.7 of its rate
    gravity     gravity x 1.5
    stiffness   Young's modulus, layers, substances and springs x 4
    friction    no friction

Keyframes are counted in frames: the other breaks leave keyframed tools and pins as they are. A break that a document
does not contain (no gravity, say) is marked '.': there is nothing to notice. 'noticed' means that an
expectation was missed or a node failed; 'GREEN' means that all expectations held.
"""
import argparse
import copy
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

root = pathlib.Path(__file__).resolve().parent.parent
BREAKS = ["frozen", "clock", "gravity", "stiffness", "friction"]
FROZEN = 3e-5  # what is left of the time of a frame: frame rates end at 1e6

# Parameters that a break multiplies: (node type, path, default where a document says nothing).
GRAVITY = [0, -9.81, 0]
PARAMS = {
    "gravity": [("Simulate", "gravity", GRAVITY), ("Layered", "gravity", GRAVITY),
                ("Vibrate", "gravity", None), ("Force", "gravity.acceleration", None)],
    "stiffness": [("Voxelize", "matter.young", 1e6), ("Sample", "matter.young", 1e6),
                  ("Plane", "matter.young", 1e6), ("ImplicitLayer", "matter.stiffness", None),
                  ("ImplicitLayer", "substance.stiffness", None), ("Springs", "stiffness", 1000),
                  ("Simulate", "lattice.rate", None)],
    "friction": [("Ground", "friction", 0.5), ("Collider", "friction", 0.5),
                 ("Ball", "friction", 0.5), ("ImplicitLayer", "matter.friction", 1),
                 ("Simulate", "lattice.contact.friction", None)],
    "frozen": [("Simulate", "dt", None), ("Vibrate", "dt", None)],
    "clock": [("Simulate", "dt", None), ("Vibrate", "dt", None)],
}
FACTOR = {"gravity": 1.5, "stiffness": 4, "friction": 0, "frozen": FROZEN, "clock": 0.7}


def without_comments(text):
    strings_or_comments = r'"(?:[^"\\]|\\.)*"|//[^\n]*|/\*.*?\*/'
    return re.sub(strings_or_comments, lambda m: m[0] if m[0][0] == '"' else " ", text, flags=re.S)


def times(value, factor):
    """A number, vector, expression or keyframes, multiplied."""
    if isinstance(value, str) and value.startswith("="):
        return f"={factor} * ({value[1:]})"
    if isinstance(value, list):
        return [times(v, factor) for v in value]
    if isinstance(value, dict):
        return {**value, "keys": [[frame, times(v, factor)] for frame, v in value["keys"]]}
    return value * factor if isinstance(value, (int, float)) else value


def without_motion(value):
    """The value, with the first of its keyframes alone."""
    if isinstance(value, list):
        return [without_motion(v) for v in value]
    if isinstance(value, dict):
        if isinstance(value.get("keys"), list):
            value = {**value, "keys": value["keys"][:1]}
        return {k: without_motion(v) for k, v in value.items()}
    return value


def multiply(params, path, default, factor):
    """Multiplies one parameter; returns whether its value changed."""
    *blocks, name = path.split(".")
    for block in blocks:
        if block not in params and default is None:
            return False
        params = params.setdefault(block, {})
    if params.get(name) is None:
        if default is None:
            return False
        params[name] = default
    before = params[name]
    params[name] = times(before, factor)
    return params[name] != before


def types_of(path, documents):
    """The type of each node by name, those of the extended document included."""
    document = documents[path]
    types = {}
    if "extends" in document:
        types = types_of((path.parent / document["extends"]).resolve(), documents)
    for name, node in document.get("nodes", {}).items():
        if node and "type" in node:
            types[name] = node["type"].split("@")[0]
    return types


def broken(path, documents, how):
    """The document at `path` with one break, and whether there was anything to break."""
    document = copy.deepcopy(documents[path])
    types = types_of(path, documents)
    changed = False
    if how in ("frozen", "clock"):
        frames = document.get("frames")
        if "extends" not in document or (frames and "fps" in frames):
            frames = document.setdefault("frames", {})
            frames["fps"] = frames.get("fps", 24) / FACTOR[how]
        if how == "frozen" and "nodes" in document:
            document["nodes"] = without_motion(document["nodes"])
        changed = True
    for name, node in document.get("nodes", {}).items():
        if not node:
            continue
        for type_name, parameter, default in PARAMS[how]:
            if types.get(name) != type_name:
                continue
            if "type" in node:
                changed |= multiply(node.setdefault("params", {}), parameter, default, FACTOR[how])
            elif "params" in node:
                changed |= multiply(node["params"], parameter, None, FACTOR[how])
    # What an asset lets others set.
    for promoted in document.get("subgraph", {}).get("params", {}).values():
        targets = promoted["to"] if isinstance(promoted["to"], list) else [promoted["to"]]
        for target in targets:
            name, _, parameter = target.partition(".")
            if (types.get(name), parameter) in [(t, p) for t, p, _ in PARAMS[how]]:
                if "default" in promoted:
                    promoted["default"] = times(promoted["default"], FACTOR[how])
                    break
    # What a document sets of an asset.
    for node in document.get("nodes", {}).values():
        if not node or not node.get("type", "").split("@")[0].endswith(".json"):
            continue
        asset_path = (path.parent / node["type"].split("@")[0]).resolve()
        asset_types = types_of(asset_path, documents)
        for given in node.get("params", {}):
            promoted = documents[asset_path]["subgraph"]["params"].get(given, {"to": []})
            targets = promoted["to"] if isinstance(promoted["to"], list) else [promoted["to"]]
            for target in targets:
                name, _, parameter = target.partition(".")
                if (asset_types.get(name), parameter) in [(t, p) for t, p, _ in PARAMS[how]]:
                    node["params"][given] = times(node["params"][given], FACTOR[how])
                    break
        changed |= broken(asset_path, documents, how)[1]
    if "extends" in document:
        changed |= broken((path.parent / document["extends"]).resolve(), documents, how)[1]
    return document, changed


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--program", default=str(root / "build/release/aspic"))
    parser.add_argument("--only", default=",".join(BREAKS), help="some of " + ",".join(BREAKS))
    parser.add_argument("scenes", nargs="*", help="as chair or shots/bridge_storm; else all")
    args = parser.parse_args()
    graphs = root / "graphs"
    paths = [p for p in graphs.rglob("*.json") if "models" not in p.relative_to(graphs).parts]
    documents = {p: json.loads(without_comments(p.read_text())) for p in paths}
    names = {p: str(p.relative_to(graphs).with_suffix("")) for p in paths}
    scenes = [p for p in sorted(paths) if "expect" in documents[p]
              and (not args.scenes or names[p] in args.scenes)]
    breaks = args.only.split(",")
    print("scene".ljust(28) + "".join(b.ljust(11) for b in breaks), flush=True)
    green = {b: [] for b in breaks}
    with tempfile.TemporaryDirectory() as folder:
        for how in breaks:
            there = pathlib.Path(folder) / how / "graphs"
            shutil.copytree(graphs, there)
            for p in paths:
                (there / p.relative_to(graphs)).write_text(
                    json.dumps(broken(p, documents, how)[0], indent=1))
        for p in scenes:
            row = names[p].ljust(28)
            for how in breaks:
                if not broken(p, documents, how)[1]:
                    row += ".".ljust(11)
                    continue
                file = pathlib.Path(folder) / how / "graphs" / p.relative_to(graphs)
                run = subprocess.run([args.program, "check", str(file), "--no-disk-cache", "-q"],
                                     capture_output=True, text=True)
                if run.returncode in (1, 3):
                    row += "noticed".ljust(11)
                elif run.returncode == 0:
                    row += "GREEN".ljust(11)
                    green[how].append(names[p])
                else:
                    sys.exit(f"{file}: {run.stdout}{run.stderr}")
            print(row, flush=True)
    for how in breaks:
        print(f"{how}: {len(green[how])} green {' '.join(green[how])}")


if __name__ == "__main__":
    start = time.time()
    main()
    print(f"{time.time() - start:.0f} s", file=sys.stderr)
