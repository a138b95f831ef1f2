// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "rig/vectorise.h"
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

void corners(const Surface& surface, const Points& x, int triangle, Vec3* out) {
  for (int k = 0; k < 3; ++k) out[k] = to_vec(x[surface.triangles[triangle][k]]);
}

using Float4 = float __attribute__((vector_size(16)));
using Int4 = int __attribute__((vector_size(16)));

[[gnu::always_inline]] inline bool boxes_meet(const Bvh::Node& a, const Bvh::Node& b) {
  // Four floats each, of which three count.
  Float4 a_low, a_high, b_low, b_high;
  std::memcpy(&a_low, a.lo, sizeof a_low);
  std::memcpy(&b_low, b.lo, sizeof b_low);
  std::memcpy(&a_high, a.hi, sizeof a_high);
  std::memcpy(&b_high, b.hi, sizeof b_high);
  const Int4 apart = (a_low > b_high) | (b_low > a_high);
  return (apart[0] | apart[1] | apart[2]) == 0;
}

using Block = Bvh::Block;
using Floats = float __attribute__((vector_size(32), aligned(32)));
using Ints = int __attribute__((vector_size(32), aligned(32)));

[[gnu::always_inline]] inline const Floats& in_lanes(const float (&lanes)[Block::kLanes]) {
  return *reinterpret_cast<const Floats*>(lanes);
}
[[gnu::always_inline]] inline const Ints& in_lanes(const int (&lanes)[Block::kLanes]) {
  return *reinterpret_cast<const Ints*>(lanes);
}

// The bits of lanes that are not 0.
[[gnu::always_inline]] inline unsigned bits_of(const Ints& lanes) {
  const Ints bits = lanes & Ints{1, 2, 4, 8, 16, 32, 64, 128};
  Int4 all = __builtin_shufflevector(bits, bits, 0, 1, 2, 3) |
             __builtin_shufflevector(bits, bits, 4, 5, 6, 7);
  all |= __builtin_shufflevector(all, all, 2, 3, 0, 1);
  return static_cast<unsigned>(all[0] | all[1]);
}

// Triangles of b whose boxes meet that of triangle i of a and, for a surface with itself, share no
// node with it.
[[gnu::always_inline]] inline unsigned meeting(const Block& a, int i, const Block& b, bool itself) {
  Ints apart = {};
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    apart |= (a.low[k][i] > in_lanes(b.high[k])) | (in_lanes(b.low[k]) > a.high[k][i]);
    if (!itself) continue;
#pragma GCC unroll 3
    for (int l = 0; l < 3; ++l) apart |= a.node[k][i] == in_lanes(b.node[l]);
  }
  return bits_of(~apart);
}

// Triangles of the block whose boxes meet a box.
[[gnu::always_inline]] inline unsigned meeting(const Block& block, const Bvh::Node& box) {
  Ints apart = {};
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    apart |= (in_lanes(block.low[k]) > box.hi[k]) | (box.lo[k] > in_lanes(block.high[k]));
  }
  return bits_of(~apart);
}

[[gnu::always_inline]] inline float extent_of(const Bvh::Node& node) {
  return (node.hi[0] - node.lo[0]) + (node.hi[1] - node.lo[1]) + (node.hi[2] - node.lo[2]);
}

// Whether t lies on one side of the plane of s, by more than `least` (m^3) of what is compared.
[[gnu::always_inline]] inline bool clearly_one_side(const Point* s, const Point* t, double least) {
  const Point n = cross3(s[1] - s[0], s[2] - s[0]);
  const double a = sum3(n * (t[0] - s[0])), b = sum3(n * (t[1] - s[0]));
  const double c = sum3(n * (t[2] - s[0]));
  return (a > least && b > least && c > least) || (a < -least && b < -least && c < -least);
}

[[gnu::always_inline]] inline bool are_apart(const Triangle& s, const Points& xa, const Triangle& t,
                                             const Points& xb, double least) {
  const Point a[3] = {xa[s[0]], xa[s[1]], xa[s[2]]}, b[3] = {xb[t[0]], xb[t[1]], xb[t[2]]};
  return clearly_one_side(a, b, least) || clearly_one_side(b, a, least);
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
  find_near_crossings(a, bvh_a, xa, b, bvh_b, xb, pairs);
  std::erase_if(pairs, [&](const auto& pair) { return !are_crossing(a, xa, b, xb, pair); });
  std::sort(pairs.begin(), pairs.end());
}

bool are_crossing(const Surface& a, const Points& xa, const Surface& b, const Points& xb,
                  const std::array<int, 2>& pair) {
  Vec3 s[3], t[3];
  corners(a, xa, pair[0], s);
  corners(b, xb, pair[1], t);
  return cross(s, t);
}

THEW_VECTORISED
void find_near_crossings(const Surface& a, const Bvh& bvh_a, const Points& xa, const Surface& b,
                         const Bvh& bvh_b, const Points& xb,
                         std::vector<std::array<int, 2>>& pairs) {
  pairs.clear();
  if (bvh_a.order.empty() || bvh_b.order.empty()) return;
  const bool itself = &a == &b && &xa == &xb;
  const auto test = [&](int i, int j, double least) __attribute__((always_inline)) {
    if (are_apart(a.triangles[i], xa, b.triangles[j], xb, least)) return;
    pairs.push_back(itself ? std::array{std::min(i, j), std::max(i, j)} : std::array{i, j});
  };
  // A step down both trees adds three entries and one down either adds one, and no tree has more
  // than 150 levels (bvh.cpp).
  constexpr int kStack = 1024;
  std::array<int, 2> stack[kStack];
  int top = 0;
  if (boxes_meet(bvh_a.nodes[0], bvh_b.nodes[0])) stack[top++] = {0, 0};
  while (top > 0) {
    const auto [n, m] = stack[--top];
    const Bvh::Node &one = bvh_a.nodes[n], &two = bvh_b.nodes[m];
    const bool same = itself && n == m;  // each pair within a node once
    bool divide_one = bvh_a.block_of[n] < 0, divide_two = bvh_b.block_of[m] < 0;
    if (!divide_one && !divide_two) {
      const Block& first = bvh_a.blocks[bvh_a.block_of[n]];
      const Block& second = bvh_b.blocks[bvh_b.block_of[m]];
      // No two corners are farther apart along x, y or z. Some five times the rounding of
      // clearly_one_side().
      const double extent = extent_of(one) + extent_of(two);
      const double least = 1e-14 * extent * extent * extent;
      for (unsigned rows = meeting(first, two); rows != 0; rows &= rows - 1) {
        const int i = std::countr_zero(rows);
        unsigned columns = meeting(first, i, second, itself);
        if (same) columns &= ~0u << i;
        for (; columns != 0; columns &= columns - 1) {
          test(first.triangle[i], second.triangle[std::countr_zero(columns)], least);
        }
      }
      continue;
    }
    if (divide_one && divide_two && !same) {  // the much larger one first
      const float left = extent_of(one), right = extent_of(two);
      divide_two = !(left > 2.0f * right);  // both where neither is a number, or this never ends
      divide_one = !(right > 2.0f * left);
    }
    const int rows = divide_one ? 2 : 1, columns = divide_two ? 2 : 1;
    for (int i = 0; i < rows; ++i) {
      for (int j = same ? i : 0; j < columns; ++j) {
        const int next = divide_one ? one.first + i : n, other = divide_two ? two.first + j : m;
        if (boxes_meet(bvh_a.nodes[next], bvh_b.nodes[other])) stack[top++] = {next, other};
      }
    }
  }
}

}  // namespace thew::skin
