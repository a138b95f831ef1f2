# SPDX-License-Identifier: Apache-2.0
"""What a bake holds, for the clients to be compared with: truth.py FOLDER MESH writes
FOLDER/truth.json and FOLDER/truth.bin, numbers as little-endian float64. `load` and `Comparison`
are for the scripts in Python."""
import json
import os
import sys

import numpy


def stretches(rest, triangles, positions):
    """Larger and smaller principal stretch by frame and node, by singular values."""
    def edges(x):
        return numpy.stack([x[triangles[:, 1]] - x[triangles[:, 0]],
                            x[triangles[:, 2]] - x[triangles[:, 0]]], axis=-1)

    _, first = numpy.unique(rest, axis=0, return_inverse=True)  # vertices at one place
    first = first.reshape(-1)
    flat, upper = numpy.linalg.qr(edges(rest))
    area = 0.5 * numpy.abs(numpy.linalg.det(upper))
    good = area > 0
    result = numpy.ones(positions.shape[:2] + (2,))
    for frame, x in enumerate(positions):
        by = edges(x)[good] @ numpy.linalg.inv(upper[good])
        values = numpy.linalg.svd(by, compute_uv=False)
        total, sums = numpy.zeros(first.max() + 1), numpy.zeros((first.max() + 1, 2))
        for corner in range(3):
            node = first[triangles[good][:, corner]]
            numpy.add.at(total, node, area[good])
            numpy.add.at(sums, node, values * area[good][:, None])
        some = total[first] > 0
        result[frame, some] = (sums[first[some]].T / total[first[some]]).T
    return result


def fibres(share, lines):
    """Unit vectors by frame and node: those of the line of action at the node's share of it."""
    result = []
    for line in lines:
        tangents = numpy.gradient(line, axis=0)
        tangents /= numpy.linalg.norm(tangents, axis=1)[:, None]
        at = numpy.clip(share, 0, 1) * (len(line) - 1)
        between = numpy.stack([numpy.interp(at, numpy.arange(len(line)), tangents[:, k])
                               for k in range(3)], axis=1)
        result.append(between / numpy.linalg.norm(between, axis=1)[:, None])
    return numpy.array(result)


def write(folder, one):
    import h5py

    arrays, meshes, at, largest = [], [], 0, []
    with h5py.File(os.path.join(folder, "bake.h5")) as bake:
        for name, group in bake["meshes"].items():
            entry = {"name": name, "kind": bytes(group.attrs["kind"]).decode()}
            found = {key: group[key][:] for key in ("positions", "triangles")}
            if entry["kind"] == "skin":
                found["stretch"] = stretches(group["rest"][:], found["triangles"].astype(int),
                                             found["positions"].astype(float))
                largest = found["stretch"][:, :, 0].max(axis=1).tolist()
            if "line" in group:
                found["fibre"] = fibres(group["coordinates"][:, 0], group["line"][:].astype(float))
            for key, values in found.items():
                values = numpy.asarray(values, dtype="<f8")
                entry[key] = {"at": at, "shape": list(values.shape)}
                arrays.append(values)
                at += values.size
            length = bake.get(f"metrics/length/{name}")
            entry["lengths"] = [] if length is None else length[:].tolist()
            entry["fibres"] = "coordinates" in group
            meshes.append(entry)
        truth = {"fps": float(bake.attrs["fps"]), "frames": bake["frames"][:].tolist(),
                 "one": one, "meshes": meshes, "largest_stretch": largest}
    with open(os.path.join(folder, "truth.bin"), "wb") as out:
        for values in arrays:
            out.write(values.tobytes())
    with open(os.path.join(folder, "truth.json"), "w") as out:
        json.dump(truth, out)


def load(folder):
    with open(os.path.join(folder, "truth.json")) as text:
        truth = json.load(text)
    numbers = numpy.fromfile(os.path.join(folder, "truth.bin"), dtype="<f8")
    for mesh in truth["meshes"]:
        for key in ("positions", "triangles"):
            size = int(numpy.prod(mesh[key]["shape"]))
            begin = mesh[key]["at"]
            mesh[key] = numbers[begin:begin + size].reshape(mesh[key]["shape"])
    return truth


class Comparison:
    """The largest difference over all that a client read of one file."""

    def __init__(self, client, what, allowed, floats=False):
        self.client, self.what, self.allowed, self.floats = client, what, allowed, floats
        self.largest, self.vertices, self.wrong = 0.0, 0, []

    def add(self, place, read, expected):
        read, expected = numpy.asarray(read, dtype="f8"), numpy.asarray(expected, dtype="f8")
        if self.floats:  # what the format can hold
            expected = expected.astype("f4").astype("f8")
        if read.shape != expected.shape:
            self.wrong.append(f"{place}: {read.shape} instead of {expected.shape}")
            return
        difference = numpy.abs(read - expected).max()
        self.largest = max(self.largest, float(difference))
        self.vertices += len(read)
        if not difference <= self.allowed:
            self.wrong.append(f"{place}: off by {difference:.3g} m")

    def same(self, place, read, expected):
        if not numpy.array_equal(numpy.asarray(read), numpy.asarray(expected)):
            self.wrong.append(f"{place}: differs")

    def tell(self):
        print(f"{self.client}, {self.what}: largest error {self.largest:.3g} m "
              f"over {self.vertices} vertices", flush=True)
        for line in self.wrong[:5]:
            print("  " + line)
        return not self.wrong and self.vertices > 0


if __name__ == "__main__":
    write(sys.argv[1], sys.argv[2])
