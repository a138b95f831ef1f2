// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "tools/compare/plane.h"
#include "tools/render/image.h"

namespace thew::tools {

/// Up to where pictures count as the same. The defaults let pass what another processor changes,
/// 3 levels of 255 on 0.1 % of the pixels, and nothing that is seen.
struct PixelLimits {
  int threshold = 0;     ///< levels by which any channel of a changed pixel differs more
  double share = 0.001;  ///< of pixels, that may be changed
  int largest = 3;       ///< levels, in any channel of any pixel
  std::optional<double> rmse, ssim, flip;  ///< the second is the least, the others the most
};

/// How far two pictures of one size are apart.
struct PixelMeasures {
  double share = 0.0;  ///< of pixels beyond the threshold
  int largest = 0;     ///< levels
  int x = 0, y = 0;    ///< where the largest is
  double rmse = 0.0;   ///< levels, over all channels
  double ssim = 1.0;   ///< mean structural similarity (Wang et al. 2004), 1: the same
  double flip = 0.0;   ///< mean LDR-FLIP, 0: the same
  double shift_x = 0.0, shift_y = 0.0;  ///< pixels right and down that explain most of it, else 0
};

/// Where `mask` (of the same size; null: everywhere) is darker than half grey nothing is compared.
/// Error(kInput) where sizes differ.
PixelMeasures measure_pixels(const Image& expected, const Image& actual, const Image* mask,
                             int threshold);
/// Empty, or which limit is broken by what, "3.2 % of pixels changed, 0.1 % allowed".
std::string broken_limit(const PixelMeasures& measures, const PixelLimits& limits);

/// The pixels outside the mask as expected.
Image masked(const Image& expected, Image actual, const Image* mask);
/// FLIP's map as a picture, from black through red and yellow to white.
Image heat_map(const Plane& error);

}  // namespace thew::tools
