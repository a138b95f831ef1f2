# SPDX-License-Identifier: Apache-2.0
"""python3 -m thew ARGUMENTS: the command that was installed or built with this module."""

import os
import pathlib
import shutil
import sys


def command() -> str:
    here = pathlib.Path(__file__).parent.absolute()
    # PREFIX/lib/python3.11/dist-packages/thew; BUILD/tools/python/thew.
    for place in (here.parents[3] / "bin/thew", here.parents[1] / "thew"):
        if place.is_file() and os.access(place, os.X_OK):
            return str(place)
    found = shutil.which("thew")
    if found is None:
        sys.exit("thew: the command is not installed beside the module; install it")
    return found


if __name__ == "__main__":
    os.execv(command(), ["thew", *sys.argv[1:]])
