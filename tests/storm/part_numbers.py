# SPDX-License-Identifier: Apache-2.0
"""Each number of a scene and of its rig made wild, for every integrator and volume mode, and each
of a character's: refused with its line, or baked, or given up with a reason; nothing that is not a
number is in the cache."""
import json
import re
import shutil

from trial import SOURCE, Limits, need_h5py

VALUES = ["nan", "inf", "-inf", "1e308", "-1e308", "5e-324", "1e-9", "0", "-1", "0.5", "1e9",
          "2147483648", "-9223372036854775808"]
INTEGRATORS = ["local_global", "quasi_static", "xpbd", "explicit"]
VOLUMES = ["exact", "none", "penalty", "linear", "printed", "zonal", "exact_always"]
LITERAL = re.compile(r"(?<![\w.#])[-+]?\d+(\.\d+)?(e[-+]?\d+)?(?!\w)")
BAKED = [0, 1, 5, 75]


def literals(text, comment):
    """(begin, end, line) of each number in it."""
    for number, line in enumerate(text.splitlines(keepends=True), 1):
        if not line.startswith(comment):
            for found in LITERAL.finditer(line):
                yield found.start(), found.end(), number


def replaced(text, literal, value):
    begin, end, number = literal
    lines = text.splitlines(keepends=True)
    line = lines[number - 1]
    lines[number - 1] = line[:begin] + value + line[end:]
    return "".join(lines)


def settings(pair):
    if not pair:  # as the scene has it, which asks for a tolerance
        return []
    integrator, volume = pair
    words = ["--set", f"solver.integrator={integrator}", "--set", f"solver.volume={volume}"]
    if integrator in ("xpbd", "explicit"):  # which cannot solve it
        words += ["--set", "contact.self=[]"]
    return words


def for_volume(text, pair):
    """The scene without what the volume mode cannot hold."""
    return text.partition("\n# A soft body")[0] + "\n" if "printed" in pair else text


def wrong_with(out):
    """What of a bake's cache or report is not a number, or nothing."""
    import h5py
    import numpy as np

    def refuse(word):
        raise ValueError(f"{word} in report.json")

    def look(name, item):
        if isinstance(item, h5py.Dataset) and not np.isfinite(item[()]).all():
            raise ValueError(f"{name} is not finite")
    try:
        json.loads((out / "report.json").read_text(), parse_constant=refuse)
        with h5py.File(out / "bake.h5", "r") as file:
            file.visititems(look)
    except (OSError, ValueError) as why:
        return str(why)
    return ""


def run(storm):
    need_h5py()
    folder = storm.work / "scene"
    shutil.copytree(SOURCE / "tests/scenes/pair", folder)
    shutil.copy(SOURCE / "tests/scenes/figure/figure.gltf", folder)
    texts = {"rig.urdf": (folder / "rig.urdf").read_text()}
    for name in ["numbers.toml", "character.toml"]:
        texts[name] = (SOURCE / "tests/storm" / name).read_text()
        (folder / name).write_text(texts[name])
    # What is legal and slow, as a stiff spring of the explicit step, is interrupted and says so.
    limits = Limits(seconds=10, patience=5)
    slow = []

    def bake(scene, out, pair):
        return storm.run(["bake", scene, "--out", out, "--no-render", "--progress", "none",
                          "--threads", "1", *settings(pair)], limits)

    pairs = []
    for pair in [(i, v) for i in INTEGRATORS for v in VOLUMES]:
        calm = folder / "calm.toml"
        calm.write_text(for_volume(texts["numbers.toml"], pair))
        ended = bake(calm, storm.work / "calm", pair)
        shutil.rmtree(storm.work / "calm", ignore_errors=True)
        if ended.code != 2:  # which says that they do not go together
            storm.check(ended, f"{pair}", [0, 5], limits)
            pairs.append(pair)

    def try_one(case):
        number, (file, literal, value, pair) = case
        out = storm.work / f"out{number}"
        mine = folder / f"{number}.{file.split('.')[1]}"
        mine.write_text(replaced(for_volume(texts[file], pair), literal, value))
        if file == "rig.urdf":
            scene = folder / f"{number}.toml"
            scene.write_text(for_volume(texts["numbers.toml"], pair).replace("rig.urdf", mine.name))
        else:
            scene = mine
        ended = bake(scene, out, pair)
        name = (f"{file}:{literal[2]}: {texts[file].splitlines()[literal[2] - 1].strip()[:60]}:"
                f" column {literal[0]} is {value}{', ' * bool(pair)}{' '.join(pair)}")
        inputs = [mine, scene]
        if ended.code == 75:
            slow.append(name)
        limit = limits if ended.code in BAKED else Limits(seconds=2)
        is_number = value not in ("nan", "inf", "-inf")
        storm.check(ended, name, [0, 1, 2, 3, 5, 75], limit, inputs, may_say_nan=not is_number)
        # urdfdom knows of no lines.
        place = f"{mine.name}:" if file == "rig.urdf" else f"{mine.name}:{literal[2]}:"
        if not is_number:
            if ended.code in BAKED:
                storm.fail("silent", name, f"code {ended.code}", ended, inputs)
            elif place not in "".join(ended.errors):
                storm.fail("ill told", name, "its place is not named: " + "".join(ended.errors),
                           ended, inputs)
        if ended.code in (0, 1):
            wrong = wrong_with(out)
            if wrong:
                storm.fail("silent", name, wrong, ended, inputs)
        if ended.code == 5 and not (out / "failure.json").exists():
            storm.fail("ill told", name, "no failure.json", ended, inputs)
        shutil.rmtree(out, ignore_errors=True)
        for file in inputs:
            file.unlink(missing_ok=True)

    found = {file: list(literals(texts[file], "#" if file.endswith("toml") else "<?"))
             for file in texts}
    cases = [(file, literal, value, pair) for pair in [*pairs, ()] for file in texts
             if bool(pair) == (file != "character.toml")
             for literal in found[file] for value in VALUES
             if literal[2] <= for_volume(texts[file], pair).count("\n")]
    storm.notes.append(f"{sum(map(len, found.values()))} numbers × {len(VALUES)} values;"
                       f" {len(pairs)} pairs of integrator and volume")
    storm.over(try_one, storm.every(enumerate(cases)))
    if slow:
        storm.notes.append(f"{len(slow)} interrupted after {limits.patience:.0f} s")
