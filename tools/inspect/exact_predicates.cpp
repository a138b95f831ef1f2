// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/exact_predicates.h"

#include <cmath>

namespace thew::tools {
namespace {

/// A sum of doubles, exact: terms that do not overlap, the smallest first (Shewchuk 1997).
struct Expansion {
  std::array<double, 97> terms;
  int size = 0;

  void add(double value) {
    int kept = 0;
    for (int i = 0; i < size; ++i) {
      const double sum = value + terms[i], part = sum - value;
      const double error = (value - (sum - part)) + (terms[i] - part);
      if (error != 0.0) terms[kept++] = error;
      value = sum;
    }
    if (value != 0.0) terms[kept++] = value;
    size = kept;
  }

  /// x y z = four doubles, each product split into its rounded value and its error.
  void add_product(double x, double y, double z) {
    const double xy = x * y, rest = std::fma(x, y, -xy);
    for (const double factor : {rest, xy}) {
      const double product = factor * z;
      add(std::fma(factor, z, -product));
      add(product);
    }
  }

  int sign() const { return size == 0 ? 0 : (terms[size - 1] > 0 ? 1 : -1); }
};

// det(b - a, c - a, d - a) = [b c d] - [a c d] + [a b d] - [a b c] with [u v w] = u . (v x w):
// no difference is rounded.
int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  Expansion sum;
  const auto add = [&](double sign, const Vec3& u, const Vec3& v, const Vec3& w) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      sum.add_product(sign * u[i], v[j], w[k]);
      sum.add_product(-sign * u[i], v[k], w[j]);
    }
  };
  add(1, b, c, d), add(-1, a, c, d), add(1, a, b, d), add(-1, a, b, c);
  return sum.sign();
}

/// a, b, c, p, q in one plane and e off it: does the segment pq meet the triangle?
bool meets_in_plane(const Vec3& p, const Vec3& q, const Corners& t, const Vec3& e) {
  const auto side = [&](const Vec3& x, const Vec3& y, const Vec3& z) {
    return orientation(x, y, z, e);
  };
  const auto inside = [&](const Vec3& x) {
    const int u = side(t[0], t[1], x), v = side(t[1], t[2], x), w = side(t[2], t[0], x);
    return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
  };
  if (inside(p) || inside(q)) return true;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &a = t[i], &b = t[(i + 1) % 3];
    const int pa = side(p, q, a), pb = side(p, q, b), ap = side(a, b, p), aq = side(a, b, q);
    // On one line: where they overlap, pq also meets the next edge, at its corner.
    if (pa == 0 && pb == 0 && ap == 0 && aq == 0) continue;
    if (pa * pb <= 0 && ap * aq <= 0) return true;
  }
  return false;
}

bool segment_meets(const Vec3& p, const Vec3& q, const Corners& t) {
  const auto& [a, b, c] = t;
  const int sp = orientation(a, b, c, p), sq = orientation(a, b, c, q);
  if (sp * sq > 0) return false;
  if (sp == 0 && sq == 0) {
    for (int i = 0; i < 3; ++i) {
      const Vec3 e = a + Vec3::Unit(i);
      if (orientation(a, b, c, e) != 0) return meets_in_plane(p, q, t, e);
    }
    return false;  // no area
  }
  const int u = orientation(p, q, a, b), v = orientation(p, q, b, c), w = orientation(p, q, c, a);
  return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

bool all_on_one_side(const Corners& s, const Corners& t) {
  const int first = orientation(t[0], t[1], t[2], s[0]);
  return first != 0 && orientation(t[0], t[1], t[2], s[1]) == first &&
         orientation(t[0], t[1], t[2], s[2]) == first;
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = c - a, w = d - a;
  const Vec3 left = u.cwiseAbs(), middle = v.cwiseAbs(), right = w.cwiseAbs();
  const double determinant = u.dot(v.cross(w));
  double permanent = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    permanent += left[i] * (middle[j] * right[k] + middle[k] * right[j]);
  }
  // Shewchuk's bound is 7.8e-16 (3 roundings of differences, 4 of products and sums); twice that.
  const double bound = 1.6e-15 * permanent;
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  return exact_orientation(a, b, c, d);
}

bool triangles_meet(const Corners& s, const Corners& t) {
  if (all_on_one_side(s, t) || all_on_one_side(t, s)) return false;
  for (int i = 0; i < 3; ++i) {
    if (segment_meets(s[i], s[(i + 1) % 3], t)) return true;
    if (segment_meets(t[i], t[(i + 1) % 3], s)) return true;
  }
  return false;
}

}  // namespace thew::tools
