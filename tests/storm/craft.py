# SPDX-License-Identifier: Apache-2.0
"""Bakes that no Thew wrote, made of one that it did, by HDF5 itself, so that every checksum in them
holds: crafts() is a list of (name, function of an open file, what must come of it)."""
import h5py
import numpy as np

REFUSED = "refused"  # by every command, with 3
OTHER = "other"  # never said to be the same as the original
ANY = "any"  # read or refused

MESHES = {"front": ["rest", "positions", "weights", "coordinates"],
          "humerus": ["rest", "positions"], "skin": ["rest", "positions"]}
METRICS = ["metrics/contact_penetration", "metrics/volume_error/front", "metrics/length/side"]


def put(file, name, data, dtype=None, chunks=None, **how):
    """Another dataset in the place of `name`, stored as a bake stores it."""
    old = file[name] if name in file else None
    if chunks is None and old is not None and old.chunks:
        data = np.asarray(data, dtype=dtype)
        chunks = tuple(max(1, n) for n in data.shape)
        if old.ndim == 3 and len(chunks) == 3:
            chunks = (1,) + chunks[1:]
    if old is not None:
        del file[name]
    settings = dict(shuffle=True, compression="gzip", fletcher32=True)
    if np.ndim(data) == 0 and "shape" not in how:
        settings, chunks = {}, None
    settings.update(how)
    return file.create_dataset(name, data=data, dtype=dtype, chunks=chunks or None, **settings)


def numbers():
    """Every kind of number in one place, in a row, in the last row, in all of them."""
    values = ["nan", "-nan", "inf", "-inf", "1e308", "-1e308", "1e300", "3.5e38", "1e39", "1e20",
              "-1e10", "1e7", "5e-324", "1e-310", "-0.0", "1e-30"]
    for name in [f"meshes/{mesh}/{part}" for mesh in MESHES for part in MESHES[mesh]] + METRICS:
        for value in values:
            for where in ["one", "row", "last", "all"]:
                yield name, value, where


def set_number(name, value, where):
    def change(file):
        data = file[name][()]
        if where == "one":
            data.flat[data.size // 2] = float(value)
        elif where == "row":
            data[len(data) // 2] = float(value)
        elif where == "last":
            data[-1] = float(value)
        else:
            data[:] = float(value)
        with np.errstate(over="ignore"):
            put(file, name, data)
    return change


def expected_of(name, value):
    number = float(value)
    if not np.isfinite(number):
        return REFUSED
    if abs(number) > 1e4 and name.endswith(("rest", "positions")):
        return REFUSED  # a place is at most 10 km
    if name.endswith("positions") and abs(number) >= 1e-3:
        return OTHER
    return ANY


def shapes():
    for name in ["meshes/front/rest", "meshes/front/positions", "meshes/front/triangles",
                 "meshes/front/weights", "meshes/skin/positions", "meshes/skin/triangles", "frames",
                 "metrics/contact_penetration"]:
        def reshaped(how, name=name):
            def change(file):
                data = file[name][()]
                made = how(data)
                if made.size == 0:
                    del file[name]
                    file.create_dataset(name, data=made)
                else:
                    put(file, name, made)
            return change
        yield f"{name} is empty", reshaped(lambda d: d[:0])
        yield f"{name} has one row", reshaped(lambda d: d[:1])
        yield f"{name} lacks a row", reshaped(lambda d: d[:-1])
        yield f"{name} has a row too many", reshaped(lambda d: np.concatenate([d, d[-1:]]))
        yield f"{name} is flat", reshaped(lambda d: d.reshape(-1) if d.ndim > 1 else d[:, None])
        yield f"{name} is a number", reshaped(lambda d: d.flat[0])
        yield f"{name} is turned", reshaped(lambda d: np.ascontiguousarray(d.T)
                                            if d.ndim > 1 else d[None])
        yield f"{name} has six ranks", reshaped(
            lambda d: d.reshape(d.shape + (1,) * (6 - d.ndim)))
        yield f"{name} lacks a column", reshaped(lambda d: d[..., :-1])
        yield f"{name} is a thousandfold", reshaped(lambda d: np.concatenate([d] * 1000))


def claims():
    """Some kilobytes that say they are much."""
    for name, shape, chunk, dtype in [
            ("meshes/front/rest", (170_000_000, 3), (170_000_000, 3), "<f8"),
            ("meshes/front/rest", (2**40, 3), (1000, 3), "<f8"),
            ("meshes/front/positions", (80_000_000_000, 134, 3), (1, 134, 3), "<f8"),
            ("meshes/front/positions", (3, 2**33, 3), (1, 2**27, 3), "<f8"),
            ("meshes/front/triangles", (2**31, 3), (2**28, 3), "<u4"),
            ("meshes/front/weights", (2**62,), (1024,), "<f8"),
            ("frames", (2**31 - 1,), (2**29 - 1,), "<i4"),
            ("frames", (1_000_000,), (1_000_000,), "<i4"),
            ("metrics/contact_penetration", (2**29 - 1,), (2**29 - 1,), "<f8")]:
        def change(file, name=name, shape=shape, chunk=chunk, dtype=dtype):
            put(file, name, None, dtype=dtype, shape=shape, chunks=chunk)
        yield f"{name} claims {shape}", change


def types():
    compound = np.dtype([("x", "<f8"), ("y", "<f8")])
    for name in ["meshes/front/rest", "meshes/front/positions", "meshes/front/triangles",
                 "meshes/front/weights", "frames", "metrics/contact_penetration"]:
        for dtype in ["i1", "<i8", "<u8", "<u2", "<f2", "<f4", ">f4", ">f8", ">i4", "c16", "?",
                      "S8", compound, h5py.string_dtype(), h5py.vlen_dtype("f8"),
                      h5py.enum_dtype({"a": 0, "b": 1}), h5py.ref_dtype, np.dtype("V4")]:
            def change(file, name=name, dtype=dtype):
                old = file[name]
                shape, chunks = old.shape, old.chunks
                data = None
                if np.dtype(dtype).kind in "iufc":
                    data = old[()].astype(dtype)
                del file[name]
                made = file.create_dataset(name, shape, dtype, data=data, chunks=chunks)
                if data is None and np.dtype(dtype).kind == "S":
                    made[...] = b"1.5"
            yield f"{name} of type {dtype}", change


def frame_lists():
    top = 2**31 - 1
    for text, frames in {"falling": [3, 2, 1], "the same": [1, 1, 1], "two the same": [1, 2, 2],
                         "below zero": [-3, -2, -1], "the least": [-2**31, 0, 1],
                         "the largest": [1, 2, top], "from the largest": [top - 2, top - 1, top],
                         "from least to largest": [-2**31, 0, top], "far apart": [1, 10**6, 10**9],
                         "zero": [0, 1, 2]}.items():
        yield f"frames are {text}", lambda file, frames=frames: put(
            file, "frames", np.array(frames, "<i4"))
    for done in [-1, 0, 2, 4, top]:
        def change(file, done=done):
            file.attrs.modify("frames_done", np.int32(done))
        yield f"frames_done is {done}", change


def triangles():
    def with_triangles(make, mesh="front"):
        def change(file):
            old = file[f"meshes/{mesh}/triangles"][()]
            put(file, f"meshes/{mesh}/triangles", np.asarray(make(old), "<u4"))
        return change

    def one(value):
        def make(old):
            old = old.copy()
            old[len(old) // 2, 1] = value
            return old
        return make
    for mesh in MESHES:
        for value in [134, 322, 2**31 - 1, 2**31, 2**32 - 1, 10**6]:
            yield f"a triangle of {mesh} names node {value}", with_triangles(one(value), mesh)
        yield f"{mesh} has one triangle", with_triangles(lambda old: old[:1], mesh)
        yield f"{mesh} is of points", with_triangles(lambda old: old * 0, mesh)
        yield f"{mesh} has each twice", with_triangles(lambda old: np.repeat(old, 2, 0), mesh)
        yield f"{mesh} is inside out", with_triangles(lambda old: old[:, ::-1], mesh)
        yield f"{mesh} is a fan", with_triangles(
            lambda old: [[0, 1, 2 + i % 40] for i in range(300)], mesh)
        yield f"{mesh} is one triangle 20,000 times", with_triangles(
            lambda old: np.repeat(old[:1], 20000, 0), mesh)
        yield f"{mesh} is half there", with_triangles(lambda old: old[::2], mesh)


def shapes_of_geometry():
    def positions(make, mesh):
        def change(file):
            for part in ["rest", "positions"]:
                name = f"meshes/{mesh}/{part}"
                put(file, name, make(file[name][()]))
        return change
    rng = np.random.default_rng(7)
    makes = {"in one place": lambda p: p * 0 + p.flat[0], "at zero": lambda p: p * 0,
             "on a line": lambda p: p * [1, 0, 0], "in a plane": lambda p: p * [1, 1, 0],
             "mirrored": lambda p: p * [-1, 1, 1], "far away": lambda p: p + 9e3,
             "huge": lambda p: p * 1e4, "tiny": lambda p: p * 1e-9,
             "denormal": lambda p: p * 1e-310,
             "shuffled": lambda p: rng.permutation(p, axis=-2),
             "noise": lambda p: rng.normal(size=p.shape),
             "stretched": lambda p: p * [1e4, 1e-4, 1]}
    for mesh in MESHES:
        for text, make in makes.items():
            yield f"all nodes of {mesh} {text}", positions(make, mesh)
    for text, make in makes.items():
        def change(file, make=make):
            for mesh in file["meshes"]:
                positions(make, mesh)(file)
        yield f"all nodes of all meshes {text}", change


def crafts():
    """All of them, in an order of its own that does not change."""
    from craft_links import attributes, links, missing, storage
    made = [(f"{name} {where}: {value}", set_number(name, value, where), expected_of(name, value))
            for name, value, where in numbers()]
    for group in [shapes, claims, types, frame_lists, triangles, shapes_of_geometry, links, storage,
                  attributes, missing]:
        made += [(name, change, ANY) for name, change in group()]
    return made
