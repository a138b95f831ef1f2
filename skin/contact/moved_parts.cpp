// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/moved_parts.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "muscles/lengths.h"
#include "rig/vectorise.h"

namespace thew::skin {
namespace {

using Lanes = MovedParts::Lanes;
constexpr int kParts = MovedParts::kParts;
constexpr double kFar = 1e300;  // m^2

// Cuts the tree into up to kParts parts, level by level.
void cut(const Surface& surface, const Bvh& bvh, size_t nodes, MovedParts& parts) {
  std::vector<int>& roots = parts.roots;
  roots = {0};
  for (size_t k = 0; k < roots.size() && roots.size() < kParts;) {
    const Bvh::Node& node = bvh.nodes[roots[k]];
    if (node.count > 0) {
      ++k;
      continue;
    }
    roots.erase(roots.begin() + static_cast<std::ptrdiff_t>(k));
    roots.insert(roots.end(), {node.first, node.first + 1});
  }
  parts.of_node.assign(nodes, 0);
  parts.of_triangle.assign(surface.triangles.size(), 0);
  for (size_t k = 0; k < roots.size(); ++k) {
    std::vector<int>& of_part = parts.nodes.emplace_back();
    std::vector<int> stack = {roots[k]};
    while (!stack.empty()) {
      const Bvh::Node& node = bvh.nodes[stack.back()];
      stack.pop_back();
      if (node.count == 0) stack.insert(stack.end(), {node.first, node.first + 1});
      for (int i = node.first; i < node.first + node.count; ++i) {
        parts.of_triangle[bvh.order[i]] = static_cast<int>(k);
        const Triangle& t = surface.triangles[bvh.order[i]];
        of_part.insert(of_part.end(), t.begin(), t.end());
      }
    }
    std::sort(of_part.begin(), of_part.end());
    of_part.erase(std::unique(of_part.begin(), of_part.end()), of_part.end());
    for (const int i : of_part) parts.of_node[i] = static_cast<int>(k);
  }
}

[[gnu::always_inline]] inline Point larger(const Point& a, const Point& b) { return a > b ? a : b; }
[[gnu::always_inline]] inline Point less(const Point& a, const Point& b) { return a < b ? a : b; }

// Four parts from the first on. Vectors of 32 bytes, since g++ makes comparisons of wider ones into
// one for each number where the processor has no wider.
[[gnu::always_inline]] inline Point four(const Lanes& lanes, int first) {
  Point out;
  std::memcpy(&out, lanes + first, sizeof out);
  return out;
}

[[gnu::always_inline]] inline MotionBound motion_bound_of(const MovedParts& parts,
                                                          const NodeBox& positions,
                                                          const NodeBox& motions, double far) {
  const Point zero = {};
  Point close = zero + kFar, away = zero;  // squared, m^2
  for (int k = 0; k < kParts; k += 4) {
    Point apart = {}, nearer = {};
    for (int axis = 0; axis < 3; ++axis) {
      // The range of motions of each part relative to the points, and its distance over the whole
      // motion.
      const Point least = four(parts.least[axis], k) - motions.high[axis];
      const Point most = four(parts.most[axis], k) - motions.low[axis];
      const Point low = four(parts.low[axis], k) - positions.high[axis] - larger(most, zero);
      const Point high = four(parts.high[axis], k) - positions.low[axis] - less(least, zero);
      const Point off = larger(larger(low, -high), zero), moved = larger(most, -least);
      apart += off * off;
      nearer += moved * moved;
    }
    const auto is_far = apart >= far * far;
    close = less(close, is_far ? apart : zero + kFar);
    away = larger(away, is_far ? zero : nearer);
  }
  const double closest = std::min(std::min(close[0], close[1]), std::min(close[2], close[3]));
  const double farthest = std::max(std::max(away[0], away[1]), std::max(away[2], away[3]));
  return {std::sqrt(farthest) + kRounding, std::sqrt(closest) - kRounding};
}

// Not a lambda: one that is not inlined, as at -O0, would return the vector in another register
// than a clone for wider vectors expects.
[[gnu::always_inline]] inline Point part_of(const Lanes* lanes, int k) {
  return Point{lanes[0][k], lanes[1][k], lanes[2][k], 0.0};
}

}  // namespace

THEW_VECTORISED
void note_parts(const Surface& surface, const Bvh& bvh, const Points& x, const Points& before,
                MovedParts& parts) {
  constexpr double kNowhere = std::numeric_limits<double>::infinity();
  constexpr size_t kFew = 64;  // triangles; a search of fewer is as fast as the bounds
  if (surface.triangles.size() < kFew) return;
  if (parts.roots.empty()) cut(surface, bvh, x.size(), parts);
  parts.known = before.size() == x.size();
  for (int k = 0; k < kParts; ++k) {
    const bool is_there = k < static_cast<int>(parts.roots.size());
    Point least = {}, most = {};
    if (parts.known && is_there) {
      const std::vector<int>& nodes = parts.nodes[k];
      least = most = x[nodes[0]] - before[nodes[0]];
      for (const int i : nodes) {
        const Point motion = x[i] - before[i];
        least = motion < least ? motion : least;
        most = motion > most ? motion : most;
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      parts.low[axis][k] = is_there ? bvh.nodes[parts.roots[k]].lo[axis] : kNowhere;
      parts.high[axis][k] = is_there ? bvh.nodes[parts.roots[k]].hi[axis] : kNowhere;
      parts.least[axis][k] = least[axis];
      parts.most[axis][k] = most[axis];
    }
  }
}

THEW_VECTORISED
MotionBound motion_bound(const MovedParts& parts, const NodeBox& positions, const NodeBox& motions,
                         double far) {
  return motion_bound_of(parts, positions, motions, far);
}

THEW_VECTORISED
void find_motion_bounds(const MovedParts& parts, const MovedParts& of, double far,
                        std::array<MotionBound, kParts>& by_part) {
  for (int k = 0; k < static_cast<int>(of.roots.size()); ++k) {
    by_part[k] = motion_bound_of(parts, {part_of(of.low, k), part_of(of.high, k)},
                                 {part_of(of.least, k), part_of(of.most, k)}, far);
  }
}

}  // namespace thew::skin
