# SPDX-License-Identifier: Apache-2.0
"""All parts of the storm, one after the other; run.sh says how it is called.

What failed is kept in BUILD/storm.failed/PART (PART.N of a share), each case a folder: its inputs
and `what`, which has the command and what it said.
"""
import argparse
import importlib
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

from trial import Skipped, Storm

PARTS = ["mutants", "bakes", "numbers", "kills", "disks", "memory"]


def main():
    parser = argparse.ArgumentParser(prog="run.sh", description=__doc__.splitlines()[0])
    parser.add_argument("build", type=Path, help="folder of a build, as build/release")
    parser.add_argument("--share", type=int, default=1, metavar="N", help="each N-th case alone")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="so many at a time")
    parser.add_argument("--sanitized", action="store_true", help="a sanitizer's build: no limits")
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS) + "; all")
    given = parser.parse_intermixed_args()
    for part in given.parts:
        if part not in PARTS:
            parser.error(f"no part \"{part}\"; there are {', '.join(PARTS)}")
    build = given.build.resolve()
    if not (build / "tools/thew").exists():
        parser.error(f"{build}/tools/thew is not there; build it first")

    failed, skipped = [], []
    wanted = given.parts or PARTS
    for name in wanted:
        kept = build / "storm.failed" / (f"{name}.{given.share}" if given.share > 1 else name)
        shutil.rmtree(kept, ignore_errors=True)
        with tempfile.TemporaryDirectory(prefix=f"thew_storm_{name}_") as work:
            storm = Storm(name, build, Path(work), kept, given)
            begin = time.monotonic()
            try:
                importlib.import_module(f"part_{name}").run(storm)
            except Skipped as why:
                print(f"{name}: skipped: {why}", flush=True)
                skipped.append(name)
                continue
            print(f"{storm.line()}; {time.monotonic() - begin:.0f} s", flush=True)
            if storm.failures:
                failed.append(name)
                print(f"{name}: what failed is in {kept}", flush=True)
    if failed:
        return 1
    return 77 if len(skipped) == len(wanted) else 0


if __name__ == "__main__":
    os.environ["LC_ALL"] = "C"
    sys.exit(main())
