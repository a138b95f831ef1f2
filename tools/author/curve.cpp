// SPDX-License-Identifier: Apache-2.0
#include "tools/author/curve.h"

#include <algorithm>
#include <cmath>

namespace thew::tools {
namespace {

constexpr int kSamples = 257;        // points of a curve, so that one lies in its middle
constexpr double kRounding = 0.004;  // m, of the corners: tendons lie close to bone
constexpr double kTurning = 0.015;   // m, over which sections turn round a corner

std::vector<Vec3> resample(const std::vector<Vec3>& points, double& length) {
  std::vector<double> s(points.size(), 0.0);
  for (size_t i = 1; i < s.size(); ++i) s[i] = s[i - 1] + (points[i] - points[i - 1]).norm();
  length = s.back();
  std::vector<Vec3> out;
  size_t k = 1;
  for (int i = 0; i < kSamples; ++i) {
    const double at = length * i / (kSamples - 1);
    while (k + 1 < s.size() && s[k] < at) ++k;
    const double step = s[k] - s[k - 1];
    const double t = step > 0.0 ? std::clamp((at - s[k - 1]) / step, 0.0, 1.0) : 0.0;
    out.push_back(points[k - 1] + t * (points[k] - points[k - 1]));
  }
  return out;
}

// One pass spreads a corner by the square root of half the passes, in samples: diffusion.
void round_corners(double radius, double length, std::vector<Vec3>& points) {
  const double spread = std::min(radius, 0.1 * length) / length * kSamples;
  std::vector<Vec3> before;
  for (int pass = 0; pass < static_cast<int>(2.0 * spread * spread); ++pass) {
    before = points;
    for (size_t i = 1; i + 1 < points.size(); ++i) {
      points[i] = 0.25 * before[i - 1] + 0.5 * before[i] + 0.25 * before[i + 1];
    }
  }
}

Vec3 tangent(const std::vector<Vec3>& points, size_t i) {
  const size_t last = points.size() - 1;
  return (points[std::min(i + 1, last)] - points[i > 0 ? i - 1 : 0]).normalized();
}

}  // namespace

Mat3 frame_along(const Vec3& tangent, const Vec3& normal) {
  const Vec3 n = (normal - normal.dot(tangent) * tangent).normalized();
  Mat3 frame;
  frame << tangent, n, tangent.cross(n);
  return frame;
}

RestCurve make_rest_curve(const TracedPath& path) {
  RestCurve curve;
  curve.path_length = path.length;
  curve.points = resample(path.points, curve.length);
  round_corners(kRounding, curve.length, curve.points);
  curve.points = resample(curve.points, curve.length);
  std::vector<Vec3> smooth = curve.points;
  round_corners(kTurning, curve.length, smooth);
  // From the middle outwards; normal 1 looks forward there, so that sections can be told apart.
  const int middle = kSamples / 2;
  curve.frames.resize(kSamples);
  const Vec3 t = tangent(smooth, middle);
  curve.frames[middle] = frame_along(t, std::abs(t.x()) < 0.8 ? Vec3::UnitX() : Vec3::UnitY());
  for (int i = middle + 1; i < kSamples; ++i) {
    curve.frames[i] = frame_along(tangent(smooth, i), curve.frames[i - 1].col(1));
  }
  for (int i = middle - 1; i >= 0; --i) {
    curve.frames[i] = frame_along(tangent(smooth, i), curve.frames[i + 1].col(1));
  }
  return curve;
}

CurvePoint point_on(const RestCurve& curve, double along) {
  const double at = std::clamp(along / curve.path_length, 0.0, 1.0) * (kSamples - 1);
  const int i = std::min(static_cast<int>(at), kSamples - 2);
  const double t = at - i;
  const Mat3& frame = curve.frames[i];
  const Vec3 tangent = (1.0 - t) * frame.col(0) + t * curve.frames[i + 1].col(0);
  const Vec3 normal = (1.0 - t) * frame.col(1) + t * curve.frames[i + 1].col(1);
  return {curve.points[i] + t * (curve.points[i + 1] - curve.points[i]),
          frame_along(tangent.normalized(), normal)};
}

}  // namespace thew::tools
