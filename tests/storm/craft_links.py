# SPDX-License-Identifier: Apache-2.0
"""Crafted bakes, the other half: links and names, storage and filters, attributes, what is gone."""
import h5py
import numpy as np
from h5py import h5d, h5p, h5s, h5t

NAMES = ["", " ", ".", "..", "a" * 255, "a" * 60000, "a\nb", "a\tb", "\x1b[31mred", "<script>x()",
         "\"'", "ä", "\u202e", "name with spaces", "-x", "%s%n", "CON", "a\\b", "$(id)"]


def links():
    def move(old, new):
        def change(file):
            file.move(old, new)
        return change
    for name in NAMES:
        if name not in ("", ".", ".."):  # HDF5 has no such links
            shown = repr(name if len(name) < 40 else f"{name[0]} × {len(name)}")
            yield f"a mesh of name {shown}", move("meshes/front", "meshes/" + name)
            yield f"a metric of name {shown}", move("metrics/unreached", "metrics/" + name)

    def linked(name, link):
        def change(file):
            del file[name]
            file[name] = link
        return change
    for name in ["meshes", "metrics", "frames", "meshes/front", "meshes/front/rest",
                 "meshes/front/positions"]:
        other = {"meshes/front": "/meshes/side"}.get(name, "/" + name.replace("front", "side"))
        yield f"{name} is a soft link", linked(name, h5py.SoftLink(other))
        yield f"{name} is a soft link to itself", linked(name, h5py.SoftLink("/" + name))
        yield f"{name} is a dangling link", linked(name, h5py.SoftLink("/nothing"))
        yield f"{name} is in another file", linked(name, h5py.ExternalLink("/etc/hostname", "/"))
        yield f"{name} is in a bake beside", linked(name, h5py.ExternalLink("good.h5", "/" + name))

    def many(count, make):
        def change(file):
            for i in range(count):
                make(file, i)
        return change

    def hard(group, target):
        def make(file, i):
            file[f"{group}/link{i:05d}"] = file[target]
        return make

    def group_of(name):
        return lambda file, i: file.create_group(f"{name}/group{i:05d}")
    yield "300 hard links to a mesh", many(300, hard("meshes", "meshes/front"))
    yield "3,000 hard links to a mesh", many(3000, hard("meshes", "meshes/front"))
    yield "30,000 hard links to a metric", many(30000, hard("metrics", "metrics/unreached"))
    yield "3,000 hard links in a mesh", many(3000, hard("meshes/front", "frames"))
    yield "3,000 links to all meshes", many(3000, hard("meshes", "meshes"))
    yield "a circle of metrics", many(5, hard("metrics", "metrics"))
    yield "a circle through the root", many(2, hard("metrics", "/"))
    yield "5,000 groups of meshes", many(5000, group_of("meshes"))
    yield "5,000 groups of metrics", many(5000, group_of("metrics"))
    yield "5,000 groups beside", many(5000, group_of("/"))
    yield "5,000 soft links", many(5000, lambda file, i: file["meshes"].__setitem__(
        f"soft{i}", h5py.SoftLink("/meshes/front")))

    def deep(where, depth):
        def change(file):
            group = file[where]
            for i in range(depth):
                group = group.create_group("d")
            group["end"] = [1.0, 2.0, 3.0]
        return change
    for depth in [3, 5, 50, 2000]:
        yield f"metrics nested {depth} deep", deep("metrics", depth)
        yield f"a mesh nested {depth} deep", deep("meshes", depth)

    def doubled(file):  # each level twice the one below: 2^20 paths to a few objects
        group = file["metrics"].create_group("level")
        for i in range(20):
            above = file["metrics"].create_group(f"level{i}")
            above["left"], above["right"] = group, group
            group = above
    yield "metrics by a million ways", doubled


def storage():
    def laid_out(name, lay_out, dtype=None):
        def change(file):
            data = file[name][()]
            del file[name]
            creation = h5p.create(h5p.DATASET_CREATE)
            space = h5s.create_simple(data.shape)
            lay_out(creation, data, space)
            kind = h5t.py_create(np.dtype(dtype) if dtype else data.dtype)
            made = h5d.create(file.id, name.encode(), kind, space, creation)
            if creation.get_layout() != h5d.VIRTUAL and creation.get_external_count() == 0:
                made.write(h5s.ALL, h5s.ALL, data)
        return change

    def chunked(*filters, chunk=None):
        def lay_out(creation, data, space):
            creation.set_chunk(chunk or ((1,) + data.shape[1:] if data.ndim == 3 else data.shape))
            for filter in filters:
                filter(creation)
        return lay_out

    def external(file, size):
        return lambda creation, data, space: creation.set_external(file, 0, size or data.nbytes)

    def virtual(file, name):
        return lambda creation, data, space: creation.set_virtual(space, file, name, space)
    gzip, sums = (lambda c: c.set_deflate(6)), (lambda c: c.set_fletcher32())
    shuffle = (lambda c: c.set_shuffle())
    unknown = (lambda c: c.set_filter(32001, h5py.h5z.FLAG_OPTIONAL, (1, 2, 3)))
    lzf = (lambda c: c.set_filter(32000, h5py.h5z.FLAG_OPTIONAL, ()))
    scale = (lambda c: c.set_scaleoffset(h5py.h5z.SO_INT, 0))
    ways = {"contiguous": lambda c, d, s: c.set_layout(h5d.CONTIGUOUS),
            "compact": lambda c, d, s: c.set_layout(h5d.COMPACT),
            "in /etc/hostname": external(b"/etc/hostname", 0),
            "in /dev/zero": external(b"/dev/zero", 0),
            "in a pipe": external(b"pipe", 0),
            "in a file that is not there": external(b"nowhere", 0),
            "virtual of another": virtual(b"good.h5", b"/frames"),
            "virtual of itself": virtual(b".", b"/frames"),
            "without filters": chunked(), "without a sum": chunked(shuffle, gzip),
            "not packed": chunked(sums), "in another order": chunked(sums, gzip, shuffle),
            "packed five times": chunked(shuffle, gzip, gzip, gzip, gzip, gzip, sums),
            "by a foreign filter": chunked(shuffle, gzip, unknown),
            "by LZF": chunked(shuffle, lzf), "packed best": chunked(shuffle, lambda c:
                                                                    c.set_deflate(9), sums)}
    for name in ["meshes/front/rest", "meshes/front/positions", "frames",
                 "metrics/contact_penetration"]:
        for text, way in ways.items():
            yield f"{name} {text}", laid_out(name, way)
    for name in ["frames", "meshes/front/triangles"]:
        yield f"{name} scaled", laid_out(name, chunked(scale))
    yield "positions in chunks of nodes", laid_out("meshes/front/positions",
                                                   chunked(shuffle, gzip, sums, chunk=(3, 1, 3)))
    yield "positions in one chunk", laid_out("meshes/front/positions",
                                             chunked(shuffle, gzip, sums, chunk=(3, 134, 3)))
    yield "rest in chunks of one", laid_out("meshes/front/rest",
                                            chunked(shuffle, gzip, sums, chunk=(1, 1)))

    def never_written(name):
        def change(file):
            old = file[name]
            shape, dtype, chunks = old.shape, old.dtype, old.chunks
            del file[name]
            file.create_dataset(name, shape, dtype, chunks=chunks, compression="gzip", shuffle=True,
                                fletcher32=True)
        return change
    for name in ["meshes/front/rest", "meshes/front/positions", "frames", "meshes/skin/triangles"]:
        yield f"{name} never written", never_written(name)


def attributes():
    values = {"a long text": np.bytes_("x" * 60000), "no text": np.bytes_(""), "a number": 7.5,
              "not a number": float("nan"), "a list": np.arange(5.0),
              "an empty list": h5py.Empty("f8"),
              "less than nothing": np.int32(-7), "the largest": np.int32(2**31 - 1),
              "0": 0.0, "1e308": 1e308, "5e-324": 5e-324, "a text of Python": "thew-bake",
              "control characters": np.bytes_("\x1b[2J\r\n\x07"),
              "not UTF-8": np.bytes_(b"\xff\xfe\x80"),
              "a page": np.bytes_("<script>alert(1)</script>"),
              "a way": np.bytes_("../../etc/passwd")}
    for name in ["format", "version", "fps", "units", "up_axis", "frames_done", "scene_hash",
                 "scene", "hash"]:
        for text, value in values.items():
            def change(file, name=name, value=value):
                del file.attrs[name]
                file.attrs[name] = value
            yield f"{name} is {text}", change

        def gone(file, name=name):
            del file.attrs[name]
        yield f"{name} is not there", gone
    for kind in ["", "Muscle", "skin", "bone", "nothing", "muscle\n", "x" * 60000]:
        def change(file, kind=kind):
            file["meshes/front"].attrs["kind"] = np.bytes_(kind)
        yield f"a mesh of kind {kind[:20]!r}", change
    for fps in [24.0001, 1e-300, -24.0, float("inf"), 1e9, 1e-9]:
        def change(file, fps=fps):
            file.attrs["fps"] = fps
        yield f"fps is {fps}", change

    def many(file):
        for i in range(3000):
            file.attrs[f"attribute {i}"] = i
    yield "3,000 attributes", many


def missing():
    for name in ["meshes", "metrics", "frames", "meshes/front", "meshes/skin", "meshes/front/rest",
                 "meshes/front/positions", "meshes/front/triangles", "meshes/front/weights",
                 "meshes/front/coordinates", "metrics/volume_error", "metrics/contact_penetration"]:
        def gone(file, name=name):
            del file[name]
        yield f"{name} is not there", gone

        def other_kind(file, name=name):
            is_group = isinstance(file[name], h5py.Group)
            del file[name]
            if is_group:
                file[name] = 1.0
            else:
                file.create_group(name)
        yield f"{name} is a group where a dataset is wanted, or the reverse", other_kind

    def emptied(name):
        def change(file):
            for each in list(file[name]):
                del file[f"{name}/{each}"]
        return change
    for name in ["meshes", "metrics", "meshes/front", "/"]:
        yield f"nothing in {name}", emptied(name)
