// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "skin/surface/surface.h"

namespace thew::skin {
namespace {

// Six times the signed volume of the tetrahedron pabc.
double orientation(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  return (a - p).dot((b - p).cross(c - p));
}

bool same_sign(double a, double b) { return (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0); }

// Whether the segment pq passes through the inside of a triangle; touching does not count.
bool pierces(const Vec3& p, const Vec3& q, const Vec3* t) {
  const double at_p = orientation(p, t[0], t[1], t[2]), at_q = orientation(q, t[0], t[1], t[2]);
  if (!same_sign(at_p, -at_q)) return false;
  const double u = orientation(p, q, t[0], t[1]), v = orientation(p, q, t[1], t[2]);
  return same_sign(u, v) && same_sign(v, orientation(p, q, t[2], t[0]));
}

// Whether all of t lies on one side of the plane of s, so that they cannot cross.
bool one_side(const Vec3* s, const Vec3* t) {
  const Vec3 n = (s[1] - s[0]).cross(s[2] - s[0]);
  const double a = n.dot(t[0] - s[0]), b = n.dot(t[1] - s[0]), c = n.dot(t[2] - s[0]);
  return same_sign(a, b) && same_sign(b, c);
}

bool cross(const Vec3* s, const Vec3* t) {
  if (one_side(s, t) || one_side(t, s)) return false;
  for (int k = 0; k < 3; ++k) {
    if (pierces(s[k], s[(k + 1) % 3], t) || pierces(t[k], t[(k + 1) % 3], s)) return true;
  }
  return false;
}

bool overlap(const Bvh::Node& a, const Bvh::Node& b) {
  for (int k = 0; k < 3; ++k) {
    if (a.lo[k] > b.hi[k] || b.lo[k] > a.hi[k]) return false;
  }
  return true;
}

bool share_node(const Triangle& s, const Triangle& t) {
  return std::any_of(s.begin(), s.end(),
                     [&](int node) { return node == t[0] || node == t[1] || node == t[2]; });
}

void corners(const Surface& surface, const Points& x, int triangle, Vec3* out) {
  for (int k = 0; k < 3; ++k) out[k] = to_vec(x[surface.triangles[triangle][k]]);
}

}  // namespace

std::vector<std::array<int, 2>> crossing_triangles(const Surface& a, const Bvh& bvh_a,
                                                   const Points& xa, const Surface& b,
                                                   const Bvh& bvh_b, const Points& xb) {
  std::vector<std::array<int, 2>> pairs;
  find_crossings(a, bvh_a, xa, b, bvh_b, xb, pairs);
  return pairs;
}

void find_crossings(const Surface& a, const Bvh& bvh_a, const Points& xa, const Surface& b,
                    const Bvh& bvh_b, const Points& xb, std::vector<std::array<int, 2>>& pairs) {
  pairs.clear();
  if (bvh_a.order.empty() || bvh_b.order.empty()) return;
  const bool itself = &a == &b && &xa == &xb;
  const auto test = [&](int i, int j) {
    if (itself && share_node(a.triangles[i], b.triangles[j])) return;
    Vec3 s[3], t[3];
    corners(a, xa, i, s);
    corners(b, xb, j, t);
    if (!cross(s, t)) return;
    pairs.push_back(itself ? std::array{std::min(i, j), std::max(i, j)} : std::array{i, j});
  };
  // A step down either tree adds two entries at most, and no tree has more than 150 levels
  // (bvh.cpp).
  constexpr int kStack = 1024;
  std::array<int, 2> stack[kStack];
  int top = 0;
  const auto push = [&](int n, int m) { stack[top++] = {n, m}; };
  push(0, 0);
  while (top > 0) {
    const auto [n, m] = stack[--top];
    const Bvh::Node &one = bvh_a.nodes[n], &two = bvh_b.nodes[m];
    if (!overlap(one, two)) continue;
    const bool same = itself && n == m;  // each pair within a node once
    if (one.count > 0 && two.count > 0) {
      for (int i = 0; i < one.count; ++i) {
        for (int j = same ? i + 1 : 0; j < two.count; ++j) {
          test(bvh_a.order[one.first + i], bvh_b.order[two.first + j]);
        }
      }
    } else if (same) {
      push(one.first, one.first);
      push(one.first + 1, one.first + 1);
      push(one.first, one.first + 1);
    } else if (one.count == 0 && (two.count > 0 || n <= m)) {
      push(one.first, m);
      push(one.first + 1, m);
    } else {
      push(n, two.first);
      push(n, two.first + 1);
    }
  }
  std::sort(pairs.begin(), pairs.end());
}

}  // namespace thew::skin
