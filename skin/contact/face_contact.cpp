// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/face_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>

#include "rig/vectorise.h"

namespace thew::skin {
namespace {

Vec3 normal_at(const Collider& collider, const SurfacePoint& point) {
  return smooth_normal(*collider.surface, *collider.x, point.triangle, point.barycentric);
}

[[gnu::always_inline]] inline Point position_of(const Collider& collider, const Points& x,
                                                const SurfacePoint& point) {
  const Triangle& t = collider.surface->triangles[point.triangle];
  const auto& b = point.barycentric;
  return b[0] * x[t[0]] + b[1] * x[t[1]] + b[2] * x[t[2]];
}

/// Points taken so far, by cells of a grid. A new one is taken only if it keeps the distance
/// `apart` (m) from points with a similar normal.
class Taken {
 public:
  explicit Taken(double apart) : apart_(apart) {}
  bool take(const Vec3& p, const Vec3& normal) {
    constexpr double kSameDirection = 0.5;
    const auto cell = [&](int axis, int step) {
      return static_cast<std::int64_t>(std::floor(p[axis] / apart_)) + step;
    };
    for (int k = 0; k < 27; ++k) {
      const auto there =
          positions_.find({cell(0, k % 3 - 1), cell(1, k / 3 % 3 - 1), cell(2, k / 9 - 1)});
      if (there == positions_.end()) continue;
      for (const auto& [q, facing] : there->second) {
        if ((p - q).norm() < apart_ && facing.dot(normal) > kSameDirection) return false;
      }
    }
    positions_[{cell(0, 0), cell(1, 0), cell(2, 0)}].push_back({p, normal});
    return true;
  }

 private:
  double apart_;
  std::map<std::array<std::int64_t, 3>, std::vector<std::pair<Vec3, Vec3>>> positions_;
};

}  // namespace

namespace {

// Curvature (1/m) across edge k of a triangle: the sine of the angle between its two faces over the
// distance between their middles, across the edge. 0 where the edge is not convex.
double curvature_across(const Surface& surface, const Points& x, int triangle, int k) {
  const int across = surface.neighbours[triangle][k];
  if (across < 0) return 0.0;
  const Triangle& t = surface.triangles[triangle];
  const Vec3 a = to_vec(x[t[k]]), b = to_vec(x[t[(k + 1) % 3]]);
  const auto middle = [&](const Triangle& of) {
    return Vec3((to_vec(x[of[0]]) + to_vec(x[of[1]]) + to_vec(x[of[2]])) / 3.0);
  };
  const Vec3 n = face_normal(surface, x, triangle), m = face_normal(surface, x, across);
  const Vec3 d = middle(surface.triangles[across]) - middle(t);
  const double apart = d.cross((b - a).normalized()).norm();
  if (d.dot(n) >= 0.0 || !(apart > 0.0)) return 0.0;
  return n.cross(m).norm() / apart;
}

}  // namespace

std::vector<SurfacePoint> rigid_points(const Surface& surface, const Points& rest,
                                       const std::vector<char>* free_nodes, double spacing) {
  constexpr double kApart = 0.7;  // of the spacing, least distance of two points
  // Of spacing over radius: nodes alone keep out of flatter surfaces; by trial.
  constexpr double kSharp = 0.2;
  constexpr int kMaxParts = 17;  // of an edge
  std::vector<SurfacePoint> points;
  Taken taken(kApart * spacing);
  const Collider at_rest{&surface, nullptr, &rest, free_nodes};
  const auto is_free = [&](int node) { return free_nodes != nullptr && (*free_nodes)[node]; };
  std::vector<double> sharpest(rest.size(), 0.0);  // 1/m, of a node's edges
  const auto is_sharp = [&](double curvature) { return curvature * spacing > kSharp; };
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const double curvature = curvature_across(surface, rest, static_cast<int>(t), k);
      for (const int node : {surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]}) {
        sharpest[node] = std::max(sharpest[node], curvature);
      }
    }
  }
  const auto add = [&](const SurfacePoint& point) {
    const Vec3 p = to_vec(position_of(at_rest, rest, point));
    if (taken.take(p, normal_at(at_rest, point))) points.push_back(point);
  };
  for (size_t node = 0; node < rest.size(); ++node) {
    if (is_free(static_cast<int>(node)) || !is_sharp(sharpest[node])) continue;
    SurfacePoint point{.triangle = surface.vertex_triangles[node].front()};
    const Triangle& t = surface.triangles[point.triangle];
    for (int k = 0; k < 3; ++k) point.barycentric[k] = t[k] == static_cast<int>(node) ? 1.0 : 0.0;
    add(point);
  }
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      const int a = surface.triangles[t][k], b = surface.triangles[t][next];
      if (is_free(a) || is_free(b) || !(is_sharp(sharpest[a]) || is_sharp(sharpest[b]))) continue;
      if (a > b && surface.neighbours[t][k] >= 0) continue;  // each edge once
      SurfacePoint point{.triangle = static_cast<int>(t)};
      const int parts = static_cast<int>(
          std::min<double>(kMaxParts, std::ceil(norm(rest[b] - rest[a]) / spacing)));
      for (int i = 1; i < parts; ++i) {
        point.barycentric[k] = 1.0 - static_cast<double>(i) / parts;
        point.barycentric[next] = static_cast<double>(i) / parts;
        add(point);
      }
    }
  }
  return points;
}

namespace {

// Distributes the constraint C = n . (sum w_k x_k - y) >= gap, with w the barycentric coordinates
// of the point of a face and y the rigid point, to the free corners of the face, as a contact for
// each. If C is violated, corner k moves by (gap - C) w_k / sum w^2 along n, the smallest
// displacement. If it is not, each corner may come nearer by (C - gap) / sum w, so that corners far
// from the point are not held back. `with` has the data of the contact except node, distance and
// offset.
void distribute(const Collider& self, const ClosestPoint& face, const Vec3& y, double gap,
                const Contact& with, std::vector<Contact>& contacts) {
  constexpr double kLeast = 0.1;  // coordinate below which a corner is left out
  // Sum of w^2 over the free corners, below which the face counts as fixed.
  constexpr double kMinSquares = 0.2;
  // Range above it in which the share grows to 1, so that it does not set in abruptly.
  constexpr double kFades = 0.1;
  const Triangle& t = self.surface->triangles[face.triangle];
  const auto& w = face.barycentric;
  double sum = 0.0, squares = 0.0;
  for (int k = 0; k < 3; ++k) {
    if (!(*self.free_nodes)[t[k]]) continue;
    sum += w[k];
    squares += w[k] * w[k];
  }
  if (squares < kMinSquares) return;
  const double share = std::min(1.0, (squares - kMinSquares) / kFades);
  const double missing = gap + with.offset - with.normal.dot(face.point - y);
  for (int k = 0; k < 3; ++k) {
    if (!(*self.free_nodes)[t[k]] || w[k] < kLeast) continue;
    Contact contact = with;
    contact.node = t[k];
    contact.distance = with.normal.dot(to_vec((*self.x)[t[k]]) - y);
    const double share_of_gap = missing > 0.0 ? share * missing * w[k] / squares : missing / sum;
    contact.offset = contact.distance - gap + share_of_gap;
    contacts.push_back(contact);
  }
}

THEW_VECTORISED
void grow_over_free(const Surface& surface, const Points& x, const std::vector<char>& is_free,
                    NodeBox& box) {
  for (const auto& [i, j, k] : surface.triangles) {
    if (!is_free[i] && !is_free[j] && !is_free[k]) continue;
    for (const int node : {i, j, k}) grow(box, x[node], x[node]);
  }
}

// Box of the faces that have a free corner; no others can give way. See box_of() for the copy.
NodeBox box_of_free(const Surface& surface, const Points& x, const std::vector<char>& is_free) {
  NodeBox grown = empty_box();
  grow_over_free(surface, x, is_free, grown);
  const NodeBox box = grown;
  return box;
}

[[gnu::always_inline]] inline bool is_within(const NodeBox& box, const Point& p) {
  for (int k = 0; k < 3; ++k) {
    if (p[k] < box.low[k] || p[k] > box.high[k]) return false;
  }
  return true;
}

bool is_with(const Contact& contact, int other) {
  return contact.of_face && contact.other == other;
}

// Box of the triangles around the nodes that press a rigid point of `other`, larger by `reach` (m).
NodeBox box_round(const Surface& surface, const Points& x, const std::vector<Contact>& pressing,
                  int other, double reach) {
  NodeBox box = empty_box();
  const Point around = {reach, reach, reach, 0.0};
  for (const Contact& contact : pressing) {
    if (!is_with(contact, other)) continue;
    for (const int t : surface.vertex_triangles[contact.node]) {
      for (const int corner : surface.triangles[t]) {
        grow(box, x[corner] - around, x[corner] + around);
      }
    }
  }
  return box;
}

bool presses_at(const std::vector<Contact>& pressing, int node, int other) {
  auto at = std::lower_bound(pressing.begin(), pressing.end(), node,
                             [](const Contact& contact, int n) { return contact.node < n; });
  for (; at != pressing.end() && at->node == node; ++at) {
    if (is_with(*at, other)) return true;
  }
  return false;
}

void set_parts(const Collider& them, ContactMemory::Other& known) {
  for (const SurfacePoint& point : *them.rigid_points) {
    known.part.push_back(them.history->parts.of_triangle[point.triangle]);
  }
}

}  // namespace

void find_face_contacts(const std::vector<Collider>& colliders, int mover,
                        const std::vector<int>& near, const ContactSettings& settings,
                        const std::vector<Contact>& pressing, ContactMemory& memory,
                        std::vector<Contact>& contacts) {
  // Share of max_depth up to which face contacts are found: a point that lies deeper did not slip
  // in between nodes (skin/notes.md, "Deeper face contacts").
  constexpr double kShallow = 0.5;
  const Collider& self = colliders[mover];
  if (self.free_nodes == nullptr) return;
  const double reach = std::max(settings.margin, settings.max_depth);
  std::optional<NodeBox> within;  // computed when it is first needed
  const auto is_in_reach = [&](const Point& p) {
    if (!within) {
      const NodeBox box = box_of_free(*self.surface, *self.x, *self.free_nodes);
      const Point around = {reach, reach, reach, 0.0};
      within = NodeBox{box.low - around, box.high + around};
    }
    return is_within(*within, p);
  };
  memory.others.resize(colliders.size());
  const size_t of_nodes = contacts.size();
  for (const int other : near) {
    const Collider& them = colliders[other];
    const std::vector<SurfacePoint>& points = *them.rigid_points;
    ContactMemory::Other& known = memory.others[other];
    const Approach approach =
        recall(them, self, static_cast<int>(points.size()), settings.margin, known);
    const bool presses = std::any_of(pressing.begin(), pressing.end(), [&](const Contact& contact) {
      return is_with(contact, other);
    });
    const NodeBox goes_on_in = box_round(*self.surface, *self.x, pressing, other, reach);
    if (approach.by_parts && known.part.empty()) set_parts(them, known);
    lower_bounds(approach, known.part, presses ? reach : settings.margin, nullptr, known, memory);
    for (int n = 0; n < memory.nearing_count; ++n) {
      const auto& [i, before] = memory.nearing[n];
      double& bound = known.distance_bound[i];
      const Point position = position_of(them, *them.x, points[i]);
      if (!is_in_reach(position)) {
        raise_by_box(*self.bvh, position, bound);
        continue;
      }
      const double farthest = is_within(goes_on_in, position) ? reach : settings.margin;
      if (bound >= farthest) continue;
      const Point motion = approach.by_parts
                               ? position - position_of(them, them.history->before, points[i])
                               : Point{};
      if (!may_be_within(approach, position, motion, farthest, before, bound)) continue;
      const Vec3 y = to_vec(position);
      ++memory.searches;
      const ClosestPoint found = find_closest(self, y, farthest, reach, i, known);
      if (found.triangle < 0) continue;
      const Triangle& t = self.surface->triangles[found.triangle];
      const bool goes_on = std::any_of(t.begin(), t.end(),
                                       [&](int node) { return presses_at(pressing, node, other); });
      if (found.distance >= (goes_on ? reach : settings.margin)) continue;
      if (found.distance <= -kShallow * settings.max_depth) continue;
      const Vec3 out = smooth_normal(*self.surface, *self.x, found.triangle, found.barycentric);
      const Vec3 own = normal_at(them, points[i]);
      if (own.dot(out) > -0.5) continue;  // the other side of something thin
      Contact with{-1, other, points[i].triangle, i, {}, -steady_normal(own, out)};
      std::copy(points[i].barycentric, points[i].barycentric + 3, with.barycentric);
      with.of_face = true;
      with.offset = thickness_at(self, found.triangle, found.barycentric) +
                    thickness_at(them, points[i].triangle, points[i].barycentric);
      distribute(self, found, y, settings.gap, with, contacts);
    }
  }
  if (contacts.size() > of_nodes) order_contacts(contacts);
}

}  // namespace thew::skin
