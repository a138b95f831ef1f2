// SPDX-License-Identifier: Apache-2.0
#include "skin/skin_props.h"

#include "skin/contact/contact.h"

namespace thew::skin {
namespace {

// Calls visit(i, nearest point) for nodes nearer to a prop than `gap` (m).
template <typename Visit>
void for_each_near(const Props& props, const Points& x, double gap, const Visit& visit) {
  for (const Collider& prop : props.colliders) {
    for (size_t i = 0; i < x.size(); ++i) {
      if (box_distance(*prop.bvh, x[i]) > gap) continue;
      const ClosestPoint near =
          closest_point(*prop.surface, *prop.bvh, *prop.x, to_vec(x[i]), props.reach);
      if (near.triangle >= 0 && near.distance < gap) visit(i, near);
    }
  }
}

}  // namespace

void leave_props(const Props& props, Points& x, std::vector<char>& marked) {
  constexpr double kLeastDirection = 1e-9;  // m; nearer, the surface's normal is the direction
  marked.assign(x.size(), 0);
  for_each_near(props, x, props.gap, [&](size_t i, const ClosestPoint& near) {
    const Vec3 normal = contact_normal(near, to_vec(x[i]), kLeastDirection);
    x[i] = to_point(Vec3(near.point + props.gap * normal));
    marked[i] = 1;
  });
}

void mark_at_props(const Props& props, const Points& x, std::vector<char>& marked) {
  for_each_near(props, x, props.gap - kNodeRounding,
                [&](size_t i, const ClosestPoint&) { marked[i] = 1; });
}

}  // namespace thew::skin
