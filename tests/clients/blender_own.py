# SPDX-License-Identifier: Apache-2.0
"""An artist's own object in Blender: make_own writes it, as its artist has it, and check_own puts
point caches back onto it.
blender -b --factory-startup --python blender_own.py -- make CHARACTER.gltf FOLDER
blender -b --factory-startup --python blender_own.py -- check FOLDER BAKE.h5 CACHE.pc2 FRAME_START
The object has one vertex a place, quads where two triangles make one, and vertices in an order that
no exporter keeps. It is written as glTF with the point attribute _thew_vertex, as FBX, and as OBJ."""
import random
import sys

import numpy

numpy.bool = bool  # Blender 3.4's importer of glTF was written for an older numpy
import bpy  # noqa: E402

WORDS = sys.argv[sys.argv.index("--") + 1 :]


def skin():
    """The largest mesh that follows an armature."""
    return max(
        (
            thing
            for thing in bpy.data.objects
            if thing.type == "MESH" and any(m.type == "ARMATURE" for m in thing.modifiers)
        ),
        key=lambda thing: len(thing.data.vertices),
    )


def make(character, folder):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=character)
    own = skin()
    own.name = "own"
    bpy.context.view_layer.objects.active = own
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.remove_doubles(threshold=1e-6)
    bpy.ops.mesh.tris_convert_to_quads()
    bpy.ops.mesh.select_all(action="SELECT")
    random.seed(1)
    bpy.ops.mesh.sort_elements(type="RANDOMIZE", elements={"VERT"}, seed=3)
    bpy.ops.object.mode_set(mode="OBJECT")
    count = len(own.data.vertices)
    own.data.attributes.new("_thew_vertex", "FLOAT", "POINT").data.foreach_set(
        "value", [float(i) for i in range(count)]
    )
    quads = sum(len(face.vertices) == 4 for face in own.data.polygons)
    print(f"own object: {count} vertices, {quads} quads of {len(own.data.polygons)} faces")
    assert quads > len(own.data.polygons) / 4
    bpy.ops.wm.save_as_mainfile(filepath=f"{folder}/own.blend")
    bpy.ops.export_scene.gltf(
        filepath=f"{folder}/own.glb", export_attributes=True, export_animations=False
    )
    bpy.ops.export_scene.fbx(filepath=f"{folder}/own.fbx", add_leaf_bones=False, bake_anim=False)
    for thing in bpy.data.objects:
        thing.select_set(thing == own)
    for modifier in own.modifiers:
        modifier.show_viewport = False
    bpy.ops.wm.obj_export(
        filepath=f"{folder}/own.obj", export_selected_objects=True, apply_modifiers=False
    )


def check(folder, points, cache, start):
    """`points`: positions by frame of the vertices that the bake has at the places of these."""
    bpy.ops.wm.open_mainfile(filepath=f"{folder}/own.blend")
    own = bpy.data.objects["own"]
    own.modifiers.clear()
    own.parent = None
    own.matrix_world.identity()
    modifier = own.modifiers.new("thew", "MESH_CACHE")
    modifier.cache_format = "PC2"
    modifier.filepath = cache
    modifier.forward_axis, modifier.up_axis = "POS_Z", "NEG_Y"  # as the export says
    modifier.frame_start = float(start)
    faces = [len(face.vertices) for face in own.data.polygons]
    truth = numpy.load(points)
    worst = 0.0
    for number, wanted in zip(truth["frames"], truth["positions"]):
        bpy.context.scene.frame_set(int(number))
        mesh = own.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        found = numpy.empty(3 * len(mesh.vertices))
        mesh.vertices.foreach_get("co", found)
        found = found.reshape(-1, 3)
        assert [len(face.vertices) for face in mesh.polygons] == faces
        assert len(mesh.uv_layers) == len(own.data.uv_layers)
        x, y, z = wanted.T
        worst = max(worst, numpy.abs(found - numpy.stack([x, -z, y], 1)).max())
    print(f"own object: within {worst:.2g} m of the bake in {len(truth['frames'])} frames")
    assert worst <= 1e-6


{"make": make, "check": check}[WORDS[0]](*WORDS[1:])
