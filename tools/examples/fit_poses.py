#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fits a pose set of `thew poses`: fit_poses.py POSES.npz [HELD_OUT]

A displacement for each vertex in the bind pose, by least squares over Gaussians of the joint values.
Of the poses the last HELD_OUT, a quarter unless given, are not fitted. Prints the error there with
the displacement and without it, which is linear blend skinning alone. Needs numpy."""
import sys
import numpy as np

poses = np.load(sys.argv[1])
good = poses["rungs"] == 0  # in the others something stands in for a muscle
joints, wanted = poses["joints"][good], poses["displacement"][good].astype(float)
transforms, influences, weights = poses["transforms"][good], poses["influences"], poses["weights"]
held_out = int(sys.argv[2]) if len(sys.argv) > 2 else len(joints) // 4
fitted = len(joints) - held_out

moving = np.ptp(joints[:fitted], axis=0) > 0
low, high = joints[:fitted, moving].min(axis=0), joints[:fitted, moving].max(axis=0)
place = (joints[:, moving] - low) / (high - low)  # 0 to 1
centres = place[:fitted][:: max(1, fitted // 60)]
apart = np.linalg.norm(place[:, None] - centres, axis=2)
features = np.hstack([np.ones((len(place), 1)), place, np.exp(-((apart / 0.4) ** 2))])

# Ridge regression: a little penalty on large coefficients keeps neighbouring Gaussians in check.
known = features[:fitted]
matrix = known.T @ known + 1e-6 * np.eye(known.shape[1])
coefficients = np.linalg.solve(matrix, known.T @ wanted[:fitted].reshape(fitted, -1))
predicted = (features @ coefficients).reshape(wanted.shape)


def skinned(pose, displacement):
    """Linear blend skinning of the base shape with a displacement in the bind pose, m."""
    x = np.hstack([poses["base"] + displacement, np.ones((len(displacement), 1))])
    return np.einsum("vk,vkij,vj->vi", weights, transforms[pose][influences], x)


def error(pose, displacement):
    """Distance of each vertex from the truth, m."""
    return np.linalg.norm(skinned(pose, displacement) - skinned(pose, wanted[pose]), axis=1)


tests = range(fitted, len(joints))
for name, guess in [("linear blend skinning", np.zeros_like(predicted)), ("fitted", predicted)]:
    off = 1e3 * np.array([error(pose, guess[pose]) for pose in tests])
    print(f"{name}: RMS {np.sqrt((off**2).mean()):.3f} mm, largest {off.max():.2f} mm")
