# SPDX-License-Identifier: Apache-2.0
"""Writes a character by the ways that lead out of Blender:
blender -b --factory-startup --python blender_routes.py -- CHARACTER.gltf FOLDER
Each is the same character in the same place. What differs is the format, and in what units and axes
the armature's own data are: as they came; in centimetres with Y up under an armature scaled by 0.01
and turned, which is what an import of FBX makes; turned by some angle; the mesh unparented; all of it
under a group."""
import math
import sys

import numpy

numpy.bool = bool  # Blender 3.4's importer of glTF was written for an older numpy
import bpy  # noqa: E402
from mathutils import Matrix  # noqa: E402

CHARACTER, FOLDER = sys.argv[sys.argv.index("--") + 1 :]
CENTIMETRES = Matrix.Rotation(math.radians(90), 4, "X") @ Matrix.Scale(0.01, 4)
TURNED = Matrix.Rotation(math.radians(37), 4, "Z") @ Matrix.Translation((0.3, 0.2, 0.1))


def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def rigs():
    return [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]


def skins():
    return [
        thing
        for thing in bpy.data.objects
        if thing.type == "MESH" and any(m.type == "ARMATURE" for m in thing.modifiers)
    ]


def as_it_came():
    pass


def scale_locations(factor):
    for action in bpy.data.actions:
        for curve in action.fcurves:
            if "pose.bones" not in curve.data_path or not curve.data_path.endswith(".location"):
                continue
            for key in curve.keyframe_points:
                for point in (key.co, key.handle_left, key.handle_right):
                    point[1] *= factor


def rebase(world):
    """Armatures and their meshes get this matrix, and their data its inverse."""
    places = {thing: thing.matrix_world.copy() for thing in skins()}
    for rig in rigs():
        into = world.inverted() @ rig.matrix_world
        rig.parent = None
        rig.data.transform(into)
        rig.matrix_world = world
        scale_locations(into.to_scale()[0])
    for thing, place in places.items():
        thing.data.transform(world.inverted() @ place, shape_keys=True)
        if thing.parent:
            thing.matrix_parent_inverse = thing.matrix_basis = Matrix.Identity(4)
        else:
            thing.matrix_world = world
    bpy.context.view_layer.update()


def in_centimetres():
    rebase(CENTIMETRES)


def turned():
    rebase(TURNED)


def unparented():
    for thing in skins():
        place = thing.matrix_world.copy()
        thing.parent = None
        thing.matrix_world = place
    bpy.context.view_layer.update()


def unparented_in_centimetres():
    in_centimetres()
    unparented()


def grouped():
    group = bpy.data.objects.new("group", None)
    bpy.context.collection.objects.link(group)
    group.matrix_world = CENTIMETRES
    bpy.context.view_layer.update()
    for rig in rigs():
        place = rig.matrix_world.copy()
        rig.parent = group
        rig.matrix_world = place
    bpy.context.view_layer.update()


def write(name, ending):
    file = f"{FOLDER}/{name}.{ending}"
    if ending == "glb":
        bpy.ops.export_scene.gltf(filepath=file, export_format="GLB")
    elif ending == "fbx":
        bpy.ops.export_scene.fbx(filepath=file)
    else:
        bpy.ops.wm.collada_export(filepath=file)


STATES = [as_it_came, in_centimetres, turned, unparented, unparented_in_centimetres, grouped]
for state in STATES:
    for ending in ("glb", "fbx", "dae"):
        if state is unparented and ending == "dae":
            continue  # Blender writes each bone twice then, under one identifier
        empty()
        bpy.ops.import_scene.gltf(filepath=CHARACTER)
        state()
        write(state.__name__, ending)
for state in (as_it_came, in_centimetres):  # FBX and back to glTF
    empty()
    bpy.ops.import_scene.fbx(filepath=f"{FOLDER}/{state.__name__}.fbx")
    write(f"{state.__name__}_by_fbx", "glb")
