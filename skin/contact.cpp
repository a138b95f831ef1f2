// SPDX-License-Identifier: Apache-2.0
#include "skin/contact.h"

#include <algorithm>
#include <cmath>

namespace thew {
namespace {

bool in_reach(const Bvh& bvh, const Vec3& p, double reach) {
  if (bvh.order.empty()) return false;
  const Bvh::Node& root = bvh.nodes[0];
  for (int k = 0; k < 3; ++k) {
    if (p[k] < root.lo[k] - reach || p[k] > root.hi[k] + reach) return false;
  }
  return true;
}

// Halfway between the other surface's normal and straight back into the mover. Past the middle of
// something thin (a tendon, an edge of bone) the nearest way out flips to the far side; the mover's
// own normal does not, so contacts neither tunnel nor flicker.
Vec3 steady_normal(const Collider& mover, int node, const Vec3& normal) {
  const Vec3 back = -node_normal(*mover.surface, *mover.x, node);
  const Vec3 sum = normal + back;
  const double length = sum.norm();
  return length > 0.1 ? Vec3(sum / length) : back;
}

}  // namespace

bool may_touch(const Collider& a, const Collider& b, const ContactSettings& settings) {
  constexpr double kRounding = 1e-6;  // m, of a tree's boxes
  return are_near(a.box, b.box, std::max(settings.margin, settings.max_depth) + kRounding);
}

Vec3 contact_normal(const ClosestPoint& near, const Vec3& p) {
  constexpr double kTouching = 1e-7;  // m; nearer, rounding would set the direction
  if (std::abs(near.distance) < kTouching) return near.normal;
  return (p - near.point) / near.distance;
}

void find_contacts(const std::vector<Collider>& colliders, int mover,
                   const std::vector<char>& ignore, const ContactSettings& settings,
                   const std::vector<Contact>& pressing, ContactMemory& memory,
                   std::vector<Contact>& contacts) {
  contacts.clear();
  const Collider& self = colliders[mover];
  if (self.free_nodes == nullptr) return;
  const int nodes = static_cast<int>(self.x->size()), others = static_cast<int>(colliders.size());
  const double reach = std::max(settings.margin, settings.max_depth);
  memory.others.resize(others);
  std::vector<int> near_ones;
  for (int other = 0; other < others; ++other) {
    if (other == mover || ignore[other]) continue;
    ContactMemory::Other& known = memory.others[other];
    known.owed += self.moved + colliders[other].moved;
    if (!may_touch(self, colliders[other], settings)) continue;
    near_ones.push_back(other);
    known.triangle.resize(nodes, -1);
    known.clear.resize(nodes, 0.0);
  }
  auto pressed = pressing.begin();
  const auto is_pressed = [&](int node, int other) {
    const auto before = [&] {
      return pressed->node < node || (pressed->node == node && pressed->other < other);
    };
    while (pressed != pressing.end() && before()) ++pressed;
    return pressed != pressing.end() && pressed->node == node && pressed->other == other;
  };
  for (int node = 0; node < nodes; ++node) {
    if (!(*self.free_nodes)[node]) continue;
    const Vec3 p = to_vec((*self.x)[node]);
    for (const int other : near_ones) {
      const Collider& target = colliders[other];
      ContactMemory::Other& known = memory.others[other];
      double& clear = known.clear[node];
      clear -= known.owed;  // what both moved can have come nearer at most
      const double margin = is_pressed(node, other) ? reach : settings.margin;
      if (clear >= margin || !in_reach(*target.bvh, p, margin)) continue;
      int& hint = known.triangle[node];
      ++memory.searches;
      const ClosestPoint near =
          closest_point(*target.surface, *target.bvh, *target.x, p, reach, hint);
      clear = near.triangle < 0 ? reach : std::max(near.distance, 0.0);
      if (near.triangle < 0) continue;
      hint = near.triangle;
      if (near.distance >= margin || near.distance <= -settings.max_depth) continue;
      const Vec3 normal = steady_normal(self, node, contact_normal(near, p));
      Contact contact{node, other, near.triangle, {}, normal, normal.dot(p - near.point)};
      std::copy(near.barycentric, near.barycentric + 3, contact.barycentric);
      contacts.push_back(contact);
    }
  }
  for (const int other : near_ones) memory.others[other].owed = 0.0;
}

}  // namespace thew
