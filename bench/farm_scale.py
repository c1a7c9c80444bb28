#!/usr/bin/env python3
"""How long 1,000 shots of 240 frames take on 10, 100 and 1,000 machines, and what the shared folder sees.

    bench/farm_scale.py [--program build/release/aspic] [--shots 1000] [--frames 240] [--cooked 12]

A soft ball falls, another one in each shot: pictures of 1280 x 720 and a video. Some frames of one shot
are cooked here; what they took and wrote drives the rest. `aspic farm --plan` cuts all shots. A discrete
simulation then gives each machine the ready task that most work waits for, as the plan does, and lets
all transfers to and from the shared folder share its bandwidth equally. Its times without a limit must
be those of the plan: exit code 1 where they are not, or where 10,000 tasks take 2 s to plan.
"""
import argparse
import heapq
import json
import pathlib
import subprocess
import sys
import tempfile
import time

INFINITE = float("inf")


def document(height, last):
    """What graphs/starter.json does, in larger pictures."""
    return {"aspic": 1, "frames": {"first": 1, "last": last, "fps": 24}, "nodes": {
        "ball": {"type": "Primitive@1", "params": {"shape": "sphere", "centre": [0, height, 0]}},
        "cubes": {"type": "Voxelize@1", "inputs": {"mesh": "ball.mesh"}, "params": {
            "method": "solid", "size": 0.0625,
            "matter": {"density": 300, "young": 30000, "poisson": 0.4}}},
        "floor": {"type": "Ground@1"},
        "sim": {"type": "Simulate@3", "params": {"step": {"substeps": 4}}, "inputs": {
            "colliders": ["floor.collider"], "cubes": "cubes.cubes", "surface": "ball.mesh"}},
        "shape": {"type": "Embed@3", "inputs": {
            "cubes": "cubes.cubes", "mesh": "ball.mesh", "state": "sim.state"}},
        "picture": {"type": "Render@2", "inputs": {"mesh": "shape.mesh"}, "params": {
            "width": 1280, "height": 720, "ground": {"kind": "at"},
            "camera": {"kind": "look_at", "eye": [3, 1.6, 4], "target": [0, 0.7, 0]}}},
        "frames": {"type": "WriteImage@1", "inputs": {"image": "picture.image"}},
        "video": {"type": "WriteVideo@1", "inputs": {"frames": "frames.file"}}}}


def size(folder):
    return sum(f.stat().st_size for f in folder.rglob("*") if f.is_file())


class Traffic:
    """Bytes that tasks read and write: of each frame, by stage; and of a shot's last task."""

    def __init__(self, program, folder, frames, cooked):
        file = folder / "shots" / "shot0000.json"
        cook = [program, "cook", file, "--cache", folder / "cache", "--out", folder / "out" / "shot0000",
                "--threads", "1", "-q", "--frames", f"1-{cooked}"]
        subprocess.run(cook + ["--node", "sim"], check=True)
        self.state = size(folder / "cache") / cooked
        subprocess.run(cook, check=True)
        self.files = size(folder / "out") / cooked
        self.made = size(folder / "cache") / cooked - self.state + self.files
        self.frames = frames

    def of(self, task):
        """(read, written)."""
        count = frames_in(task["frames"])
        return {"chain": (0, self.state * count), "frames": (self.state * count, self.made * count),
                "last": (2 * self.files * self.frames, 0)}.get(task["stage"], (0, 0))


def frames_in(text):
    """How many frames "1-4,9" is."""
    ends = [part.split("x")[0].split("-") for part in text.split(",")]
    return sum(int(e[-1]) - int(e[0]) + 1 for e in ends)


def simulate(seconds, after, bytes_of, machines, bandwidth):
    """s until all tasks are done. A task works, then its bytes go over the shared folder."""
    dependants, missing, left = [[] for _ in seconds], [len(a) for a in after], list(seconds)
    for task in range(len(seconds) - 1, -1, -1):  # each stands after those that it waits for
        left[task] = seconds[task] + max((left[d] for d in dependants[task]), default=0)
        for before in after[task]:
            dependants[before].append(task)
    ready = [(-left[t], t) for t, m in enumerate(missing) if m == 0]
    heapq.heapify(ready)
    working, moving, now, moved, free = [], [], 0.0, 0.0, machines
    while ready or working or moving:
        while ready and free:
            free -= 1
            task = heapq.heappop(ready)[1]
            heapq.heappush(working, (now + seconds[task], task))
        # `moved`: bytes that each transfer has moved that began at 0. All of them are equally fast.
        done = now + (moving[0][0] - moved) * len(moving) / bandwidth if moving else INFINITE
        until = min(done, working[0][0] if working else INFINITE)
        if moving:
            moved += (until - now) * bandwidth / len(moving) if bandwidth < INFINITE else 0
        now = until
        if working and working[0][0] <= done:
            task = heapq.heappop(working)[1]
            if bandwidth < INFINITE:
                heapq.heappush(moving, (moved + bytes_of[task], task))
                continue
        else:
            moved, task = heapq.heappop(moving)
        free += 1
        for d in dependants[task]:
            missing[d] -= 1
            if missing[d] == 0:
                heapq.heappush(ready, (-left[d], d))
    return now


def plan(program, folder, files, out, more=()):
    """The plan as JSON, and how many seconds the command took."""
    begin = time.monotonic()
    said = subprocess.run([program, "farm", *files, "--cache", folder / "cache", "--out", out,
                           "--plan", "--json", *more], check=True, text=True, capture_output=True)
    return json.loads(said.stdout), time.monotonic() - begin


def duration(s):
    s = round(s)
    return f"{s // 3600} h {s % 3600 // 60} min" if s >= 3600 else f"{s // 60} min {s % 60} s"


def table(planned, traffic, server):
    tasks = planned["tasks"]
    place = {t["name"]: i for i, t in enumerate(tasks)}
    seconds, after = [t["seconds"] for t in tasks], [[place[a] for a in t["after"]] for t in tasks]
    moves = [traffic.of(t) for t in tasks]
    read, written = (sum(m[i] for m in moves) for i in (0, 1))
    told = {m["count"]: m["seconds"] for m in planned["machines"]}
    print(f"{len(tasks)} tasks, {sum(seconds) / 3600:.1f} hours of work, "
          f"{written / 1e9:.0f} GB are written and {read / 1e9:.0f} GB read\n")
    print(f"| machines | time | in use | written | read | time by a server of {server / 1e9:g} GB/s |\n"
          "|---|---|---|---|---|---|")
    good = True
    for n in (1, 10, 100, 1000):
        free = simulate(seconds, after, moves, n, INFINITE)
        if abs(free - told[n]) > 1e-6 * free:
            print(f"error: {n} machines: expected the plan's {told[n]} s, found {free} s", file=sys.stderr)
            good = False
        full = simulate(seconds, after, [sum(m) for m in moves], n, server)
        print(f"| {n} | {duration(free)} | {sum(seconds) / n / free:.0%} | {written / free / 1e6:.3g} MB/s "
              f"| {read / free / 1e6:.3g} MB/s | {duration(full)} |")
    print(f"\nthe server is full at {sum(seconds) * server / (read + written):.0f} machines")
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--program", default="build/release/aspic")
    parser.add_argument("--shots", type=int, default=1000)
    parser.add_argument("--frames", type=int, default=240)
    parser.add_argument("--cooked", type=int, default=12, help="frames that are cooked here")
    parser.add_argument("--server", type=float, default=1.25e9, help="bytes/s that the shared folder moves")
    asked = parser.parse_args()
    program = pathlib.Path(asked.program).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "shots").mkdir()
        for i in range(asked.shots):
            text = json.dumps(document(1 + i / 1000, asked.frames))
            (folder / "shots" / f"shot{i:04}.json").write_text(text)
        traffic = Traffic(program, folder, asked.frames, asked.cooked)
        planned, took = plan(program, folder, sorted((folder / "shots").iterdir()), folder / "out")
        good = table(planned, traffic, asked.server)
        print(f"{len(planned['tasks'])} tasks of {asked.shots} documents were planned in {took:.2f} s")
        (folder / "shots" / "shot0000.json").write_text(json.dumps(document(1, 10_000)))
        long, took = plan(program, folder, [folder / "shots" / "shot0000.json"],
                          folder / "out" / "shot0000", ("--task-seconds", "0.001"))
        print(f"{len(long['tasks'])} tasks of one document were planned in {took:.2f} s")
    return 0 if good and took < 2 else 1


if __name__ == "__main__":
    sys.exit(main())
