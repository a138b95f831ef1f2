// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/self_contact.h"

#include <algorithm>
#include <cmath>

namespace thew::skin {
namespace {

// Most cosine between the normals of node and wall; chosen by trial.
constexpr double kFacing = -0.3;

// The nearest triangle within `reach` (m) that faces the node and lies in front of it or, if the
// node `met` a wall in the step before, behind it.
ClosestPoint facing_wall(const Collider& self, const Vec3& own, int node, bool met, double reach,
                         const std::vector<int>& nearby) {
  const Vec3 p = to_vec((*self.x)[node]);
  ClosestPoint best;
  double nearest = reach;
  for (const int t : nearby) {
    const Triangle& c = self.surface->triangles[t];
    if (c[0] == node || c[1] == node || c[2] == node) continue;
    if (face_normal(*self.surface, *self.x, t).dot(own) > kFacing) continue;
    const ClosestPoint wall = closest_on_triangle(*self.surface, *self.x, t, p);
    const bool in_front = wall.distance >= 0.0 && own.dot(wall.point - p) >= 0.0;
    const double away = std::abs(wall.distance);
    if ((!in_front && !met) || away > nearest) continue;
    if (away == nearest && best.triangle >= 0 && best.triangle < t) continue;
    nearest = away;
    best = wall;
  }
  return best;
}

}  // namespace

void find_self_contacts(const Collider& self, int mover, const ContactSettings& settings,
                        const std::vector<Contact>& before, std::vector<int>& nearby,
                        std::vector<Contact>& contacts) {
  const int nodes = static_cast<int>(self.x->size());
  auto known = before.begin();  // first self contact that is not before the node
  const size_t others = contacts.size();
  for (int node = 0; node < nodes; ++node) {
    if (!(*self.free_nodes)[node]) continue;
    while (known != before.end() && (known->node < node || known->other != mover)) ++known;
    const bool met = known != before.end() && known->node == node;
    const double reach = met ? std::max(settings.margin, settings.max_depth) : settings.margin;
    const Vec3 p = to_vec((*self.x)[node]), own = node_normal(*self.surface, *self.x, node);
    triangles_near(*self.bvh, p, reach, nearby);
    const ClosestPoint wall = facing_wall(self, own, node, met, reach, nearby);
    if (wall.triangle < 0) continue;
    const Vec3 normal = steady_normal(own, wall.normal);
    Contact contact{node, mover, wall.triangle, -1, {}, normal, normal.dot(p - wall.point)};
    std::copy(wall.barycentric, wall.barycentric + 3, contact.barycentric);
    contact.offset = thickness_at(self, node) + thickness_at(self, wall.triangle, wall.barycentric);
    contacts.push_back(contact);
  }
  if (contacts.size() == others) return;
  order_contacts(contacts);
}

}  // namespace thew::skin
