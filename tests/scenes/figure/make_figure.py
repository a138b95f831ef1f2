# SPDX-License-Identifier: Apache-2.0
"""Writes figure.gltf: a made-up person for the tests. A trunk and two arms, closed shapes that
overlap, with seams along them; the bones run beside the middle of the flesh, the sections are no
circles, and the thickness differs from the template's in each. One animation has curves of all
kinds. Usage: make_figure.py figure.gltf [dressed.gltf], where the second is the same person as an
artist's program would write it: in pieces and materials, with normals, texture and a hat, in
centimetres under a turned armature, with fat painted on its arms."""
import base64
import json
import math
import struct
import sys
import zlib

AROUND = 14  # the last vertex of a ring is at the place of the first

# Joints: name, parent, place (m; y up, looks along +z), for the left; the right is its mirror.
JOINTS = [("Hips", -1, (0, 0.95, 0)), ("Chest", 0, (0, 1.25, 0))]
ARM = [("Shoulder", (0.05, 1.40, -0.01)), ("Arm", (0.17, 1.38, -0.02)),
       ("ForeArm", (0.37, 1.21, -0.035)), ("Hand", (0.53, 1.075, 0.02))]
for side, sign in (("Left", 1), ("Right", -1)):
    parent = 1
    for name, (x, y, z) in ARM:
        JOINTS.append((side + name, parent, (sign * x, y, z)))
        parent = len(JOINTS) - 1

vertices, triangles, joints, weights = [], [], [], []


def add(a, b, s):
    return tuple(p + s * q for p, q in zip(a, b))


def sub(a, b):
    return tuple(p - q for p, q in zip(a, b))


def unit(a):
    length = math.sqrt(sum(p * p for p in a))
    return tuple(p / length for p in a)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def tube(rings):
    """Rings: (middle, half axis a, half axis b, [(joint, weight), ...]); a point at either end."""
    first = len(vertices)
    count = 0
    for middle, a, b, bound in rings:
        turns = 1 if a == (0, 0, 0) else AROUND + 1
        for k in range(turns):
            angle = 2 * math.pi * (k % AROUND) / AROUND
            vertices.append(add(add(middle, a, math.cos(angle)), b, math.sin(angle)))
            bound_four = ([(j, w) for j, w in bound if w > 0] + [(0, 0.0)] * 4)[:4]
            joints.append([j for j, _ in bound_four])
            weights.append([w for _, w in bound_four])
            count += 1
    last = first + count - 1

    def put(a, b, c):
        triangles.append((a, c, b))

    rows = len(rings) - 2
    at = lambda row, k: first + 1 + row * (AROUND + 1) + k
    for k in range(AROUND):
        put(first, at(0, k), at(0, k + 1))
        put(last, at(rows - 1, k + 1), at(rows - 1, k))
        for row in range(rows - 1):
            put(at(row, k), at(row + 1, k), at(row + 1, k + 1))
            put(at(row, k), at(row + 1, k + 1), at(row, k + 1))


def smoothstep(t):
    t = min(max(t, 0.0), 1.0)
    return t * t * (3 - 2 * t)


def trunk():
    rings = []
    for i in range(12):
        u = i / 11
        size = 0.0 if i in (0, 11) else 1.0 - 0.45 * u ** 6
        share = smoothstep((u - 0.2) / 0.4)
        rings.append(((0, 0.86 + 0.62 * u, -0.01), (0.16 * size, 0, 0), (0, 0, -0.1 * size),
                      [(1, share), (0, 1 - share)]))
    rings[0] = (rings[0][0], (0, 0, 0), (0, 0, 0), [(0, 1.0)])
    rings[-1] = (rings[-1][0], (0, 0, 0), (0, 0, 0), [(1, 1.0)])
    tube(rings)


def limb(sign, base):
    """base: the shoulder's joint; along the bones, the middle of the flesh 8 mm before them."""
    places = [JOINTS[base + k][2] for k in range(4)]
    tip = add(places[3], sub(places[3], places[2]), 0.8)
    marks = [add(places[1], sub(places[2], places[1]), -0.35), places[1], places[2], places[3], tip]
    # By the way along: (section, half axis upwards, half axis forwards, m)
    sizes = [(0.0, 0.034, 0.034), (1.0, 0.052, 0.043), (1.5, 0.047, 0.038), (2.0, 0.035, 0.041),
             (2.35, 0.040, 0.036), (3.0, 0.020, 0.028), (3.4, 0.014, 0.04), (4.0, 0.009, 0.03)]
    rings = []
    steps = 34
    for i in range(steps + 1):
        s = 4.0 * i / steps
        k = min(int(s), 3)
        along = unit(sub(marks[k + 1], marks[k]))
        out = add(marks[k], sub(marks[k + 1], marks[k]), s - k)
        near = max(n for n in range(len(sizes) - 1) if sizes[n][0] <= s)
        u = (s - sizes[near][0]) / (sizes[near + 1][0] - sizes[near][0])
        up, fore = ((1 - u) * sizes[near][n] + u * sizes[near + 1][n] for n in (1, 2))
        b = unit(cross(cross(along, (0, 0, 1)), along))
        a = cross(b, along)
        middle = add(out, b, 0.008)
        shares = [1 - smoothstep((s - 0.7) / 0.5), 1 - smoothstep((s - 1.8) / 0.4),
                  1 - smoothstep((s - 2.85) / 0.3)]
        bound = [(base, shares[0]), (base + 1, shares[1] - shares[0]),
                 (base + 2, shares[2] - shares[1]), (base + 3, 1 - shares[2])]
        zero = i in (0, steps)
        none = (0.0, 0.0, 0.0)
        rings.append((middle, (0, 0, 0) if zero else add(none, a, up), add(none, b, fore), bound))
    tube(rings)


trunk()
starts = [0, len(vertices)]
limb(1, 2)
starts.append(len(vertices))
limb(-1, 6)
starts.append(len(vertices))

chunks, views, accessors = [], [], []


def accessor(values, kind, form, component, target=None, extent=False):
    data = b"".join(struct.pack("<" + form * len(v), *v) for v in values)
    offset = sum(len(c) for c in chunks)
    views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(data)})
    if target:
        views[-1]["target"] = target
    chunks.append(data + b"\0" * (-len(data) % 4))
    accessors.append({"bufferView": len(views) - 1, "componentType": component,
                      "count": len(values), "type": kind})
    if extent:
        rounded = [struct.unpack("<" + form * len(v), struct.pack("<" + form * len(v), *v))
                   for v in values]
        accessors[-1]["min"] = [min(v[k] for v in rounded) for k in range(len(values[0]))]
        accessors[-1]["max"] = [max(v[k] for v in rounded) for k in range(len(values[0]))]
    return len(accessors) - 1


def local(index):
    _, parent, place = JOINTS[index]
    return place if parent < 0 else sub(place, JOINTS[parent][2])


nodes = [{"name": name, "translation": list(local(i))} for i, (name, _, _) in enumerate(JOINTS)]
for i, (_, parent, _) in enumerate(JOINTS):
    if parent >= 0:
        nodes[parent].setdefault("children", []).append(i)
nodes.append({"name": "Figure", "mesh": 0, "skin": 0})

mesh = {"POSITION": accessor(vertices, "VEC3", "f", 5126, 34962, True),
        "JOINTS_0": accessor(joints, "VEC4", "B", 5121, 34962),
        "WEIGHTS_0": accessor(weights, "VEC4", "f", 5126, 34962)}
faces = accessor([(i,) for t in triangles for i in t], "SCALAR", "H", 5123, 34963)
binds = accessor([(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1)
                  for _, _, (x, y, z) in JOINTS], "MAT4", "f", 5126)


def turn(axis, degrees):
    half = math.radians(degrees) / 2
    return tuple(math.sin(half) * p for p in unit(axis)) + (math.cos(half),)


times = accessor([(0.0,), (0.5,), (1.25,), (2.0,)], "SCALAR", "f", 5126, None, True)
few = accessor([(0.25,), (1.75,)], "SCALAR", "f", 5126, None, True)
wave = [turn((0, 1, 0), -angle) for angle in (0, 70, 30, 110)]
slow = (0.0, 0.0, 0.0, 0.0)
# In-tangent, value, out-tangent of each key.
spline = [slow, wave[0], (0.1, -1.3, 0.2, -0.4), (0.0, -0.5, 0.3, 0.1), wave[1],
          (-0.2, 0.9, 0.0, 0.3), (0.1, 0.2, 0.4, 0.0), wave[2], (0.3, -1.1, 0.1, -0.6),
          (0.0, -0.7, -0.2, 0.2), wave[3], slow]
hips = local(0)
stretch = [(0, 0, 0), (1, 1, 1), (0.8, -0.4, 0.1), (0.5, 0.9, -0.2), (1.3, 0.9, 1.1), (0, 0, 0)]
samplers = [
    {"input": times, "output": accessor(spline, "VEC4", "f", 5126), "interpolation": "CUBICSPLINE"},
    {"input": times, "output": accessor([hips, add(hips, (0, 0, 1), 0.1), add(hips, (1, 0, 0), 0.2),
                                         hips], "VEC3", "f", 5126), "interpolation": "STEP"},
    {"input": few, "output": accessor(stretch, "VEC3", "f", 5126), "interpolation": "CUBICSPLINE"},
    {"input": times, "output": accessor([turn((0, 1, 0), a) for a in (0, 60, 90, 20)], "VEC4", "f",
                                        5126), "interpolation": "LINEAR"},
    {"input": few, "output": accessor([turn((1, 0, 0), a) for a in (0, 35)], "VEC4", "f", 5126),
     "interpolation": "STEP"}]
index = {name: i for i, (name, _, _) in enumerate(JOINTS)}
channels = [{"sampler": s, "target": {"node": index[node], "path": path}} for s, node, path in (
    (0, "LeftForeArm", "rotation"), (1, "Hips", "translation"), (2, "LeftHand", "scale"),
    (3, "RightForeArm", "rotation"), (4, "Chest", "rotation"))]

data = b"".join(chunks)
gltf = {"asset": {"version": "2.0", "generator": "tests/scenes/figure/make_figure.py"},
        "scene": 0, "scenes": [{"nodes": [0, len(nodes) - 1]}], "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": mesh, "indices": faces}]}],
        "skins": [{"joints": list(range(len(JOINTS))), "inverseBindMatrices": binds}],
        "animations": [{"name": "wave", "samplers": samplers, "channels": channels}],
        "bufferViews": views, "accessors": accessors,
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," +
                     base64.b64encode(data).decode()}]}
with open(sys.argv[1], "w") as out:
    json.dump(gltf, out, indent=None, separators=(",", ":"))
    out.write("\n")
if len(sys.argv) < 3:
    sys.exit()

# --- dressed.gltf ---------------------------------------------------------------------------------
chunks.clear()
views.clear()
accessors.clear()


def smooth_normals():
    """One for each place: the sum of the areas of its triangles."""
    sums = {}
    for t in triangles:
        a, b, c = (vertices[i] for i in t)
        area = cross(sub(b, a), sub(c, a))
        for p in (a, b, c):
            sums[p] = add(sums.get(p, (0.0, 0.0, 0.0)), area, 1.0)
    return [unit(sums[p]) for p in vertices]


# The armature: a quarter turn about x and centimetres, (x, y, z) -> (x, z, -y) / 100 upwards.
def into_armature(p, scale=100.0):
    return (scale * p[0], -scale * p[2], scale * p[1])


def piece(number, with_tangents):
    """One primitive: trunk, left arm or right arm."""
    first, end = starts[number], starts[number + 1]
    normals = [into_armature(n, 1.0) for n in smooth_normals()[first:end]]
    rows = [(((i - 1) % (AROUND + 1)) / AROUND, i / (end - first)) for i in range(end - first)]
    out = {"attributes": {
        "POSITION": accessor([into_armature(p) for p in vertices[first:end]], "VEC3", "f", 5126,
                             34962, True),
        "NORMAL": accessor(normals, "VEC3", "f", 5126, 34962),
        "TEXCOORD_0": accessor(rows, "VEC2", "f", 5126, 34962),
        "JOINTS_0": accessor(joints[first:end], "VEC4", "B", 5121, 34962),
        "WEIGHTS_0": accessor(weights[first:end], "VEC4", "f", 5126, 34962)},
        "indices": accessor([(i - first,) for t in triangles if first <= t[0] < end for i in t],
                            "SCALAR", "H", 5123, 34963)}
    if number > 0:  # painted on the arms alone: 1 on the upper arm, 0 on the forearm
        arm = 3 if number == 1 else 7
        painted = [(sum(w for j, w in zip(joints[i], weights[i]) if j == arm),)
                   for i in range(first, end)]
        out["attributes"]["_THEW_FAT"] = accessor(painted, "SCALAR", "f", 5126, 34962)
    if with_tangents:
        tangents = [unit(cross(n, (0.1, 0.2, 0.97))) + (1.0,) for n in normals]
        out["attributes"]["TANGENT"] = accessor(tangents, "VEC4", "f", 5126, 34962)
    return out


def hat():
    """A pyramid with hard edges, positions and normals by turns in one view."""
    tip, base = (0.0, 0.5, 0.0), [(0.1, 0.3, 0.1), (0.1, 0.3, -0.1), (-0.1, 0.3, -0.1),
                                  (-0.1, 0.3, 0.1)]
    faces = [(tip, base[k], base[(k + 1) % 4]) for k in range(4)]
    faces += [(base[0], base[2], base[1]), (base[0], base[3], base[2])]
    corners = [(into_armature(p), into_armature(unit(cross(sub(f[1], f[0]), sub(f[2], f[0]))), 1.0))
               for f in faces for p in f]
    offset = sum(len(c) for c in chunks)
    chunks.append(b"".join(struct.pack("<6f", *p, *n) for p, n in corners))
    views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(chunks[-1]),
                  "byteStride": 24, "target": 34962})
    for byte, extent in ((0, True), (12, False)):
        accessors.append({"bufferView": len(views) - 1, "byteOffset": byte, "componentType": 5126,
                          "count": len(corners), "type": "VEC3"})
        if extent:
            rounded = [struct.unpack("<3f", struct.pack("<3f", *p)) for p, _ in corners]
            accessors[-1]["min"] = [min(p[k] for p in rounded) for k in range(3)]
            accessors[-1]["max"] = [max(p[k] for p in rounded) for k in range(3)]
    return {"attributes": {"POSITION": len(accessors) - 2, "NORMAL": len(accessors) - 1},
            "material": 1}


def png():
    def chunk(kind, content):
        return (struct.pack(">I", len(content)) + kind + content +
                struct.pack(">I", zlib.crc32(kind + content)))
    rows = b"".join(b"\0" + bytes(row) for row in ((200, 150, 120, 190, 140, 110),
                                                   (190, 140, 110, 200, 150, 120)))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


del nodes[-1]
at = {"Armature": len(nodes), "Body": len(nodes) + 1, "Arms": len(nodes) + 2, "Hat": len(nodes) + 3}
half = math.sqrt(0.5)
for i, node in enumerate(nodes):
    node["translation"] = list(into_armature(local(i)))
nodes += [{"name": "Armature", "children": [0, at["Body"], at["Arms"]], "scale": [0.01] * 3,
           "rotation": [-half, 0.0, 0.0, half], "extras": {"unit": "cm"}},
          {"name": "Body", "mesh": 0, "skin": 0}, {"name": "Arms", "mesh": 1, "skin": 0},
          {"name": "Hat", "mesh": 2, "translation": list(into_armature((0.0, 0.05, 0.0)))}]
nodes[index["Chest"]]["children"].append(at["Hat"])
body, left, right = piece(0, False), piece(1, True), piece(2, False)
body["material"], left["material"], right["material"] = 0, 0, 1
body["targets"] = [{"POSITION": accessor([(0.0, -1.0 if 0.0 < w[1] < 1.0 else 0.0, 0.0)
                                          for w in weights[:starts[1]]], "VEC3", "f", 5126, 34962,
                                         True)}]
binds = accessor([(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *into_armature(place, -100.0), 1)
                  for _, _, place in JOINTS], "MAT4", "f", 5126)
times = accessor([(0.0,), (0.5,), (1.0,)], "SCALAR", "f", 5126, None, True)
bend = accessor([turn((0, 0, 1), a) for a in (0, -40, -90)], "VEC4", "f", 5126)
lift = accessor([turn((0, 1, 0), a) for a in (0, 15, 25)], "VEC4", "f", 5126)
hips = into_armature(hips)
sway = accessor([hips, add(hips, (1, 0, 0), 10.0), hips], "VEC3", "f", 5126)
breathe = accessor([(0.0,), (1.0,), (0.0,)], "SCALAR", "f", 5126)


def animation(name, curves):
    return {"name": name, "samplers": [{"input": times, "output": output}
                                       for output, _, _ in curves],
            "channels": [{"sampler": i, "target": {"node": node, "path": path}}
                         for i, (_, node, path) in enumerate(curves)]}


animations = [animation("bend", [(bend, index["LeftForeArm"], "rotation"),
                                 (lift, index["RightArm"], "rotation"),
                                 (sway, index["Hips"], "translation")]),
              animation("breath", [(breathe, at["Body"], "weights")])]
data = b"".join(chunks)
gltf = {"asset": {"version": "2.0", "generator": "tests/scenes/figure/make_figure.py",
                  "extras": {"author": "nobody"}},
        "scene": 0, "scenes": [{"nodes": [at["Armature"]]}], "nodes": nodes,
        "meshes": [{"name": "trunk", "primitives": [body], "weights": [0.0],
                    "extras": {"targetNames": ["breath"]}},
                   {"name": "arms", "primitives": [left, right]},
                   {"name": "hat", "primitives": [hat()]}],
        "materials": [{"name": "skin", "extras": {"layer": 1}, "pbrMetallicRoughness": {
                           "baseColorTexture": {"index": 0}, "metallicFactor": 0.0}},
                      {"name": "cloth", "pbrMetallicRoughness": {
                           "baseColorFactor": [0.2, 0.3, 0.6, 1.0], "metallicFactor": 0.0}}],
        "textures": [{"source": 0}],
        "images": [{"name": "check", "uri": "data:image/png;base64," +
                    base64.b64encode(png()).decode()}],
        "skins": [{"joints": list(range(len(JOINTS))), "inverseBindMatrices": binds}],
        "animations": animations, "bufferViews": views, "accessors": accessors}
data = b"".join(chunks)
gltf["buffers"] = [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," +
                    base64.b64encode(data).decode()}]
with open(sys.argv[2], "w") as out:
    json.dump(gltf, out, indent=None, separators=(",", ":"))
    out.write("\n")
