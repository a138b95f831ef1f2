// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/multipliers.h"

#include <tuple>

namespace thew::skin {
namespace {

Point point_at(const std::vector<Collider>& colliders, const Contact& contact,
               const Points& other) {
  const Triangle& t = colliders[contact.other].surface->triangles[contact.triangle];
  const auto& b = contact.barycentric;
  return b[0] * other[t[0]] + b[1] * other[t[1]] + b[2] * other[t[2]];
}

}  // namespace

bool is_shared(const std::vector<Collider>& colliders, const Contact& contact) {
  return colliders[contact.other].soft && !contact.of_face;
}

Point contact_point(const std::vector<Collider>& colliders, const Contact& contact) {
  return point_at(colliders, contact, *colliders[contact.other].previous_iterate);
}

Point contact_point_before(const std::vector<Collider>& colliders, const Contact& contact) {
  const Collider& other = colliders[contact.other];
  if (other.start) return point_at(colliders, contact, *other.start);
  return to_point(other.to_start * to_vec(contact_point(colliders, contact)));
}

double contact_gap(const std::vector<Collider>& colliders, const Contact& contact, const Point& x,
                   double wanted) {
  const Collider& it = colliders[contact.other];
  const Points& other = *it.previous_iterate;
  const Triangle& t = it.surface->triangles[contact.triangle];
  const Point d = x - contact.barycentric[0] * other[t[0]] - contact.barycentric[1] * other[t[1]] -
                  contact.barycentric[2] * other[t[2]];
  return contact.normal.x() * d[0] + contact.normal.y() * d[1] + contact.normal.z() * d[2] -
         (wanted + contact.offset);
}

void keep_multipliers(const ContactMotion& before, bool friction, ContactMotion& now) {
  const std::vector<Contact>&old = before.contacts, &after = now.contacts;
  now.normal_multiplier.assign(after.size(), 0.0);
  if (friction) now.friction_multiplier.assign(after.size(), Point{});
  const auto key = [](const Contact& c) { return std::tuple(c.node, c.other, c.of_face); };
  size_t o = 0;
  for (size_t c = 0; c < after.size(); c = group_end(after, c)) {
    while (o < old.size() && key(old[o]) < key(after[c])) ++o;
    if (o == old.size() || key(old[o]) != key(after[c])) continue;
    now.normal_multiplier[c] =
        before.normal_multiplier[active_in_group(before.normal_multiplier, o, group_end(old, o))];
    if (o < before.friction_multiplier.size()) {
      now.friction_multiplier[c] = before.friction_multiplier[o];
    }
  }
}

bool project_out(const ContactSolve& solve, const std::vector<Contact>& contacts, bool with_soft,
                 std::span<Points> freed, Points& x) {
  bool moves = false;
  for (const Contact& contact : contacts) {
    const bool shared = is_shared(solve.colliders, contact);
    if (shared && !with_soft) continue;
    const Point n = to_point(contact.normal);
    const double open = contact_gap(solve.colliders, contact, x[contact.node], solve.settings.gap);
    if (open >= (with_soft ? 0.0 : -kNodeRounding)) continue;
    moves = true;
    x[contact.node] -= (shared ? 0.5 : 1.0) * open * n;
    for (Points& direction : freed) {
      Point& z = direction[contact.node];
      z -= dot(n, z) * n;
    }
  }
  return moves;
}

}  // namespace thew::skin
