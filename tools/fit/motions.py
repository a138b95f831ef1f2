#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How the muscles of characters follow motions: motions.py THEW FOLDER CHARACTER... [MOTION...]
CHARACTER is a glTF, VRM, FBX or Collada file. MOTION is a BVH, or random:N, which is N seeded
motions of shoulder, elbow and forearm within a human's range. Each character's scene is made as
table.py makes it, FOLDER/NAME/NAME.toml, and baked whole in its own animations and in each MOTION;
their rows in the README.md beside this file are rewritten."""
import concurrent.futures
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys

README = pathlib.Path(__file__).with_name("README.md")
HEAD = "| character | motion |"
FPS = 24
KEYS, KEY_FRAMES, PIECES = 5, 12, 24  # poses of a random motion, frames and samples between two


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    try:
        return done.returncode, json.loads(done.stdout)
    except ValueError:
        return done.returncode, {"message": done.stderr.strip()}


# Rotations as rows of 3 x 3.

def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def about(axis, angle):
    x, y, z = axis
    s, c = math.sin(angle), math.cos(angle)
    d = 1 - c
    return [[c + d * x * x, d * x * y - s * z, d * x * z + s * y],
            [d * x * y + s * z, c + d * y * y, d * y * z - s * x],
            [d * x * z - s * y, d * y * z + s * x, c + d * z * z]]


def zxy(r):
    """degrees, r = Rz Rx Ry"""
    return [math.degrees(a) for a in (math.atan2(-r[0][1], r[1][1]),
                                      math.asin(max(-1.0, min(1.0, r[2][1]))),
                                      math.atan2(-r[2][0], r[2][2]))]


def random_angles(generator):
    """rad: elevation, its plane (0 outward, 90 degrees forward), axial turn, elbow, roll"""
    plane = generator.uniform(-60, 130)
    most = 60 if plane < 0 else 150 if plane < 90 else 100
    angles = (generator.uniform(0, most), plane, generator.uniform(-70, 80),
              generator.uniform(0, 140), generator.uniform(-80, 80))
    return [math.radians(a) for a in angles]


def arm_turns(angles, side):
    """Of upper arm and forearm, which lie along x at rest; side: -1 right, 1 left."""
    elevation, plane, axial, elbow, roll = angles
    mirror = -side  # turns about y and z change their sign in the mirror
    hanging = about((0, 0, 1), mirror * math.pi / 2)
    up = about((-math.sin(plane), 0, side * math.cos(plane)), elevation)
    upper = times(times(up, about((0, 1, 0), mirror * axial)), hanging)
    return upper, times(about((0, 1, 0), mirror * elbow), about((-1, 0, 0), roll))


def joint(name, offset, children=()):
    inner = "".join(children) or "End Site\n{\nOFFSET %g 0 0\n}\n" % (offset[0] or 0.1)
    return "JOINT %s\n{\nOFFSET %g %g %g\nCHANNELS 3 Zrotation Xrotation Yrotation\n%s}\n" % (
        (name,) + tuple(offset) + (inner,))


def write_random_bvh(file, seed):
    generators = {-1: random.Random(2 * seed), 1: random.Random(2 * seed + 1)}
    arms = [joint(word + "Shoulder", (side * 0.03, 0.15, 0), [
        joint(word + "Arm", (side * 0.14, 0, 0), [
            joint(word + "ForeArm", (side * 0.29, 0, 0), [
                joint(word + "Hand", (side * 0.25, 0, 0))])])])
        for side, word in ((-1, "Right"), (1, "Left"))]
    spine = joint("Spine", (0, 0.2, 0), [joint("Neck", (0, 0.25, 0))] + arms)
    lines = []
    start, end = {}, {side: random_angles(generators[side]) for side in generators}
    for k in range((KEYS - 1) * PIECES + 1):
        if k % PIECES == 0:
            start = end
            end = {side: random_angles(generators[side]) for side in generators}
        t = k % PIECES / PIECES
        t = t * t * (3 - 2 * t)
        row = [0.0, 0.9, 0.0] + [0.0] * 9  # hips, spine, neck
        for side in (-1, 1):
            angles = [(1 - t) * a + t * b for a, b in zip(start[side], end[side])]
            upper, fore = arm_turns(angles, side)
            row += [0.0] * 3 + zxy(upper) + zxy(fore) + [0.0] * 3
        lines.append(" ".join("%.6f" % value for value in row))
    file.write_text(
        "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0.9 0\nCHANNELS 6 Xposition Yposition Zposition "
        "Zrotation Xrotation Yrotation\n%s}\nMOTION\nFrames: %d\nFrame Time: %.9f\n%s\n"
        % (spine, len(lines), KEY_FRAMES / FPS / PIECES, "\n".join(lines)))


def seconds_of(bvh):
    words = bvh.read_text().split()
    return int(words[words.index("Frames:") + 1]) * float(words[words.index("Time:") + 1])


def motions_of(thew, scene, character, asked):
    """(row's name, clip in TOML, seconds) each"""
    _, about_it = run(thew, "inspect", character, "--json")
    for one in about_it.get("animations", []):
        yield one["animation"], "animation = %s" % json.dumps(one["animation"]), one["seconds"]
    for word in asked:
        if word.startswith("random:"):
            for seed in range(1, int(word[7:]) + 1):
                bvh = scene.parent / ("random_%d.bvh" % seed)
                write_random_bvh(bvh, seed)
                yield "random", "file = %s" % json.dumps(bvh.name), seconds_of(bvh)
        else:
            bvh = scene.parent / pathlib.Path(word).name  # a scene's files lie below it
            shutil.copyfile(word, bvh)
            yield bvh.name, "file = %s" % json.dumps(bvh.name), seconds_of(bvh)


def bake(thew, scene, number, clip, seconds):
    frames = max(2, round(seconds * FPS))
    out = scene.parent / ("motion_%d" % number)
    code, answer = run(thew, "bake", scene, "--out", out, "--frames", "1-%d" % frames,
                       "--overwrite", "--no-render", "--threads", "1", "--progress", "none",
                       "--json", "--set", "rig.clip={ %s }" % clip,
                       "--set", 'scene.frames="1-%d"' % frames)
    found = {"code": code, "frames": frames, "bakes": 1}
    if code not in (0, 1):
        found["why"] = answer.get("error", answer).get("message", "")
        return found
    report = json.loads((out / "report.json").read_text())
    _, crossings = run(thew, "inspect", out / "bake.h5", "--json")
    by_frame = crossings.get("crossings_by_frame", [])
    found["bone"] = [one["bone and muscle"]["deepest_penetration_mm"] for one in by_frame]
    found["muscle"] = [one["muscle and muscle"]["deepest_penetration_mm"] for one in by_frame]
    found["volume"] = max(one["max_volume_error"] for one in report["muscles"])
    found["out"] = 1e3 * report["skin"]["max_poke_through_m"]
    found["into"] = 1e3 * report["skin"]["max_penetration_m"]
    found["covered"] = 1e3 * report["skin"]["max_covered_penetration_m"]
    found["rungs"] = sum(len(one["frames"]) for one in report["rungs"])
    found["muscle_frames"] = frames * len(report["muscles"])
    (out / "bake.h5").unlink()
    return found


def together(many):
    """The worst of several bakes."""
    sums = ("frames", "rungs", "muscle_frames", "bone", "muscle", "bakes")
    all_of = {}
    for one in many:
        for key, value in one.items():
            if key not in all_of:
                all_of[key] = value
            elif key in sums:
                all_of[key] = all_of[key] + value
            else:
                all_of[key] = max(all_of[key], value)
    return all_of


def share_below(values, limit):
    return "%.0f %%" % math.floor(100.0 * sum(v <= limit for v in values) / max(1, len(values)))


def row_of(character, name, all_of):
    bakes = "" if all_of["bakes"] == 1 else "%d × " % all_of["bakes"]
    cells = [character.name, bakes + name, all_of["frames"], all_of["code"]]
    if "volume" not in all_of:
        return cells + [all_of["why"]]
    return cells + ["%.0e" % all_of["volume"], "%.1f" % max(all_of["bone"], default=0.0),
                    share_below(all_of["muscle"], 3.0), "%.1f" % max(all_of["muscle"], default=0.0),
                    "%.1f" % all_of["out"], "%.1f" % all_of["into"],
                    "%.1f" % all_of["covered"],
                    "%.2f %%" % (100.0 * all_of["rungs"] / all_of["muscle_frames"])]


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    thew, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    is_motion = [word.startswith("random:") or word.endswith(".bvh") for word in sys.argv[3:]]
    asked = [word for word, motion in zip(sys.argv[3:], is_motion) if motion]
    lines = README.read_text().splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith(HEAD))
    end = next((i for i in range(head, len(lines)) if not lines[i].startswith("|")), len(lines))
    rows = {tuple(cell.strip() for cell in line.split("|")[1:3]): line
            for line in lines[head + 2:end]}
    for word in (word for word, motion in zip(sys.argv[3:], is_motion) if not motion):
        character = pathlib.Path(word)
        scene = folder / character.stem / (character.stem + ".toml")
        code, made = run(thew, "new", character, "--out", scene, "--force", "--json")
        if code != 0:
            print("%s: %s" % (character, made.get("error", made).get("message", "")))
            continue
        motions = list(motions_of(thew, scene, character, asked))
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda at: bake(thew, scene, at, *motions[at][1:]),
                                  range(len(motions))))
        for name in dict.fromkeys(one[0] for one in motions):
            cells = row_of(character, name, together(
                [one for motion, one in zip(motions, found) if motion[0] == name]))
            line = "| " + " | ".join(str(cell).replace("|", "/").replace("\n", " ")
                                     for cell in cells) + " |"
            rows[(cells[0], cells[1])] = line
            print(line, flush=True)
        README.write_text("\n".join(lines[:head + 2] + [rows[key] for key in sorted(rows)] +
                                    lines[end:]) + "\n")


main()
