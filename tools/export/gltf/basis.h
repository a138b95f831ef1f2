// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/types.h"

namespace thew::tools {

/// A motion as a base shape and a few displacements with weights by frame, all weights within 0..1
/// (readers clamp them). Least squares: the first eigenvectors of the frames' scalar products.
struct MotionBasis {
  std::vector<std::vector<double>> factors;  ///< by target, frame: target = sum of factor × frame
  std::vector<double> base_factors;          ///< by frame: base = sum of factor × frame
  std::vector<std::vector<float>> weights;   ///< by frame, target
};

/// `count` targets at most; fewer where the motion has no more in it.
MotionBasis fit_motion_basis(const std::vector<const std::vector<Vec3>*>& frames, int count);

/// By target, frame: the factors that make, of any values by frame (less a base of their own), the
/// targets that with these weights come closest to them.
std::vector<std::vector<double>> least_squares_factors(
    const std::vector<std::vector<float>>& weights);

/// sum over f of factors[f] * frames[f]
std::vector<Vec3> combine(const std::vector<double>& factors,
                          const std::vector<const std::vector<Vec3>*>& frames);

}  // namespace thew::tools
