// SPDX-License-Identifier: Apache-2.0
#include "skin/skin_props.h"

#include <algorithm>

#include "skin/contact/contact.h"
#include "skin/skin_passes.h"

namespace thew::skin {
namespace {

constexpr int kMostRounds = 10;  // of moving nodes and faces in turn
// By how much a corner moves at most where its face lacks 1: the largest b / sum_k b_k^2 of
// barycentric coordinates.
constexpr double kOfCorner = 1.37;

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

void move_nodes(const Props& props, SkinState& state) {
  constexpr double kLeastDirection = 1e-9;  // m; nearer, the surface's normal is the direction
  for_each_near(props, state.x, props.gap, [&](size_t i, const ClosestPoint& near) {
    const Vec3 normal = contact_normal(near, to_vec(state.x[i]), kLeastDirection);
    state.x[i] = to_point(Vec3(near.point + props.gap * normal));
    state.held[i] = 1;
  });
}

// A prop may be finer than the skin, and come through between its nodes. Moves the face that is
// nearest to such a point of it beyond the prop's tangent plane there, if the two face each other:
// the other wall of a limb, or what a point at the prop's back sees, does not. A node moves by no
// more than what its faces lack asks for. Returns whether there was one.
bool move_faces(const Props& props, const Surface& surface, SkinState& state) {
  fit_tree(surface, state);
  state.at_props.clear();
  for (const Collider& prop : props.colliders) {
    for (size_t i = 0; i < prop.x->size(); ++i) {
      const Point& point = (*prop.x)[i];
      if (box_distance(state.bvh, point) > props.gap) continue;
      const Vec3 p = to_vec(point);
      const ClosestPoint near = closest_point(surface, state.bvh, state.x, p, props.reach);
      if (near.triangle < 0 || near.distance >= props.gap - kRounding) continue;
      const Vec3 out = node_normal(*prop.surface, *prop.x, static_cast<int>(i));
      if (near.normal.dot(out) >= 0.0 || is_on_border(surface, near)) continue;
      const double level = out.dot(p) + props.gap;
      state.at_props.push_back(plane_at(near, level));
      state.at_props.back().normal = out;
      for (const int node : surface.triangles[near.triangle]) {
        double& most = state.skinned.most[node];
        most = std::max(most, kOfCorner * (level - out.dot(near.point)));
      }
    }
  }
  for (const SkinPlane& plane : state.at_props) {
    const Triangle& t = surface.triangles[plane.triangle];
    const auto& b = plane.barycentric;
    Point on{};
    double squares = 0.0;
    for (int k = 0; k < 3; ++k) on += b[k] * state.x[t[k]], squares += b[k] * b[k];
    const double lack = plane.level - plane.normal.dot(to_vec(on));
    if (lack <= 0.0) continue;
    for (int k = 0; k < 3; ++k) {
      const Point& from = state.skinned.before[t[k]];
      const Point by = state.x[t[k]] + (lack * b[k] / squares) * to_point(plane.normal) - from;
      const double far = norm(by), most = state.skinned.most[t[k]];
      state.x[t[k]] = from + (far > most ? most / far : 1.0) * by;
      state.held[t[k]] = 1;
    }
  }
  return !state.at_props.empty();
}

}  // namespace

void leave_props(const Props& props, const Surface& surface, SkinState& state) {
  state.held.assign(state.x.size(), 0);
  if (props.colliders.empty()) return;
  state.skinned.before = state.x;
  state.skinned.most.assign(state.x.size(), 0.0);
  for (int round = 0; round < kMostRounds; ++round) {
    move_nodes(props, state);
    if (!move_faces(props, surface, state)) return;
  }
  move_nodes(props, state);
}

void mark_at_props(const Props& props, const Points& x, std::vector<char>& marked) {
  for_each_near(props, x, props.gap - kNodeRounding,
                [&](size_t i, const ClosestPoint&) { marked[i] = 1; });
}

}  // namespace thew::skin
