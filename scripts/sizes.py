#!/usr/bin/env python3
"""Lists functions, sources and headers that are too long to take in, and headers that do not open with
what they are for.

    scripts/sizes.py [FOLDER ...]

Limits: 60 lines a function, 500 a source, 200 a header. What stands in scripts/large.txt, one
"path" or "path:function" a line with the reason behind a '#', may be longer; an entry there that is
no longer needed is a mistake too. Exit code 1 where something is listed. Needs universal-ctags.
"""
import pathlib
import subprocess
import sys

LAYERS = ["geometry", "physics", "render", "graph", "runtime", "nodes"]
FUNCTION, SOURCE, HEADER = 60, 500, 200
root = pathlib.Path(__file__).resolve().parent.parent


def functions(files):
    """(path, name, line, lines) of each function, as ctags sees it."""
    tags = subprocess.run(
        ["ctags", "-f", "-", "--language-force=C++", "--kinds-C++=f", "--fields=+neK", "--excmd=number",
         "-L", "-"], input="\n".join(map(str, files)), cwd=root, text=True, check=True,
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    for tag in tags.splitlines():
        name, path, _, *fields = tag.split("\t")
        of = dict(f.split(":", 1) for f in fields if ":" in f)
        if "line" in of and "end" in of:
            yield path, name, int(of["line"]), int(of["end"]) - int(of["line"]) + 1


def opens_with_comment(text):
    """Whether the first line that says something after the guard is a comment."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#pragma once")]
    return bool(lines) and lines[0].startswith("//")


def main():
    folders = sys.argv[1:] or LAYERS
    listed = {}
    for line in (root / "scripts/large.txt").read_text().splitlines():
        place, _, reason = line.partition("#")
        if place.strip():
            listed[place.strip()] = reason.strip()
    files = sorted(f.relative_to(root) for folder in folders
                   for end in ("*.cpp", "*.hpp") for f in (root / folder).rglob(end))
    found = {}
    for file in files:
        lines = len((root / file).read_text().splitlines())
        limit = HEADER if file.suffix == ".hpp" else SOURCE
        if lines > limit:
            found[str(file)] = f"{file}: {lines} lines, limit {limit}"
        if file.suffix == ".hpp" and not opens_with_comment((root / file).read_text()):
            found[f"{file}:purpose"] = f"{file}: does not open with what it is for"
    for path, name, line, lines in functions(files):
        if lines > FUNCTION:
            found[f"{path}:{name}"] = f"{path}:{line}: {name} has {lines} lines, limit {FUNCTION}"
    wrong = [text for place, text in found.items() if place not in listed]
    if not sys.argv[1:]:
        wrong += [f"scripts/large.txt: {place} is within its limit: remove the line"
                  for place in listed if place not in found]
    wrong += [f"scripts/large.txt: {place} has no reason" for place, why in listed.items() if not why]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
