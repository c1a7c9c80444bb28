#!/usr/bin/env python3
"""Textured models through ReadMesh and every writer, read back in Blender.

    bench/blender/read_back.py [MODEL ...] [--aspic build/release/aspic]

Blender (Debian: blender, python3-numpy) makes four models (monkey: texture and normal map; leaves:
a texture with holes; cloth: a texture that repeats, and vertex colours; two_parts: a texture and a
plain colour) and writes them as GLB and OBJ. Aspic reads these and the files that are named, and
writes each in all formats. Blender reads both: the table says, of every written file, how much of
the surface has the colour of the original, texture times colour, within 2 of 255 at a place inside
each face, and whether normal maps, holes, vertex colours and faces of four corners or more are
there: glTF has triangles only. X3D is left out: Debian's
Blender cannot open any (its importer asks Python 3.11 for a mode of open() that is gone).
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

# Formats whose plain colours are display values here; Blender takes them for light.
DISPLAYED = ('obj', 'dae')
FORMATS = ['obj', 'glb', 'ply', 'gltf', 'dae', 'fbx']


# ---- in Blender -----------------------------------------------------------------------------------

def make_picture(bpy, name, size, colour_at, folder):
    """A PNG file whose texel (x, y), rows from the bottom, has the display colour colour_at(x, y)."""
    import numpy
    picture = bpy.data.images.new(name, size, size, alpha=True)
    pixels = numpy.array([[colour_at(x, y) for x in range(size)] for y in range(size)])
    picture.pixels = (pixels / 255).ravel()
    picture.filepath_raw = os.path.join(folder, name + '.png')
    picture.file_format = 'PNG'
    picture.save()
    return bpy.data.images.load(picture.filepath_raw)


def material_of(bpy, name, colour=None, normals=None, holes=False, plain=(0.8, 0.3, 0.1, 1)):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    shader = nodes['Principled BSDF']
    shader.inputs['Base Color'].default_value = plain
    if colour:
        texture = nodes.new('ShaderNodeTexImage')
        texture.image = colour
        links.new(texture.outputs['Color'], shader.inputs['Base Color'])
        if holes:
            links.new(texture.outputs['Alpha'], shader.inputs['Alpha'])
            material.blend_method = 'CLIP'
    if normals:
        normals.colorspace_settings.name = 'Non-Color'
        texture, node = nodes.new('ShaderNodeTexImage'), nodes.new('ShaderNodeNormalMap')
        texture.image = normals
        links.new(texture.outputs['Color'], node.inputs['Color'])
        links.new(node.outputs['Normal'], shader.inputs['Normal'])
    return material


def make_models(bpy, folder):
    squares = [(200, 60, 40), (40, 170, 70), (50, 80, 200), (230, 220, 90)]
    checks = make_picture(bpy, 'checks', 64, lambda x, y: squares[x // 32 + y // 32 * 2] + (255,), folder)
    stripes = make_picture(bpy, 'stripes', 32,
                           lambda x, y: ((220, 40, 60, 255) if x < 16 else (240, 240, 225, 255)), folder)
    leaf = make_picture(bpy, 'leaf', 64, lambda x, y: (60, 140, 50, 255 if abs(x - 32) + abs(y - 32) < 28 else 0),
                        folder)
    waves = make_picture(bpy, 'waves', 64,
                         lambda x, y: (128 + (60 if x % 16 < 8 else -60), 128, 240, 255), folder)

    def finish(name, materials):
        thing = bpy.context.object
        thing.name = thing.data.name = name
        for material in materials:
            thing.data.materials.append(material)
        for kind, call in (('glb', lambda p: bpy.ops.export_scene.gltf(filepath=p, use_selection=True)),
                           ('obj', lambda p: bpy.ops.wm.obj_export(filepath=p, export_selected_objects=True,
                                                                   export_pbr_extensions=True))):
            call(os.path.join(folder, f'{name}.{kind}'))
        bpy.ops.object.delete()

    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete()
    bpy.ops.mesh.primitive_monkey_add(calc_uvs=True)
    finish('monkey', [material_of(bpy, 'fur', checks, waves)])
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6)
    finish('leaves', [material_of(bpy, 'leaf', leaf, holes=True)])
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=12, y_subdivisions=12)
    cloth = bpy.context.object.data
    for corner in cloth.uv_layers[0].data:
        corner.uv = (3 * corner.uv[0] - 0.5, 2 * corner.uv[1])
    colours = cloth.color_attributes.new('Col', 'FLOAT_COLOR', 'POINT')
    for i, v in enumerate(cloth.vertices):
        colours.data[i].color = (0.5 + 0.4 * v.co.x, 0.5 + 0.4 * v.co.y, 0.3, 1)
    finish('cloth', [material_of(bpy, 'stripes', stripes)])
    bpy.ops.mesh.primitive_cube_add()
    for polygon in bpy.context.object.data.polygons:
        polygon.material_index = polygon.index % 2
    finish('two_parts', [material_of(bpy, 'textured', checks), material_of(bpy, 'plain')])


def read_into(bpy, path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    kind = path.rsplit('.', 1)[1].lower()
    call = {'obj': lambda: bpy.ops.wm.obj_import(filepath=path),
            'glb': lambda: bpy.ops.import_scene.gltf(filepath=path),
            'gltf': lambda: bpy.ops.import_scene.gltf(filepath=path),
            'ply': lambda: bpy.ops.import_mesh.ply(filepath=path),
            'fbx': lambda: bpy.ops.import_scene.fbx(filepath=path),
            'dae': lambda: bpy.ops.wm.collada_import(filepath=path)}[kind]
    call()


def display(c):
    c = min(max(c, 0.0), 1.0)
    return 255 * (12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055)


def linear(c):
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


class Look:
    """What a material of Blender says of colour, as far as the files can."""

    def __init__(self, material, displayed=False):
        import numpy
        self.factor, self.pixels, self.normals, self.clips = (0.8, 0.8, 0.8), None, False, False
        if material is None:
            return
        self.clips = material.blend_method in ('CLIP', 'HASHED', 'BLEND')
        shader = next((n for n in (material.node_tree.nodes if material.use_nodes else [])
                       if n.type == 'BSDF_PRINCIPLED'), None)
        if shader is None:
            self.factor = tuple(material.diffuse_color)[:3]
            return
        base = shader.inputs['Base Color']
        self.factor = tuple(base.default_value)[:3]
        self.normals = bool(shader.inputs['Normal'].links)
        found = [link.from_node for link in base.links]
        if found:
            self.factor = (1, 1, 1)
        while found:
            node = found.pop()
            if node.type == 'TEX_IMAGE' and node.image and node.image.size[0]:
                width, height = node.image.size
                self.pixels = numpy.array(node.image.pixels[:]).reshape(height, width, 4)
            for socket in node.inputs:
                if socket.links:
                    found.append(socket.links[0].from_node)
                elif node.type == 'MIX_RGB' and socket.type == 'RGBA':
                    self.factor = tuple(socket.default_value)[:3]
                elif node.type == 'MIX' and socket.type == 'RGBA' and socket.enabled:
                    self.factor = tuple(socket.default_value)[:3]

        if displayed and self.pixels is None:
            self.factor = tuple(linear(c) for c in self.factor)

    def at(self, uv):
        if self.pixels is None or uv is None:
            return tuple(display(c) for c in self.factor)
        height, width = self.pixels.shape[:2]
        texel = self.pixels[int(uv[1] % 1 * height) % height][int(uv[0] % 1 * width) % width]
        return tuple(display(f * linear(t)) for f, t in zip(self.factor, texel))


def surface(bpy, kind):
    """All triangles in the world, z up, with what colours them; and which things there are."""
    from mathutils import Vector
    triangles, has = [], {'uv': False, 'picture': False, 'normals': False, 'holes': False, 'vertex': False,
                          'quads': False}
    for thing in bpy.context.scene.objects:
        if thing.type != 'MESH':
            continue
        mesh = thing.data
        mesh.calc_loop_triangles()
        looks = [Look(m, kind in DISPLAYED) for m in mesh.materials] or [Look(None)]
        uvs = mesh.uv_layers.active
        colours = mesh.color_attributes[0] if len(mesh.color_attributes) else None
        has['uv'] |= uvs is not None
        has['vertex'] |= colours is not None
        has['quads'] |= any(len(polygon.vertices) > 3 for polygon in mesh.polygons)
        for look in looks:
            has['picture'] |= look.pixels is not None
            has['normals'] |= look.normals
            has['holes'] |= look.clips
        for t in mesh.loop_triangles:
            corners = [thing.matrix_world @ mesh.vertices[v].co for v in t.vertices]
            if kind == 'ply':  # whose importer turns nothing
                corners = [Vector((c[0], -c[2], c[1])) for c in corners]
            own = None
            if colours:
                index = t.loops if colours.domain == 'CORNER' else t.vertices
                own = [Vector(colours.data[i].color[:3]) for i in index]
            triangles.append((corners, looks[min(t.material_index, len(looks) - 1)],
                              [Vector((*uvs.data[i].uv, 0)) for i in t.loops] if uvs else None, own))
    return triangles, has


def seen_at(triangle, point):
    """The colour and the vertex colour of a triangle at a point, in levels of 255."""
    from mathutils.geometry import barycentric_transform
    corners, look, uv, own = triangle
    colour = look.at(barycentric_transform(point, *corners, *uv) if uv else None)
    if own:
        own = [display(c) for c in barycentric_transform(point, *corners, *own)]
    return colour, own


def compared(first, second):
    """The shares of the area whose colours, and vertex colours, agree within 2; the farthest place."""
    from mathutils import Vector
    from mathutils.bvhtree import BVHTree
    corners = [c for triangle in second for c in triangle[0]]
    tree = BVHTree.FromPolygons(corners, [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(len(second))])
    size = max((t[0][0] - first[0][0][0]).length for t in first) or 1
    area = same = same_vertex = off = 0
    for triangle in first:
        a, b, c = triangle[0]
        own_area = (b - a).cross(c - a).length / 2
        if own_area == 0:
            continue
        place = a * 0.4 + b * 0.35 + c * 0.25
        colour, vertex = seen_at(triangle, place)
        away = tree.find_nearest(place)[3]
        off = max(off, away / size)
        # Of several faces in one place, that which agrees best.
        seen = [seen_at(second[i], at) for at, _, i, _ in tree.find_nearest_range(place, 1.01 * away + 1e-4 * size)]
        area += own_area
        same += own_area * any(max(abs(p - q) for p, q in zip(colour, s)) <= 2 for s, _ in seen)
        if vertex:
            same_vertex += own_area * any(o and max(abs(p - q) for p, q in zip(vertex, o)) <= 2
                                          for _, o in seen)
    return same / area, same_vertex / area, off


def in_blender(job):
    import bpy
    import numpy
    if not hasattr(numpy, 'bool'):
        numpy.bool = bool  # Blender 3.4 asks a newer NumPy for it
    if job['do'] == 'make':
        make_models(bpy, job['folder'])
        return {}
    read_into(bpy, job['original'])
    original, had = surface(bpy, job['original'].rsplit('.', 1)[1].lower())
    answer = {'had': had}
    for kind, path in job['files'].items():
        try:
            read_into(bpy, path)
            triangles, has = surface(bpy, kind)
            same, vertex, off = compared(original, triangles)
            answer[kind] = {'same': same, 'vertex': vertex, 'off': off, 'has': has}
        except Exception as error:  # of any importer: said in the table
            answer[kind] = {'error': str(error).strip().splitlines()[-1]}
    return answer


# ---- outside --------------------------------------------------------------------------------------

def blender(job):
    with tempfile.NamedTemporaryFile('w+', suffix='.json') as asked, tempfile.NamedTemporaryFile('r') as told:
        json.dump({**job, 'to': told.name}, asked)
        asked.flush()
        run = subprocess.run(['blender', '-b', '--factory-startup', '--python-exit-code', '3', '--python',
                              os.path.abspath(__file__), '--', asked.name], capture_output=True, text=True,
                             env={**os.environ, 'PATH': '/usr/bin:/bin'})  # Debian's own Python, with its NumPy
        if run.returncode:
            sys.exit(run.stdout[-3000:] + run.stderr[-3000:])
        return json.load(told)


def written_by_aspic(aspic, model, folder):
    nodes = {'read': {'type': 'ReadMesh@1', 'params': {'path': os.path.abspath(model)}}}
    for kind in FORMATS:
        nodes[kind] = {'type': 'WriteMesh@1', 'inputs': {'mesh': 'read.mesh'},
                       'params': {'path': f'{kind}/m.{kind}'}}
    graph = os.path.join(folder, 'graph.json')
    with open(graph, 'w') as file:
        json.dump({'aspic': 1, 'frames': {'first': 1, 'last': 1}, 'nodes': nodes}, file)
    run = subprocess.run([aspic, 'cook', graph, '--out', folder, '--no-disk-cache', '--keep-going',
                          '--allow-outside'], capture_output=True, text=True)
    if run.returncode:
        print(run.stdout[-2000:], run.stderr[-2000:])
    said = [line for line in (run.stdout + run.stderr).splitlines() if 'warning' in line.lower()]
    return {k: p for k in FORMATS if os.path.exists(p := os.path.join(folder, k, f'm.{k}'))}, said


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('models', nargs='*')
    parser.add_argument('--aspic', default='build/release/aspic')
    parser.add_argument('--keep', help='folder for the files, which is kept')
    options = parser.parse_args()
    kept_while_running = None if options.keep else tempfile.TemporaryDirectory()
    top = options.keep or kept_while_running.name
    made = os.path.join(top, 'made')
    os.makedirs(made, exist_ok=True)
    blender({'do': 'make', 'folder': made})
    models = [os.path.join(made, f'{n}.{k}') for n in ('monkey', 'leaves', 'cloth', 'two_parts')
              for k in ('glb', 'obj')] + options.models
    print('| model | format | colour | vertex colour | uv | picture | normal map | holes | quads |\n' + '|---' * 9 + '|')
    for model in models:
        name = os.path.basename(model)
        folder = os.path.join(top, name.replace('.', '_'))
        os.makedirs(folder, exist_ok=True)
        files, said = written_by_aspic(options.aspic, model, folder)
        told = blender({'do': 'compare', 'original': os.path.abspath(model), 'files': files})
        had = told['had']

        def mark(there, before):
            return ('yes' if there else '**lost**') if before else ('added' if there else '-')
        for kind in FORMATS:
            if kind not in told:
                print(f'| {name} | {kind} | not written |')
                continue
            t = told[kind]
            if 'error' in t:
                print(f'| {name} | {kind} | {t["error"]} |')
                continue
            has = t['has']
            place = '' if t['off'] < 1e-3 else f' (moved by {t["off"]:.3f})'
            vertex = f'{100 * t["vertex"]:.1f} %' if had['vertex'] else '-'
            print(f'| {name} | {kind} | {100 * t["same"]:.1f} %{place} | {vertex} | ' +
                  ' | '.join(mark(has[k], had[k]) for k in ('uv', 'picture', 'normals', 'holes', 'quads')) + ' |')
        for line in said:
            print('    ' + line)


if __name__ == '__main__':
    if '--' in sys.argv:
        with open(sys.argv[sys.argv.index('--') + 1]) as file:
            asked = json.load(file)
        answer = in_blender(asked)
        with open(asked['to'], 'w') as file:
            json.dump(answer, file)
    else:
        main()
