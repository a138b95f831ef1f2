# SPDX-License-Identifier: Apache-2.0
"""What own.sh has made, against the bake itself: own_check.py FOLDER. Writes FOLDER/truth.npz, the
positions of the artist's vertices as bake.h5 and the numbers in own.glb have them."""
import json
import re
import struct
import sys

import h5py
import numpy

SAME_BAKE = 1e-4  # m, of one character by two ways
folder = sys.argv[1]


def numbers_of(file):
    """_thew_vertex of all vertices as the bake has them, node by node; -1 of other meshes."""
    data = open(file, "rb").read()
    length = struct.unpack("<I", data[12:16])[0]
    document, binary = json.loads(data[20 : 20 + length]), data[28 + length :]
    numbers = []

    def visit(index):
        node = document["nodes"][index]
        mesh = document["meshes"][node["mesh"]] if "mesh" in node else {"primitives": []}
        for primitive in mesh["primitives"]:
            names = [n for n in primitive["attributes"] if n.strip("_") == "THEW_VERTEX"]
            accessor = document["accessors"][primitive["attributes"][(names + ["POSITION"])[0]]]
            if not names:
                numbers.append(numpy.full(accessor["count"], -1))
                continue
            view = document["bufferViews"][accessor["bufferView"]]
            start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            numbers.append(numpy.frombuffer(binary, "<f4", accessor["count"], start).astype(int))
        for child in node.get("children", []):
            visit(child)

    for root in document["scenes"][document.get("scene", 0)]["nodes"]:
        visit(root)
    return numpy.concatenate(numbers)


def points_of(file):
    data = open(file, "rb").read()
    count, _, _, samples = struct.unpack("<iffi", data[16:32])
    return numpy.frombuffer(data, "<f4", 3 * count * samples, 32).reshape(samples, count, 3)


with h5py.File(f"{folder}/glb/bake.h5") as bake:
    skin, frames = bake["meshes/skin/positions"][:], bake["frames"][:]
numbers = numbers_of(f"{folder}/own.glb")
assert len(numbers) == skin.shape[1]
truth = numpy.empty((len(skin), numbers.max() + 1, 3), "f4")
truth[:, numbers[numbers >= 0]] = skin[:, numbers >= 0]
numpy.savez(f"{folder}/truth.npz", frames=frames, positions=truth)
placed = points_of(f"{folder}/glb/placed.pc2")
assert (placed == truth).all()
apart = numpy.abs(points_of(f"{folder}/fbx/placed.pc2") - truth).max()
assert apart <= SAME_BAKE, apart

# Faces as the artist has them, in USD.
wanted = [len(line.split()) - 1 for line in open(f"{folder}/own.obj") if line.startswith("f ")]
text = open(f"{folder}/glb/own.usda").read()
text = text[text.index('def Mesh "skin"') :]
found = json.loads(re.search(r"faceVertexCounts = (\[[^]]*\])", text)[1])
assert found == wanted
print(
    f"  {len(wanted)} faces, {wanted.count(4)} of them quads; {truth.shape[1]} vertices in their "
    f"order; by FBX within {apart:.2g} m of the same by glTF"
)
