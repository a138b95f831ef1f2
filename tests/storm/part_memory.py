# SPDX-License-Identifier: Apache-2.0
"""Commands under `ulimit -v` from 200 MB to 2 GB in 30 steps: done, or one error that says why."""
import shutil

from trial import SOURCE, Limits, Skipped, put_users_files

SCENE = SOURCE / "tests/scenes/pair/scene.toml"
STEPS = 30


def run(storm):
    if storm.sanitized:
        raise Skipped("a sanitizer takes what memory it likes")
    whole, other = storm.work / "whole", storm.work / "other"
    calm = Limits(seconds=60)
    words = ["bake", SCENE, "--progress", "none", "--out"]
    storm.check(storm.run([*words, whole], calm), "the bake itself", [0], calm)
    other_words = [*words, other, "--no-render", "--set", "solver.volume=none"]
    storm.check(storm.run(other_words, calm), "the bake that differs", [0], calm)
    bake = whole / "bake.h5"
    commands = {
        "bake": [*words, "OUT/bake"],
        "inspect": ["inspect", bake],
        "compare": ["compare", bake, other / "bake.h5", "--html", "OUT/page.html"],
        "export": ["export", bake, "--progress", "none", "OUT/bake.glb"],
        "render": ["render", bake, "--scene", SCENE, "--progress", "none", "--out", "OUT/frames"],
    }
    done = {name: 0 for name in commands}
    not_loaded = []

    def try_one(case):
        name, megabytes = case
        out = storm.work / f"{name}_{megabytes}"
        put_users_files(out / "bake")
        put_users_files(out)  # beside the frames of `render` and the export
        words = [str(word).replace("OUT/", f"{out}/") for word in commands[name]]
        limits = Limits(seconds=20, address_kib=megabytes * 1000)
        ended = storm.run(words, limits)
        if any("error while loading shared libraries" in line for line in ended.errors):
            not_loaded.append(case)  # by the system, before there is a command
            return
        good = 1 if name == "compare" else 0
        storm.check(ended, f"{name}, {megabytes} MB", [good, 3, 4, 75], limits)
        left = [path for path in out.rglob("*") if path.suffix == ".tmp"]
        if left:
            storm.fail("lost", f"{name}, {megabytes} MB", f"left {left[0].name}", ended)
        if ended.code == good:
            done[name] += 1
        elif name == "bake":  # what it had is kept, and goes on where there is room
            again = storm.run([*words, "--resume"], Limits(seconds=20))
            storm.check(again, f"resumed after {megabytes} MB", [0], Limits(seconds=20))
        if name == "bake" and (out / "bake/bake.h5").exists():
            if (out / "bake/bake.h5").read_bytes() != bake.read_bytes():
                storm.fail("different", f"{name}, {megabytes} MB", "another bake.h5", ended)
        for folder in [out, out / "bake"]:
            storm.check_users_files(folder, f"{name}, {megabytes} MB", ended)
        shutil.rmtree(out)

    cases = [(name, 200 + 1800 * step // (STEPS - 1)) for step in range(STEPS)
             for name in commands]
    storm.over(try_one, storm.every(cases))
    storm.notes.append("done: " + ", ".join(f"{name} {count}" for name, count in done.items())
                       + f"; {len(not_loaded)} could not be loaded")
