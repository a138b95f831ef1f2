// SPDX-License-Identifier: Apache-2.0
#include "tools/export/gltf/quantized.h"

#include <algorithm>
#include <cmath>

namespace thew::tools {
namespace {

constexpr double kSteps16 = 32767.0, kSteps8 = 127.0;
constexpr double kLeastScale = 1e-3;  // m; of a mesh that hardly moves

// Of the frames' normals at a vertex, by axis: a base from `low` to `high` is within 1 of them all.
// 0 is in each of these ranges.
struct Range {
  Vec3 low = Vec3::Constant(-1.0), high = Vec3::Constant(1.0);
  void add(const Vec3& normal) {
    low = low.cwiseMax(normal - Vec3::Ones());
    high = high.cwiseMin(normal + Vec3::Ones());
  }
  bool has(const Vec3& n) const {
    return (n.array() >= low.array()).all() && (n.array() <= high.array()).all();
  }
};

// A vector of length 1 in the range, as near to `wanted` as cutting off and stretching makes it.
// False where there is none: the farthest corner is nearer than 1.
bool fit_into(const Range& range, const Vec3& wanted, Vec3& found) {
  if (range.has(wanted)) {
    found = wanted;
    return true;
  }
  const Vec3 cut = wanted.cwiseMax(range.low).cwiseMin(range.high);
  Vec3 corner, farthest;  // that on the side of the wanted one, and of all
  for (int k = 0; k < 3; ++k) {
    corner[k] = cut[k] >= 0.0 ? range.high[k] : range.low[k];
    farthest[k] = range.high[k] > -range.low[k] ? range.high[k] : range.low[k];
  }
  if (corner.norm() < 1.0) corner = farthest;
  if (corner.norm() < 1.0) return false;
  // Between them lies one of length 1: |cut + t (corner - cut)|^2 = 1.
  const Vec3 way = corner - cut;
  const double a = way.squaredNorm(), b = cut.dot(way), c = cut.squaredNorm() - 1.0;
  const double t = (-b + std::sqrt(b * b - a * c)) / a;
  // A little inside, so that rounding leaves it there; the length is made 1 again below.
  found = (cut + std::clamp(t, 0.0, 1.0) * way).normalized();
  return true;
}

bool move_normals(Morphs& morphs) {
  std::vector<Vec3>& base = morphs.base.normals;
  std::vector<Vec3> moved = base;
  for (std::size_t v = 0; v < base.size(); ++v) {
    Range range;
    for (const Shape& target : morphs.targets) range.add(base[v] + target.normals[v]);
    if (!fit_into(range, base[v], moved[v])) return false;
  }
  for (Shape& target : morphs.targets) {
    for (std::size_t v = 0; v < base.size(); ++v) target.normals[v] += base[v] - moved[v];
  }
  base = moved;
  return true;
}

double step_of(double value, double steps) {
  return std::clamp(std::round(steps * value), -steps, steps) / steps;
}

template <typename T>
std::size_t add_integers(Glb& glb, const std::vector<Vec3>& values, double steps, bool bounds) {
  std::vector<std::array<T, 3>> rows;
  for (const Vec3& value : values) {
    auto& row = rows.emplace_back();
    for (int k = 0; k < 3; ++k) row[k] = static_cast<T>(std::lround(steps * value[k]));
  }
  return add_rows(glb, rows, bounds);
}

}  // namespace

double quantize(Morphs& morphs) {
  double largest = kLeastScale;
  for (const Shape& target : morphs.targets) {
    for (const Vec3& p : target.positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  }
  const double scale = as_float32(largest * (1.0 + 1e-6));  // not less for being rounded
  for (Vec3& p : morphs.base.positions) {
    for (double& x : p) x = scale * as_float32(x / scale);
  }
  const bool fits = move_normals(morphs);
  for (Shape& target : morphs.targets) {
    for (Vec3& p : target.positions) {
      for (double& x : p) x = scale * step_of(x / scale, kSteps16);
    }
    for (Vec3& n : target.normals) {
      for (double& x : n) x = fits ? step_of(x, kSteps8) : x;
    }
  }
  return scale;
}

std::size_t add_scaled(Glb& glb, const std::vector<Vec3>& values, double scale) {
  std::vector<Vec3> shares = values;
  for (Vec3& p : shares) p /= scale;
  return add_vectors(glb, shares, true);
}

std::size_t add_steps_16(Glb& glb, const std::vector<Vec3>& values, double scale) {
  return add_integers<std::int16_t>(glb, values, kSteps16 / scale, true);
}

std::size_t add_normal_steps(Glb& glb, const std::vector<Vec3>& values) {
  const bool whole = std::all_of(values.begin(), values.end(), [](const Vec3& n) {
    return n.cwiseAbs().maxCoeff() <= 1.0 &&
           (n * kSteps8 - (n * kSteps8).array().round().matrix()).norm() < 1e-9;
  });
  return whole ? add_integers<std::int8_t>(glb, values, kSteps8, false)
               : add_vectors(glb, values, false);
}

}  // namespace thew::tools
