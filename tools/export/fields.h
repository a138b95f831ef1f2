// SPDX-License-Identifier: Apache-2.0
//
// What a bake tells of a mesh's nodes without holding it: it follows from what it holds.
#pragma once

#include <array>
#include <vector>

#include "tools/export/motion.h"

namespace thew::tools {

/// The line of action of the shot's m-th mesh at the i-th frame, in the space of its points: that
/// of the world unless the mesh moves as one piece.
std::vector<Vec3> line_of_action(const ShotFrame& frame, std::size_t m, std::size_t i,
                                 const RigidMotion& rigid);

/// Unit vectors along the fibres by node: those of the line of action where the node's share of the
/// path is, from origin to insertion. `line` as BakeFrame::lines; empty: there are none.
std::vector<Vec3> fibre_directions(const BakeMesh& mesh, const std::vector<Vec3>& line);

/// The larger and the smaller principal stretch of the surface by node, 1 at rest: over the
/// triangles around the node, means by their area at rest. 1 where they have none. `first`, of
/// first_at_position(rest), joins vertices at one place.
std::vector<std::array<float, 2>> principal_stretches(const TriMesh& rest,
                                                      const std::vector<int>& first,
                                                      const std::vector<Vec3>& positions);

}  // namespace thew::tools
