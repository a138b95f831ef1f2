// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace thew::tools {

/// One number for each pixel, rows from the top.
struct Plane {
  int width = 0, height = 0;
  std::vector<double> values;
};

/// Taps -radius..radius of a Gaussian, their sum 1.
std::vector<double> gaussian(double deviation, int radius);

/// Weighs neighbours by `across` (to the right) times `down`, each of an odd number of taps about
/// the pixel; beyond the border the border's pixels go on.
Plane filter(const Plane& in, const std::vector<double>& across, const std::vector<double>& down);

}  // namespace thew::tools
