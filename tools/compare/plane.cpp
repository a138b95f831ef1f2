// SPDX-License-Identifier: Apache-2.0
#include "tools/compare/plane.h"

#include <algorithm>
#include <cmath>

namespace thew::tools {

std::vector<double> gaussian(double deviation, int radius) {
  std::vector<double> taps;
  double sum = 0.0;
  for (int x = -radius; x <= radius; ++x) {
    taps.push_back(std::exp(-0.5 * x * x / (deviation * deviation)));
    sum += taps.back();
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

// Tap by tap over whole rows, so that the compiler can work on several pixels at once.
Plane filter(const Plane& in, const std::vector<double>& across, const std::vector<double>& down) {
  const int w = in.width, h = in.height;
  const int reach_x = static_cast<int>(across.size()) / 2,
            reach_y = static_cast<int>(down.size()) / 2;
  Plane rows{w, h, std::vector<double>(in.values.size(), 0.0)}, out = rows;
  std::vector<double> padded(w + 2ul * reach_x);
  for (int y = 0; y < h; ++y) {
    const double* from = &in.values[1ul * w * y];
    double* to = &rows.values[1ul * w * y];
    std::fill_n(padded.begin(), reach_x, from[0]);
    std::copy_n(from, w, padded.begin() + reach_x);
    std::fill_n(padded.begin() + reach_x + w, reach_x, from[w - 1]);
    for (std::size_t k = 0; k < across.size(); ++k) {
      for (int x = 0; x < w; ++x) to[x] += across[k] * padded[x + k];
    }
  }
  for (int y = 0; y < h; ++y) {
    double* to = &out.values[1ul * w * y];
    for (int k = -reach_y; k <= reach_y; ++k) {
      const double* from = &rows.values[1ul * w * std::clamp(y + k, 0, h - 1)];
      for (int x = 0; x < w; ++x) to[x] += down[k + reach_y] * from[x];
    }
  }
  return out;
}

}  // namespace thew::tools
