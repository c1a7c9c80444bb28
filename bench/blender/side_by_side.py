#!/usr/bin/env python3
"""Pairs of pictures to judge blind: Render beside Blender's Workbench and EEVEE.

    bench/blender/side_by_side.py OUT [--aspic build/release/aspic]
        cooks four frames of four scenes, has Blender draw the same meshes (GLB) from the same
        camera at the same size, and writes OUT/pairs/01.png ...: two pictures beside each other, in
        an order by chance. Judge these, one line each in OUT/judged.txt: left, right or equal.
    bench/blender/side_by_side.py OUT --open
        says which was which, and counts.

EEVEE needs a GL context: Debian's xvfb and Mesa's llvmpipe serve (packages blender, python3-numpy,
xvfb, xauth). Both engines get what is cheap to ask for: Workbench shadows, cavity and the materials'
colours, EEVEE a soft sun of the same direction and strength, sky light, ambient occlusion and the
same floor; both 8 samples.
"""
import argparse
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile

SCENES = {'chair_drop': [8, 16, 24, 36], 'three_sheets': [12, 24, 36, 48],
          'pouffe': [10, 20, 30, 40], 'skittles': [8, 14, 20, 30]}
SIZE = (640, 360)
FLOOR = (0.70, 0.69, 0.67)


# ---- in Blender -----------------------------------------------------------------------------------

def turned(p):
    return (p[0], -p[2], p[1])  # y up to z up


def build(bpy, job):
    from mathutils import Vector
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=job['mesh'])
    for thing in bpy.context.scene.objects:
        for material in thing.data.materials if thing.type == 'MESH' else []:
            shader = material.node_tree.nodes.get('Principled BSDF')
            if shader and not shader.inputs['Base Color'].links:
                material.diffuse_color = shader.inputs['Base Color'].default_value
    bpy.ops.mesh.primitive_plane_add(size=60, location=(0, 0, job['ground']))
    floor = bpy.data.materials.new('floor')
    floor.use_nodes = True
    floor.node_tree.nodes['Principled BSDF'].inputs['Base Color'].default_value = (*FLOOR, 1)
    floor.node_tree.nodes['Principled BSDF'].inputs['Roughness'].default_value = 1
    floor.diffuse_color = (*FLOOR, 1)
    bpy.context.object.data.materials.append(floor)

    camera = bpy.data.objects.new('camera', bpy.data.cameras.new('camera'))
    bpy.context.scene.collection.objects.link(camera)
    eye, target = Vector(turned(job['eye'])), Vector(turned(job['target']))
    camera.location = eye
    camera.rotation_euler = (target - eye).to_track_quat('-Z', 'Y').to_euler()
    camera.data.sensor_fit = 'VERTICAL'
    camera.data.angle = math.radians(job['field_of_view'])
    bpy.context.scene.camera = camera

    azimuth, elevation = math.radians(-25), math.radians(50)  # of Render's key light
    to_light = Vector(turned((math.sin(azimuth) * math.cos(elevation), math.sin(elevation),
                              math.cos(azimuth) * math.cos(elevation))))
    sun = bpy.data.objects.new('sun', bpy.data.lights.new('sun', 'SUN'))
    sun.rotation_euler = to_light.to_track_quat('Z', 'Y').to_euler()
    sun.data.energy, sun.data.angle, sun.data.color = 2.6, math.radians(8), (1, 0.95, 0.87)
    sun.data.use_contact_shadow = True
    bpy.context.scene.collection.objects.link(sun)
    world = bpy.data.worlds.new('world')
    world.use_nodes = True
    world.node_tree.nodes['Background'].inputs['Color'].default_value = (0.42, 0.46, 0.52, 1)
    bpy.context.scene.world = world


def in_blender(bpy, job):
    import numpy
    if not hasattr(numpy, 'bool'):
        numpy.bool = bool
    build(bpy, job)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.view_settings.view_transform = 'Standard'
    for engine, path in job['pictures'].items():
        scene.render.engine = engine
        if engine == 'BLENDER_WORKBENCH':
            scene.display.shading.color_type = 'MATERIAL'
            scene.display.shading.show_shadows = scene.display.shading.show_cavity = True
            scene.display.render_aa = '8'
        else:
            scene.eevee.taa_render_samples = 8
            scene.eevee.use_gtao = scene.eevee.use_soft_shadows = True
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)


# ---- outside --------------------------------------------------------------------------------------

def document(scene):
    with open(f'graphs/{scene}.json') as file:
        return json.loads(re.sub(r'^\s*//.*$', '', file.read(), flags=re.M))


def cook(aspic, scene, frames, out):
    """Our pictures, and the meshes of these frames; the camera and the floor's height."""
    graph = document(scene)
    render = next(n for n in graph['nodes'].values() if n['type'].startswith('Render'))
    for name in [n for n, v in graph['nodes'].items()
                 if v['type'].split('@')[0] in ('WriteVideo', 'WriteImage', 'ContactSheet', 'Measure')]:
        del graph['nodes'][name]
    graph.pop('expect', None)
    meshes = render['inputs']['mesh']
    if isinstance(meshes, list) and len(meshes) > 1:
        graph['nodes']['all'] = {'type': 'Merge@1', 'inputs': {'meshes': meshes}}
        meshes = 'all.mesh'
    params = render.setdefault('params', {})
    params.update({'width': SIZE[0], 'height': SIZE[1], 'legend': False, 'label': ''})
    render['inputs'] = {k: v for k, v in render['inputs'].items() if k in ('mesh', 'rest')}
    graph['nodes']['side_mesh'] = {'type': 'WriteMesh@1',
                                   'inputs': {'mesh': meshes[0] if isinstance(meshes, list) else meshes},
                                   'params': {'path': 'm.####.glb'}}
    name = next(n for n, v in graph['nodes'].items() if v is render)
    graph['nodes']['side_picture'] = {'type': 'WriteImage@1', 'inputs': {'image': f'{name}.image'},
                                      'params': {'path': 'ours.####.png'}}
    path = f'graphs/side_by_side_{scene}.json'
    with open(path, 'w') as file:
        json.dump(graph, file)
    try:
        subprocess.run([aspic, 'cook', path, '--out', out, '--frames', ','.join(map(str, frames)),
                        '--node', 'side_mesh', '--node', 'side_picture', '-q'], check=True)
    finally:
        os.remove(path)
    camera = params['camera']
    ground = params.get('ground', {}).get('height', 0)
    return {'eye': camera['eye'], 'target': camera['target'],
            'field_of_view': camera.get('field_of_view', 28), 'ground': ground}


def draw(job):
    with tempfile.NamedTemporaryFile('w', suffix='.json') as asked:
        json.dump(job, asked)
        asked.flush()
        subprocess.run(['xvfb-run', '-a', 'blender', '-b', '--factory-startup', '--python-exit-code', '3',
                        '--python', os.path.abspath(__file__), '--', asked.name], check=True,
                       stdout=subprocess.DEVNULL, env={**os.environ, 'PATH': '/usr/bin:/bin'})


def make(aspic, out):
    pairs = []
    for scene, frames in SCENES.items():
        folder = os.path.abspath(os.path.join(out, scene))
        os.makedirs(folder, exist_ok=True)
        camera = cook(aspic, scene, frames, folder)
        for frame in frames:
            pictures = {e: os.path.join(folder, f'{e}.{frame:04}.png')
                        for e in ('BLENDER_WORKBENCH', 'BLENDER_EEVEE')}
            draw({**camera, 'mesh': os.path.join(folder, f'm.{frame:04}.glb'), 'pictures': pictures})
            ours = os.path.join(folder, f'ours.{frame:04}.png')
            pairs += [(ours, picture) for picture in pictures.values()]
    random.shuffle(pairs)
    os.makedirs(os.path.join(out, 'pairs'), exist_ok=True)
    order = [random.sample(pair, 2) for pair in pairs]
    for number, (left, right) in enumerate(order, 1):
        subprocess.run(['ffmpeg', '-loglevel', 'error', '-y', '-i', left, '-i', right, '-filter_complex',
                        'hstack', os.path.join(out, 'pairs', f'{number:02}.png')], check=True)
    with open(os.path.join(out, 'order.json'), 'w') as file:
        json.dump(order, file)


def count(out):
    with open(os.path.join(out, 'order.json')) as file:
        order = json.load(file)
    with open(os.path.join(out, 'judged.txt')) as file:
        judged = [line.split()[0] for line in file if line.strip()]
    counts = {}
    for number, ((left, right), word) in enumerate(zip(order, judged), 1):
        ours_left = 'ours' in os.path.basename(left)
        other = os.path.basename(right if ours_left else left).split('.')[0]
        result = 'equal' if word == 'equal' else 'ours' if (word == 'left') == ours_left else 'theirs'
        frame = os.path.basename(left).split('.')[1]
        print(f'{number:02} {os.path.basename(os.path.dirname(left))} {frame} against {other}: {result}')
        counts.setdefault(other, {}).setdefault(result, 0)
        counts[other][result] += 1
    print(counts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('out')
    parser.add_argument('--aspic', default='build/release/aspic')
    parser.add_argument('--open', action='store_true')
    options = parser.parse_args()
    if options.open:
        count(options.out)
    else:
        make(options.aspic, options.out)


if __name__ == '__main__':
    if '--' in sys.argv:
        import bpy
        with open(sys.argv[sys.argv.index('--') + 1]) as file:
            in_blender(bpy, json.load(file))
    else:
        main()
