# SPDX-License-Identifier: Apache-2.0
"""Makes a person with a rig of Rigify's, which comes with Blender, that bends its arms and chest in an
animation, and writes it by all its bones and by those alone that deform it:
blender -b --factory-startup --python blender_rigify.py -- FOLDER"""
import math
import sys

import numpy

numpy.bool = bool  # Blender 3.4's exporter of glTF was written for an older numpy
import bmesh  # noqa: E402
import bpy  # noqa: E402
from mathutils import Matrix  # noqa: E402

FOLDER = sys.argv[sys.argv.index("--") + 1]
RADII = {  # m, about the bones of the rig that is generated from
    "spine": 0.13, "spine.001": 0.13, "spine.002": 0.14, "spine.003": 0.14, "spine.004": 0.06,
    "spine.005": 0.06, "spine.006": 0.09, "shoulder": 0.05, "upper_arm": 0.045, "forearm": 0.035,
    "hand": 0.035, "thigh": 0.08, "shin": 0.055, "foot": 0.04, "toe": 0.03,
}  # fmt: skip


def radius_of(bone):
    name = bone.name.removesuffix(".L").removesuffix(".R")
    return 0.011 if name.startswith(("f_", "thumb", "palm")) else RADII.get(name)


def body_around(bones):
    """Balls along the bones, melted into one skin."""
    balls = bmesh.new()
    for bone in bones:
        radius = radius_of(bone)
        if radius is None:
            continue
        steps = max(2, int(bone.length / (0.35 * radius)))
        for step in range(steps + 1):
            at = bone.head_local.lerp(bone.tail_local, step / steps)
            bmesh.ops.create_icosphere(
                balls, subdivisions=2, radius=radius, matrix=Matrix.Translation(at)
            )
    mesh = bpy.data.meshes.new("body")
    balls.to_mesh(mesh)
    body = bpy.data.objects.new("body", mesh)
    bpy.context.collection.objects.link(body)
    bpy.context.view_layer.objects.active = body
    for kind, settings in (
        ("REMESH", {"mode": "VOXEL", "voxel_size": 0.006}),
        ("SMOOTH", {"factor": 0.5, "iterations": 6}),
        ("DECIMATE", {"ratio": 0.15}),
    ):
        modifier = body.modifiers.new(kind, kind)
        for name, value in settings.items():
            setattr(modifier, name, value)
        bpy.ops.object.modifier_apply(modifier=kind)
    return body


def key(rig, bone, frame, degrees):
    bone = rig.pose.bones[bone]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler = [math.radians(angle) for angle in degrees]
    bone.keyframe_insert("rotation_euler", frame=frame)


bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.preferences.addon_enable(module="rigify")
bpy.ops.object.armature_human_metarig_add()
plan = bpy.context.object
body = body_around(plan.data.bones)
bpy.context.view_layer.objects.active = plan
bpy.ops.pose.rigify_generate()
rig = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE" and thing != plan)
bpy.ops.object.select_all(action="DESELECT")
body.select_set(True)
rig.select_set(True)
bpy.context.view_layer.objects.active = rig
bpy.ops.object.parent_set(type="ARMATURE_AUTO")
bpy.data.objects.remove(plan)
for side in "LR":
    rig.pose.bones["upper_arm_parent." + side]["IK_FK"] = 1.0
for frame, share in ((1, 0.0), (24, 1.0)):
    key(rig, "upper_arm_fk.R", frame, (-40 * share, 0, 30 * share))
    key(rig, "forearm_fk.R", frame, (90 * share, 0, 0))
    key(rig, "forearm_fk.L", frame, (60 * share, 0, 0))
    key(rig, "chest", frame, (15 * share, 20 * share, 0))
bpy.context.scene.render.fps = 24
bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 24
for name, deforming in (("all", False), ("deforming", True)):
    bpy.ops.export_scene.gltf(
        filepath=f"{FOLDER}/{name}.glb", export_format="GLB", export_def_bones=deforming
    )
