# SPDX-License-Identifier: Apache-2.0
"""Crafted bakes, each given to every command that reads one: an end by itself, one message where it
is refused, and nothing that is not a number in what is written."""
import re
import shutil

from trial import LIST, NOT_A_NUMBER, SOURCE, Limits, need_h5py

PAIR = SOURCE / "tests/scenes/pair/scene.toml"
FORMATS = ["obj", "ply", "glb", "usda", "usdc", "usdz", "abc", "xdmf", "pc2", "mdd"]
# Infinity and NaN as float32, either way round; a bake's meshes have no such bytes by chance.
WILD = [b"\x00\x00\x80\x7f", b"\x00\x00\x80\xff", b"\x00\x00\xc0\x7f", b"\x00\x00\xc0\xff"]


def commands(bake, good, out):
    yield ["inspect", bake]
    yield ["compare", good, bake]
    yield ["compare", good, bake, "--html", out / "page.html"]
    for ending in FORMATS:
        name = "bake.####." + ending if ending in ("obj", "ply") else "bake." + ending
        mesh = ["--mesh", "front"] if ending in ("ply", "pc2", "mdd") else []  # these hold but one
        yield ["export", bake, "--progress", "none", *mesh, out / name]
    yield ["render", bake, "--scene", PAIR, "--progress", "none", "--out", out / "frames"]


def wild_in(file):
    """What of a written file is not a number, or empty."""
    if file.suffix == ".png":
        return ""
    data = file.read_bytes()
    if file.suffix in (".pc2", ".mdd"):
        words = [word[::-1] for word in WILD] if file.suffix == ".mdd" else WILD
        return "not a number" if any(has_word(data, word) for word in words) else ""
    if file.suffix == ".glb":
        length = int.from_bytes(data[12:16], "little")
        text = data[20:20 + length].decode(errors="replace")
        return "null in its JSON" if re.search(r"\b(null|NaN|Infinity)\b", text) else ""
    if file.suffix == ".abc":
        return ""
    if file.suffix == ".ply":  # binary after its header, where any word may stand by chance
        import numpy as np
        header, _, body = data.partition(b"end_header\n")
        place = "<f8" if b"double x" in header else "<f4"
        row = np.dtype([("place", place, 3), ("normal and velocity", "<f4", 6)])
        rows = np.frombuffer(body, row, int(re.search(rb"element vertex (\d+)", header)[1]))
        is_finite = all(np.isfinite(rows[part]).all() for part in row.names)
        return "" if is_finite else "not a number"
    text = data.decode(errors="replace")
    if file.suffix == ".html":  # of its text; scripts may speak of such things
        text = re.sub(r"<(script|style)\b.*?</\1>|base64,[\w+/=]*", "", text, flags=re.DOTALL)
    found = NOT_A_NUMBER.search(text)
    return found[0] if found else ""


def has_word(data, word):
    """Whether one of the data's words of four bytes is it."""
    at = data.find(word)
    while at >= 0 and at % 4:
        at = data.find(word, at + 1)
    return at >= 0


def run(storm):
    need_h5py()
    import h5py
    from craft import OTHER, REFUSED, crafts, put
    good = storm.work / "good.h5"
    limits = Limits(seconds=60)
    ended = storm.run(["bake", PAIR, "--frames", "1-3", "--no-render", "--progress", "none",
                       "--out", storm.work / "whole"], limits)
    storm.check(ended, "the bake itself", [0], limits)
    shutil.move(storm.work / "whole/bake.h5", good)

    # What a command takes for calm bakes, its pictures above all, comes on top.
    def nudge(file):
        positions = file["meshes/front/positions"][()]
        positions[1, 5] += 0.01
        put(file, "meshes/front/positions", positions)
    nudged = storm.work / "nudged.h5"
    shutil.copy(good, nudged)
    with h5py.File(nudged, "r+", libver="latest") as file:
        nudge(file)
    calm = []
    (storm.work / "calm").mkdir()
    for words in commands(nudged, good, storm.work / "calm"):
        ended = storm.run(words, limits)
        storm.check(ended, "two calm bakes", [0, 1], limits)
        calm.append(ended.seconds)

    def try_one(case):
        number, (name, change, expected) = case
        folder = storm.work / f"{number:04d}"
        folder.mkdir()
        bake = folder / "bake.h5"
        shutil.copy(good, bake)
        shutil.copy(good, folder / "good.h5")
        with storm.lock:  # HDF5 is one for all threads
            with h5py.File(bake, "r+", libver="latest") as file:
                change(file)
        for words, seconds in zip(commands(bake, good, folder / "out"), calm):
            # As the promise has it: a second more for every 8 MiB of file.
            limits = Limits(seconds=2 + seconds + bake.stat().st_size / 2**23)
            (folder / "out").mkdir()
            ended = storm.run(words, limits)
            codes = [0, 1, 3, 4] if words[0] == "compare" else [0, 3, 4]
            if "--mesh" in words:  # which may be gone
                codes.append(2)
            storm.check(ended, name, codes, limits, [bake])
            if ended.code in (0, 1):
                if expected == REFUSED:
                    storm.fail("silent", name, f"code {ended.code}", ended, [bake])
                if expected == OTHER and words[0] == "compare" and ended.code == 0:
                    storm.fail("silent", name, "said to be the same", ended, [bake])
            for file in (folder / "out").rglob("*"):
                wild = wild_in(file) if file.is_file() else ""
                if wild:
                    storm.fail("silent", name, f"{wild} in {file.name}", ended, [bake, file])
                # The pictures before the one that failed stay.
                half_done = ended.code > 1 and words[0] != "render"
                if half_done and file.is_file() and file.name != LIST:
                    storm.fail("lost", name, f"it left {file.name}", ended, [bake])
                    break
            shutil.rmtree(folder / "out")
        shutil.rmtree(folder)

    storm.over(try_one, storm.every(enumerate(crafts())))
