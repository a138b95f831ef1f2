#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What `thew new` makes of characters: table.py THEW FOLDER CHARACTER...
Makes FOLDER/NAME/NAME.toml of each character, without any option, and bakes it there, then rewrites
the rows of these characters in the README.md beside this file. Their last column is by hand: what
was seen in FOLDER/NAME/bake/frames."""
import json
import pathlib
import subprocess
import sys

README = pathlib.Path(__file__).with_name("README.md")
HEAD = "| character |"


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    try:
        return done.returncode, json.loads(done.stdout)
    except ValueError:
        return done.returncode, {"message": done.stderr.strip()}


def cell(text):
    return str(text).replace("|", "/").replace("\n", " ")


def row_of(thew, folder, character, seen):
    name = character.stem
    scene = folder / name / (name + ".toml")
    code, made = run(thew, "new", character, "--out", scene, "--force", "--json")
    if code != 0:
        why = made.get("error", made).get("message", "")
        return [character.name, "`new` ends with %d: %s" % (code, why.replace(str(folder), ""))]
    arm = made["arms"][0]
    code, _ = run(thew, "bake", scene, "--out", scene.parent / "bake", "--overwrite", "--json",
                  "--progress", "none")
    out = into = "-"
    if code in (0, 1):
        report = json.loads((scene.parent / "bake" / "report.json").read_text())
        out = "%.1f" % (1e3 * report["skin"]["max_poke_through_m"])
        into = "%.1f" % (1e3 * report["skin"]["max_penetration_m"])
    return [character.name,
            " ".join(arm[part] for part in ("clavicle", "humerus", "forearm", "hand")),
            "%.2f" % made["size"],
            " / ".join("%.1f" % (100 * arm[part])
                       for part in ("upper_arm_girth_m", "forearm_girth_m")),
            "%.0f (%.0f)" % (1e6 * made["volume_m3"], 1e6 * made["volume_in_proportion_m3"]),
            "%.2f" % made["room_filled"], code, out, into, seen]


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    thew, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    lines = README.read_text().splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith(HEAD))
    end = next((i for i in range(head, len(lines)) if not lines[i].startswith("|")), len(lines))
    rows = {line.split("|")[1].strip(): line for line in lines[head + 2:end]}
    for character in map(pathlib.Path, sys.argv[3:]):
        old = rows.get(character.name, "").split("|")
        cells = row_of(thew, folder, character, old[-2].strip() if len(old) > 2 else "")
        cells += [""] * (lines[head].count("|") - 1 - len(cells))
        rows[character.name] = "| " + " | ".join(map(cell, cells)) + " |"
        print(rows[character.name], flush=True)
        README.write_text("\n".join(lines[:head + 2] + list(rows.values()) + lines[end:]) + "\n")


main()
