// SPDX-License-Identifier: Apache-2.0
//
// The searches of a step: the flesh below the skin, flesh that comes near its triangles, the other
// walls of its folds. Nodes that lie near one another search together, because most of them find
// nothing, which one look at the tree then tells of all.
#include <algorithm>
#include <cmath>

#include "rig/vectorise.h"
#include "skin/skin_layer.h"
#include "skin/skin_passes.h"
#include "skin/surface/box_query.h"

namespace thew::skin {
namespace {

constexpr int kGroups = 16;  // that a thread takes at a time

void order_by_planes(SkinState& state) {
  std::array<int, FleshPlanes::kMaxPlanes + 2> begin = {};
  for (const int count : state.planes.count) ++begin[count + 1];
  for (size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
  state.by_planes.resize(state.planes.count.size());
  for (size_t i = 0; i < state.by_planes.size(); ++i) {
    state.by_planes[begin[state.planes.count[i]]++] = static_cast<int>(i);
  }
}

// Groups of the nodes of all colliders, made anew for other colliders.
void group_flesh(const std::vector<Collider>& below, SkinState& state) {
  std::vector<int>& begin = state.flesh_begin;
  bool known = begin.size() == below.size() + 1;
  for (size_t c = 0; c < below.size() && known; ++c) {
    known = begin[c + 1] - begin[c] == static_cast<int>(below[c].x->size());
  }
  if (known) return;
  begin.assign(1, 0);
  state.flesh_groups.clear();
  for (size_t c = 0; c < below.size(); ++c) {
    begin.push_back(begin[c] + static_cast<int>(below[c].x->size()));
    for (const NodeGroup& group : groups_of(*below[c].surface, *below[c].bvh)) {
      state.flesh_groups.push_back({group, static_cast<int>(c)});
    }
  }
  state.cover_hints.assign(begin.back(), -1);
  state.cover_slack.resize(begin.back());
  state.cover_over.resize(begin.back());
  state.covered.resize(begin.back());
}

// Sets cover_over of the nodes of a group that the skin may have come near since they were last
// looked for, and how far it may move until it comes near again. `reach` is as far as it may be
// out, `radius` (m) as far as is searched. A node below the skin does not come out of it without
// going through it.
void find_covers_over(const SkinModel& model, const Collider& flesh, const FleshGroup& group,
                      double depth, double reach, double radius, SkinState& state) {
  const int begin = state.flesh_begin[group.collider];
  PointGroup points;
  std::array<int, PointGroup::kMost> nodes;
  for (int i = 0; i < group.count; ++i) {
    const int node = begin + group.nodes[i];
    state.covered[node] = 0;
    if (state.cover_slack[node] > 0.0) continue;
    nodes[points.count] = node;
    points.at[points.count] = to_vec((*flesh.x)[group.nodes[i]]);
    points.bound[points.count] = radius;
    points.hint[points.count++] = state.cover_hints[node];
  }
  if (points.count == 0) return;
  find_closest_points(model.surface, state.bvh, state.x, points);
  for (int i = 0; i < points.count; ++i) {
    const ClosestPoint& near = points.closest[i];
    const int node = nodes[i];
    state.cover_slack[node] = radius - reach;
    if (near.triangle < 0) continue;
    state.cover_hints[node] = near.triangle;
    state.cover_slack[node] = std::max(-near.distance - depth, near.distance - reach);
    if (near.distance < -depth || near.distance > reach) continue;
    if (is_on_border(model.surface, near)) continue;
    const double cover = model.cover.empty() ? model.settings.lengths.cover : model.cover[node];
    const double level = near.normal.dot(points.at[i]) + cover;
    state.cover_over[node] = plane_at(near, level);
    state.covered[node] = 1;
  }
}

[[gnu::always_inline]] inline Point sum_of_normals(const SkinState& state, const Triangle& t) {
  return state.normals[t[0]] + state.normals[t[1]] + state.normals[t[2]];
}

THEW_VECTORISED
void find_normal_boxes(const SkinModel& model, SkinState& state) {
  for (size_t n = state.bvh.nodes.size(); n-- > 0;) {
    const Bvh::Node& node = state.bvh.nodes[n];
    NodeBox box = empty_box();
    for (int i = node.first; i < node.first + node.count; ++i) {
      const Point sum = sum_of_normals(state, model.surface.triangles[state.bvh.order[i]]);
      grow(box, sum, sum);
    }
    for (int i = node.first; node.count == 0 && i < node.first + 2; ++i) {
      grow(box, state.normal_boxes[i].low, state.normal_boxes[i].high);
    }
    state.normal_boxes[n] = box;
  }
}

// Whether no vector of one box has an angle of 90 degrees or more to one of the other.
[[gnu::always_inline]] inline bool face_alike(const NodeBox& a, const NodeBox& b) {
  constexpr double kAboveRounding = 1e-12;  // of products of unit vectors
  const auto less = [](const Point& s, const Point& t) __attribute__((always_inline)) {
    return s < t ? s : t;
  };
  return sum3(less(less(a.low * b.low, a.low * b.high), less(a.high * b.low, a.high * b.high))) >
         kAboveRounding;
}

// Whether a triangle that does not have the node faces it.
bool may_be_wall(const SkinModel& model, const SkinState& state, int triangle, int node) {
  const Triangle& c = model.surface.triangles[triangle];
  if (c[0] == node || c[1] == node || c[2] == node) return false;
  return !(to_vec(sum_of_normals(state, c)).dot(to_vec(state.normals[node])) > 0.0);
}

// Looks for a wall among the triangles of a leaf: the nearest that faces the node.
void find_wall(const SkinModel& model, const SkinState& state, const Bvh::Node& leaf, int node,
               double& nearest, ClosestPoint& wall) {
  for (int i = leaf.first; i < leaf.first + leaf.count; ++i) {
    const int t = state.bvh.order[i];
    if (!may_be_wall(model, state, t, node)) continue;
    const ClosestPoint point =
        closest_on_triangle(model.surface, state.x, t, to_vec(state.x[node]));
    const double away = std::abs(point.distance);
    if (away > nearest || (away == nearest && wall.triangle >= 0 && wall.triangle < t)) continue;
    nearest = away;
    wall = point;
  }
}

THEW_VECTORISED
void find_walls(const SkinModel& model, const NodeGroup& group, SkinState& state) {
  const double reach = model.settings.lengths.fold_reach;
  NodeBox box = empty_box(), normals = empty_box();
  std::array<double, PointGroup::kMost> nearest;
  std::array<ClosestPoint, PointGroup::kMost> walls;
  BoxQuery queries[PointGroup::kMost];
  for (int i = 0; i < group.count; ++i) {
    const int node = group.nodes[i];
    grow(box, state.x[node], state.x[node]);
    grow(normals, state.normals[node], state.normals[node]);
    nearest[i] = reach;
    queries[i] = BoxQuery(NodeBox{state.x[node], state.x[node]});
  }
  const BoxQuery query(box);
  int stack[kStack], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const int at = stack[--top];
    const Bvh::Node& node = state.bvh.nodes[at];
    if (box_distance2(node, query) > reach * reach) continue;
    if (face_alike(state.normal_boxes[at], normals)) continue;
    for (int i = 0; node.count > 0 && i < group.count; ++i) {
      if (box_distance2(node, queries[i]) > nearest[i] * nearest[i]) continue;
      find_wall(model, state, node, group.nodes[i], nearest[i], walls[i]);
    }
    if (node.count > 0) continue;
    stack[top++] = node.first;
    stack[top++] = node.first + 1;
  }
  for (int i = 0; i < group.count; ++i) {
    state.walls[group.nodes[i]] = plane_at(walls[i], model.wall_level[group.nodes[i]]);
  }
}

}  // namespace

void find_flesh_below(const SkinModel& model, const std::vector<Collider>& below, bool first,
                      const Loop& loop, SkinState& state) {
  const Lengths& lengths = model.settings.lengths;
  state.hints.resize(state.x.size() * (below.size() + 1), -1);
  const auto search = [&](const NodeGroup& group) {
    NodeGroup wanted;
    for (int i = 0; i < group.count; ++i) {
      const int node = group.nodes[i];
      const double moved = to_vec(state.x[node] - state.searched_at[node]).norm();
      if (!first && !(moved > lengths.lookup_motion)) continue;
      wanted.nodes[wanted.count++] = node;
      state.searched_at[node] = state.x[node];
    }
    if (wanted.count == 0) return;
    find_flesh(below, state.x, wanted, lengths.flesh_reach, model.settings.bridging,
               lengths.least_direction, state.hints, state.planes);
  };
  loop.ranges(static_cast<int>(state.groups.size()), kGroups, [&](int from, int to) {
    for (int g = from; g < to; ++g) search(state.groups[g]);
  });
  order_by_planes(state);
}

bool is_on_border(const Surface& surface, const ClosestPoint& near) {
  const double* b = near.barycentric;
  const auto is_border = [&](int triangle, int edge) {
    return surface.neighbours[triangle][edge] < 0;
  };
  for (int k = 0; k < 3; ++k) {
    if (b[k] >= 1.0) {  // a corner
      const int node = surface.triangles[near.triangle][k];
      for (const int t : surface.vertex_triangles[node]) {
        for (int edge = 0; edge < 3; ++edge) {
          const Triangle& c = surface.triangles[t];
          if ((c[edge] == node || c[(edge + 1) % 3] == node) && is_border(t, edge)) return true;
        }
      }
    } else if (b[k] <= 0.0 && is_border(near.triangle, (k + 1) % 3)) {
      return true;
    }
  }
  return false;
}

SkinPlane plane_at(const ClosestPoint& near, double level) {
  const double* b = near.barycentric;
  return {near.triangle, {b[0], b[1], b[2]}, near.normal, level};
}

void find_covers(const SkinModel& model, const std::vector<Collider>& below, double depth,
                 double ahead, bool first, const Loop& loop, SkinState& state) {
  const double reach = std::max(depth, model.settings.lengths.cover_reach);
  fit_tree(model.surface, state);
  group_flesh(below, state);
  if (first) {
    std::fill(state.cover_slack.begin(), state.cover_slack.end(), 0.0);
  } else {
    const double moved = largest_distance(state.x, state.covers_at) + kRounding;
    for (double& slack : state.cover_slack) slack -= moved;
  }
  state.covers_at = state.x;
  const double radius = first ? reach + ahead : reach;
  loop.ranges(static_cast<int>(state.flesh_groups.size()), kGroups, [&](int from, int to) {
    for (int g = from; g < to; ++g) {
      const FleshGroup& group = state.flesh_groups[g];
      find_covers_over(model, below[group.collider], group, depth, reach, radius, state);
    }
  });
  state.covers.clear();
  for (size_t node = 0; node < state.covered.size(); ++node) {
    if (state.covered[node]) state.covers.push_back(state.cover_over[node]);
  }
}

void find_folds(const SkinModel& model, const Loop& loop, SkinState& state) {
  find_normal_boxes(model, state);
  loop.ranges(static_cast<int>(state.groups.size()), kGroups, [&](int from, int to) {
    for (int g = from; g < to; ++g) find_walls(model, state.groups[g], state);
  });
  state.folds.clear();
  for (size_t i = 0; i < state.walls.size(); ++i) {
    if (state.walls[i].triangle >= 0) state.folds.push_back({static_cast<int>(i), state.walls[i]});
  }
}

void find_wall_levels(SkinModel& model) {
  model.wall_level.assign(model.rest.size(), model.settings.fold_gap);
  const SkinState rest = initial_skin(model);
  std::vector<int> nearby;
  for (size_t i = 0; i < model.rest.size(); ++i) {
    const int node = static_cast<int>(i);
    const Vec3 p = to_vec(model.rest[i]);
    double& level = model.wall_level[i];
    triangles_near(rest.bvh, p, model.settings.lengths.fold_reach, nearby);
    for (const int t : nearby) {
      if (!may_be_wall(model, rest, t, node)) continue;
      const ClosestPoint wall = closest_on_triangle(model.surface, rest.x, t, p);
      level = std::min(level, wall.normal.dot(p - wall.point));
    }
  }
}

}  // namespace thew::skin
