# SPDX-License-Identifier: Apache-2.0
"""Compares bakes of one character that came by several ways: routes_check.py FOLDER NAME, where
FOLDER/WAY/bake.h5 are the bakes and the one called `input` is what the others are compared with. The
ways divide vertices differently, so each is compared with the one that lies at its place at rest."""
import glob
import os
import sys

import h5py
import numpy
from scipy.spatial import cKDTree

BIND, BAKED = 1e-5, 1e-4  # m


def read(folder):
    with h5py.File(f"{folder}/bake.h5") as file:
        return {
            name: (mesh["rest"][:], mesh["positions"][:]) for name, mesh in file["meshes"].items()
        }


def partners(points, among):
    """Index of the nearest of `among`, by point, and how far it is."""
    distance, index = cKDTree(among).query(points)
    return index, distance


folder, character = sys.argv[1:]
truth = read(f"{folder}/input")
failed = False
for way in sorted(os.path.dirname(p) for p in glob.glob(f"{folder}/*/bake.h5")):
    found = read(way)
    bind = baked = flesh = 0.0
    for name, (rest, positions) in truth.items():
        own_rest, own = found[name]
        if name == "skin":
            there, apart = partners(own_rest.astype("f8"), rest.astype("f8"))
            back = partners(rest.astype("f8"), own_rest.astype("f8"))[1]
            bind = max(apart.max(), back.max())
            baked = numpy.linalg.norm(own - positions[:, there], axis=2).max()
        else:
            flesh = max(flesh, numpy.linalg.norm(own - positions, axis=2).max())
    ok = bind <= BIND and max(baked, flesh) <= BAKED
    failed = failed or not ok
    print(
        f"  {character}, {os.path.basename(way)}: bind pose within {bind:.2g} m, skin {baked:.2g}, "
        f"muscles and bones {flesh:.2g}, {len(positions)} frames: {'right' if ok else 'WRONG'}"
    )
sys.exit(failed)
