// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "skin/surface/surface.h"

namespace thew::skin {

/// The parts that a surface is cut into at the top of its tree: where each is, and what its nodes
/// have moved since they were last looked at. Muscles that go along with one forearm move by 1 cm a
/// frame and next to nothing against each other.
struct MovedParts {
  static constexpr int kParts = 8;
  using Lanes = double __attribute__((vector_size(8 * kParts)));
  std::vector<int> roots;                 ///< of the parts' trees; with the next two, once
  std::vector<std::vector<int>> nodes;    ///< by part, those on a border in both
  std::vector<int> of_node, of_triangle;  ///< the part, one of them
  alignas(64) Lanes low[3], high[3];      ///< m, boxes; those that are missing lie nowhere
  Lanes least[3], most[3];                ///< m, of the nodes' ways
  bool known = false;                     ///< the ways are of the last step
};

/// Of the tree that is refitted to x. Nodes were `before`, or anywhere where it is of another size.
/// Nothing is known of surfaces of few triangles.
void note_parts(const Surface& surface, const Bvh& bvh, const Points& x, const Points& before,
                MovedParts& parts);

/// What has come of points that lay outside of the surface by `clear` (m): they still do, by
/// min(clear - owed, apart).
struct MotionBound {
  double owed = 0.0, apart = 0.0;  ///< m
};
/// Of points that are in a box and whose ways were in another, each on a straight line; parts that
/// they were `enough` (m) apart from all the time count by that, others by how they moved.
MotionBound motion_bound(const MovedParts& parts, const NodeBox& places, const NodeBox& ways,
                         double enough);
/// The same of the points of each part.
void find_motion_bounds(const MovedParts& parts, const MovedParts& of, double enough,
                        std::array<MotionBound, MovedParts::kParts>& by_part);

}  // namespace thew::skin
