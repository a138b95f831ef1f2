// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "muscles/path.h"

namespace thew::tools {

/// A muscle's path at rest with its corners rounded, and frames that turn as little as possible.
struct RestCurve {
  std::vector<Vec3> points;  ///< at equal distances
  std::vector<Mat3> frames;  ///< columns: tangent, then two that span the section
  double length = 0.0;       ///< m
  double path_length = 0.0;  ///< m, of the path itself
};

/// The ends stay.
RestCurve make_rest_curve(const TracedPath& path);

struct CurvePoint {
  Vec3 point;
  Mat3 frame;
};
/// The first column along `tangent`, the second as near `normal` as that leaves it.
Mat3 frame_along(const Vec3& tangent, const Vec3& normal);

/// `along`: m of the path, not of the rounded curve.
CurvePoint point_on(const RestCurve& curve, double along);

}  // namespace thew::tools
