// SPDX-License-Identifier: Apache-2.0
#include "skin/flesh_level.h"

namespace thew::skin {

FleshValue flesh_value(const FleshPlanes& planes, int node, const Vec3& x, double bridging) {
  FleshValue value;
  const FleshPlanes::Plane* near = planes.planes[node].data();
  FleshLevel level;
  find_level(near, planes.count[node], x, bridging, level);
  if (level.active == 0) return value;
  value.found = true;
  value.level = level.level;
  value.nearest = level.distances[0].away;
  value.gradient_of_level = gradient_of(near, level, bridging);
  value.normal_of_nearest = near[level.distances[0].plane].normal;
  return value;
}

}  // namespace thew::skin
