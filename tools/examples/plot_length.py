# SPDX-License-Identifier: Apache-2.0
"""A muscle's length against a joint's angle:

    plot_length.py SCENE FOLDER [MUSCLE [JOINT [PICTURE]]]

Bakes the scene into the folder, or takes the bake that is there. With matplotlib it shows the curve,
or writes PICTURE; without, it prints the table.
"""
import math
import sys

import thew


def main(scene_file, folder, muscle="biceps_long", joint="elbow", picture=None):
    scene = thew.Scene.read(scene_file)
    bake = thew.bake(scene, folder, progress=lambda now: print(f"\r{now.done} of {now.of}", end=""))
    print()
    angles = [math.degrees(scene.pose(frame)[joint]) for frame in bake.frames]
    lengths = 1e3 * bake.metrics[f"length/{muscle}"]
    try:
        import matplotlib
        if picture:
            matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError:
        print(f"{joint} (deg)\t{muscle} (mm)")
        for angle, length in zip(angles, lengths):
            print(f"{angle:.1f}\t{length:.2f}")
        return
    pyplot.plot(angles, lengths)
    pyplot.xlabel(f"{joint} (deg)")
    pyplot.ylabel(f"{muscle} (mm)")
    pyplot.savefig(picture) if picture else pyplot.show()


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except thew.Error as error:
        sys.exit(str(error))
