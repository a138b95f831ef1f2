// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "sim/cache/cache.h"

namespace thew::tools {

/// "muscle", "bone", "skin" or "prop"
const char* kind_name(BakeMesh::Kind kind);
/// What exports paint it with: red, green and blue, linear.
std::array<double, 3> kind_colour(BakeMesh::Kind kind);

/// For each vertex the one with which it is shaded: the first at its place at rest. A skin's are
/// apart where its edge is sharp, at 60 degrees: a file may have a vertex for each triangle, or for
/// each side of a texture's seam, without any edge to be seen.
std::vector<int> shaded_vertices(const BakeMesh& mesh);
/// The triangles by these vertices.
std::vector<Triangle> shaded_triangles(const BakeMesh& mesh);

}  // namespace thew::tools
