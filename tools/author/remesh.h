// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/author/level_grid.h"

namespace thew::tools {

/// Brings the edges of a closed mesh to the length (m) that is wanted where they lie, its corners
/// to six triangles each, and its vertices onto the surface of level 0: splits, collapses and flips
/// of edges, and shifts along the surface in turn (Botsch, Kobbelt 2004).
TriMesh remeshed(const TriMesh& mesh, const Level& wanted, const Level& level);

/// Smooths a closed mesh where triangles meet at more than 70 degrees, until none do or it has done
/// so 50 times.
void smooth_folds(TriMesh& mesh);

}  // namespace thew::tools
