// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "muscles/lanes.h"
#include "skin/surface/surface.h"

namespace thew::skin {

struct OnTriangle {
  double b[3];
  double distance2;
};

// Ericson, Real-Time Collision Detection, 5.1.5. On corners and edges the other barycentric
// coordinates are exactly 0.
inline OnTriangle nearest_on_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const auto at = [&](double v, double w) {
    return OnTriangle{{1.0 - v - w, v, w}, (ap - v * ab - w * ac).squaredNorm()};
  };
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {{1, 0, 0}, ap.squaredNorm()};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {{0, 1, 0}, bp.squaredNorm()};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return at(d1 / (d1 - d3), 0.0);
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {{0, 0, 1}, cp.squaredNorm()};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return at(0.0, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    const OnTriangle edge = at(1.0 - w, w);
    return {{0.0, edge.b[1], edge.b[2]}, edge.distance2};
  }
  const double sum = va + vb + vc;
  if (!(sum > 0.0))
    return {{1, 0, 0},
            ap.squaredNorm()};  // the triangle has no area, and rounding missed its edges
  return at(vb / sum, vc / sum);
}

// In the order in which Eigen sums.
[[gnu::always_inline]] inline Lanes dot_as_eigen(const Lanes3& a, const Lanes3& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}

[[gnu::always_inline]] inline Lanes3 in_all_lanes(const Vec3& p) {
  const Lanes zero = {};
  return {zero + p.x(), zero + p.y(), zero + p.z()};
}

// The squared distances of nearest_on_triangle, to the bit, of four points from a triangle each.
[[gnu::always_inline]] inline Lanes distances2(const Triangle* const* t, const Points& x,
                                               const Lanes3& p) {
  const auto corner = [&](int k) __attribute__((always_inline)) {
    return side_by_side(x[(*t[0])[k]], x[(*t[1])[k]], x[(*t[2])[k]], x[(*t[3])[k]]);
  };
  const Lanes zero = {}, one = zero + 1.0;
  const Lanes3 a = corner(0), b = corner(1), c = corner(2);
  const Lanes3 ab = minus(b, a), ac = minus(c, a), ap = minus(p, a);
  const Lanes3 bp = minus(p, b), cp = minus(p, c);
  const Lanes d1 = dot_as_eigen(ab, ap), d2 = dot_as_eigen(ac, ap), d3 = dot_as_eigen(ab, bp),
              d4 = dot_as_eigen(ac, bp);
  const Lanes d5 = dot_as_eigen(ab, cp), d6 = dot_as_eigen(ac, cp);
  const Lanes vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  const Lanes sum = va + vb + vc;
  const auto at_a = (d1 <= 0.0) & (d2 <= 0.0);
  const auto at_b = (d3 >= 0.0) & (d4 <= d3);
  const auto on_ab = (vc <= 0.0) & (d1 >= 0.0) & (d3 <= 0.0);
  const auto at_c = (d6 >= 0.0) & (d5 <= d6);
  const auto on_ac = (vb <= 0.0) & (d2 >= 0.0) & (d6 <= 0.0);
  const auto on_bc = (va <= 0.0) & (d4 - d3 >= 0.0) & (d5 - d6 >= 0.0);
  const auto no_area = ~(sum > 0.0);
  // v = up_v / down_v and w likewise, of the first case that holds; the last line counts first.
  Lanes up_v = vb, down_v = sum, up_w = vc, down_w = sum;
  const auto set = [&](const auto& where, const Lanes& v, const Lanes& of_v, const Lanes& w,
                       const Lanes& of_w) __attribute__((always_inline)) {
    up_v = where ? v : up_v;
    down_v = where ? of_v : down_v;
    up_w = where ? w : up_w;
    down_w = where ? of_w : down_w;
  };
  set(no_area, zero, one, zero, one);
  set(on_bc, zero, one, d4 - d3, (d4 - d3) + (d5 - d6));
  set(on_ac, zero, one, d2, d2 - d6);
  set(on_ab, d1, d1 - d3, zero, one);
  set(at_a, zero, one, zero, one);
  const Lanes w = up_w / down_w;
  const Lanes v = (on_bc & ~(on_ac | on_ab | at_a)) ? one - w : up_v / down_v;
  Lanes3 off = {ap.x - v * ab.x - w * ac.x, ap.y - v * ab.y - w * ac.y, ap.z - v * ab.z - w * ac.z};
  const auto is_c = at_c & ~(at_a | at_b | on_ab), is_b = at_b & ~at_a;
  const auto pick = [&](const auto& where, const Lanes3& from) __attribute__((always_inline)) {
    off.x = where ? from.x : off.x;
    off.y = where ? from.y : off.y;
    off.z = where ? from.z : off.z;
  };
  pick(is_c, cp);
  pick(is_b, bp);
  return dot_as_eigen(off, off);
}

}  // namespace thew::skin
