// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "rig/types.h"

namespace thew::muscles {

// Four nodes at a time, with one vector for each coordinate. Always inlined, because a call between
// functions compiled for different instruction sets would pass vectors in different registers.

using Lanes = double __attribute__((vector_size(32)));
inline constexpr int kLanes = 4;  // AVX2 has enough registers for four nodes, not for eight

struct Lanes3 {
  Lanes x, y, z;
};

// Transposes four points in registers.
[[gnu::always_inline]] inline Lanes3 side_by_side(const Point& a, const Point& b, const Point& c,
                                                  const Point& d) {
  const Point xz0 = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const Point xz1 = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const Point y0 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Point y1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return {__builtin_shufflevector(xz0, xz1, 0, 1, 4, 5),
          __builtin_shufflevector(y0, y1, 0, 1, 4, 5),
          __builtin_shufflevector(xz0, xz1, 2, 3, 6, 7)};
}

[[gnu::always_inline]] inline Lanes3 gather(const Point* rows, const int* i) {
  return side_by_side(rows[i[0]], rows[i[1]], rows[i[2]], rows[i[3]]);
}

// Writes four points to their rows. Lanes that repeat a node write the same values.
[[gnu::always_inline]] inline void scatter(const Lanes3& a, const int* i, Point* rows) {
  const Lanes none = {};
  const Point xy02 = __builtin_shufflevector(a.x, a.y, 0, 4, 2, 6);
  const Point xy13 = __builtin_shufflevector(a.x, a.y, 1, 5, 3, 7);
  const Point z02 = __builtin_shufflevector(a.z, none, 0, 4, 2, 6);
  const Point z13 = __builtin_shufflevector(a.z, none, 1, 5, 3, 7);
  rows[i[0]] = __builtin_shufflevector(xy02, z02, 0, 1, 4, 5);
  rows[i[1]] = __builtin_shufflevector(xy13, z13, 0, 1, 4, 5);
  rows[i[2]] = __builtin_shufflevector(xy02, z02, 2, 3, 6, 7);
  rows[i[3]] = __builtin_shufflevector(xy13, z13, 2, 3, 6, 7);
}

[[gnu::always_inline]] inline Lanes3 minus(const Lanes3& a, const Lanes3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

[[gnu::always_inline]] inline Lanes dot(const Lanes3& a, const Lanes3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

[[gnu::always_inline]] inline Lanes root(const Lanes& a) {
  Lanes out;
  for (int l = 0; l < kLanes; ++l) out[l] = std::sqrt(a[l]);
  return out;
}

}  // namespace thew::muscles
