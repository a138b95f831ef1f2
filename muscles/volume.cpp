// SPDX-License-Identifier: Apache-2.0
#include "muscles/volume.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rig/vectorise.h"

namespace thew::muscles {
namespace {

// Sums stay in their lanes until the end, so that their order does not depend on the processor.
[[gnu::always_inline]] inline Point centroid(const Points& x) {
  Point even = {}, odd = {};
  const size_t n = x.size();
  for (size_t i = 0; i + 1 < n; i += 2) {
    even += x[i];
    odd += x[i + 1];
  }
  if (n % 2) even += x[n - 1];
  return n ? (even + odd) / static_cast<double>(n) : even;
}

}  // namespace

THEW_VECTORISED
double enclosed_volume(const Points& x, const std::vector<Triangle>& triangles) {
  // V = sum p1 . (p2 x p3) / 6 = sum p1 . N / 6 with N = (p2 - p1) x (p3 - p1)
  const Point origin = centroid(x);
  Point volume = {};
  for (const auto& [i, j, k] : triangles) {
    const Point a = x[i];
    volume += (a - origin) * cross3(x[j] - a, x[k] - a);
  }
  return sum3(volume) / 6.0;
}

THEW_VECTORISED
void volume_gradient(const Points& x, const std::vector<Triangle>& triangles, Points& gradient) {
  // dV/dp1 = sum p2 x p3 / 6 over the triangles around p1. Around a closed ring p1 x (p3 - p2) sums
  // to zero, so N / 6 may be added at all three corners instead: one product, and no origin is
  // needed.
  gradient.assign(x.size(), Point{});
  for (const auto& [i, j, k] : triangles) {
    const Point a = x[i];
    const Point n = cross3(x[j] - a, x[k] - a) * (1.0 / 6.0);
    gradient[i] += n;
    gradient[j] += n;
    gradient[k] += n;
  }
}

THEW_VECTORISED
VolumeCubic volume_along(const Points& x, const Points& d, const std::vector<Triangle>& triangles) {
  // V is a symmetric trilinear form T(x, x, x) of a closed surface, so V(x + s d) =
  // T(x,x,x) + 3 T(x,x,d) s + 3 T(x,d,d) s^2 + T(d,d,d) s^3. With N from x and Q from d as above:
  // 6 c0 = sum p1 . N, 6 c1 = sum (d1 + d2 + d3) . N, 6 c2 = sum (p1 + p2 + p3) . Q,
  // 6 c3 = sum d1 . Q.
  const Point origin = centroid(x);
  Point c0 = {}, c1 = {}, c2 = {}, c3 = {};
  for (const auto& [i, j, k] : triangles) {
    const Point a = x[i], u = x[j] - a, v = x[k] - a, p = a - origin;
    const Point e = d[i], f = d[j] - e, g = d[k] - e;
    const Point n = cross3(u, v), q = cross3(f, g);
    c0 += p * n;
    c1 += (3.0 * e + (f + g)) * n;
    c2 += (3.0 * p + (u + v)) * q;
    c3 += e * q;
  }
  return {sum3(c0) / 6.0, sum3(c1) / 6.0, sum3(c2) / 6.0, sum3(c3) / 6.0};
}

namespace {

// h(t) = |V - target| for t = |s| in the direction in which it falls: h = g - k1 t + k2 t^2 + k3
// t^3, with g > 0 and k1 >= 0.
struct Fall {
  double g, k1, k2, k3;
  double value(double t) const { return g + t * (-k1 + t * (k2 + t * k3)); }
  double slope(double t) const { return -k1 + t * (2.0 * k2 + t * 3.0 * k3); }

  // The t at which h stops falling: the first root of h', infinity if there is none.
  double end() const {
    const double discriminant = k2 * k2 + 3.0 * k1 * k3;
    if (discriminant > 0.0 || k3 > 0.0) {
      const double root = std::sqrt(std::max(discriminant, 0.0));
      if (k2 > 0.0) return k1 / (k2 + root);
      if (k3 > 0.0) return (root - k2) / (3.0 * k3);
    }
    return std::numeric_limits<double>::infinity();
  }

  // The root in (0, high], where h falls and h(high) <= 0, by Newton's method, with bisection where
  // it leaves the bracket.
  double root(double high) const {
    double low = 0.0, t = k1 > 0.0 ? std::min(g / k1, high) : 0.5 * high;
    for (int pass = 0; pass < 200; ++pass) {
      const double h = value(t);
      if (h == 0.0) return t;
      (h > 0.0 ? low : high) = t;
      double next = t - h / slope(t);
      // At rounding error a step leads to a neighbouring number or nowhere.
      if (std::fabs(next - t) <= std::numeric_limits<double>::epsilon() * t) return next;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      if (next == low || next == high) return next;
      t = next;
    }
    return t;
  }
};

}  // namespace

VolumeRoot nearest_root(const VolumeCubic& cubic, double target) {
  const auto [c0, c1, c2, c3] = cubic;
  const double g = c0 - target;
  if (!std::isfinite(g) || !std::isfinite(c1) || !std::isfinite(c2) || !std::isfinite(c3)) {
    return {0.0, false};
  }
  if (g == 0.0) return {};
  if (c1 == 0.0 && c2 == 0.0 && c3 == 0.0) return {0.0, false};
  const double sign = g > 0.0 ? 1.0 : -1.0;
  const double downhill = (c1 != 0.0 ? c1 : c3) * sign > 0.0 ? -1.0 : 1.0;
  const Fall fall{sign * g, std::fabs(c1), sign * c2, sign * downhill * c3};

  double high = fall.end();
  if (std::isinf(high)) {
    high = fall.k1 > 0.0 ? fall.g / fall.k1 : 1.0;
    while (fall.value(high) > 0.0 && !std::isinf(high)) high *= 2.0;
    if (std::isinf(high))
      return {0.0, false};  // coefficients of such different size are not those of a muscle
  } else if (fall.value(high) > 0.0) {
    // A double root may miss zero by its rounding.
    const double rounding =
        4.0 * std::numeric_limits<double>::epsilon() * std::max(std::fabs(c0), std::fabs(target));
    return {downhill * high, fall.value(high) <= rounding};
  }
  return {downhill * fall.root(high), true};
}

}  // namespace thew::muscles
