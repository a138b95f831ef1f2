# SPDX-License-Identifier: Apache-2.0
"""Prints tools/farm/scale.md: scale.py THEW ROOT OUT [TASKS] >tools/farm/scale.md

All figures are measured: an arm that is baked and drawn in OUT, its system calls by strace (to be
installed), the disk of OUT, and the simulation of simulate.py. OUT should lie on the file system that is asked about.
"""
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time

THEW, ROOT, OUT = (os.path.abspath(word) for word in sys.argv[1:4])
HERE = os.path.dirname(os.path.abspath(__file__))
SHOTS, CHARACTERS, FRAMES, NIGHT_HOURS = 200, 10, 120, 10
SCENE = f"{ROOT}/assets/arm/arm.toml"
BAKES = SHOTS * CHARACTERS


def bake(out, *more, before=()):
    begin = time.monotonic()
    subprocess.run([*before, THEW, "bake", SCENE, "--out", out, "--threads", "1", "--progress", "none",
                    "--bounds", "warn", *more], check=True, stderr=subprocess.DEVNULL)
    return time.monotonic() - begin


def holdings(folder):
    files = [os.path.join(at, name) for at, _, names in os.walk(folder) for name in names]
    return len(files), sum(os.path.getsize(file) for file in files)


def calls(*more):
    """System calls that wait for a disk, of a bake of so many frames."""
    with tempfile.NamedTemporaryFile("r") as table:
        shutil.rmtree(f"{OUT}/traced", ignore_errors=True)
        bake(f"{OUT}/traced", *more,
             before=("strace", "-f", "-c", "-e", "trace=rename,fsync,fdatasync,openat,flock", "-o",
                     table.name))
        counts = dict.fromkeys(("rename", "fsync", "openat", "flock"), 0)
        for line in table.read().splitlines():
            words = line.split()
            if words and words[-1] in counts:
                counts[words[-1]] = int(words[3])
        return counts


def per_frame_calls(*more):
    few, many = calls("--frames", "1-4", *more), calls("--frames", "1-12", *more)
    return {name: (many[name] - few[name]) / 8 for name in many}


def disk_rates():
    """Files written, synced and renamed in a second, with and without the sync of the folder."""
    rates = {}
    folder = f"{OUT}/disk"
    os.makedirs(folder, exist_ok=True)
    for what in ("rename", "fsync"):
        begin, count = time.monotonic(), 0
        while time.monotonic() - begin < 3.0:
            path = f"{folder}/{count % 500}"
            descriptor = os.open(path + ".tmp", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.write(descriptor, b"x" * 4096)
            if what == "fsync":
                os.fsync(descriptor)
            os.close(descriptor)
            os.rename(path + ".tmp", path)
            count += 1
        rates[what] = count / (time.monotonic() - begin)
    return rates


def megabytes(count):
    return f"{count / 1e6:.2f} MB" if count < 1e9 else f"{count / 1e9:.0f} GB"


def main():
    os.makedirs(OUT, exist_ok=True)
    whole = f"{OUT}/arm"
    shutil.rmtree(whole, ignore_errors=True)
    bake(whole)
    with open(f"{whole}/report.json", encoding="utf-8") as file:
        report = json.load(file)
    cpu = report["cpu_seconds"]
    solved = sum(cpu[stage] for stage in cpu if stage not in ("total", "render"))
    frames = len(report["frames"])
    cache = os.path.getsize(f"{whole}/bake.h5") / frames
    pictures, picture_bytes = holdings(f"{whole}/frames")
    files, size = holdings(whole)

    parts = f"{OUT}/parts"
    shutil.rmtree(parts, ignore_errors=True)
    bake(parts, "--frames", "1-12", "--chunk")
    part_files, part_bytes = holdings(f"{parts}/bake.parts")
    of_bake, of_drawing = per_frame_calls("--chunk"), per_frame_calls()
    rates = disk_rates()
    show = subprocess.run([sys.executable, f"{HERE}/simulate.py", THEW, ROOT, f"{OUT}/show",
                           str(SHOTS), str(CHARACTERS)], check=True, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, text=True).stdout
    processor = re.search(r"model name\s*: (.*)", open("/proc/cpuinfo", encoding="utf-8").read())
    hours = cpu["total"] * BAKES / 3600
    syncs = of_drawing["fsync"] * FRAMES * BAKES / (NIGHT_HOURS * 3600)
    renames = of_drawing["rename"] * FRAMES * BAKES / (NIGHT_HOURS * 3600)

    print(f"""# What a show asks for

Written by `tests/farm/scale.py`, whose figures are measured where it runs: {processor[1] if processor else platform.machine()},
one core a task. The show: {SHOTS} shots × {CHARACTERS} characters = {BAKES:,} bakes of the arm (twelve muscles,
skin, contact), {FRAMES} frames each, with {len(of_views(whole))} views drawn, in a night of {NIGHT_HOURS} h.

## Bytes and files

| | a frame | a bake | the show |
| --- | --- | --- | --- |
| `bake.h5` | {megabytes(cache)} | {megabytes(cache * FRAMES)} | {megabytes(cache * FRAMES * BAKES)} |
| pictures and movies | {megabytes(picture_bytes / frames)} | {megabytes(picture_bytes)} | {megabytes(picture_bytes * BAKES)} |
| all that stays | {megabytes(size / frames)} | {megabytes(size)}, {files} files | {megabytes(size * BAKES)}, {files * BAKES:,} files |
| `bake.parts/`, until a bake ends | {megabytes(part_bytes / 12)} | {megabytes(part_bytes / 12 * FRAMES)}, {FRAMES + part_files - 12} files | as many as run at once |

A part is larger than its frame in the cache, as it is in double precision and not compressed; one
for each half second of steps also holds the solver's state, so that a bake can be resumed from it.
Chunks stay after they are joined, as large as these parts, until somebody removes them. Files of the
show are mostly pictures: one a view and frame.

## What a shared file system bears

System calls a frame (strace, 12 frames less 4):

| | `fsync` | `rename` | `openat` | `flock` |
| --- | --- | --- | --- | --- |
| a bake without pictures | {of_bake['fsync']:.1f} | {of_bake['rename']:.1f} | {of_bake['openat']:.1f} | {of_bake['flock']:.1f} |
| with its pictures | {of_drawing['fsync']:.1f} | {of_drawing['rename']:.1f} | {of_drawing['openat']:.1f} | {of_drawing['flock']:.1f} |

Over the night the show asks for {syncs:.0f} `fsync` and {renames:.0f} `rename` a second. The disk here does {rates['rename']:.0f}
files a second that are written and renamed, {rates['fsync']:.0f} that are synced as well. For a file server,
run this script with OUT on it. Where it is the limit, let a shot write fewer frames
(`frames = "1-120x2"`): pictures ask for most of it.

Locks are `flock` on the bake's folder and, for one line, on its list of files. NFS from version 4
on, or version 3 with its lock service, keeps them between machines; on a mount with `nolock` two
machines may bake into one folder at once, and this is not noticed.

## Scheduler

A simulated run of the show: real graph, arrays and `submit.sh`, a played cluster in which one task in
a hundred fails and as many are interrupted (`tests/farm/simulate.py`); what failed is submitted again:

```
{show.rstrip()}
```

Of Slurm's limits, `MaxArraySize=1001` is kept (arrays of 1,000 at most), and `MaxJobCount=10000` is
not: it counts every task of an array, so that this show wants it to be raised. Where the queue is
full, the submission breaks off, and `submit.sh` goes on later. A bake's tasks are at most 5 deep, of
10 that are looked through for circles (`max_depend_depth`). Open Job Description allows 1,024 values
of a task parameter, of which 1,000 are used, and says nothing of the number of steps.

## A night's cost

A bake takes {cpu['total']:.0f} CPU seconds here, {solved:.0f} of them to solve and measure, {cpu['render']:.0f} to draw. The show: {hours:.0f} core
hours, which {max(1, round(hours / NIGHT_HOURS))} cores do in the night. A task costs {show_setup(report):.1f} s more than its frames (the scene is
read, muscles settle), which a chunk of few frames pays again and again: let a chunk take ten times
that at least. `OUT/pilot.json` has these figures for your own characters, and `thew farm JOBS.toml
--dry-run` adds them up.""")


def of_views(folder):
    return {name.split(".")[0] for name in os.listdir(f"{folder}/frames") if name.endswith(".png")
            and name.count(".") == 2}


def show_setup(report):
    return sum(report["cpu_seconds"][stage] for stage in ("setup", "settle"))


main()
