// SPDX-License-Identifier: Apache-2.0
//
// Opens edges at which a surface is folded after the solve of a step: contact presses nodes one by
// one, and where a belly is thin between two others its triangles turn over.
#pragma once

#include <vector>

#include "skin/contact/parting.h"

namespace thew::skin {

/// The edge from corner `side` of a triangle to its next corner.
struct FoldedEdge {
  int triangle, side;
};

/// Scratch of find_folded_edges(), kept so that a step does not allocate.
struct FoldWork {
  std::vector<FoldedEdge> edges;  ///< found
  Points areas;                   ///< m^2, by triangle, twice its area vector
};

/// Finds the edges with a free corner in one of their two triangles whose normals differ by more
/// than 85 degrees, and by more than at rest. Not those that are beyond 90 degrees at rest (m).
void find_folded_edges(const Collider& body, const std::vector<Vec3>& rest, FoldWork& work);

/// Adds, for each of these edges, to the push of its four corners that are free the shortest
/// displacement that opens it to 85 degrees, or to what it has at rest; of a corner at most
/// `longest` (m).
void push_open(const Collider& body, const std::vector<Vec3>& rest,
               const std::vector<FoldedEdge>& edges, double longest, Parting& parting);

}  // namespace thew::skin
