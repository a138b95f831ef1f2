# SPDX-License-Identifier: Apache-2.0
"""Storms of kills on the arm: each a bake with its pictures that is killed again and again, among
frames, while it packs and while it draws, and goes on with another number of threads each time. It
ends as if nothing had been, and the user's own files in its folder are as they were."""
import json
import os
import random
import shutil
import signal
import time

from trial import SOURCE, USERS_FILES, Limits, put_users_files

ARM = SOURCE / "assets/arm/arm.toml"
STORMS = 300
# One bake in ten goes through the fold of the skin, without pictures.
SETTINGS = {"early": ["--frames", "1-5", "--set", "render.size=[96,54]"],
            "fold": ["--frames", "44-56", "--no-render"]}
LIMITS = Limits(seconds=600, wall=600)


def words(out, settings, threads):
    return ["bake", ARM, "--out", out, "--resume", "--progress", "none", "--threads", str(threads),
            *settings]


def kept_frames(out):
    """Frames that the manifest lists; its last line may be torn."""
    manifest = out / "bake.parts/manifest.jsonl"
    try:
        lines = manifest.read_text().split("\n")[:-1]
    except OSError:
        return []
    return [json.loads(line)["frame"] for line in lines]


def pictures(out):
    return sorted(path for path in (out / "frames").glob("*.png")
                  if f"frames/{path.name}" not in USERS_FILES)


def bytes_of(out):
    """What a bake's folder holds that is the same each time."""
    return {path.name: path.read_bytes() for path in [out / "bake.h5", *pictures(out)]}


def await_moment(storm, process, out, moment, rng):
    """Waits for one of the moments at which a bake is most easily hurt, then a little more."""
    kind, count = moment
    while not storm.has_ended(process):
        if (kind == "frame" and len(kept_frames(out)) >= count or
                kind == "packing" and ((out / "bake.h5.tmp").exists() or
                                       (out / "bake.h5").exists()) or
                kind == "picture" and len(pictures(out)) >= count or
                kind == "time"):
            break
        time.sleep(0.001)
    time.sleep(rng.uniform(0.0, count if kind == "time" else 0.03))


def kind_of(number):
    return "fold" if number % 10 == 9 else "early"


def run(storm):
    storms = storm.every(range(STORMS))
    whole, seconds = {}, {}
    for name in sorted({kind_of(number) for number in storms}):
        out = storm.work / name
        begin = time.monotonic()
        ended = storm.run(words(out, SETTINGS[name], 2), LIMITS)
        seconds[name] = time.monotonic() - begin
        storm.check(ended, f"the bake itself, {name}", [0, 1], LIMITS)
        whole[name] = bytes_of(out)
        shutil.rmtree(out)
    killed = {"frame": 0, "packing": 0, "picture": 0, "time": 0}

    def try_one(number):
        rng = random.Random(number)
        kind = kind_of(number)
        settings = SETTINGS[kind]
        out = storm.work / f"storm{number}"
        put_users_files(out)
        name, kept, code = f"storm {number}, {kind}", [], None
        for kill in range(rng.randint(2, 6) + 1):
            moment = rng.choice([("time", 1.1 * seconds[kind]), ("frame", len(kept) + 1),
                                 ("frame", rng.randint(1, 5)), ("packing", 0),
                                 ("picture", rng.randint(1, 15))])
            process = storm.start(words(out, settings, rng.randint(1, 4)), LIMITS)
            await_moment(storm, process, out, moment, rng)
            os.kill(process.pid, signal.SIGKILL)
            ended = storm.finish(process, LIMITS)
            code = ended.code
            if code != -signal.SIGKILL:
                storm.check(ended, name, [0, 1], LIMITS)
                break
            killed[moment[0]] += 1
            now = kept_frames(out)
            if not (out / "bake.h5").exists() and now[:len(kept)] != kept:
                storm.fail("lost", name, f"kept {kept}, after kill {kill} {now}", ended)
            kept = now
        if code == -signal.SIGKILL:
            ended = storm.run(words(out, settings, rng.randint(1, 4)), LIMITS)
            storm.check(ended, name, [0, 1], LIMITS)
        found = bytes_of(out) if (out / "bake.h5").exists() else {}
        differing = [file for file in whole[kind] if found.get(file) != whole[kind][file]]
        if differing or len(found) != len(whole[kind]):
            more = sorted(found.keys() - whole[kind].keys())
            storm.fail("different", name, f"{differing} are not those of the uninterrupted bake,"
                       f" {more} are more", ended)
        left = [path for path in out.rglob("*")
                if path.suffix == ".tmp" or path.name == "bake.parts"]
        if left:
            storm.fail("lost", name, f"{left[0].name} is left", ended)
        storm.check_users_files(out, name, ended)
        shutil.rmtree(out)

    storm.over(try_one, storms)
    storm.notes.append("killed " + ", ".join(f"{count} by {moment}"
                                             for moment, count in killed.items()))
