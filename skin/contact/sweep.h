// SPDX-License-Identifier: Apache-2.0
//
// Before contacts are looked for: what has gone beyond a rigid surface in one step, from where it
// might come out on the other side. Along each way the distance is marched (sphere tracing, Hart
// 1996), so that nothing is missed however fast it is.
#pragma once

#include <vector>

#include "skin/contact/collider.h"

namespace thew::skin {

/// A body's way in a step, from `start` to x.
struct BodyWay {
  NodeBox before, after;
  double farthest = 0.0;  ///< m, of a node
};
BodyWay way_of(const Points& start, const Points& x);
/// Whether a node may have gone deeper than `depth` (m) into a rigid collider, of which a node has
/// moved by `moved` (m) at most. Looks at boxes alone.
bool may_tunnel(const BodyWay& body, const Collider& rigid, double moved, double depth);

/// The node that has gone farthest beyond the surface, as the surface sees it.
struct Tunnelling {
  int node = -1;        ///< none goes deeper than asked for
  double inside = 0.0;  ///< m, of its way
  double way = 0.0;     ///< m
};
/// Deeper than `depth` (m); the march takes steps of `least` (m) or more. Needs the collider's
/// tree.
Tunnelling find_tunnelling(const Points& start, const Points& x,
                           const std::vector<char>& free_nodes, const Collider& rigid, double depth,
                           double least);

}  // namespace thew::skin
