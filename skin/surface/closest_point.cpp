// SPDX-License-Identifier: Apache-2.0
//
// Nearest point with a shrinking bound, sign by angle-weighted pseudonormals (Baerentzen and Aanaes
// 2005).
#include <algorithm>
#include <cmath>

#include "rig/vectorise.h"
#include "skin/surface/box_query.h"
#include "skin/surface/nearest_triangle.h"

namespace thew::skin {
namespace {

// Outward unit normal at a point of a triangle: that of the face, edge or corner on which it lies,
// which its barycentric coordinates of 0 tell.
Vec3 pseudonormal(const Surface& surface, const Points& x, int triangle, const double* b) {
  for (int k = 0; k < 3; ++k) {
    const bool first = b[k] > 0.0, second = b[(k + 1) % 3] > 0.0, third = b[(k + 2) % 3] > 0.0;
    if (first && !second && !third) return node_normal(surface, x, surface.triangles[triangle][k]);
    if (first && second && !third) {
      Vec3 n = face_normal(surface, x, triangle);
      const int across = surface.neighbours[triangle][k];
      if (across >= 0) n += face_normal(surface, x, across);
      const double length = n.norm();
      return length > 0.0 ? Vec3(n / length)
                          : node_normal(surface, x, surface.triangles[triangle][k]);
    }
  }
  return face_normal(surface, x, triangle);
}

// Whether p lies outside a convex surface over the inside of a face: no other face is as near then.
// Not next to an edge, where by rounding the face across it may be as near, because the result must
// not depend on the order of the search.
bool is_over_face(const Surface& surface, const Points& x, int triangle, const OnTriangle& near,
                  const Vec3& p) {
  constexpr double kBeside = 1e-6;  // of the distance to p; its square is far above rounding
  const Triangle& t = surface.triangles[triangle];
  const Vec3 corner[3] = {to_vec(x[t[0]]), to_vec(x[t[1]]), to_vec(x[t[2]])};
  const Vec3 across = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  const double distance = (p - corner[0]).norm() + (corner[1] - corner[0]).norm();
  for (int k = 0; k < 3; ++k) {
    const double edge = (corner[(k + 2) % 3] - corner[(k + 1) % 3]).norm();
    if (!(near.b[k] * across.norm() > kBeside * distance * edge)) return false;
  }
  return across.dot(p - corner[0]) > 0.0;
}

struct Nearest {
  int triangle = -1;
  double distance2 = 0.0;  // m^2
};

OnTriangle nearest_on(const Surface& surface, const Points& x, int triangle, const Vec3& p) {
  const Triangle& t = surface.triangles[triangle];
  return nearest_on_triangle(to_vec(x[t[0]]), to_vec(x[t[1]]), to_vec(x[t[2]]), p);
}

bool has_triangle(const Surface& surface, int triangle) {
  return triangle >= 0 && triangle < static_cast<int>(surface.triangles.size());
}

ClosestPoint closest_on(const Surface& surface, const Points& x, int triangle, const Vec3& p,
                        const OnTriangle& near) {
  ClosestPoint point;
  const Triangle& t = surface.triangles[triangle];
  const double* b = near.b;
  point.triangle = triangle;
  std::copy(b, b + 3, point.barycentric);
  point.point = b[0] * to_vec(x[t[0]]) + b[1] * to_vec(x[t[1]]) + b[2] * to_vec(x[t[2]]);
  point.normal = pseudonormal(surface, x, triangle, b);
  point.distance = std::sqrt(near.distance2);
  if (point.normal.dot(p - point.point) < 0.0) point.distance = -point.distance;
  return point;
}

using Float8 = float __attribute__((vector_size(32)));

// A point or a box, rounded outwards, in all lanes.
struct WideQuery {
  Float8 below[3], up[3];
  [[gnu::always_inline]] WideQuery(const Point& low, const Point& high) {
    Float4 down, above, unused;
    round_both(low, down, unused);
    round_both(high, unused, above);
    const Float8 zero = {};
    for (int axis = 0; axis < 3; ++axis) {
      below[axis] = zero + down[axis];
      up[axis] = zero + above[axis];
    }
  }
};

// Lower bounds of the squared distances from eight boxes, whose coordinates along an axis are
// `stride` after those along the one before.
[[gnu::always_inline]] inline Float8 box_distances2(const float* low, const float* high, int stride,
                                                    const WideQuery& of) {
  Float8 sum = {};
  const Float8 zero = {};
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
    Float8 lo, hi;
    std::memcpy(&lo, low + axis * stride, sizeof lo);
    std::memcpy(&hi, high + axis * stride, sizeof hi);
    Float8 a = lo - of.up[axis], b = of.below[axis] - hi;
    a = a > b ? a : b;
    a = a > zero ? a : zero;
    sum += a * a;
  }
  return sum * kBelowRounding;
}

// A bound for floats that is not below a number, and below the distance of what is missing.
[[gnu::always_inline]] inline float rounded_up(double a) {
  return std::min(static_cast<float>(a) * (1.0f + 2e-7f) + std::numeric_limits<float>::min(),
                  std::numeric_limits<float>::max());
}

// Blocks near some points, with their boxes.
struct NearBlocks {
  static constexpr int kMost = 64, kLanes = 8;
  alignas(32) float low[3][kMost], high[3][kMost];
  int block[kMost], count = 0;

  [[gnu::always_inline]] void add(const Bvh& bvh, const Bvh::Wide& wide, int child) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis][count] = wide.low[axis][child];
      high[axis][count] = wide.high[axis][child];
    }
    block[count++] = bvh.block_of[wide.node[child]];
  }
};

// Triangles that wait for being tested four at a time.
struct Waiting {
  int triangle[kLanes + Bvh::Block::kLanes];
  int count = 0;
};

// Tests the first four triangles that wait, or all if there are fewer. Of equally near triangles
// the one of the lowest index wins, so that the order of the search does not matter.
[[gnu::always_inline]] inline void test_waiting(const Surface& surface, const Points& x,
                                                const Lanes3& p, Waiting& waiting,
                                                Nearest& nearest) {
  const int last = std::min(waiting.count, kLanes) - 1;
  const Triangle* triangles[kLanes];  // where there are fewer than four, the last again
  for (int k = 0; k < kLanes; ++k) {
    triangles[k] = &surface.triangles[waiting.triangle[std::min(k, last)]];
  }
  const Lanes distance2 = distances2(triangles, x, p);
  for (int k = 0; k <= last; ++k) {
    const int t = waiting.triangle[k];
    if (distance2[k] > nearest.distance2 ||
        (distance2[k] == nearest.distance2 && nearest.triangle >= 0 && nearest.triangle <= t)) {
      continue;
    }
    nearest = {t, distance2[k]};
  }
  waiting.count -= last + 1;
  for (int k = 0; k < waiting.count; ++k) waiting.triangle[k] = waiting.triangle[last + 1 + k];
}

// Adds the triangles of a block whose boxes are near a point.
[[gnu::always_inline]] inline void add_near(const Bvh::Block& block, const WideQuery& query,
                                            float limit, Waiting& waiting) {
  using Int8 = int __attribute__((vector_size(32)));
  const Int8 near_lanes =
      box_distances2(block.low[0], block.high[0], Bvh::Block::kLanes, query) <= limit;
  alignas(32) int is_near[Bvh::Block::kLanes];  // -1: yes
  std::memcpy(is_near, &near_lanes, sizeof is_near);
#pragma GCC unroll 8
  for (int l = 0; l < Bvh::Block::kLanes; ++l) {
    waiting.triangle[waiting.count] = block.triangle[l];
    waiting.count -= is_near[l];
  }
}

// The nearest triangle to a point of those in the blocks.
[[gnu::always_inline]] inline void test_blocks(const Surface& surface, const Bvh& bvh,
                                               const Points& x, const NearBlocks& blocks,
                                               const Vec3& p, Nearest& nearest) {
  const WideQuery query(to_point(p), to_point(p));
  const Lanes3 in_lanes = in_all_lanes(p);
  alignas(32) float bounds[NearBlocks::kMost + 4];
  int near[NearBlocks::kMost + 4], count = 0;
  float limit = rounded_up(nearest.distance2);
  for (int i = 0; i < blocks.count; i += NearBlocks::kLanes) {
    const Float8 distance2 =
        box_distances2(&blocks.low[0][i], &blocks.high[0][i], NearBlocks::kMost, query);
    std::memcpy(bounds + i, &distance2, sizeof distance2);
  }
  for (int k = 0; k < 4; ++k) bounds[blocks.count + k] = std::numeric_limits<float>::infinity();
  for (int i = 0; i < blocks.count; i += 4) {  // without a branch, which would be mispredicted
#pragma GCC unroll 4
    for (int k = i; k < i + 4; ++k) {
      near[count] = k;
      count += bounds[k] <= limit;
    }
  }
  if (count > 0 && nearest.triangle < 0) {
    const auto is_nearer = [&](int a, int b) { return bounds[a] < bounds[b]; };
    std::swap(near[0], *std::min_element(near, near + count, is_nearer));
  }
  Waiting waiting;
  for (int k = 0; k < count; ++k) {
    if (bounds[near[k]] > limit) continue;
    add_near(bvh.blocks[blocks.block[near[k]]], query, limit, waiting);
    while (waiting.count >= kLanes) {
      test_waiting(surface, x, in_lanes, waiting, nearest);
      limit = rounded_up(nearest.distance2);
    }
  }
  if (waiting.count > 0) test_waiting(surface, x, in_lanes, waiting, nearest);
}

// The distance of each point from the triangle that it hints at.
[[gnu::always_inline]] inline void test_hints(const Surface& surface, const Points& x,
                                              const PointGroup& group, Nearest* nearest) {
  for (int first = 0; first < group.count; first += kLanes) {
    const Triangle* triangles[kLanes];
    Point at[kLanes];
    int hints[kLanes];
    bool any = false;
    for (int k = 0; k < kLanes; ++k) {
      const int i = std::min(first + k, group.count - 1);
      const bool known = has_triangle(surface, group.hint[i]);
      any = any || known;
      hints[k] = known ? group.hint[i] : -1;
      triangles[k] = &surface.triangles[known ? hints[k] : 0];
      at[k] = to_point(group.at[i]);
    }
    if (!any) continue;
    const Lanes distance2 = distances2(triangles, x, side_by_side(at[0], at[1], at[2], at[3]));
    for (int k = 0; k < kLanes && first + k < group.count; ++k) {
      if (hints[k] < 0 || distance2[k] > nearest[first + k].distance2) continue;
      nearest[first + k] = {hints[k], distance2[k]};
    }
  }
}

THEW_VECTORISED
void find_nearest(const Surface& surface, const Bvh& bvh, const Points& x, const PointGroup& group,
                  Nearest* nearest) {
  test_hints(surface, x, group, nearest);
  NodeBox box = empty_box();
  for (int i = 0; i < group.count; ++i) grow(box, to_point(group.at[i]), to_point(group.at[i]));
  const WideQuery query(box.low, box.high);
  NearBlocks blocks;
  float farthest2 = 0.0f;
  const auto find_farthest = [&]() __attribute__((always_inline)) {
    farthest2 = 0.0f;
    for (int i = 0; i < group.count; ++i) {
      farthest2 = std::max(farthest2, rounded_up(nearest[i].distance2));
    }
  };
  const auto test = [&]() __attribute__((always_inline)) {
    for (int i = 0; i < group.count; ++i) {
      test_blocks(surface, bvh, x, blocks, group.at[i], nearest[i]);
    }
    blocks.count = 0;
    find_farthest();
  };
  find_farthest();
  int stack[kWideStack], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Bvh::Wide& wide = bvh.wide[stack[--top]];
    const Float8 distance2 = box_distances2(wide.low[0], wide.high[0], Bvh::Wide::kChildren, query);
    alignas(32) float bounds[Bvh::Wide::kChildren];
    std::memcpy(bounds, &distance2, sizeof distance2);
    int near[Bvh::Wide::kChildren], count = 0;
#pragma GCC unroll 8
    for (int k = 0; k < Bvh::Wide::kChildren; ++k) {
      near[count] = k;
      count += bounds[k] <= farthest2;
    }
    for (int k = 0; k < count; ++k) {
      if (wide.child[near[k]] >= 0) {
        stack[top++] = wide.child[near[k]];
      } else {
        blocks.add(bvh, wide, near[k]);
        if (blocks.count == NearBlocks::kMost) test();
      }
    }
  }
  if (blocks.count > 0) test();
}

THEW_VECTORISED
void find_nearest(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p,
                  Nearest& nearest) {
  const WideQuery query(to_point(p), to_point(p));
  const Lanes3 in_lanes = in_all_lanes(p);
  float limit = rounded_up(nearest.distance2);
  Waiting waiting;
  struct Entry {
    int wide;
    float distance2;
  } stack[kWideStack];
  int top = 0;
  stack[top++] = {0, 0.0f};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (entry.distance2 > limit) continue;
    const Bvh::Wide& wide = bvh.wide[entry.wide];
    const Float8 distance2 = box_distances2(wide.low[0], wide.high[0], Bvh::Wide::kChildren, query);
    alignas(32) float bounds[Bvh::Wide::kChildren];
    std::memcpy(bounds, &distance2, sizeof bounds);
    int near[Bvh::Wide::kChildren + 1], count = 0;
#pragma GCC unroll 8
    for (int k = 0; k < Bvh::Wide::kChildren; ++k) {
      near[count] = k;
      count += bounds[k] <= limit;
    }
    const int first = top;
    for (int k = 0; k < count; ++k) {
      const int child = near[k];
      if (wide.child[child] >= 0) {
        stack[top++] = {wide.child[child], bounds[child]};
        continue;
      }
      add_near(bvh.blocks[bvh.block_of[wide.node[child]]], query, limit, waiting);
      while (waiting.count >= kLanes || (nearest.triangle < 0 && waiting.count > 0)) {
        test_waiting(surface, x, in_lanes, waiting, nearest);
        limit = rounded_up(nearest.distance2);
      }
    }
    // The nearest is looked into first.
    for (int k = first; k < top - 1; ++k) {
      if (stack[k].distance2 < stack[top - 1].distance2) std::swap(stack[k], stack[top - 1]);
    }
  }
  if (waiting.count > 0) test_waiting(surface, x, in_lanes, waiting, nearest);
}

}  // namespace

ClosestPoint closest_point(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p,
                           double bound, int hint) {
  Nearest nearest{-1, bound * bound};
  OnTriangle near = {};
  if (has_triangle(surface, hint)) {
    near = nearest_on(surface, x, hint, p);
    if (!(near.distance2 > nearest.distance2)) nearest = {hint, near.distance2};
  }
  if (!(surface.convex && nearest.triangle >= 0 && is_over_face(surface, x, hint, near, p))) {
    if (!bvh.order.empty()) find_nearest(surface, bvh, x, p, nearest);
  }
  if (nearest.triangle < 0) return {};
  if (nearest.triangle != hint) near = nearest_on(surface, x, nearest.triangle, p);
  return closest_on(surface, x, nearest.triangle, p, near);
}

void find_closest_points(const Surface& surface, const Bvh& bvh, const Points& x,
                         PointGroup& group) {
  Nearest nearest[PointGroup::kMost];
  for (int i = 0; i < group.count; ++i) {
    group.closest[i].triangle = -1;
    nearest[i] = {-1, group.bound[i] * group.bound[i]};
  }
  if (!bvh.order.empty()) find_nearest(surface, bvh, x, group, nearest);
  for (int i = 0; i < group.count; ++i) {
    const int t = nearest[i].triangle;
    if (t < 0) continue;
    group.closest[i] =
        closest_on(surface, x, t, group.at[i], nearest_on(surface, x, t, group.at[i]));
  }
}

std::vector<NodeGroup> groups_of(const Surface& surface, const Bvh& bvh) {
  std::vector<NodeGroup> groups;
  std::vector<char> has_group(surface.vertex_triangles.size(), 0);
  const auto add = [&](int node) {
    if (groups.empty() || groups.back().count == PointGroup::kMost) groups.emplace_back();
    groups.back().nodes[groups.back().count++] = node;
  };
  for (const int t : bvh.order) {
    for (const int node : surface.triangles[t]) {
      if (has_group[node]) continue;
      has_group[node] = 1;
      add(node);
    }
  }
  // Nodes of no triangle are searched for as well.
  for (size_t node = 0; node < has_group.size(); ++node) {
    if (!has_group[node]) add(static_cast<int>(node));
  }
  return groups;
}

void triangles_near(const Bvh& bvh, const Vec3& p, double reach, std::vector<int>& triangles) {
  triangles.clear();
  if (bvh.order.empty()) return;
  const BoxQuery query(p);
  int stack[kStack], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Bvh::Node& node = bvh.nodes[stack[--top]];
    if (box_distance2(node, query) > reach * reach) continue;
    triangles.insert(triangles.end(), bvh.order.begin() + node.first,
                     bvh.order.begin() + node.first + node.count);
    if (node.count > 0) continue;
    stack[top++] = node.first;
    stack[top++] = node.first + 1;
  }
}

ClosestPoint closest_on_triangle(const Surface& surface, const Points& x, int triangle,
                                 const Vec3& p) {
  const Triangle& t = surface.triangles[triangle];
  const Vec3 a = to_vec(x[t[0]]), b = to_vec(x[t[1]]), c = to_vec(x[t[2]]);
  const OnTriangle near = nearest_on_triangle(a, b, c, p);
  ClosestPoint point;
  point.triangle = triangle;
  std::copy(near.b, near.b + 3, point.barycentric);
  point.point = near.b[0] * a + near.b[1] * b + near.b[2] * c;
  point.normal = face_normal(surface, x, triangle);
  point.distance = std::sqrt(near.distance2);
  if (point.normal.dot(p - point.point) < 0.0) point.distance = -point.distance;
  return point;
}

}  // namespace thew::skin
