// SPDX-License-Identifier: Apache-2.0
#include "skin/flesh_field.h"

#include <algorithm>
#include <cmath>

namespace thew::skin {

void find_flesh(const std::vector<Collider>& below, const Vec3& p, double reach, double bridging,
                double least_direction, int node, std::vector<int>& hints, FleshPlanes& planes) {
  struct Found {
    double distance;
    int other;
    FleshPlanes::Plane plane;
  };
  // Sorted by distance; the last entry is one too many.
  std::array<Found, FleshPlanes::kMaxPlanes + 1> found;
  int count = 0;
  double nearest = reach;  // m, on either side of a surface
  const int others = static_cast<int>(below.size());
  int* hint = hints.data() + static_cast<size_t>(node) * (others + 1);
  const auto query = [&](int j) {
    const Collider& flesh = below[j];
    // A surface that is farther than the nearest by the bridging radius has no weight.
    const double bound = count > 0 ? std::min(reach, nearest + bridging) : reach;
    if (flesh.bvh->order.empty() || box_distance(*flesh.bvh, to_point(p)) > bound) return;
    const ClosestPoint near =
        closest_point(*flesh.surface, *flesh.bvh, *flesh.x, p, bound, hint[j]);
    if (near.triangle < 0) return;
    hint[j] = near.triangle;
    const Vec3 normal = contact_normal(near, p, least_direction);
    const auto before = [&](const Found& one) {
      return one.distance < near.distance || (one.distance == near.distance && one.other < j);
    };
    int at = count;
    for (; at > 0 && !before(found[at - 1]); --at) found[at] = found[at - 1];
    found[at] = {near.distance, j, {normal, normal.dot(p) - near.distance}};
    count = std::min(count + 1, FleshPlanes::kMaxPlanes);
    nearest = std::min(nearest, std::abs(near.distance));
  };
  const int first = hint[others];  // the nearest surface of the last search: starting from it rules
                                   // out most of the others
  if (first >= 0) query(first);
  for (int j = 0; j < others; ++j) {
    if (j != first) query(j);
  }
  if (count > 0) hint[others] = found[0].other;
  // Whether a farther surface was found depends on the order of the search, so these are removed.
  const auto too_far = [&](const Found& one) {
    return std::abs(one.distance) > std::min(reach, nearest + bridging);
  };
  count = static_cast<int>(std::remove_if(found.begin(), found.begin() + count, too_far) -
                           found.begin());
  while (count > 1 && found[count - 1].distance > found[0].distance + bridging) --count;
  for (int k = 0; k < count; ++k) planes.planes[node][k] = found[k].plane;
  planes.count[node] = count;
}

FleshValue flesh_value(const FleshPlanes& planes, int node, const Vec3& x, double bridging) {
  FleshValue value;
  const int count = planes.count[node];
  if (count == 0) return value;
  const auto& near = planes.planes[node];
  struct Distance {
    double away;
    int plane;
  } d[FleshPlanes::kMaxPlanes] = {};
  for (int k = 0; k < count; ++k) {
    const double distance = near[k].normal.dot(x) - near[k].offset;
    int at = k;
    for (; at > 0 && d[at - 1].away > distance; --at) d[at] = d[at - 1];
    d[at] = {distance, k};
  }
  value.nearest = d[0].away;
  value.found = true;
  value.normal_of_nearest = near[d[0].plane].normal;
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
  double total = 0.0;
  for (int k = 0; k < active; ++k) {
    const double weight = std::max(bridging - (d[k].away - d[0].away) + f, 0.0);
    value.gradient_of_level += weight * near[d[k].plane].normal;
    total += weight;
  }
  value.gradient_of_level /= total;
  value.level = d[0].away + f;
  return value;
}

}  // namespace thew::skin
