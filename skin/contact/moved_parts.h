// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "skin/surface/surface.h"

namespace thew::skin {

/// The parts of a surface at the top of its tree: the box of each, and the range of the motions of
/// its nodes since the last search. Motion bounds by part are useful because muscles that move
/// along with one forearm move by 1 cm in a frame, and hardly at all against each other
/// (skin/notes.md, "A search in every step").
struct MovedParts {
  static constexpr int kParts = 8;
  using Lanes = double[kParts];
  std::vector<int> roots;                 ///< nodes of the tree; this and the next two are set once
  std::vector<std::vector<int>> nodes;    ///< nodes by part; those on a border are in both
  std::vector<int> of_node, of_triangle;  ///< part of a node (one of them) and of a triangle
  /// m, boxes of the parts; at infinity for parts that do not exist.
  alignas(32) Lanes low[3], high[3];
  alignas(32) Lanes least[3], most[3];  ///< m, range of the motions of the nodes
  bool known = false;                   ///< whether the motions are those of the last step
};

/// Sets the parts of a surface with positions x, to which its tree is refitted, and `before` at the
/// last search; if that has another size the motions are not known. Surfaces of few triangles have
/// no parts.
void note_parts(const Surface& surface, const Bvh& bvh, const Points& x, const Points& before,
                MovedParts& parts);

/// Bounds for points outside a surface since the last search: a point that was at least b (m) away
/// is now at least min(b - approach, separation) away.
struct MotionBound {
  double approach = 0.0, separation = 0.0;  ///< m
};
/// Bounds for points in the box `positions` whose motions, each along a straight line, are in the
/// box `motions`. Parts that stayed at least `far` (m) away count by that separation, the others by
/// their relative motion.
MotionBound motion_bound(const MovedParts& parts, const NodeBox& positions, const NodeBox& motions,
                         double far);
/// The same for the points of each part of another surface.
void find_motion_bounds(const MovedParts& parts, const MovedParts& of, double far,
                        std::array<MotionBound, MovedParts::kParts>& by_part);

}  // namespace thew::skin
