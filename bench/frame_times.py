#!/usr/bin/env python3
"""What each feature of Render costs: processor time of a frame of graphs/models/chair.obj, 960 x 540.

    bench/frame_times.py [ASPIC]

A turntable of 11 frames less one of 1, divided by 10, the better of two: without start-up and
reading. Time of all threads of both processes: it depends less than time by the clock on what else
the machine does.
"""
import json
import os
import resource
import subprocess
import sys
import tempfile

BASE = {'width': 960, 'height': 540, 'camera': {'kind': 'turntable', 'turn': 3}}
FEATURES = {'standard': {}, 'quality = draft': {'quality': 'draft'},
            'quality = preview': {'quality': 'preview'}, 'quality = final': {'quality': 'final'},
            'look = plain': {'look': 'plain'}, 'light.shadow = off': {'light': {'shadow': 'off'}},
            'light.occlusion = 0': {'light': {'occlusion': 0}}, 'linear = whole': {'linear': 'whole'}}
FRAMES = 10


def spent():
    of = resource.getrusage(resource.RUSAGE_CHILDREN)
    return of.ru_utime + of.ru_stime


def seconds(aspic, params, frames, folder):
    graph = os.path.join(folder, 'graph.json')
    nodes = {'chair': {'type': 'ReadMesh@1', 'params': {'unit': 'm',
                                                        'path': os.path.abspath('graphs/models/chair.obj')}},
             'picture': {'type': 'Render@2', 'inputs': {'mesh': 'chair.mesh', 'rest': 'chair.mesh'},
                         'params': {**BASE, **params}}}
    with open(graph, 'w') as file:
        json.dump({'aspic': 1, 'frames': {'first': 1, 'last': FRAMES + 1}, 'nodes': nodes}, file)
    before = spent()
    subprocess.run([aspic, 'cook', graph, '--out', folder, '--no-disk-cache', '--allow-outside',
                    '--threads', '1', '-q', '--node', 'picture', '--frames', frames], check=True)
    return spent() - before


def main():
    aspic = sys.argv[1] if len(sys.argv) > 1 else 'build/release/aspic'
    with tempfile.TemporaryDirectory() as folder:
        for name, params in FEATURES.items():
            best = min(seconds(aspic, params, f'1-{FRAMES + 1}', folder) -
                       seconds(aspic, params, '1', folder) for _ in range(2))
            print(f'| `{name}` | {1000 * best / FRAMES:.0f} ms |', flush=True)


if __name__ == '__main__':
    main()
