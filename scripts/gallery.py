#!/usr/bin/env python3
"""Makes docs/gallery.md: a picture and the graph of each scene that has a picture.

    scripts/gallery.py                  cooks a frame of each scene and writes the page
    scripts/gallery.py bridge flag      only these pictures, and the page
    scripts/gallery.py --page           the page alone, from the pictures that are there

The pictures (docs/pictures/, JPEG, at most 150 kB each) are drawn in quality `final`. Needs the
built program and ffmpeg.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

root = pathlib.Path(__file__).resolve().parent.parent
pictures = root / "docs/pictures"
program = root / "build/release/aspic"
most_bytes = 150_000

# The frame in which the scene's event is seen.
scenes = {
    "bridge": 60, "cushion": 12, "pile": 22, "pouffe": 20, "torn_sheet": 14, "torn_ring": 60, "trampoline": 20, "flag": 60,
    "jelly_drop": 64, "many_jellies": 60, "squashed_buns": 30, "chair": 8, "chair_drop": 12,
    "beam": 48, "plane_push": 22, "two_soft_solids": 16, "safety_net": 13, "figure_falls": 24,
    "bounce_on_stairs": 20, "clover_on_stairs": 24, "blend_constant_volume": 48, "breathing": 18,
    "dough_and_pliers": 66, "kitchen": 48, "coated_cubes": 16, "felt_on_stone": 24,
    "reaching_puppet": 48, "starter": 12, "folding_ribbon": 19, "three_sheets": 14, "walk_by_keys": 40,
    "scanned_duck": 9, "skittles": 19, "three_cloths": 40, "shots/bridge_lorry": 60,
    "twirling_skirt": 45, "rubber_cone": 28, "crushed_drum": 31, "pebbles": 12, "wall": 14, "dominoes": 48,
    "wrecking_ball": 44, "tablecloth": 26,
}


def merged(under, over):
    """`over` where it says something, and else `under`: what `extends` does."""
    if not (isinstance(under, dict) and isinstance(over, dict)):
        return over
    return under | {k: merged(under.get(k), v) for k, v in over.items()}


def read(path):
    graph = json.loads(re.sub(r"^\s*//.*$", "", path.read_text(), flags=re.M))
    if "extends" in graph:
        graph = merged(read(path.parent / graph["extends"]), graph)
    return graph


def document(scene):
    return read(root / f"graphs/{scene}.json")


def picture_of(scene):
    return f"{scene.split('/')[-1]}.jpg"


def wires(value):
    """The outputs that an input is linked to."""
    return [value] if isinstance(value, str) else [w for v in value for w in wires(v)]


def drawing(nodes):
    """The graph in Mermaid, left to right; what only measures is left out."""
    shown = {n: d["type"].split("@")[0] for n, d in nodes.items() if not d["type"].startswith("Measure")}
    lines = ["flowchart LR"]
    lines += [f'  {n}["{n}<br><i>{t}</i>"]' for n, t in shown.items()]
    for n in shown:
        sources = {w.split(".")[0] for v in nodes[n].get("inputs", {}).values() for w in wires(v)}
        lines += [f"  {s} --> {n}" for s in sorted(sources) if s in shown]
    return "\n".join(lines)


def draw(scene, frame):
    nodes = document(scene)["nodes"]
    writer, image = next((n, d["inputs"]["image"]) for n, d in nodes.items()
                         if d["type"].startswith("WriteImage"))
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([program, "cook", root / f"graphs/{scene}.json", "--quiet", "--out", out,
                        "--node", writer, "--frames", str(frame), "--set",
                        f'{image.split(".")[0]}.quality=final'], check=True)
        drawn = next(pathlib.Path(out).rglob("*.png"))
        to = pictures / picture_of(scene)
        for quality in (2, 3, 4, 6, 8):
            subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-i", drawn, "-q:v", str(quality),
                            to], check=True)
            if to.stat().st_size <= most_bytes:
                break


def page():
    text = ("# Gallery\n\nA frame of scenes in `graphs/`, with their graphs. "
            "`scripts/gallery.py` makes this page.\n")
    for scene, frame in scenes.items():
        if not (pictures / picture_of(scene)).exists():
            continue
        graph = document(scene)
        doc = graph.get("doc", "A ball of foam falls on the floor.")
        text += (f"\n## {scene}\n\n{doc}\n\n![Frame {frame} of {scene}](pictures/{picture_of(scene)})\n\n"
                 f"<details><summary>The graph of "
                 f"<a href=\"../graphs/{scene}.json\">{scene}.json</a></summary>\n\n"
                 f"```mermaid\n{drawing(graph['nodes'])}\n```\n\n</details>\n")
    (root / "docs/gallery.md").write_text(text)


def main():
    pictures.mkdir(exist_ok=True)
    words = sys.argv[1:]
    if words != ["--page"]:
        for scene in words or scenes:
            draw(scene, scenes[scene])
    page()


main()
