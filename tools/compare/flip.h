// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/compare/plane.h"
#include "tools/render/image.h"

namespace thew::tools {

/// Pixels in a degree of the viewer's sight: a screen 0.7 m wide of 3840 pixels, seen from 0.7 m.
inline constexpr double kPixelsPerDegree = 67.02064327658226;

/// LDR-FLIP: how different each pixel looks, 0..1, to one who sees two pictures of one size
/// alternate. Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference
/// Evaluator for Alternating Images", HPG 2020.
/// 0 where both are the same within flip_reach().
Plane flip(const Image& expected, const Image& actual, double pixels_per_degree = kPixelsPerDegree);

/// Pixels, in each direction.
int flip_reach(double pixels_per_degree = kPixelsPerDegree);

}  // namespace thew::tools
