// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <limits>

#include "skin/surface/surface.h"

namespace thew::skin {

constexpr int kStack = 192;  // entries; each split leaves at least an eighth on either side, so 150
                             // levels suffice for 2^31 triangles

constexpr int kWideStack = 7 * kStack;  // entries; each level leaves seven children at most

using Float4 = float __attribute__((vector_size(16)));

// Two float steps cover the rounding of the conversion.
[[gnu::always_inline]] inline void round_both(const Point& v, Float4& below, Float4& above) {
  const Float4 f = __builtin_convertvector(v, Float4), by = (f < 0.0f ? -f : f) * 1.2e-7f;
  below = f - by - std::numeric_limits<float>::min();
  above = f + by + std::numeric_limits<float>::min();
}

// A point or a box of points, rounded outwards, in the layout in which lo and hi of a box are read:
// (lo, hi[0]) and (lo[2], hi).
struct BoxQuery {
  Float4 up, down;
  BoxQuery() = default;
  [[gnu::always_inline]] explicit BoxQuery(const NodeBox& box) {
    constexpr float kFar = std::numeric_limits<float>::infinity();
    Float4 below, unused;
    round_both(box.high, unused, up);
    round_both(box.low, below, unused);
    up[3] = kFar;
    down = Float4{-kFar, below[0], below[1], below[2]};
  }
  [[gnu::always_inline]] explicit BoxQuery(const Vec3& p)
      : BoxQuery(NodeBox{to_point(p), to_point(p)}) {}
};

constexpr float kBelowRounding = 1.0f - 2e-6f;  // a factor that covers the rounding of a distance

// A lower bound of the squared distance to the box.
[[gnu::always_inline]] inline float box_distance2(const Bvh::Node& node, const BoxQuery& p) {
  Float4 low, high;
  std::memcpy(&low, node.lo, sizeof low);
  std::memcpy(&high, node.lo + 2, sizeof high);
  const Float4 zero{};
  Float4 a = low - p.up, b = p.down - high;
  a = a > zero ? a : zero;
  b = b > zero ? b : zero;
  a = a * a + b * b;
  return ((a[0] + a[1]) + (a[2] + a[3])) * kBelowRounding;
}

}  // namespace thew::skin
