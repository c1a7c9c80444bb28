#!/usr/bin/env python3
"""Layers drawn by rays: seconds a frame of two scenes at 960 x 540, and the size of their records.

    bench/layer_rays.py [ASPIC]

The time is that of ten frames less that of one, divided by nine, from simulated frames in a cache:
by the clock, and of the processor over both threads, which depends less on what else the machine
does. The mesh is the one that the scene's Polygonize makes of the same frame, as a binary PLY.
"""
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

SCENES = {'kitchen': (51, 'motion', 'surface'), 'figure_falls': (41, 'motion', 'surface')}
FRAMES = 10


def spent():
    of = resource.getrusage(resource.RUSAGE_CHILDREN)
    return of.ru_utime + of.ru_stime


def cook(aspic, graph, folder, node, frames):
    wall, before = time.monotonic(), spent()
    subprocess.run([aspic, 'cook', graph, '--out', folder, '--cache', folder + '/cache',
                    '--allow-outside', '--threads', '2', '-q', '--node', node, '--frames', frames],
                   check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - wall, spent() - before


def with_writers(name, folder):
    path = os.path.abspath(f'graphs/{name}.json')
    _, motion, surface = SCENES[name]
    shot = {'aspic': 1, 'extends': path, 'nodes': {
        'picture': {'params': {'width': 960, 'height': 540}},
        'record': {'type': 'WriteScene@1', 'inputs': {'scene': f'{motion}.scene'},
                   'params': {'path': 'scene.####.layers'}},
        'meshes': {'type': 'WriteMesh@1', 'inputs': {'mesh': f'{surface}.mesh'},
                   'params': {'path': 'mesh.####.ply'}}}}
    with open(f'{folder}/{name}.json', 'w') as file:
        json.dump(shot, file)
    return f'{folder}/{name}.json'


def size(folder, end):
    return max(os.path.getsize(os.path.join(folder, f)) for f in os.listdir(folder) if f.endswith(end))


def main():
    aspic = sys.argv[1] if len(sys.argv) > 1 else 'build/release/aspic'
    print('| scene | s a frame | processor s a frame | record, bytes | mesh, bytes | record of mesh |')
    print('|---|--:|--:|--:|--:|--:|')
    for name, (first, motion, _) in SCENES.items():
        with tempfile.TemporaryDirectory() as folder:
            graph = with_writers(name, folder)
            cook(aspic, graph, folder, motion, f'1-{first + FRAMES}')
            ten = cook(aspic, graph, folder, 'picture', f'{first}-{first + FRAMES - 1}')
            one = cook(aspic, graph, folder, 'picture', f'{first + FRAMES}')
            wall, busy = ((a - b) / (FRAMES - 1) for a, b in zip(ten, one))
            cook(aspic, graph, folder, 'record', f'{first}')
            cook(aspic, graph, folder, 'meshes', f'{first}')
            record, mesh = size(folder, '.layers'), size(folder, '.ply')
            print(f'| `{name}` | {wall:.2f} | {busy:.2f} | {record} | {mesh} | '
                  f'{100 * record / mesh:.2f} % |', flush=True)


if __name__ == '__main__':
    main()
