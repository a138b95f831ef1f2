// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "skin/contact/collider.h"

namespace thew::skin {

/// What a search for contacts keeps for the next one, only to speed it up: for each point and
/// collider the nearest triangle found last, and a lower bound of the signed distance (m). The
/// bound holds for surfaces that do not cross themselves.
struct ContactMemory {
  /// Indexed by node of the mover, or by rigid point of the other; empty until the two have been
  /// near each other once.
  struct Other {
    std::vector<int> triangle;
    std::vector<double> distance_bound;
    /// What all bounds are still to be lowered by, while none comes near: approach and separation
    /// of a MotionBound. `least` is a bound of all points that are searched for, so lowered.
    MotionBound pending = {0.0, std::numeric_limits<double>::infinity()};
    double least = -std::numeric_limits<double>::infinity();  ///< m
    std::vector<int> part;   ///< of the rigid points, once the parts of the other are known
    double travelled = 0.0;  ///< m, sum of both histories when distance_bound was last updated
  };
  /// A point that may be near, and what its bound was before it was lowered.
  struct Nearing {
    int point;
    double before;
  };
  std::vector<Other> others;  ///< by collider
  std::vector<Nearing> nearing;
  int nearing_count = 0;
  std::int64_t searches = 0;  ///< number of nearest-point searches since the start
};

/// How far the points of a collider may have approached a surface since the bounds were last
/// updated (conservative advancement).
struct Approach {
  double distance = 0.0;  ///< m, most by which the two can have approached each other
  const Collider& surface;
  bool by_parts = false;  ///< whether motion_bound is known
  /// For each part of the collider of the points.
  std::array<MotionBound, MovedParts::kParts> motion_bound = {};
};
/// The approach since the last call for the same pair, and sizes `known` for so many points.
Approach recall(const Collider& points_of, const Collider& surface, int points, double margin,
                ContactMemory::Other& known);
/// Lowers the bounds of all points by the approach, of which those that are
/// `searched` (null: all) may have to be searched for. The points whose bound is below `margin` (m)
/// then become the first `memory.nearing_count` of `memory.nearing`, in their order. `part` has the
/// part of each point, or is not used if the approach is not known by parts.
void lower_bounds(const Approach& approach, const std::vector<int>& part, double margin,
                  const std::vector<char>* searched, ContactMemory::Other& known,
                  ContactMemory& memory);
/// Raises the bound of a point outside the box of a surface to its distance from the box.
void raise_by_box(const Bvh& bvh, const Point& p, double& bound);
/// Whether a point, which has moved by `motion` to p, may lie within `margin` (m) of the surface or
/// inside it. Raises the bound, which was `before`, if the motion of the point itself gives a
/// better one.
bool may_be_within(const Approach& approach, const Point& p, const Point& motion, double margin,
                   double before, double& bound);
/// The nearest point of the surface to point i at p, if p is within `margin` of it or inside;
/// points deeper than `reach` (m) may be missed. Updates what is known of the point.
ClosestPoint find_closest(const Collider& surface, const Vec3& p, double margin, double reach,
                          int i, ContactMemory::Other& known);

}  // namespace thew::skin
