// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "skin/contact/collider.h"

namespace thew::skin {

/// What a search for contacts leaves to the next, only to speed it up: the last triangle of each
/// point and collider, and a bound of its signed distance (m): it surely has so much or more, of a
/// surface that does not cross itself.
struct ContactMemory {
  /// By node of the mover, or by held point of the other; empty until the two have been near each
  /// other once.
  struct Other {
    std::vector<int> triangle;
    std::vector<double> clear;
    double travelled = 0.0;  ///< m, of both, when `clear` was last looked at
  };
  std::vector<Other> others;  ///< by collider
  std::int64_t searches = 0;  ///< made since the start
};

/// What may have come of the bounds of a collider's points against a surface since they were looked
/// at last.
struct Approach {
  double owed = 0.0;  ///< m, what the two can have come nearer at most
  const Collider& surface;
  bool by_parts = false;  ///< the next is known
  std::array<MotionBound, MovedParts::kParts> motion_bound =
      {};  ///< by part of the points' collider
};
Approach recall(const Collider& points_of, const Collider& surface, int points, double margin,
                ContactMemory::Other& known);
/// The bound of a point of a part, lowered by that.
double lowered(const Approach& approach, int part, double clear);
/// What lies outside of a surface's box is outside of the surface, by as much at least.
void note_box(const Bvh& bvh, const Point& p, double& clear);
/// Whether a point may lie within `margin` (m) of the surface or inside it, having gone `way` to p;
/// raises the bound, which was `before`, where that tells more.
bool may_be_near(const Approach& approach, const Point& p, const Point& way, double margin,
                 double before, double& clear);
/// The nearest point of the surface, of a point `i` that may be within `margin`: none where it is
/// neither, nor inside. Beyond `reach` it may be missed.
ClosestPoint look(const Collider& surface, const Vec3& p, double margin, double reach, int i,
                  ContactMemory::Other& known);

}  // namespace thew::skin
