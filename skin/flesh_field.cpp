// SPDX-License-Identifier: Apache-2.0
#include "skin/flesh_field.h"

#include <algorithm>
#include <cmath>

#include "skin/depth.h"

namespace thew::skin {

namespace {

// The surfaces that were found near a node, sorted by distance.
struct NearSurfaces {
  // Many more than kMaxPlanes, because some of the first turn out to be too far.
  static constexpr int kMost = 32;
  struct Found {
    double distance;
    int other;
    FleshPlanes::Plane plane;
  };
  std::array<Found, kMost + 1> found;  // the last entry is one too many
  int count = 0;
  double nearest;  // m, on either side of a surface

  void add(const Found& one) {
    const auto before = [&](const Found& it) {
      return it.distance < one.distance || (it.distance == one.distance && it.other < one.other);
    };
    int at = count;
    for (; at > 0 && !before(found[at - 1]); --at) found[at] = found[at - 1];
    found[at] = one;
    count = std::min(count + 1, kMost);
    nearest = std::min(nearest, std::abs(one.distance));
  }
  // Whether a farther surface was found depends on the order of the search, so these are removed.
  void keep(double within, double bridging) {
    const auto too_far = [&](const Found& one) { return std::abs(one.distance) > within; };
    count = static_cast<int>(std::remove_if(found.begin(), found.begin() + count, too_far) -
                             found.begin());
    count = std::min(count, FleshPlanes::kMaxPlanes);
    while (count > 1 && found[count - 1].distance > found[0].distance + bridging) --count;
  }
};

// A flattened end that lies folded upon itself has edges whose normals look inwards. By them what
// is outside was deep inside for the blink of a step, and the skin was thrown there.
void tell_side(const Collider& flesh, const Vec3& p, ClosestPoint& closest) {
  if (!(closest.distance < 0.0) || encloses(*flesh.surface, *flesh.bvh, *flesh.x, p)) return;
  closest.distance = -closest.distance;
  closest.normal = -closest.normal;
}

}  // namespace

void find_flesh(const std::vector<Collider>& below, const Points& x, const NodeGroup& group,
                double reach, double bridging, double least_direction, std::vector<int>& hints,
                FleshPlanes& planes) {
  const int others = static_cast<int>(below.size());
  const auto hints_of = [&](int i) {
    return hints.data() + static_cast<size_t>(group.nodes[i]) * (others + 1);
  };
  std::array<NearSurfaces, PointGroup::kMost> near;
  PointGroup points;
  points.count = group.count;
  NodeBox box = empty_box();
  for (int i = 0; i < group.count; ++i) {
    grow(box, x[group.nodes[i]], x[group.nodes[i]]);
    points.at[i] = to_vec(x[group.nodes[i]]);
    near[i].nearest = reach;
    // The nearest surface of the last search rules out most of the others.
    const int* hint = hints_of(i);
    const int first = hint[others];
    if (first < 0 || first >= others) continue;
    const Collider& flesh = below[first];
    const int triangles = static_cast<int>(flesh.surface->triangles.size());
    if (hint[first] < 0 || hint[first] >= triangles) continue;
    const ClosestPoint at =
        closest_on_triangle(*flesh.surface, *flesh.x, hint[first], points.at[i]);
    near[i].nearest = std::min(reach, std::abs(at.distance));
  }
  for (int j = 0; j < others; ++j) {
    const Collider& flesh = below[j];
    double farthest = 0.0;
    for (int i = 0; i < group.count; ++i) {
      // A surface that is farther than the nearest by the bridging radius has no weight.
      points.bound[i] = std::min(reach, near[i].nearest + bridging);
      farthest = std::max(farthest, points.bound[i]);
    }
    if (flesh.bvh->order.empty() || box_distance(*flesh.bvh, box) > farthest) continue;
    for (int i = 0; i < group.count; ++i) points.hint[i] = hints_of(i)[j];
    find_closest_points(*flesh.surface, *flesh.bvh, *flesh.x, points);
    for (int i = 0; i < group.count; ++i) {
      ClosestPoint& closest = points.closest[i];
      if (closest.triangle < 0) continue;
      tell_side(flesh, points.at[i], closest);
      hints_of(i)[j] = closest.triangle;
      const Vec3 normal = contact_normal(closest, points.at[i], least_direction);
      near[i].add({closest.distance, j, {normal, normal.dot(points.at[i]) - closest.distance}});
    }
  }
  for (int i = 0; i < group.count; ++i) {
    if (near[i].count > 0) hints_of(i)[others] = near[i].found[0].other;
    near[i].keep(std::min(reach, near[i].nearest + bridging), bridging);
    for (int k = 0; k < near[i].count; ++k) {
      planes.planes[group.nodes[i]][k] = near[i].found[k].plane;
    }
    planes.count[group.nodes[i]] = near[i].count;
  }
}

}  // namespace thew::skin
