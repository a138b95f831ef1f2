// SPDX-License-Identifier: Apache-2.0
//
// Tunnelling check, before contacts are searched for: nodes that have gone so deep into a rigid
// surface in one step that they might come out on the other side. The path of each node is marched
// by its distance from the surface (sphere tracing, Hart 1996), so that none is missed however fast
// it is.
#pragma once

#include <vector>

#include "skin/contact/collider.h"

namespace thew::skin {

/// The motion of a body in a step: its boxes at the begin and at the end.
struct BodyMotion {
  NodeBox before, after;
  double farthest = 0.0;  ///< m, longest motion of a node
};
BodyMotion body_motion(const Points& start, const Points& x);
/// Whether a node may have gone deeper than `depth` (m) into a rigid collider whose nodes have
/// moved by at most `moved` (m). Uses boxes alone.
bool may_tunnel(const BodyMotion& body, const Collider& rigid, double moved, double depth);

/// The node that has gone farthest beyond the surface, in the frame of the surface; one that bends
/// may have come to a node that far.
struct Tunnelling {
  int node = -1;          ///< -1: no node goes deeper than the limit
  double inside = 0.0;    ///< m, length of its path beyond the surface
  double distance = 0.0;  ///< m, length of its path in the step
};
/// Finds the node with the longest path beyond the surface, if longer than `depth` (m). The march
/// takes steps of at least `least` (m). Needs the tree of the collider.
Tunnelling find_tunnelling(const Points& start, const Points& x,
                           const std::vector<char>& free_nodes, const Collider& rigid, double depth,
                           double least);

}  // namespace thew::skin
