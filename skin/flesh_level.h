// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "skin/flesh_field.h"

namespace thew::skin {

struct FleshValue {
  bool found = false;    ///< whether a surface is within reach
  double level = 0.0;    ///< f, m
  double nearest = 0.0;  ///< least d_j, m
  /// Weighted mean of the unit normals; shorter than 1 in a crevice.
  Vec3 gradient_of_level = Vec3::Zero();
  Vec3 normal_of_nearest = Vec3::Zero();
};

/// f and its gradient at x by the planes of the node.
FleshValue flesh_value(const FleshPlanes& planes, int node, const Vec3& x, double bridging);

// The same in two parts, since most who ask for the level need no gradient. Always inlined, so
// that callers are compiled with them for their own vector width.

/// The planes of a node in the order of their distances.
struct FleshLevel {
  double level = 0.0;  ///< f, m
  double relative;     ///< m, f less the distance of the nearest
  int active = 0;      ///< how many of the nearest planes count; 0: there is none
  struct Distance {
    double away;
    int plane;
  } distances[FleshPlanes::kMaxPlanes];
};

[[gnu::always_inline]] inline void find_level(const FleshPlanes::Plane* near, int count,
                                              const Vec3& x, double bridging, FleshLevel& of) {
  of.active = 0;
  if (count == 0) return;
  auto* d = of.distances;
  for (int k = 0; k < count; ++k) {
    const double distance = near[k].normal.dot(x) - near[k].offset;
    int at = k;
    for (; at > 0 && d[at - 1].away > distance; --at) d[at] = d[at - 1];
    d[at] = {distance, k};
  }
  // n f^2 + 2 S1 f + S2 = R^2 over the n nearest, with a_j = R - d_j, S1 = sum a_j, S2 = sum a_j^2.
  // Distances are taken relative to the nearest, so that no large numbers cancel.
  double s1 = 0.0, s2 = 0.0, f = 0.0;
  int active = 0;
  while (active < count) {
    const double a = bridging - (d[active].away - d[0].away);
    if (active > 0 && a + f <= 0.0) break;
    s1 += a;
    s2 += a * a;
    ++active;
    const double under = s1 * s1 - active * (s2 - bridging * bridging);
    f = (-s1 + std::sqrt(std::max(under, 0.0))) / active;
  }
  of.active = active;
  of.relative = f;
  of.level = d[0].away + f;
}

[[gnu::always_inline]] inline Vec3 gradient_of(const FleshPlanes::Plane* near,
                                               const FleshLevel& level, double bridging) {
  Vec3 gradient = Vec3::Zero();
  double total = 0.0;
  for (int k = 0; k < level.active; ++k) {
    const auto& [away, plane] = level.distances[k];
    const double weight =
        std::max(bridging - (away - level.distances[0].away) + level.relative, 0.0);
    gradient += weight * near[plane].normal;
    total += weight;
  }
  return gradient / total;
}

/// The part of flesh_value() that the nearest surface alone gives: found, nearest and its normal.
inline FleshValue nearest_flesh(const FleshPlanes& planes, int node, const Vec3& x) {
  FleshValue value;
  const auto& near = planes.planes[node];
  for (int k = 0; k < planes.count[node]; ++k) {
    const double distance = near[k].normal.dot(x) - near[k].offset;
    if (value.found && !(distance < value.nearest)) continue;
    value.found = true;
    value.nearest = distance;
    value.normal_of_nearest = near[k].normal;
  }
  return value;
}

// Weight of the normal of the skin in outward_direction; chosen by trial.
inline constexpr double kNormalShare = 0.1;
// Least cosine by which a step is divided, bounds oblique steps.
inline constexpr double kLeastAlong = 0.3;

/// Unit vector out of the flesh: along the gradient of the field, plus a little of the normal of
/// the skin, because the gradient vanishes in the middle of a crevice.
[[gnu::always_inline]] inline Vec3 outward_direction(const Vec3& gradient, const Point& normal) {
  const Vec3 out = gradient + kNormalShare * to_vec(normal);
  const double length = out.norm();
  return length > 0.0 ? Vec3(out / length) : to_vec(normal);
}
/// How far (m) a node has to move along `direction` for the field to rise by `lack` (m).
[[gnu::always_inline]] inline double climb_distance(const Vec3& gradient, const Vec3& direction,
                                                    double lack) {
  return lack / std::max(gradient.dot(direction), kLeastAlong);
}

}  // namespace thew::skin
