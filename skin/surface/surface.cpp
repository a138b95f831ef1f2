// SPDX-License-Identifier: Apache-2.0
#include "skin/surface/surface.h"

#include <algorithm>

#include "muscles/lengths.h"
#include "rig/math.h"

namespace thew::skin {
namespace {

// Edge `side % 3` of triangle `side / 3`, with the smaller vertex first.
struct Side {
  int low, high, side;
  bool operator<(const Side& other) const {
    return std::array{low, high, side} < std::array{other.low, other.high, other.side};
  }
};

}  // namespace

Surface make_surface(std::vector<Triangle> triangles, int nodes) {
  Surface surface;
  const int count = static_cast<int>(triangles.size());
  surface.neighbours.assign(triangles.size(), {-1, -1, -1});
  surface.vertex_triangles.resize(nodes);
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (int t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), 3 * t + k});
      surface.vertex_triangles[a].push_back(t);
    }
  }
  std::sort(sides.begin(), sides.end());
  for (size_t i = 1; i < sides.size(); ++i) {
    const Side &one = sides[i - 1], &two = sides[i];
    if (one.low != two.low || one.high != two.high) continue;
    surface.neighbours[one.side / 3][one.side % 3] = two.side / 3;
    surface.neighbours[two.side / 3][two.side % 3] = one.side / 3;
  }
  surface.triangles = std::move(triangles);
  return surface;
}

bool is_convex(const Surface& surface, const Points& x) {
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    const Point n = to_point(face_normal(surface, x, static_cast<int>(t)));
    const Point corner = x[surface.triangles[t][0]];
    for (const Point& p : x) {
      if (dot(n, p - corner) > kRounding) return false;
    }
  }
  return true;
}

// Sum of the solid angles of the triangles (van Oosterom and Strackee 1983) over 4 pi.
double winding_number(const Surface& surface, const Points& x, const Vec3& p) {
  double sum = 0.0;
  for (const Triangle& t : surface.triangles) {
    const Vec3 a = to_vec(x[t[0]]) - p, b = to_vec(x[t[1]]) - p, c = to_vec(x[t[2]]) - p;
    const double u = a.norm(), v = b.norm(), w = c.norm();
    sum +=
        2.0 * arc_tan2(a.dot(b.cross(c)), u * v * w + a.dot(b) * w + b.dot(c) * u + c.dot(a) * v);
  }
  return sum / (4.0 * kPi);
}

Vec3 face_normal(const Surface& surface, const Points& x, int triangle) {
  const Triangle& t = surface.triangles[triangle];
  const Vec3 a = to_vec(x[t[0]]);
  const Vec3 n = (to_vec(x[t[1]]) - a).cross(to_vec(x[t[2]]) - a);
  const double length = n.norm();
  return length > 0.0 ? Vec3(n / length) : Vec3::Zero();
}

Vec3 node_normal(const Surface& surface, const Points& x, int node) {
  Vec3 sum = Vec3::Zero();
  for (int t : surface.vertex_triangles[node]) {
    const Triangle& corners = surface.triangles[t];
    const int k = corners[0] == node ? 0 : corners[1] == node ? 1 : 2;
    const Vec3 p = to_vec(x[node]);
    const Vec3 u = to_vec(x[corners[(k + 1) % 3]]) - p, v = to_vec(x[corners[(k + 2) % 3]]) - p;
    const Vec3 cross = u.cross(v);
    const double length = cross.norm();
    if (length > 0.0) sum += arc_tan2(length, u.dot(v)) / length * cross;
  }
  const double length = sum.norm();
  return length > 0.0 ? Vec3(sum / length) : Vec3::UnitZ();
}

}  // namespace thew::skin
