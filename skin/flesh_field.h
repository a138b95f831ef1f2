// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "skin/contact/contact.h"

namespace thew::skin {

/// The surfaces below the skin as one smooth field f of the distances d_j to each of them:
///   sum_j max(R + f - d_j, 0)^2 = R^2
/// Near a single surface f is the distance to it. Between two surfaces f is less, so that a level
/// of f bridges a crevice instead of following it inwards, and the gradient of f points out of the
/// crevice. R is the bridging radius (m). Each surface near a node is approximated by a plane.
struct FleshPlanes {
  static constexpr int kMaxPlanes = 8;  ///< most surfaces near one node that count
  struct Plane {
    Vec3 normal;    ///< unit, out of the surface
    double offset;  ///< m: d_j(x) = normal . x - offset near the point of the search
  };
  std::vector<std::array<Plane, kMaxPlanes>> planes;
  std::vector<int> count;
};

/// Finds the planes of the nodes of a group, which are at x: those of the surfaces within `reach`
/// (m) whose distance is at most the bridging radius more than that of the nearest surface, on
/// either side; others do not affect f. Below the distance `least_direction` (m) the pseudonormal
/// gives the direction. `hints` only speed up the search; it has one entry for each node and
/// surface and one more for each node, -1 at first.
void find_flesh(const std::vector<Collider>& below, const Points& x, const NodeGroup& group,
                double reach, double bridging, double least_direction, std::vector<int>& hints,
                FleshPlanes& planes);

}  // namespace thew::skin
