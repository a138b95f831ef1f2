# SPDX-License-Identifier: Apache-2.0
"""Mutated files given to the command, over all that it reads; tests/fuzz/mutants does the same
inside one process. Each is read, or refused with one message; a mutated part of a bake is found,
and the bake that goes on from it is the uninterrupted one."""
import random
import shutil

from trial import SOURCE, Limits

CORPUS = SOURCE / "tests/fuzz/corpus"
SCENES = SOURCE / "tests/scenes"
SHARED = SOURCE.parent / "shared/data"  # beside the checkout, where there is one
COUNTS = {"scene": 1000, "urdf": 500, "clip": 800, "mesh": 1000, "character": 500, "cache": 700,
          "parts": 500}
WORDS = [b"-1", b"1e999", b"nan", b"inf", b"0", b"4294967296", b'"', b"[[[[", b"../../etc", b"\n",
         b"<a>", b"{}", b"1e-320", b"1,5", b"\xff\xfe", b"\0", b"9" * 400]
BVH = b"""HIERARCHY
ROOT Hips
{
  OFFSET 0 0.95 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT RightArm
  {
    OFFSET -0.17 0.43 -0.02
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT RightForeArm
    {
      OFFSET -0.2 -0.17 -0.015
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET -0.16 -0.135 0.055
      }
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.0416667
0 0.95 0 0 0 0 0 0 0 0 0 0
0 0.96 0 1 2 3 10 5 2.5 0 20 0
0 0.95 0 0 0 0 20 10 5 0 40 0
"""
CHARACTER_SCENE = """[rig]
file = "{rig}"
[rig.clip]
{clip}
[[muscle]]
name = "a"
path = [["RightArm", 0, 0, 0.02], ["RightForeArm", 0.1, 0, 0.02]]
profile = {{ around = 8, rings = 6, radius = [[0, 0.01]] }}
[skin]
kind = "skinned"
"""
CLIP_SCENE = """[rig]
file = "rig.urdf"
[rig.clip]
file = "{clip}"
columns = {{ elbow = "elbow", wrist = "" }}
[[muscle]]
name = "a"
path = [["humerus", 0.03, -0.03, 0], ["ulna", 0.03, -0.05, 0]]
profile = {{ around = 8, rings = 6, radius = [[0, 0.01]] }}
"""


def mutate(files, rng):
    """One of them with one change, two or four."""
    data = bytearray(rng.choice(files))
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        at = rng.randrange(len(data) + 1)
        length = rng.randrange(min(64, len(data) - at) + 1)
        way = rng.randrange(8)
        if way == 0 and at < len(data):
            data[at] ^= 1 << rng.randrange(8)
        elif way == 1 and at < len(data):
            data[at] = rng.randrange(256)
        elif way == 2:
            del data[at:at + length]
        elif way == 3:
            data[at:at] = data[at:at + length]
        elif way == 4 and rng.random() < 0.3:
            del data[at:]
        elif way == 5:
            data[at:at + length] = rng.choice(WORDS)
        elif way == 6 and rng.random() < 0.3:
            other = rng.choice(files)
            data[at:] = other[rng.randrange(len(other) + 1):]
        else:  # a number of its own, much larger
            while at < len(data) and not 0x31 <= data[at] <= 0x39:
                at += 1
            data[at:at] = b"9" * rng.randint(1, 12) if at < len(data) else b""
    return bytes(data)


def files_of(folder):
    return [path.read_bytes() for path in sorted(folder.iterdir())]


def shared(*names):
    return [(SHARED / name).read_bytes() for name in names if (SHARED / name).exists()]


class Reader:
    """The folder that a mutant of each kind is put into, and the command that reads it."""

    def __init__(self, storm):
        self.storm, self.folder = storm, storm.work / "given"
        for scene in ["pressed", "every_key", "one_muscle", "pair"]:
            shutil.copytree(SCENES / scene, self.folder, dirs_exist_ok=True)
        figure = (SCENES / "figure/figure.gltf").read_bytes()
        (self.folder / "figure.gltf").write_bytes(figure)
        self.scene_of_pair = (SCENES / "pair/scene.toml").read_text()
        more = [(SOURCE / "tests/storm" / name).read_bytes()
                for name in ["numbers.toml", "character.toml"]]
        self.files = {
            "scene": files_of(CORPUS / "scene") + more, "urdf": files_of(CORPUS / "urdf"),
            "clip": files_of(CORPUS / "clip") + [BVH] * 2 + shared("makehuman_dance1.bvh"),
            "mesh": files_of(CORPUS / "mesh"),
            "character": [figure] * 4 + shared("robot_expressive.glb", "cesium_man.gltf")}

    def put(self, name, data):
        file = self.folder / name
        file.write_bytes(data if isinstance(data, bytes) else data.encode())
        return file

    def dry_run(self, scene, number):
        return ["bake", scene, "--dry-run", "--out", self.folder / f"out{number}"]

    def scene(self, number, data):
        file = self.put(f"{number}.toml", data)
        return ["inspect", file] if number % 2 else self.dry_run(file, number), [file]

    def urdf(self, number, data):
        rig = self.put(f"{number}.urdf", data)
        scene = self.put(f"{number}.toml", self.scene_of_pair.replace("rig.urdf", rig.name))
        return self.dry_run(scene, number), [rig, scene]

    def clip(self, number, data):
        if data.startswith(b"HIERARCHY"):
            clip = self.put(f"{number}.bvh", data)
            scene = CHARACTER_SCENE.format(rig="figure.gltf", clip=f'file = "{clip.name}"')
        else:
            clip = self.put(f"{number}.{'csv' if b'time' in data[:8] else 'mot'}", data)
            scene = CLIP_SCENE.format(clip=clip.name)
        scene = self.put(f"{number}.toml", scene)
        return self.dry_run(scene, number), [clip, scene]

    def mesh(self, number, data):
        ending, _, rest = data.partition(b"\n")  # a file of the corpus begins with its ending
        word = ending.decode(errors="replace")
        mesh = self.put(f"{number}.{word if word.isalnum() and len(word) < 6 else 'obj'}", rest)
        return ["inspect", mesh], [mesh]

    def character(self, number, data):
        ending = "glb" if data.startswith(b"glTF") else "gltf"
        rig = self.put(f"{number}.{ending}", data)
        if number % 2:
            return ["inspect", rig], [rig]
        scene = self.put(f"{number}.toml",
                         CHARACTER_SCENE.format(rig=rig.name, clip='animation = "wave"'))
        return self.dry_run(scene, number), [rig, scene]


class Bakes:
    """A whole bake, and one that has all its parts and no room for bake.h5."""

    def __init__(self, storm):
        self.storm = storm
        self.whole, self.parts = storm.work / "whole", storm.work / "parts"
        storm.check(storm.run(self.words(self.whole)), "the bake itself", [0])
        self.bytes = (self.whole / "bake.h5").read_bytes()
        blocks = Limits(file_blocks=len(self.bytes) // 512 - 1)
        storm.check(storm.run(self.words(self.parts), blocks), "the bake that keeps parts", [4])
        self.names = sorted(path.name for path in (self.parts / "bake.parts").iterdir())

    def words(self, out):
        return ["bake", SCENES / "pair/scene.toml", "--frames", "1-6", "--out", out, "--no-render",
                "--progress", "none", "--threads", "1"]

    def cache(self, number, rng):
        file = self.storm.work / f"{number}.h5"
        file.write_bytes(mutate([self.bytes], rng))
        self.storm.check(self.storm.run(["inspect", file]), f"cache {number}", [0, 3],
                         inputs=[file])
        file.unlink()

    def part(self, number, rng):
        out = self.storm.work / f"out{number}"
        shutil.copytree(self.parts, out)
        file = out / "bake.parts" / self.names[rng.randrange(len(self.names))]
        name = f"parts {number}, {file.name}"
        file.write_bytes(mutate([file.read_bytes()], rng))
        mutant = file.read_bytes()
        ended = self.storm.run([*self.words(out), "--resume"])
        # What says which scene it is of may have changed; then it is another's, and left alone.
        codes = [0] if file.name != "bake.json" else [0, 2, 3]
        self.storm.check(ended, name, codes, inputs=[file])
        if ended.code == 0 and (out / "bake.h5").read_bytes() != self.bytes:
            file.parent.mkdir(exist_ok=True)
            file.write_bytes(mutant)
            self.storm.fail("different", name, "the bake is not the uninterrupted one", ended,
                            [file])
        if ended.code != 0 and file.read_bytes() != mutant:
            self.storm.fail("lost", name, "what was refused was changed", ended)
        shutil.rmtree(out)


def run(storm):
    reader, bakes = Reader(storm), Bakes(storm)
    accepted = dict.fromkeys(COUNTS, 0)

    def try_one(case):
        number, kind = case
        rng = random.Random(number)
        if kind in ("cache", "parts"):
            (bakes.cache if kind == "cache" else bakes.part)(number, rng)
            return
        words, inputs = getattr(reader, kind)(number, mutate(reader.files[kind], rng))
        ended = storm.run(words)
        storm.check(ended, f"{kind} {number}", [0, 1, 2, 3], inputs=inputs, may_say_nan=True)
        accepted[kind] += ended.code == 0
        if "--dry-run" in words and words[-1].exists():
            storm.fail("silent", f"{kind} {number}", "a dry run wrote something", ended, inputs)
            shutil.rmtree(words[-1])
        for file in inputs:
            file.unlink(missing_ok=True)

    kinds = [kind for kind, count in COUNTS.items() for _ in range(count)]
    storm.over(try_one, storm.every(enumerate(kinds)))
    storm.notes.append(", ".join(f"{count} {kind}" for kind, count in accepted.items() if count) +
                       " accepted")
