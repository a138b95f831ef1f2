// SPDX-License-Identifier: Apache-2.0
#include "skin/depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace thew::skin {
namespace {

// How often the outline of a triangle goes around the origin in the plane of axes u and v, across
// the ray: 1, -1 or 0. Rounding decides in the same way for both triangles of an edge, so that a
// ray through an edge or a corner of a closed surface counts exactly once.
int turns(const Vec3* corner, int u, int v) {
  int sum = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = corner[k], &b = corner[(k + 1) % 3];
    if ((a[v] <= 0.0) == (b[v] <= 0.0)) continue;
    const double left = a[u] * b[v] - b[u] * a[v];
    if (a[v] <= 0.0 && left > 0.0) ++sum;
    if (b[v] <= 0.0 && left < 0.0) --sum;
  }
  return sum;
}

// Whether a triangle whose outline goes around the ray (`round` times) lies ahead of the origin.
bool is_ahead(const Vec3* corner, int axis, int round) {
  const auto [least, most] = std::minmax({corner[0][axis], corner[1][axis], corner[2][axis]});
  if (least > 0.0 || most <= 0.0) return least > 0.0;
  return round * corner[0].dot(corner[1].cross(corner[2])) > 0.0;
}

// How often the ray from p along an axis, or against it, leaves the surface, less how often it
// enters it.
int count_along(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p, int axis,
                bool against) {
  constexpr int kStack = 192;  // see kStack in bvh.cpp
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  int count = 0, stack[kStack], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Bvh::Node& node = bvh.nodes[stack[--top]];
    if (against ? node.lo[axis] > p[axis] : node.hi[axis] < p[axis]) continue;
    if (node.lo[u] > p[u] || node.hi[u] < p[u] || node.lo[v] > p[v] || node.hi[v] < p[v]) {
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const Triangle& t = surface.triangles[bvh.order[i]];
      const Vec3 corner[3] = {to_vec(x[t[0]]) - p, to_vec(x[t[1]]) - p, to_vec(x[t[2]]) - p};
      const int round = turns(corner, u, v);
      if (round != 0 && is_ahead(corner, axis, round) != against) count += round;
    }
    if (node.count > 0) continue;
    stack[top++] = node.first;
    stack[top++] = node.first + 1;
  }
  return count;
}

double distance_to(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p) {
  constexpr double kAnywhere = std::numeric_limits<double>::infinity();
  return std::abs(closest_point(surface, bvh, x, p, kAnywhere).distance);
}

// Largest distance (m) from the surface of the points on one side of it.
double farthest(const Surface& surface, const Bvh& bvh, const Points& x, const Points& points,
                bool inside) {
  double most = 0.0;
  if (bvh.order.empty()) return most;
  for (const Point& row : points) {
    const Vec3 p = to_vec(row);
    if (encloses(surface, bvh, x, p) != inside) continue;
    most = std::max(most, distance_to(surface, bvh, x, p));
  }
  return most;
}

}  // namespace

bool encloses(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p) {
  if (bvh.order.empty() || box_distance(bvh, to_point(p)) > 0.0) return false;
  int inside = 0;  // number of rays by which p is inside
  for (int axis = 0; axis < 3; ++axis) inside += count_along(surface, bvh, x, p, axis, false) != 0;
  if (inside == 0 || inside == 3) return inside == 3;
  for (int axis = 0; axis < 3; ++axis) inside += count_along(surface, bvh, x, p, axis, true) != 0;
  if (inside <= 1 || inside >= 5) return inside >= 5;
  return std::abs(winding_number(surface, x, p)) > 0.5;
}

int ray_count(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p) {
  return count_along(surface, bvh, x, p, 0, false);
}

double deepest_inside(const Surface& surface, const Bvh& bvh, const Points& x,
                      const Points& points) {
  return farthest(surface, bvh, x, points, true);
}

double deepest_inside(const std::vector<Collider>& bodies, const Points& points) {
  double most = 0.0;
  for (const Collider& body : bodies) {
    most = std::max(most, deepest_inside(*body.surface, *body.bvh, *body.x, points));
  }
  return most;
}

double farthest_outside(const Surface& surface, const Bvh& bvh, const Points& x,
                        const Points& points) {
  return farthest(surface, bvh, x, points, false);
}

}  // namespace thew::skin
