# SPDX-License-Identifier: Apache-2.0
"""Disks of 40 sizes, from next to nothing to enough: bake, pictures and exports end with 4 and one
message, keep what they had completed, leave nothing half done, and go on where there is room."""
import ctypes
import json
import os
import time

from trial import LIST, SOURCE, Limits, Skipped

SCENE = SOURCE / "tests/scenes/pair/scene.toml"
SIZES = 40
LIMITS = Limits(seconds=20)
EXPORTS = {"usda": "bake.usda", "usdz": "bake.usdz", "glb": "bake.glb", "obj": "bake.####.obj"}
NEW_NAMESPACE, REMOUNT, PRIVATE, RECURSIVE, DETACH = 0x20000, 32, 1 << 18, 1 << 14, 2

libc = ctypes.CDLL(None, use_errno=True)


def mount(folder, flags, options):
    kind = b"tmpfs" if options else None
    if libc.mount(b"none", os.fsencode(folder), kind, flags, options.encode() or None) != 0:
        why = os.strerror(ctypes.get_errno())
        raise Skipped(f"no permission to mount a small disk: {why}")


class Disk:
    def __init__(self, folder, size):
        self.folder = folder
        folder.mkdir()
        mount(folder, 0, f"size={size}")

    def grow(self, size):
        mount(self.folder, REMOUNT, f"size={size}")

    def used(self):
        of = os.statvfs(self.folder)
        return (of.f_blocks - of.f_bfree) * of.f_frsize

    def remove(self):
        libc.umount2(os.fsencode(self.folder), DETACH)
        self.folder.rmdir()


def bytes_below(folder):
    return {str(path.relative_to(folder)): path.read_bytes()
            for path in sorted(folder.rglob("*")) if path.is_file() and path.name != LIST}


def size_of(folder):
    return sum(os.stat(path).st_blocks * 512 for path in folder.rglob("*"))


def most_used(storm, words):
    """Bytes that a bake takes of a disk while it runs: at its end its parts are gone."""
    disk, most = Disk(storm.work / "large", 1 << 30), 0
    process = storm.start(words(disk.folder / "out"), LIMITS)
    while not storm.has_ended(process):
        most = max(most, disk.used())
        time.sleep(0.001)
    storm.finish(process, LIMITS)
    most = max(most, disk.used())
    disk.remove()
    return most


def run(storm):
    # Disks that only this process and its children see.
    if libc.unshare(NEW_NAMESPACE) != 0:
        raise Skipped("no permission to mount a small disk")
    mount("/", PRIVATE | RECURSIVE, "")

    def words(out, *more):
        return ["bake", SCENE, "--out", out, "--progress", "none", "--threads", "1", "--frames",
                "1-6", "--set", "render.size=[960,540]", *more]

    def bake(out, *more):
        return storm.run(words(out, *more), LIMITS)

    def export(out, name):
        return storm.run(["export", whole / "bake.h5", "--progress", "none", out / name], LIMITS)
    whole = storm.work / "whole"
    storm.check(bake(whole), "the bake itself", [0], LIMITS)
    most = most_used(storm, words)
    pictures = {name: data for name, data in bytes_below(whole).items()
                if name.endswith((".png", ".h5"))}
    exported = {}
    for ending, name in EXPORTS.items():
        out = storm.work / ending
        out.mkdir()
        storm.check(export(out, name), ending, [0], LIMITS)
        exported[ending] = (size_of(out), bytes_below(out))
    full = dict.fromkeys(["bake", *EXPORTS], 0)

    def told(name, ended, out):
        storm.check(ended, name, [0, 4], LIMITS)
        if ended.code == 4 and "space" not in ended.errors[0]:
            storm.fail("ill told", name, ended.errors[0], ended)
        left = [path for path in out.rglob("*") if path.suffix in (".tmp", ".list")]
        if left:
            storm.fail("lost", name, f"{left[0].name} is left", ended)

    def try_one(number):
        size = 8192 + most * 5 // 4 * number // (SIZES - 1)
        name = f"a disk of {size >> 10} KiB"
        disk = Disk(storm.work / f"disk{number}", size)
        out = disk.folder / "out"
        ended = bake(out)
        told(name, ended, disk.folder)
        full["bake"] += ended.code == 4
        manifest = out / "bake.parts/manifest.jsonl"
        kept = [json.loads(line) for line in manifest.read_text().splitlines()] if (
            manifest.exists()) else []
        for part in kept:
            if (out / "bake.parts" / part["file"]).stat().st_size != part["bytes"]:
                storm.fail("lost", name, f"frame {part['frame']} is not whole", ended)
        if ended.code == 4 and ended.seconds > 0.2 and not kept and not (out / "bake.h5").exists():
            storm.notes.append(f"{size >> 10} KiB kept no frame")
        disk.grow(4 * most)
        again = bake(out, "--resume")
        storm.check(again, name + ", resumed", [0], LIMITS)
        found = bytes_below(out)
        differing = [file for file, data in pictures.items() if found.get(file) != data]
        if differing:
            storm.fail("different", name, f"{differing[:3]} after it was resumed", again)
        disk.remove()
        for ending, (needed, data) in exported.items():
            size = 4096 + (needed + 4096) * number // (SIZES - 2)
            name = f"a disk of {size >> 10} KiB for .{ending}"
            disk = Disk(storm.work / f"disk{number}", size)
            ended = export(disk.folder, EXPORTS[ending])
            told(name, ended, disk.folder)
            full[ending] += ended.code == 4
            if ended.code == 4 and bytes_below(disk.folder):
                storm.fail("lost", name, f"it left {list(bytes_below(disk.folder))[0]}", ended)
            disk.grow(4 * needed + 65536)
            again = export(disk.folder, EXPORTS[ending])
            storm.check(again, name + ", again", [0], LIMITS)
            if bytes_below(disk.folder) != data:
                storm.fail("different", name, "another file after it was exported again", again)
            disk.remove()

    storm.over(try_one, storm.every(range(SIZES)))
    storm.notes.append("full: " + ", ".join(f"{count} {name}" for name, count in full.items()))
