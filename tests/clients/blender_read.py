# SPDX-License-Identifier: Apache-2.0
"""Reads the exports in Blender:
blender -b --factory-startup --python blender_read.py -- blender|alembic FOLDER…
Alembic by itself: blender.org's Blender has its importer, Debian's has not, and exits with 77."""
import json
import os
import sys
import traceback

import numpy

numpy.bool = bool  # Blender 3.4's importer of glTF was written for an older numpy
import bpy  # noqa: E402

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from truth import Comparison, load  # noqa: E402

CLIENT = "Blender " + bpy.app.version_string


def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def vertices(data):
    values = numpy.empty(3 * len(data.vertices), dtype="f4")
    data.vertices.foreach_get("co", values)
    return values.reshape(-1, 3)


def triangles(data):
    return [list(polygon.vertices) for polygon in data.polygons]


def evaluated(thing, frame):
    bpy.context.scene.frame_set(frame)
    return vertices(thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).data)


def placed(thing, frame):
    """Where an object that moves as a whole has its vertices."""
    read = evaluated(thing, frame)
    place = numpy.array(thing.matrix_world)
    return read @ place[:3, :3].T + place[:3, 3]


def y_up(read):
    return numpy.stack([read[:, 0], read[:, 2], -read[:, 1]], axis=1)


def point_cache(folder, truth, ending):
    mesh = next(m for m in truth["meshes"] if m["name"] == truth["one"])
    result = Comparison(CLIENT, f"{folder}/one.{ending}", 0.0, floats=True)
    empty()
    bpy.ops.wm.obj_import(filepath=f"{folder}/one.rest.obj")
    thing = bpy.context.object
    result.same("triangles", triangles(thing.data), mesh["triangles"])
    cache = thing.modifiers.new("cache", "MESH_CACHE")
    cache.cache_format = ending.upper()
    cache.filepath = f"{folder}/one.{ending}"
    cache.frame_start = truth["frames"][0]
    for i, frame in enumerate(truth["frames"]):
        result.add(f"frame {frame}", evaluated(thing, frame), mesh["positions"][i])
    return result.tell()


def obj(folder, truth):
    result = Comparison(CLIENT, f"{folder}/obj", 0.0, floats=True)
    for i, frame in enumerate(truth["frames"]):
        empty()
        bpy.ops.wm.obj_import(filepath=f"{folder}/obj/all.{frame:04d}.obj")
        for mesh in truth["meshes"]:
            data = bpy.data.objects[mesh["name"]].data
            result.add(f"{mesh['name']}, frame {frame}", vertices(data), mesh["positions"][i])
            result.same(f"{mesh['name']}, triangles", triangles(data), mesh["triangles"])
    return result.tell()


def ply(folder, truth):
    mesh = next(m for m in truth["meshes"] if m["name"] == truth["one"])
    result = Comparison(CLIENT, f"{folder}/ply", 0.0, floats=True)
    for i, frame in enumerate(truth["frames"]):
        empty()
        read = bpy.ops.wm.ply_import if "ply_import" in dir(bpy.ops.wm) else bpy.ops.import_mesh.ply
        read(filepath=f"{folder}/ply/one.{frame:04d}.ply")
        data = bpy.context.object.data
        result.add(f"frame {frame}", vertices(data), mesh["positions"][i])
        result.same("triangles", triangles(data), mesh["triangles"])
    return result.tell()


def glb(folder, truth, name, allowed):
    result = Comparison(CLIENT, f"{folder}/{name}", allowed)
    empty()
    bpy.context.scene.render.fps = int(truth["fps"])
    bpy.ops.import_scene.gltf(filepath=f"{folder}/{name}")
    for mesh in truth["meshes"]:
        thing = bpy.data.objects[mesh["name"]]
        for i, frame in enumerate(truth["frames"]):
            read = placed(thing, frame)  # time is frame / fps
            result.add(f"{mesh['name']}, frame {frame}", y_up(read), mesh["positions"][i])
        result.same(f"{mesh['name']}, triangles", triangles(thing.data), mesh["triangles"])
    return result.tell()


def alembic(folder, truth):
    # At a frame its reader may stand a rounding of the time away, and blends two samples there.
    result = Comparison(CLIENT, f"{folder}/all.abc", 1e-6)
    empty()
    bpy.context.scene.render.fps = int(truth["fps"])
    bpy.ops.wm.alembic_import(filepath=f"{folder}/all.abc", as_background_job=False)
    for mesh in truth["meshes"]:
        thing = bpy.data.objects[mesh["name"]]
        for i, frame in enumerate(truth["frames"]):  # time is frame / fps
            read = placed(thing, frame)
            result.add(f"{mesh['name']}, frame {frame}", y_up(read), mesh["positions"][i])
        result.same(f"{mesh['name']}, triangles", triangles(thing.data), mesh["triangles"])
    return result.tell()


def same_order(folder, truth):
    """The skin that came out is the character's own mesh: Blender reads both, vertex by vertex."""
    skin = next(m for m in truth["meshes"] if m["name"] == "skin")
    result = Comparison(CLIENT, f"{folder}/input.gltf", 1e-6)
    empty()
    bpy.ops.import_scene.gltf(filepath=f"{folder}/input.gltf")
    thing = next(t for t in bpy.data.objects if t.type == "MESH" and t.vertex_groups)
    result.same("triangles", triangles(thing.data), skin["triangles"])
    read = vertices(thing.data)
    # What goes with the hips is below the muscles and stands still while the elbows bend.
    hips = thing.vertex_groups["Hips"].index
    still = [v.index for v in thing.data.vertices
             if any(g.group == hips and g.weight > 0 for g in v.groups)]
    for i, frame in enumerate(truth["frames"]):
        result.add(f"hips, frame {frame}", y_up(read)[still], skin["positions"][i][still])
    return result.tell()


PIECES = ("hat", "trunk", "arms")  # meshes of the dressed figure, in the order of the bake's skin


def object_of(mesh):
    """Objects are named after nodes or meshes, as Blender needs more objects than a file has."""
    return next(t for t in bpy.data.objects if t.type == "MESH" and t.data.name == mesh)


def look(file):
    """Texture coordinates and materials of each piece, as Blender has them."""
    empty()
    bpy.ops.import_scene.gltf(filepath=file)
    found = {}
    for name in PIECES:
        data = object_of(name).data
        uvs = [numpy.array([tuple(c.uv) for c in layer.data]) for layer in data.uv_layers]
        found[name] = (uvs, [m.name for m in data.materials], triangles(data))
    return found


def stated_in(name):
    """m, as the file states it."""
    with open(name, "rb") as file:
        head = file.read(20)
        text = json.loads(file.read(int.from_bytes(head[12:16], "little")))
    return 1e-3 * text["asset"]["extras"]["position_error_max_mm"]


def onto(folder, truth, name):
    """The character's own file with its skin as baked, within the error that the file states."""
    stated = stated_in(f"{folder}/{name}.glb")
    result = Comparison(CLIENT, f"{folder}/{name}.glb", stated + 1e-6)
    before, after = look(f"{folder}/input.gltf"), look(f"{folder}/{name}.glb")
    for piece in PIECES:
        for layer, was in zip(after[piece][0], before[piece][0]):
            result.same(f"{piece}, texture coordinates", layer, was)
        result.same(f"{piece}, materials", after[piece][1], before[piece][1])
        result.same(f"{piece}, triangles", after[piece][2], before[piece][2])
    empty()
    bpy.context.scene.render.fps = int(truth["fps"])
    bpy.ops.import_scene.gltf(filepath=f"{folder}/{name}.glb")
    skin = next(m for m in truth["meshes"] if m["name"] == "skin")
    for i, frame in enumerate(truth["frames"]):
        read = numpy.concatenate([placed(object_of(piece), frame) for piece in PIECES])
        result.add(f"frame {frame}", y_up(read), skin["positions"][i])
    return result.tell()


def caches_onto(folder, truth):
    """Each of the artist's own objects with its point cache on it."""
    result = Comparison(CLIENT, f"{folder}/caches", 0.0, floats=True)
    skin = next(m for m in truth["meshes"] if m["name"] == "skin")
    empty()
    bpy.ops.import_scene.gltf(filepath=f"{folder}/input.gltf")
    things = [object_of(piece) for piece in PIECES]
    for thing in things:
        for modifier in list(thing.modifiers):
            thing.modifiers.remove(modifier)
        cache = thing.modifiers.new("cache", "MESH_CACHE")
        cache.cache_format = "PC2"
        cache.filepath = f"{folder}/caches.{thing.data.name.title()}.pc2"
        if thing.data.name == "trunk":
            cache.filepath = f"{folder}/caches.Body.pc2"  # files are named after nodes
        cache.frame_start = truth["frames"][0]
    for i, frame in enumerate(truth["frames"]):
        read = numpy.concatenate([evaluated(thing, frame) for thing in things])
        result.add(f"frame {frame}", read, skin["positions"][i])
    return result.tell()


def stated_error(folder):
    with open(f"{folder}/basis.txt") as text:
        return 1e-3 * float(text.read().split("position error ")[1].split(" mm")[0])


def exports(folder, truth):
    if folder.endswith("/onto"):
        names = ("onto", "onto_basis", "correctives", "correctives_basis")
        return all([onto(folder, truth, name) for name in names] + [caches_onto(folder, truth)])
    good = point_cache(folder, truth, "pc2")
    good &= point_cache(folder, truth, "mdd")
    good &= obj(folder, truth)
    good &= ply(folder, truth)
    good &= glb(folder, truth, "all.glb", 1e-6)
    good &= glb(folder, truth, "basis.glb", stated_error(folder) + 1e-6)
    good &= glb(folder, truth, "quantized.glb", stated_in(f"{folder}/quantized.glb") + 1e-6)
    if os.path.exists(f"{folder}/input.gltf"):
        good &= same_order(folder, truth)
    return good


what, *folders = sys.argv[sys.argv.index("--") + 1:]
good = True
try:
    if what == "alembic" and not bpy.app.build_options.alembic:
        print(f"skipped: {CLIENT} was built without Alembic; BLENDER=PATH names blender.org's",
              flush=True)
        os._exit(77)
    for folder in folders:
        good &= (alembic if what == "alembic" else exports)(folder, load(folder))
except Exception:
    traceback.print_exc()
    good = False
sys.stdout.flush()
os._exit(0 if good else 1)  # Blender's own exit code says nothing of the script
