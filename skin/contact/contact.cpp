// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/contact.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace thew::skin {
namespace {

// Whether the surface is flat around a point of a triangle, up to the distance `reach` (m).
bool is_flat(const Surface& surface, const Points& x, int triangle, const Vec3& face,
             const double* barycentric, double reach) {
  const Triangle& t = surface.triangles[triangle];
  const Vec3 corner[3] = {to_vec(x[t[0]]), to_vec(x[t[1]]), to_vec(x[t[2]])};
  const double twice_area = (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm();
  for (int k = 0; k < 3; ++k) {
    const double edge = (corner[(k + 1) % 3] - corner[k]).norm();
    if (barycentric[(k + 2) % 3] * twice_area > reach * edge) continue;
    const int across = surface.neighbours[triangle][k];
    if (across < 0 || face.dot(face_normal(surface, x, across)) < 1.0 - 1e-9) return false;
  }
  return true;
}

}  // namespace

// Past the middle of something thin (a tendon, an edge of bone) the direction to the nearest point
// of the surface jumps to the far side. The own normal of the mover does not, so contacts neither
// tunnel nor flicker.
Vec3 steady_normal(const Vec3& own, const Vec3& normal) {
  const Vec3 sum = normal - own;
  const double length = sum.norm();
  return length > 0.1 ? Vec3(sum / length) : Vec3(-own);
}

ContactSettings times(const ContactSettings& settings, double size) {
  ContactSettings out = settings;
  for (double* length : {&out.margin, &out.max_depth, &out.gap, &out.spacing}) *length *= size;
  out.lengths = times(out.lengths, size);
  return out;
}

void find_candidate_pairs(const std::vector<Collider>& colliders, const ContactSettings& settings,
                          CandidatePairs& pairs) {
  const double reach = std::max(settings.margin, settings.max_depth) + kBoxRounding;
  auto& [near, order] = pairs;
  near.resize(colliders.size());
  for (std::vector<int>& others : near) others.clear();
  order.clear();
  Point low{}, high{};
  for (size_t c = 0; c < colliders.size(); ++c) {
    const Point centre = 0.5 * (colliders[c].box.low + colliders[c].box.high);
    low = c == 0 || centre < low ? centre : low;
    high = c == 0 || centre > high ? centre : high;
    order.push_back(static_cast<int>(c));
  }
  const int axis = longest_axis(high - low);
  const auto begin_of = [&](int c) { return colliders[c].box.low[axis]; };
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return begin_of(a) != begin_of(b) ? begin_of(a) < begin_of(b) : a < b;
  });
  for (size_t i = 0; i < order.size(); ++i) {
    const NodeBox& box = colliders[order[i]].box;
    for (size_t j = i + 1; j < order.size(); ++j) {
      if (begin_of(order[j]) > box.high[axis] + reach) break;
      if (!are_near(box, colliders[order[j]].box, reach)) continue;
      near[order[i]].push_back(order[j]);
      near[order[j]].push_back(order[i]);
    }
  }
  for (std::vector<int>& others : near) std::sort(others.begin(), others.end());
}

void order_contacts(std::vector<Contact>& contacts) {
  std::sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) {
    return std::tie(a.node, a.other, a.point) < std::tie(b.node, b.other, b.point);
  });
}

size_t group_end(const std::vector<Contact>& contacts, size_t c) {
  const auto key = [&](size_t i) {
    return std::tuple(contacts[i].node, contacts[i].other, contacts[i].of_face);
  };
  size_t end = c + 1;
  while (contacts[c].of_face && end < contacts.size() && key(end) == key(c)) ++end;
  return end;
}

size_t active_in_group(const std::vector<double>& multipliers, size_t c, size_t end) {
  const auto presses = [](double p) { return p > 0.0; };
  const auto found = std::find_if(multipliers.begin() + c, multipliers.begin() + end, presses);
  return found == multipliers.begin() + end ? c : found - multipliers.begin();
}

Vec3 smooth_normal(const Surface& surface, const Points& x, int triangle,
                   const double* barycentric) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    if (barycentric[k] == 0.0) continue;
    sum += barycentric[k] * node_normal(surface, x, surface.triangles[triangle][k]);
  }
  return sum.normalized();
}

Vec3 contact_normal(const ClosestPoint& near, const Vec3& p, double least_direction) {
  if (std::abs(near.distance) < least_direction) return near.normal;
  return (p - near.point) / near.distance;
}

namespace {

// Whether the normal of a node points against n. It does if the normals of all its faces do, which
// is cheaper to test.
bool points_against(const Collider& self, int node, const Vec3& n) {
  const Points& x = *self.x;
  const auto faces_against = [&](int triangle) {
    const Triangle& t = self.surface->triangles[triangle];
    const Vec3 a = to_vec(x[t[0]]);
    return (to_vec(x[t[1]]) - a).cross(to_vec(x[t[2]]) - a).dot(n) < 0.0;
  };
  const std::vector<int>& round = self.surface->vertex_triangles[node];
  return std::all_of(round.begin(), round.end(), faces_against) ||
         node_normal(*self.surface, x, node).dot(n) < 0.0;
}

// The contact normal. Soft surfaces have their interpolated normal. A wide flat face of a bone has
// its own normal, so that nodes that slide along it do not sink in, unless the node has come from
// the other side.
Vec3 normal_against(const Collider& self, int node, const Collider& target,
                    const ClosestPoint& found, const Vec3& p, const ContactSettings& settings) {
  const double least_direction = settings.lengths.least_direction;
  const Surface& surface = *target.surface;
  const Points& x = *target.x;
  const auto own_normal = [&] { return node_normal(*self.surface, *self.x, node); };
  if (target.free_nodes != nullptr) {
    return steady_normal(own_normal(),
                         smooth_normal(surface, x, found.triangle, found.barycentric));
  }
  Vec3 face = face_normal(surface, x, found.triangle);
  if (is_flat(surface, x, found.triangle, face, found.barycentric, settings.margin) &&
      (found.distance > -least_direction || points_against(self, node, face))) {
    return face;
  }
  return steady_normal(own_normal(), contact_normal(found, p, least_direction));
}

}  // namespace

void find_contacts(const std::vector<Collider>& colliders, int mover, const std::vector<int>& near,
                   const ContactSettings& settings, const std::vector<Contact>& pressing,
                   ContactMemory& memory, std::vector<Contact>& contacts) {
  contacts.clear();
  const Collider& self = colliders[mover];
  if (self.free_nodes == nullptr) return;
  const int nodes = static_cast<int>(self.x->size());
  constexpr double kSoftDepth = 2.0;  // of max_depth, between two soft surfaces
  const double release = std::max(settings.margin, settings.max_depth);
  memory.others.resize(colliders.size());
  static const std::vector<int> kNoParts;
  for (const int other : near) {
    const Collider& target = colliders[other];
    ContactMemory::Other& known = memory.others[other];
    const Approach approach = recall(self, target, nodes, settings.margin, known);
    auto pressed = pressing.begin();  // not before the node
    const auto is_passed = [&](const Contact& contact, int node) {
      return contact.node < node || contact.other != other || contact.of_face;
    };
    const double deepest = (target.free_nodes == nullptr ? 1.0 : kSoftDepth) * settings.max_depth;
    const double reach = std::max(settings.margin, deepest);
    const bool presses = std::any_of(pressing.begin(), pressing.end(), [&](const Contact& contact) {
      return contact.other == other && !contact.of_face;
    });
    lower_bounds(approach, approach.by_parts ? self.history->parts.of_node : kNoParts,
                 presses ? release : settings.margin, self.free_nodes, known, memory);
    for (int n = 0; n < memory.nearing_count; ++n) {
      const auto& [node, before] = memory.nearing[n];
      double& bound = known.distance_bound[node];
      while (pressed != pressing.end() && is_passed(*pressed, node)) ++pressed;
      const bool goes_on = pressed != pressing.end() && pressed->node == node;
      const double margin = goes_on ? release : settings.margin;
      if (bound >= margin) continue;
      const Point x = (*self.x)[node];
      const Point motion = approach.by_parts ? x - self.history->before[node] : Point{};
      if (!may_be_within(approach, x, motion, margin, before, bound)) continue;
      const Vec3 p = to_vec(x);
      ++memory.searches;
      const ClosestPoint found = find_closest(target, p, margin, reach, node, known);
      if (found.triangle < 0 || found.distance >= margin || found.distance <= -deepest) continue;
      const Vec3 normal = normal_against(self, node, target, found, p, settings);
      Contact contact{node, other, found.triangle, -1, {}, normal, normal.dot(p - found.point)};
      std::copy(found.barycentric, found.barycentric + 3, contact.barycentric);
      contact.offset =
          thickness_at(self, node) + thickness_at(target, found.triangle, found.barycentric);
      contacts.push_back(contact);
    }
  }
  order_contacts(contacts);
}

}  // namespace thew::skin
